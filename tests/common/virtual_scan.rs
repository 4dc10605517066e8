//! Virtual scans: the scan of a known true surface.
//!
//! A virtual scan is a grid over the parameter square. Its vertices are displaced, have Gaussian
//! noise in space, and are missing in the holes. Everything is deterministic, so `cargo run
//! --example make_fixtures` always writes the same fixtures.

use std::io::{self, Write};

/// A true surface over [0, 1]².
pub type Truth = fn(f64, f64) -> [f64; 3];

/// A region of the parameter square that the scanner missed: a star with a centre, a mean radius,
/// an amplitude and a number of arms. A star inside a star is an island.
#[derive(Debug, Clone, Copy)]
pub struct Star {
    pub centre: [f64; 2],
    pub radius: f64,
    pub arms: f64,
}

impl Star {
    pub fn holds(&self, u: f64, v: f64) -> bool {
        let (x, y) = (u - self.centre[0], v - self.centre[1]);
        x.hypot(y) < self.radius * (1.0 + 0.25 * (self.arms * y.atan2(x) + 0.7).cos())
    }
}

/// A scan and its true values.
#[derive(Debug, Clone)]
pub struct VirtualScan {
    pub truth: Truth,
    pub holes: Vec<Star>,
    /// The regions that the scanner missed, including those at the border.
    pub bays: Vec<Star>,
    /// The measured points in mm.
    pub points: Vec<[f64; 3]>,
    /// The true parameters of each point.
    pub uv: Vec<[f64; 2]>,
    pub triangles: Vec<[u32; 3]>,
}

/// A relief of 100 × 80 mm with a dome, a ridge, and waves in one corner.
pub fn relief(u: f64, v: f64) -> [f64; 3] {
    let (x, y) = (100.0 * (u - 0.5), 80.0 * (v - 0.5));
    let dome = 18.0 * (-(x * x + y * y) / 1800.0).exp();
    let ridge = 4.0 * (-((x - 18.0) / 7.0).powi(2) - ((y + 6.0) / 18.0).powi(2)).exp();
    let waves =
        0.8 * (x / 3.0).sin() * (-((x + 28.0) / 14.0).powi(2) - ((y - 18.0) / 12.0).powi(2)).exp();
    [x, y, dome + ridge + waves]
}

/// Three quarters of a rippled barrel. It overhangs, so no projection to a plane is one-to-one.
pub fn rolled_sheet(u: f64, v: f64) -> [f64; 3] {
    let (angle, y) = (1.5 * std::f64::consts::PI * (u - 0.5), 90.0 * (v - 0.5));
    let radius = 30.0 + 4.0 * (y / 20.0).cos() + 1.2 * (4.0 * angle).sin() * (y / 12.0).cos();
    [radius * angle.sin(), y, radius * angle.cos()]
}

/// A closed ring of 100 mm whose tube has three thick and three thin places.
pub fn ring(u: f64, v: f64) -> [f64; 3] {
    let [angle, turn] = [u, v].map(|x| std::f64::consts::TAU * x);
    let tube = 12.0 + 3.0 * (3.0 * angle).cos();
    let reach = 35.0 + tube * turn.cos();
    [reach * angle.cos(), reach * angle.sin(), tube * turn.sin()]
}

/// The wavy sheet of 100 × 100 mm with a bump, for the comparison of the paper's figures.
pub fn sheet(u: f64, v: f64) -> [f64; 3] {
    let (x, y) = (100.0 * u, 100.0 * v);
    let bump = 5.0 * (-((x - 60.0).powi(2) + (y - 40.0).powi(2)) / 200.0).exp();
    [x, y, 8.0 * (x / 15.0).sin() * (y / 18.0).cos() + bump]
}

