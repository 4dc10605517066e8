//! Meshes that are the same but for a rigid motion, in whatever order they have their points and polygons.
//!
//! Distances from the centroid do not change by a motion. Two points at rare distances fix the motion but for a few
//! candidates. Each candidate is checked at every point against the rounding of the file, and then all polygons are compared.

use std::collections::BTreeMap;
use std::collections::HashMap;

use super::placement::rotation_of;
use super::{MeshId, Placement, SceneMesh};
use crate::cad::affine::{cross, dot, unit};

/// The first rotation comes from two points that are at least this share of the radius away from the centroid, and
/// from a line. So it is off by less than [`FIRST`] roundings at any point.
const LEVER: f64 = 0.25;

/// How far a point may be from its place by the first rotation, in steps of the rounding: two errors of √3 roundings at points of the
/// least lever for each of two angles, and the error of the point and of the centroids.
const FIRST: f64 = 36.0;

/// The most candidates that are tried for two meshes. Rare distances leave a few; only regular shapes have many, of
/// which most fit.
const MOST_TRIES: usize = 4096;

/// The largest step as a share of the radius of a mesh. The numbers of a design may be whole without being rounded, and
/// then parts that differ by a step are different parts.
const LARGEST_STEP: f64 = 1e-4;

/// The largest distance of two rounded numbers from each other in steps: half a step of one, and half a step along each
/// axis of the other one, which is turned.
const WORST: f64 = 1.37; // (1 + √3) / 2

/// The root mean square of so many such distances in steps: each of the two roundings has 1/√12. It is in three of its
/// standard deviations: those of the mean of squares are √1.4 / √count, for the sum of two even distributions.
fn usual(count: f64) -> f64 {
    const MEAN: f64 = 1.0 / 6.0;
    (MEAN * (1.0 + 3.0 * (1.4 / count).sqrt())).sqrt()
}

/// Meshes that were seen.
pub(super) struct KnownMeshes {
    rounding: f64,
    /// By the counts of points and polygons, and by the logarithm of the radius.
    by_size: BTreeMap<MeshSize, Vec<(MeshId, MeshInvariants)>>,
}

/// The counts of points and polygons, and the logarithm of the radius in steps.
type MeshSize = ([usize; 2], i64);

/// What a mesh keeps in a motion, and its distinct points.
pub(super) struct MeshInvariants {
    /// The distinct points of polygons.
    points: Vec<[f64; 3]>,
    /// For each polygon its corners as numbers of these points, beginning at the least, and its colour.
    polygons: Vec<(Vec<u32>, Option<[u8; 3]>)>,
    centroid: [f64; 3],
    /// The distance of each point from the centroid.
    radii: Vec<f64>,
    /// The points by their radii.
    by_radius: Vec<u32>,
}

impl KnownMeshes {
    /// Meshes of a file with this rounding.
    pub(super) fn new(rounding: f64) -> Self {
        KnownMeshes { rounding, by_size: BTreeMap::new() }
    }

    /// The step between the numbers of a mesh.
    fn step(&self, shape: &MeshInvariants) -> f64 {
        self.rounding.min(LARGEST_STEP * shape.radius())
    }

    /// The radii of the same mesh differ by less than four steps, so they are in the same bin or in neighbours.
    fn key(shape: &MeshInvariants) -> ([usize; 2], i64) {
        let bin = shape.radius().max(f64::MIN_POSITIVE).ln() / (4.0 * LARGEST_STEP);
        // A quotient beyond its range becomes the end of it.
        ([shape.points.len(), shape.polygons.len()], bin.floor() as i64)
    }

    pub(super) fn add(&mut self, id: MeshId, shape: MeshInvariants) {
        self.by_size.entry(Self::key(&shape)).or_default().push((id, shape));
    }

    /// The known mesh that a motion takes to this one, with the motion, or what has to be known of this one.
    pub(super) fn find(
        &self,
        meshes: &[SceneMesh],
        mesh: &SceneMesh,
    ) -> Result<(MeshId, Placement), MeshInvariants> {
        let shape = MeshInvariants::of(mesh);
        let ((counts, bin), step) = (Self::key(&shape), self.step(&shape));
        for bin in [bin, bin.saturating_sub(1), bin.saturating_add(1)] {
            for (id, known) in self.by_size.get(&(counts, bin)).into_iter().flatten() {
                // A place can have a colour of its own, but it cannot take one away.
                let has_colour = |mesh: &SceneMesh| mesh.colour.is_some();
                if has_colour(&meshes[id.0]) == has_colour(mesh)
                    && let Some(motion) = known.motion_to(&shape, step)
                {
                    return Ok((*id, motion));
                }
            }
        }
        Err(shape)
    }
}

