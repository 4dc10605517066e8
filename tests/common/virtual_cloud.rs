//! Virtual clouds: the points of virtual scans without their triangles, with what real clouds have.

use std::collections::BTreeMap;

use scan2step::formats::points::PointScan;
use scan2step::formats::{Points, Soup};
use scan2step::nalgebra::{Point3, Vector3};

use super::virtual_scan::{Random, Star, Truth, VirtualScan};

/// How a cloud differs from a single even scan.
#[derive(Debug, Clone, Copy, Default)]
pub struct Flaws {
    /// The number of scans that lie over each other, each with its own noise and each moved by half
    /// of the noise. 0 and 1 mean a single one that is not moved.
    pub layers: usize,
    /// The share of points that are outliers.
    pub outliers: f64,
    /// Whether the density falls to a fifth across the surface.
    pub uneven: bool,
}

/// A cloud with the scan that it was made of.
pub struct VirtualCloud {
    pub scan: VirtualScan,
    pub cloud: Points,
    /// The standard deviation of the noise in mm.
    pub noise: f64,
    /// The distance in mm between neighbouring points of one layer.
    pub spacing: f64,
    /// For each point of the cloud whether it is an outlier.
    pub is_outlier: Vec<bool>,
}

/// The surfaces of virtual clouds, each with holes.
pub fn holes(count: usize) -> Vec<Star> {
    let star = |x, y, radius, arms| Star { centre: [x, y], radius, arms };
    let all = [star(0.3, 0.3, 0.09, 5.0), star(0.7, 0.65, 0.1, 3.0), star(0.4, 0.75, 0.08, 4.0)];
    all[..count].to_vec()
}

impl VirtualCloud {
    /// Makes a cloud of `size` points, with a noise of a share of their spacing.
    pub fn new(
        truth: Truth,
        size: [usize; 2],
        noise: f64,
        holes: usize,
        flaws: Flaws,
        seed: u64,
    ) -> Self {
        let exact = VirtualScan::new(truth, size, 0.0, self::holes(holes), seed);
        let count = exact.points.len();
        let spacing = (exact.true_area() / count as f64).sqrt();
        let noise = noise * spacing;
        let mut random = Random::new(seed);
        let mut points: Vec<([f64; 3], bool)> = Vec::new();
        for layer in 0..flaws.layers.max(1) {
            let of_layer = VirtualScan::new(
                truth,
                size,
                noise,
                self::holes(holes),
                seed + 1000 * layer as u64,
            );
            let shift = unit(&mut random) * if flaws.layers > 1 { 0.5 * noise } else { 0.0 };
            for (p, uv) in of_layer.points.iter().zip(&of_layer.uv) {
                // A fifth stays at one side, all at the other.
                if flaws.uneven && random.uniform() > 1.0 - 0.8 * uv[0] {
                    continue;
                }
                points.push(((Vector3::from(*p) + shift).into(), false));
            }
        }
        let (low, high) = points
            .iter()
            .fold((Point3::from([f64::MAX; 3]), Point3::from([f64::MIN; 3])), |(l, h), p| {
                (l.inf(&p.0.into()), h.sup(&p.0.into()))
            });
        let outliers = (flaws.outliers * points.len() as f64) as usize;
        for k in 0..outliers {
            let p = if k % 2 == 0 {
                low + (high - low).component_mul(&Vector3::from_fn(|_, _| random.uniform()))
            } else {
                let near = (random.uniform() * count as f64) as usize;
                let reach = (noise * (2.0 + 18.0 * random.uniform())).max(0.3 * spacing);
                Point3::from(points[near].0) + unit(&mut random) * reach
            };
            points.push((p.into(), true));
        }
        for i in (1..points.len()).rev() {
            points.swap(i, (random.uniform() * (i + 1) as f64) as usize);
        }
        let (positions, is_outlier): (Vec<_>, Vec<_>) = points.into_iter().unzip();
        VirtualCloud { scan: exact, cloud: cloud(positions), noise, spacing, is_outlier }
    }
}

/// A cloud of these points in one scan.
pub fn cloud(positions: Vec<[f64; 3]>) -> Points {
    let scans = vec![PointScan { points: 0..positions.len(), ..PointScan::default() }];
    Points { positions, scans, ..Points::default() }
}

fn unit(random: &mut Random) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random.normal()).normalize()
}

/// What a soup of triangles is, found without the library.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SoupCheck {
    /// Sides of triangles that another triangle has in the same direction.
    pub bad_edges: usize,
    /// Vertices from which more than one boundary edge leaves.
    pub bad_vertices: usize,
    pub components: usize,
    /// The number of edges of each boundary loop, ascending.
    pub loops: Vec<usize>,
    pub area: f64,
}

impl SoupCheck {
    /// Checks a soup of triangles whose points are all used.
    pub fn new(soup: &Soup) -> Self {
        let triangles: Vec<[u32; 3]> =
            soup.polygons.iter().map(|t| t.try_into().expect("a triangle")).collect();
        let mut sides: BTreeMap<(u32, u32), usize> = BTreeMap::new();
        let of_triangle = |t: &[u32; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
        triangles.iter().flat_map(of_triangle).for_each(|s| *sides.entry(s).or_default() += 1);
        let open: Vec<(u32, u32)> =
            sides.keys().filter(|&&(a, b)| !sides.contains_key(&(b, a))).copied().collect();
        let next: BTreeMap<u32, u32> = open.iter().copied().collect();
        SoupCheck {
            bad_edges: sides.values().filter(|&&count| count > 1).count(),
            bad_vertices: open.len() - next.len(),
            components: components(soup.points.len(), &triangles),
            loops: loop_lengths(next),
            area: triangles.iter().map(|t| area(t.map(|v| soup.points[v as usize]))).sum(),
        }
    }

    /// Whether the soup is an oriented manifold mesh.
    pub fn is_manifold(&self) -> bool {
        self.bad_edges == 0 && self.bad_vertices == 0
    }
}

fn area(t: [[f64; 3]; 3]) -> f64 {
    let [a, b, c] = t.map(Point3::from);
    0.5 * (b - a).cross(&(c - a)).norm()
}

fn loop_lengths(mut next: BTreeMap<u32, u32>) -> Vec<usize> {
    let mut lengths = Vec::new();
    while let Some((&start, _)) = next.first_key_value() {
        let (mut v, mut length) = (start, 0);
        while let Some(after) = next.remove(&v) {
            v = after;
            length += 1;
        }
        lengths.push(length);
    }
    lengths.sort_unstable();
    lengths
}

fn components(points: usize, triangles: &[[u32; 3]]) -> usize {
    let mut root: Vec<u32> = (0..points as u32).collect();
    let find = |root: &mut Vec<u32>, mut v: u32| {
        while root[v as usize] != v {
            root[v as usize] = root[root[v as usize] as usize];
            v = root[v as usize];
        }
        v
    };
    for t in triangles {
        for k in 1..3 {
            let (a, b) = (find(&mut root, t[0]), find(&mut root, t[k]));
            root[a.max(b) as usize] = a.min(b);
        }
    }
    (0..points).filter(|&v| root[v] as usize == v).count()
}