/// The fixture `relief.ply` with a noise of 0.06 mm and two holes.
pub fn relief_scan() -> VirtualScan {
    let holes = vec![
        Star { centre: [0.33, 0.35], radius: 0.10, arms: 3.0 },
        Star { centre: [0.68, 0.7], radius: 0.07, arms: 5.0 },
    ];
    VirtualScan::new(relief, [70, 60], 0.06, holes, 1)
}

/// The fixture `rolled_sheet.obj` with a noise of 0.05 mm and one hole.
pub fn rolled_scan() -> VirtualScan {
    let holes = vec![Star { centre: [0.45, 0.55], radius: 0.10, arms: 4.0 }];
    VirtualScan::new(rolled_sheet, [80, 60], 0.05, holes, 2)
}

/// The fixture `ring.obj`: a whole body of genus 1 with a noise of 0.05 mm.
pub fn ring_scan() -> VirtualScan {
    let (n, m) = (80, 32);
    let mut random = Random::new(4);
    let (mut points, mut uv, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for (i, j) in (0..n * m).map(|k| (k / m, k % m)) {
        let at = [(i, n), (j, m)].map(|(k, count)| {
            (k as f64 + 0.4 * (random.uniform() - 0.5)) / f64::from(count as u32)
        });
        points.push(ring(at[0], at[1]).map(|x| x + 0.05 * random.normal()));
        uv.push(at);
        let name = |i: usize, j: usize| (i % n * m + j % m) as u32;
        let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    VirtualScan { truth: ring, holes: vec![], bays: vec![], points, uv, triangles }
}

/// The experiment of the paper: 8,100 points minus a hole, and a noise of 0.15 mm, which makes the
/// boundary rough.
pub fn paper_scan() -> VirtualScan {
    let holes = vec![Star { centre: [0.35, 0.62], radius: 0.10, arms: 5.0 }];
    VirtualScan::new(sheet, [90, 90], 0.15, holes, 3)
}

/// The relief with two holes and a ragged border, which has bays and teeth that are three edges
/// deep.
pub fn ragged_scan() -> VirtualScan {
    let star = |centre, radius, arms| Star { centre, radius, arms };
    let holes = vec![star([0.35, 0.4], 0.10, 3.0), star([0.68, 0.62], 0.07, 5.0)];
    let bays = vec![
        star([0.2, 0.02], 0.09, 3.0),
        star([0.98, 0.45], 0.08, 4.0),
        star([0.6, 0.97], 0.11, 5.0),
        star([0.03, 0.8], 0.07, 2.0),
    ];
    VirtualScan::cut(relief, [90, 80], 0.03, (holes, bays, 3), 21)
}

/// The relief with a wide hole, an island in it, and a hole in the island.
pub fn island_scan() -> VirtualScan {
    let holes = vec![
        Star { centre: [0.48, 0.5], radius: 0.26, arms: 3.0 },
        Star { centre: [0.5, 0.48], radius: 0.14, arms: 4.0 },
        Star { centre: [0.52, 0.47], radius: 0.05, arms: 2.0 },
    ];
    VirtualScan::new(relief, [80, 70], 0.05, holes, 5)
}

impl VirtualScan {
    /// Samples `truth` on an `n` × `m` grid.
    pub fn new(truth: Truth, size: [usize; 2], noise: f64, holes: Vec<Star>, seed: u64) -> Self {
        VirtualScan::cut(truth, size, noise, (holes, Vec::new(), 0), seed)
    }

    /// The same with bays in the border, and with teeth along the whole border. The width and the
    /// depth of the teeth are numbers of vertices.
    pub fn cut(
        truth: Truth,
        [n, m]: [usize; 2],
        noise: f64,
        (holes, bays, teeth): (Vec<Star>, Vec<Star>, usize),
        seed: u64,
    ) -> Self {
        let mut random = Random::new(seed);
        let mut all = Vec::with_capacity(n * m);
        for i in 0..n {
            for j in 0..m {
                let mut jitter = |k: usize, count: usize| {
                    let inside = k > 0 && k + 1 < count;
                    let shift = 0.4 * (random.uniform() - 0.5) * f64::from(u8::from(inside));
                    (k as f64 + shift) / (count - 1) as f64
                };
                let (u, v) = (jitter(i, n), jitter(j, m));
                let point = truth(u, v).map(|x| x + noise * random.normal());
                all.push(([u, v], point));
            }
        }
        let gap = |k: usize| {
            let (i, j) = (k / m, k % m);
            let between = |along: usize| teeth > 0 && (along / teeth) % 2 == 1;
            let ends = i < teeth || i + teeth >= n;
            let sides = j < teeth || j + teeth >= m;
            (ends && between(j)) || (sides && between(i)) || (ends && sides && teeth > 0)
        };
        let gone = |k: usize| {
            let [u, v] = all[k].0;
            let hole = holes.iter().filter(|h| h.holds(u, v)).count() % 2 == 1;
            hole || gap(k) || bays.iter().any(|b| b.holds(u, v))
        };
        let mut triangles = Vec::new();
        for k in (0..n - 1).flat_map(|i| (0..m - 1).map(move |j| i * m + j)) {
            let (a, b, c, d) = (k, k + m, k + m + 1, k + 1);
            let halves = if random.uniform() < 0.5 {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            };
            triangles.extend(halves.into_iter().filter(|t| !t.iter().any(|&x| gone(x))));
        }
        let mut scan =
            VirtualScan { truth, holes, bays, points: vec![], uv: vec![], triangles: vec![] };
        let mut number = vec![None; n * m];
        for t in triangles {
            let mut corner = |x: usize| {
                *number[x].get_or_insert_with(|| {
                    scan.uv.push(all[x].0);
                    scan.points.push(all[x].1);
                    scan.points.len() as u32 - 1
                })
            };
            let t = t.map(&mut corner);
            scan.triangles.push(t);
        }
        scan
    }

    /// The area in mm² of the measured triangles with their corners at the true positions.
    pub fn true_area(&self) -> f64 {
        let place = |v: u32| {
            let [u, w] = self.uv[v as usize];
            nalgebra::Point3::from((self.truth)(u, w))
        };
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(place);
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        self.triangles.iter().map(area).sum()
    }

    /// The number of faces of the scan, and the number of their inner loops.
    pub fn faces_and_inner_loops(&self) -> (usize, usize) {
        let around = |star: &Star| {
            let [u, v] = star.centre;
            let wider = |h: &&Star| h.radius > star.radius && h.holds(u, v);
            self.holes.iter().filter(wider).count()
        };
        let islands = self.holes.iter().filter(|star| around(star) % 2 == 1).count();
        (1 + islands, self.holes.len() - islands)
    }

    /// Points of the true surface that are not near the holes or the edge.
    pub fn true_points(&self, n: usize) -> Vec<[f64; 3]> {
        let first = if self.bays.is_empty() { 0.02 } else { 0.06 };
        let at = |i: usize| first + (1.0 - 2.0 * first) * i as f64 / (n - 1) as f64;
        let grid = (0..n * n).map(|k| (at(k / n), at(k % n)));
        let far = |&(u, v): &(f64, f64)| {
            let times = |share: f64| {
                let scaled = |h: &&Star| Star { radius: share * h.radius, ..**h }.holds(u, v);
                self.holes.iter().filter(scaled).count()
            };
            let wide = |b: &Star| Star { radius: 1.25 * b.radius, ..*b };
            let in_bay = self.bays.iter().any(|b| wide(b).holds(u, v));
            times(1.25) == times(0.8) && times(1.0) % 2 == 0 && !in_bay
        };
        grid.filter(far).map(|(u, v)| (self.truth)(u, v)).collect()
    }

    /// The root mean square distance of points from the true surface, in mm.
    pub fn rms(&self, points: impl Iterator<Item = [f64; 3]>) -> f64 {
        let distances = self.distances(points);
        let squares: f64 = distances.iter().map(|d| d * d).sum();
        (squares / distances.len().max(1) as f64).sqrt()
    }

    /// The distances of points from the true surface, in mm. Newton steps in (u, v) start at the
    /// nearest sample of a grid.
    pub fn distances(&self, points: impl Iterator<Item = [f64; 3]>) -> Vec<f64> {
        const GRID: usize = 100;
        let step = 1.0 / GRID as f64;
        let uv = |k: usize| ((k / (GRID + 1)) as f64 * step, (k % (GRID + 1)) as f64 * step);
        let grid: Vec<_> = (0..(GRID + 1) * (GRID + 1))
            .map(|k| (uv(k), nalgebra::Point3::from((self.truth)(uv(k).0, uv(k).1))))
            .collect();
        let distance = |p: [f64; 3]| {
            let p = nalgebra::Point3::from(p);
            let squared = |s: &nalgebra::Point3<f64>| (s - p).norm_squared();
            let nearest = grid.iter().min_by(|a, b| squared(&a.1).total_cmp(&squared(&b.1)));
            self.distance(p, nearest.expect("a grid has points").0)
        };
        points.map(distance).collect()
    }

    /// The distance of a point from the true surface near (u, v), in mm.
    fn distance(&self, p: nalgebra::Point3<f64>, (mut u, mut v): (f64, f64)) -> f64 {
        let at = |u: f64, v: f64| nalgebra::Point3::from((self.truth)(u, v));
        let mut best = (at(u, v) - p).norm();
        let e = 1e-6;
        for _ in 0..8 {
            let r = p - at(u, v);
            let su = (at(u + e, v) - at(u - e, v)) / (2.0 * e);
            let sv = (at(u, v + e) - at(u, v - e)) / (2.0 * e);
            let gram = nalgebra::Matrix2::new(su.dot(&su), su.dot(&sv), su.dot(&sv), sv.dot(&sv));
            let right = nalgebra::Vector2::new(su.dot(&r), sv.dot(&r));
            let Some(d) = gram.lu().solve(&right) else { break };
            u = (u + d.x).clamp(0.0, 1.0);
            v = (v + d.y).clamp(0.0, 1.0);
            best = best.min((at(u, v) - p).norm());
        }
        best
    }

    /// Writes a binary PLY file of floats.
    pub fn write_ply(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "ply\nformat binary_little_endian 1.0\ncomment virtual scan, millimetres")?;
        writeln!(out, "element vertex {}", self.points.len())?;
        writeln!(out, "property float x\nproperty float y\nproperty float z")?;
        writeln!(out, "element face {}", self.triangles.len())?;
        writeln!(out, "property list uchar int vertex_indices\nend_header")?;
        for x in self.points.iter().flatten() {
            out.write_all(&(*x as f32).to_le_bytes())?;
        }
        for t in &self.triangles {
            out.write_all(&[3])?;
            for v in t {
                out.write_all(&v.to_le_bytes())?;
            }
        }
        Ok(())
    }

    /// Writes the points alone as columns of text.
    pub fn write_xyz(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "// virtual scan, millimetres: x y z")?;
        self.points.iter().try_for_each(|[x, y, z]| writeln!(out, "{x:.4} {y:.4} {z:.4}"))
    }

    /// Writes an OBJ file.
    pub fn write_obj(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "# virtual scan, millimetres")?;
        for [x, y, z] in &self.points {
            writeln!(out, "v {x:.4} {y:.4} {z:.4}")?;
        }
        for [a, b, c] in &self.triangles {
            writeln!(out, "f {} {} {}", a + 1, b + 1, c + 1)?;
        }
        Ok(())
    }
}

/// A small random generator (xorshift64*). It is the same on every machine.
pub struct Random(u64);

impl Random {
    /// A generator whose numbers follow from the seed.
    pub fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// A random number from 0 to 1.
    pub fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A standard normal random number by the method of Box and Muller.
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}