impl MeshInvariants {
    fn of(mesh: &SceneMesh) -> Self {
        let mut numbers: HashMap<[u64; 3], u32> = HashMap::new();
        let (mut points, mut polygons) = (Vec::new(), Vec::new());
        let mut colours = vec![None; mesh.soup.polygons.len()];
        for (run, value) in mesh.colours.iter() {
            colours[run].fill(mesh.colours.values()[value]);
        }
        for (polygon, colour) in mesh.soup.polygons.iter().zip(colours) {
            let number = |&corner: &u32| {
                let point = mesh.soup.points[corner as usize];
                // Zero has two signs.
                let key = point.map(|x| (x + 0.0).to_bits());
                *numbers.entry(key).or_insert_with(|| {
                    points.push(point);
                    points.len() as u32 - 1
                })
            };
            polygons.push((polygon.iter().map(number).collect::<Vec<u32>>(), colour));
        }
        polygons.iter_mut().for_each(|(corners, _)| from_the_least(corners));
        polygons.sort_unstable();
        let count = points.len().max(1) as f64;
        let sum = points.iter().fold([0.0; 3], |sum, p| [0, 1, 2].map(|k| sum[k] + p[k]));
        let centroid = sum.map(|x| x / count);
        let radii: Vec<f64> = points.iter().map(|p| length(minus(*p, centroid))).collect();
        let mut by_radius: Vec<u32> = (0..points.len() as u32).collect();
        by_radius.sort_by(|&a, &b| radii[a as usize].total_cmp(&radii[b as usize]));
        MeshInvariants { points, polygons, centroid, radii, by_radius }
    }

    fn radius(&self) -> f64 {
        self.by_radius.last().map_or(0.0, |&last| self.radii[last as usize])
    }

    /// The vector of a point from the centroid.
    fn arm(&self, point: u32) -> [f64; 3] {
        minus(self.points[point as usize], self.centroid)
    }

    /// The points whose radius is near one.
    fn near_radius(&self, radius: f64, within: f64) -> &[u32] {
        let at = |bound: f64| self.by_radius.partition_point(|&p| self.radii[p as usize] < bound);
        &self.by_radius[at(radius - within)..at(radius + within)]
    }

    /// The motion that takes this mesh to another one.
    fn motion_to(&self, other: &MeshInvariants, rounding: f64) -> Option<Placement> {
        let within = 4.0 * rounding;
        // All radii must agree, which most other meshes fail.
        let mut radii = self.by_radius.iter().zip(&other.by_radius);
        let differ = |(&a, &b): (&u32, &u32)| {
            (self.radii[a as usize] - other.radii[b as usize]).abs() > within
        };
        if self.points.len() != other.points.len() || radii.any(differ) {
            return None;
        }
        let grid = PointCells::of(&other.points, FIRST * rounding);
        // Most files have the same order everywhere.
        let same_order: Vec<u32> = (0..self.points.len() as u32).collect();
        if let Some(motion) = self.fitted(other, &same_order, rounding) {
            return Some(motion);
        }
        let [first, second] = self.references(within)?;
        let frame = frame(self.arm(first), self.arm(second))?;
        let apart = length(minus(self.arm(first), self.arm(second)));
        let mut tries = 0;
        for &a in other.near_radius(self.radii[first as usize], within) {
            for &b in other.near_radius(self.radii[second as usize], within) {
                let found = length(minus(other.arm(a), other.arm(b)));
                if a == b || (found - apart).abs() > 2.0 * within {
                    continue;
                }
                tries += 1;
                if tries > MOST_TRIES {
                    return None;
                }
                let Some(to) = self::frame(other.arm(a), other.arm(b)) else { continue };
                let turn = between(&frame, &to);
                if let Some(order) = self.matched(other, (&turn, &grid))
                    && let Some(motion) = self.fitted(other, &order, rounding)
                {
                    return Some(motion);
                }
            }
        }
        None
    }

