//! Tessellations of known smooth surfaces. All vertices are exactly on the surface.

use std::collections::HashMap;
use std::f64::consts::PI;

/// A true surface over [0, 1]² with a width of about 100 mm. Its isolines have constant speed, so
/// that the midpoint of a chord lies under the midpoint of its arc.
pub type Truth = fn(f64, f64) -> [f64; 3];

pub const SURFACES: [(&str, Truth); 5] = [
    ("sphere cap", sphere),
    ("cylinder part", cylinder),
    ("torus part", torus),
    ("saddle", saddle),
    ("wavy sheet", wavy),
];

fn sphere(u: f64, v: f64) -> [f64; 3] {
    let (a, b) = (1.4 * (u - 0.5), 1.4 * (v - 0.5));
    [60.0 * a.sin() * b.cos(), 60.0 * b.sin(), 60.0 * a.cos() * b.cos()]
}

fn cylinder(u: f64, v: f64) -> [f64; 3] {
    let a = PI * (u - 0.5);
    [40.0 * a.sin(), 100.0 * v, 40.0 * a.cos()]
}

fn torus(u: f64, v: f64) -> [f64; 3] {
    let (a, b) = (1.2 * u, 2.4 * (v - 0.5));
    let radius = 60.0 + 25.0 * b.cos();
    [radius * a.cos(), radius * a.sin(), 25.0 * b.sin()]
}

fn saddle(u: f64, v: f64) -> [f64; 3] {
    let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    [50.0 * x, 50.0 * y, 20.0 * (x * x - y * y)]
}

fn wavy(u: f64, v: f64) -> [f64; 3] {
    [100.0 * u, 100.0 * v, 5.0 * (9.0 * u).sin() * (8.0 * v).cos()]
}

/// The kinds of tessellations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A grid of square cells.
    Regular,
    /// A grid of square cells with displaced inner vertices.
    Jittered,
    /// Cells that are twenty times as long as wide.
    Thin,
    /// A regular grid. Some of its edges are split near one end.
    Slivers,
    /// Edges that are halved only where the surface needs it.
    Adaptive,
}

pub const KINDS: [Kind; 5] =
    [Kind::Regular, Kind::Jittered, Kind::Thin, Kind::Slivers, Kind::Adaptive];

/// The parameters of vertices, and triangles.
#[derive(Clone)]
pub struct Tessellation {
    pub truth: Truth,
    pub uv: Vec<[f64; 2]>,
    pub triangles: Vec<[u32; 3]>,
}

impl Tessellation {
    /// A tessellation whose edges are at most `chord` mm from the surface.
    pub fn new(truth: Truth, kind: Kind, chord: f64, random: &mut Random) -> Self {
        let needed = [0, 1].map(|k| cells(truth, k, chord));
        let long = [0, 1].map(|k| length(truth, k));
        let edge = [0, 1].map(|k| long[k] / needed[k] as f64);
        let shortest = edge[0].min(edge[1]);
        let count = |k: usize, edge: f64| (long[k] / edge).ceil().max(2.0) as usize;
        match kind {
            Kind::Regular => Self::grid(truth, [0, 1].map(|k| count(k, shortest))),
            Kind::Jittered => Self::grid(truth, [0, 1].map(|k| count(k, shortest))).strewn(random),
            Kind::Thin => {
                // Long in the direction of least curvature, and short across it.
                let k = usize::from(edge[1] > edge[0]);
                let across = edge[1 - k].min(edge[k].min(long[k] / 2.0) / 20.0);
                let mut cells = [0; 2];
                cells[k] = count(k, 20.0 * across);
                cells[1 - k] = count(1 - k, across);
                Self::grid(truth, cells)
            }
            Kind::Slivers => {
                let grid = Self::grid(truth, [0, 1].map(|k| count(k, shortest)));
                let mut split = HashMap::new();
                for t in &grid.triangles {
                    // The first edge of two triangles is their diagonal.
                    if random.uniform() < 0.4 {
                        split.insert(sorted(t[0], t[1]), 0.04);
                    }
                }
                grid.split(&split)
            }
            Kind::Adaptive => Self::adaptive(truth, chord),
        }
    }