    /// Two points that fix a rotation: of those with enough lever the ones whose radii the fewest others have.
    fn references(&self, within: f64) -> Option<[u32; 2]> {
        let least = LEVER * self.radius();
        let rarity = |&p: &u32| self.near_radius(self.radii[p as usize], within).len();
        let far = |p: &u32| self.radii[*p as usize] >= least;
        let first = self.by_radius.iter().copied().filter(far).min_by_key(rarity)?;
        let along = unit(self.arm(first))?;
        let off = |p: &u32| length(cross(along, self.arm(*p))) >= least;
        let second = self.by_radius.iter().copied().filter(off).min_by_key(rarity)?;
        Some([first, second])
    }

    /// The point of the other mesh that is where a rotation takes each point. `None` if one has none.
    fn matched(
        &self,
        other: &MeshInvariants,
        (turn, grid): (&Placement, &PointCells),
    ) -> Option<Vec<u32>> {
        let place = |p: u32| {
            let turned = turn.turn(self.arm(p));
            grid.nearest(&other.points, [0, 1, 2].map(|k| turned[k] + other.centroid[k]))
        };
        (0..self.points.len() as u32).map(place).collect()
    }

    /// The motion of least squares (Kabsch, 1976) that takes each point to that of the other mesh in an order. `None`
    /// unless each vertex agrees within the rounding, which both have, the root mean square is that of rounding, and
    /// all polygons and their colours are the same.
    fn fitted(&self, other: &MeshInvariants, order: &[u32], rounding: f64) -> Option<Placement> {
        let mut covariance = [[0.0; 3]; 3];
        for (p, &q) in (0..).zip(order) {
            let (from, to) = (self.arm(p), other.arm(q));
            for (column, along) in covariance.iter_mut().zip(from) {
                *column = [0, 1, 2].map(|i| column[i] + to[i] * along);
            }
        }
        let axes = rotation_of(&covariance)?;
        let turned = Placement::linear(axes).apply(self.centroid);
        let translation = [0, 1, 2].map(|i| other.centroid[i] - turned[i]);
        let motion = Placement { axes, translation };
        let mut squares = 0.0;
        for (p, &q) in self.points.iter().zip(order) {
            let off = minus(motion.apply(*p), other.points[q as usize]);
            if off.iter().any(|x| x.abs() > WORST * rounding) {
                return None;
            }
            squares += dot(off, off);
        }
        let count = (3 * self.points.len()).max(1) as f64;
        if (squares / count).sqrt() > usual(count) * rounding {
            return None;
        }
        let moved = |(corners, colour): &(Vec<u32>, Option<[u8; 3]>)| {
            let mut corners: Vec<u32> = corners.iter().map(|&c| order[c as usize]).collect();
            from_the_least(&mut corners);
            (corners, *colour)
        };
        let mut polygons: Vec<_> = self.polygons.iter().map(moved).collect();
        polygons.sort_unstable();
        (polygons == other.polygons).then_some(motion)
    }
}

/// Points in cells.
struct PointCells {
    cell: f64,
    points: HashMap<[i64; 3], Vec<u32>>,
}

impl PointCells {
    fn of(points: &[[f64; 3]], cell: f64) -> Self {
        let mut grid = PointCells { cell, points: HashMap::new() };
        for (number, p) in (0..).zip(points) {
            grid.points.entry(grid.cell_of(*p)).or_default().push(number);
        }
        grid
    }

    fn cell_of(&self, p: [f64; 3]) -> [i64; 3] {
        // A quotient beyond its range becomes the end of it.
        p.map(|x| (x / self.cell).floor() as i64)
    }

    /// The nearest point that is not farther than a cell.
    fn nearest(&self, points: &[[f64; 3]], p: [f64; 3]) -> Option<u32> {
        let [x, y, z] = self.cell_of(p);
        let mut best = (self.cell, None);
        for k in 0..27 {
            let [i, j, k] = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
            let cell = [x.saturating_add(i), y.saturating_add(j), z.saturating_add(k)];
            for &number in self.points.get(&cell).into_iter().flatten() {
                let off = length(minus(points[number as usize], p));
                if off <= best.0 {
                    best = (off, Some(number));
                }
            }
        }
        best.1
    }
}