    /// A grid with the given numbers of cells.
    pub fn grid(truth: Truth, [n, m]: [usize; 2]) -> Self {
        let at = |i: usize, j: usize| [i as f64 / n as f64, j as f64 / m as f64];
        let uv = (0..=n).flat_map(|i| (0..=m).map(move |j| at(i, j))).collect();
        let halves = |i: usize, j: usize| {
            let [a, b] = [i, i + 1].map(|i| (i * (m + 1) + j) as u32);
            [[b + 1, a, b], [a, b + 1, a + 1]]
        };
        let cells = (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
        Tessellation { truth, uv, triangles: cells.flat_map(|(i, j)| halves(i, j)).collect() }
    }

    fn strewn(mut self, random: &mut Random) -> Self {
        let inside = |p: [f64; 2]| p.iter().all(|x| *x > 1e-9 && *x < 1.0 - 1e-9);
        let m = self.uv.iter().position(|p| p[1] > 1.0 - 1e-9).unwrap();
        let n = self.uv.len() / (m + 1) - 1;
        for p in self.uv.iter_mut().filter(|p| inside(**p)) {
            p[0] += 0.5 * (random.uniform() - 0.5) / n as f64;
            p[1] += 0.5 * (random.uniform() - 0.5) / m as f64;
        }
        self
    }

    fn adaptive(truth: Truth, chord: f64) -> Self {
        let mut mesh = Self::grid(truth, [2, 2]);
        loop {
            let edges =
                mesh.triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
            let far: HashMap<[u32; 2], f64> = edges
                .map(|(a, b)| sorted(a, b))
                .filter(|e| missed(truth, mesh.uv[e[0] as usize], mesh.uv[e[1] as usize]) > chord)
                .map(|e| (e, 0.5))
                .collect();
            if far.is_empty() {
                return mesh;
            }
            mesh = mesh.split(&far);
        }
    }

    /// Splits edges, each at a share of its length, and the triangles beside them.
    fn split(&self, edges: &HashMap<[u32; 2], f64>) -> Self {
        let mut uv = self.uv.clone();
        let mut order: Vec<(&[u32; 2], &f64)> = edges.iter().collect();
        order.sort_by_key(|(e, _)| **e);
        let mut middle = HashMap::new();
        for (e, share) in order {
            let [a, b] = e.map(|v| self.uv[v as usize]);
            middle.insert(*e, uv.len() as u32);
            uv.push([0, 1].map(|k| a[k] + share * (b[k] - a[k])));
        }
        let mut triangles = Vec::new();
        let mut left = self.triangles.clone();
        while let Some([a, b, c]) = left.pop() {
            let of = |a: u32, b: u32| middle.get(&sorted(a, b));
            match ([of(a, b), of(b, c), of(c, a)], a) {
                ([Some(&x), Some(&y), Some(&z)], _) => {
                    triangles.extend([[a, x, z], [x, b, y], [z, y, c], [x, y, z]]);
                }
                ([Some(&x), ..], _) => left.extend([[a, x, c], [x, b, c]]),
                ([None, None, None], _) => triangles.push([a, b, c]),
                _ => left.push([b, c, a]),
            }
        }
        Tessellation { truth: self.truth, uv, triangles }
    }

    /// The vertices with noise in every direction.
    pub fn points(&self, noise: f64, random: &mut Random) -> Vec<[f64; 3]> {
        let at = |&[u, v]: &[f64; 2]| (self.truth)(u, v).map(|x| x + noise * random.normal());
        self.uv.iter().map(at).collect()
    }

    /// The median of the shortest edges of all triangles, in mm.
    pub fn edge(&self) -> f64 {
        let at = |v: u32| (self.truth)(self.uv[v as usize][0], self.uv[v as usize][1]);
        let shortest = |t: &[u32; 3]| {
            let [a, b, c] = t.map(at);
            distance(a, b).min(distance(b, c)).min(distance(c, a))
        };
        let mut all: Vec<f64> = self.triangles.iter().map(shortest).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    }
}

fn sorted(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// The distance of a chord from the surface at its midpoint.
fn missed(truth: Truth, a: [f64; 2], b: [f64; 2]) -> f64 {
    let (p, q) = (truth(a[0], a[1]), truth(b[0], b[1]));
    let middle = truth(0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]));
    distance([0, 1, 2].map(|k| 0.5 * (p[k] + q[k])), middle)
}

/// The isoline along parameter `k` at a given value of the other parameter.
fn on(k: usize, along: f64, beside: f64) -> [f64; 2] {
    if k == 0 { [along, beside] } else { [beside, along] }
}

/// The least number of cells along parameter `k` for the wanted chord error.
fn cells(truth: Truth, k: usize, chord: f64) -> usize {
    let good = |n: &usize| {
        let at = |i: usize| i as f64 / *n as f64;
        let isoline = |j: usize| {
            let j = j as f64 / 20.0;
            (0..*n).all(|i| missed(truth, on(k, at(i), j), on(k, at(i + 1), j)) <= chord)
        };
        (0..=20).all(isoline)
    };
    (2..).find(good).unwrap()
}

/// The length of the surface along parameter `k`.
fn length(truth: Truth, k: usize) -> f64 {
    let at = |i: usize| on(k, i as f64 / 100.0, 0.5);
    let point = |i: usize| truth(at(i)[0], at(i)[1]);
    (0..100).map(|i| distance(point(i), point(i + 1))).sum()
}

/// A random generator of its own, so that the meshes are the same in every run.
pub struct Random(pub u64);

impl Random {
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (2.0 * PI * self.uniform()).cos()
    }
}