/// Turns a list of corners around so that the least comes first.
fn from_the_least(corners: &mut [u32]) {
    let least = corners.iter().enumerate().min_by_key(|(_, corner)| **corner);
    if let Some((at, _)) = least {
        corners.rotate_left(at);
    }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// A right-handed frame of unit vectors with two directions in its first plane.
fn frame(a: [f64; 3], b: [f64; 3]) -> Option<[[f64; 3]; 3]> {
    let x = unit(a)?;
    let z = unit(cross(x, b))?;
    Some([x, cross(z, x), z])
}

/// The rotation that takes one frame to another.
fn between(from: &[[f64; 3]; 3], to: &[[f64; 3]; 3]) -> Placement {
    // The image of an axis: its coordinates in the first frame along the axes of the second.
    let image = |axis: usize| {
        [0, 1, 2].map(|row: usize| (0..3).map(|k| from[k][axis] * to[k][row]).sum::<f64>())
    };
    Placement::linear([image(0), image(1), image(2)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Soup;

    /// A wedge that has no symmetry.
    const POINTS: [[f64; 3]; 6] = [
        [0.0, 0.0, 0.0],
        [7.0, 0.0, 0.0],
        [0.0, 5.0, 0.0],
        [0.0, 0.0, 3.0],
        [7.0, 0.0, 2.0],
        [0.0, 5.0, 1.0],
    ];
    const FACES: [&[u32]; 8] = [
        &[0, 2, 1],
        &[3, 4, 5],
        &[0, 1, 4],
        &[0, 4, 3],
        &[1, 2, 5],
        &[1, 5, 4],
        &[2, 0, 3],
        &[2, 3, 5],
    ];

    fn mesh(point: impl Fn([f64; 3]) -> [f64; 3], shuffle: bool, colour: [u8; 3]) -> SceneMesh {
        let order: [u32; 6] = if shuffle { [4, 2, 0, 5, 1, 3] } else { [0, 1, 2, 3, 4, 5] };
        let mut soup = Soup { points: vec![[0.0; 3]; 6], ..Soup::default() };
        for (number, p) in POINTS.into_iter().enumerate() {
            soup.points[order[number] as usize] = point(p).map(|x| (x * 1e6).round() / 1e6);
        }
        let mut faces: Vec<Vec<u32>> =
            FACES.iter().map(|face| face.iter().map(|&c| order[c as usize]).collect()).collect();
        if shuffle {
            faces.reverse();
            faces.iter_mut().for_each(|face| face.rotate_left(1));
        }
        faces.into_iter().for_each(|face| soup.polygons.push(face));
        SceneMesh { soup, colour: Some(colour), ..SceneMesh::default() }
    }

    fn turned(p: [f64; 3]) -> [f64; 3] {
        let (s, c) = 0.7_f64.sin_cos();
        [c * p[0] - s * p[1] + 40.0, p[2] - 3.0, -s * p[0] - c * p[1]]
    }

    fn found(a: &SceneMesh, b: &SceneMesh) -> Option<Placement> {
        let mut known = KnownMeshes::new(1e-6);
        known.add(MeshId(0), MeshInvariants::of(a));
        known.find(std::slice::from_ref(a), b).ok().map(|(_, motion)| motion)
    }

    #[test]
    fn the_order_does_not_matter() {
        let plain = mesh(|p| p, false, [1, 2, 3]);
        let motion = found(&plain, &mesh(turned, true, [3, 2, 1])).expect("the same wedge");
        for p in POINTS {
            let off = minus(motion.apply(p), turned(p));
            assert!(length(off) < 1e-5, "{off:?}");
        }
        assert!(found(&plain, &mesh(|p| p, true, [1, 2, 3])).is_some());
    }

    #[test]
    fn whole_numbers_are_a_design() {
        let scaled = |by: f64| mesh(move |p| p.map(|x| by * x), false, [1, 2, 3]);
        let (plain, longer) = (scaled(100.0), scaled(100.1));
        let mut known = KnownMeshes::new(1.0);
        known.add(MeshId(0), MeshInvariants::of(&plain));
        let meshes = std::slice::from_ref(&plain);
        assert!(known.find(meshes, &longer).is_err());
        assert!(known.find(meshes, &plain).is_ok());
    }

    #[test]
    fn a_mirror_image_or_another_vertex_is_another_mesh() {
        let plain = mesh(|p| p, false, [1, 2, 3]);
        let mut mirrored = mesh(|[x, y, z]| [x, y, -z], true, [1, 2, 3]);
        mirrored.soup.polygons.turn_over();
        assert!(found(&plain, &mirrored).is_none());
        let moved =
            |p: [f64; 3]| if p == POINTS[5] { turned([0.0, 5.0, 1.000005]) } else { turned(p) };
        assert!(found(&plain, &mesh(moved, true, [1, 2, 3])).is_none());
        let mut bare = mesh(turned, true, [1, 2, 3]);
        bare.colour = None;
        assert!(found(&plain, &bare).is_none());
    }
}
