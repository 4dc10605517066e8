//! One ratio tells the mesh of a CAD program from a scan.

use super::tessellation::Tessellation;

/// How many pairs of neighbouring triangles are flat within the rounding of the file, and how many nearly so.
///
/// Any smooth density of errors puts about nine times as many pairs between one and ten roundings as below one. A
/// mesh whose vertices are exact has a hole above one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FlatPairs {
    /// Pairs that are flat within the rounding.
    pub exact: usize,
    /// Pairs that are off by one to ten times the rounding.
    pub near: usize,
}

/// Pairs that turn more are creases and say nothing about precision.
const LEAST_COSINE: f64 = 0.766;

/// Pairs up to so many roundings off are nearly flat. Noise puts `NEAR - 1` times as many there as below one.
const NEAR: f64 = 10.0;

/// So few pairs say nothing: two exact pairs and no near one happen by noise once in a hundred parts.
const FEWEST_PAIRS: usize = 3;

impl FlatPairs {
    /// Counts the pairs of a mesh.
    pub fn of(mesh: &Tessellation) -> Self {
        FlatPairs::within(mesh, 1.0)
    }

    /// The same with errors that are so many times as large.
    pub(super) fn within(mesh: &Tessellation, factor: f64) -> Self {
        (0..mesh.areas.len() as u32).fold(FlatPairs::default(), |mut pairs, t| {
            pairs.add(mesh, factor, t);
            pairs
        })
    }

    /// Adds the pairs of a triangle with its later neighbours.
    fn add(&mut self, mesh: &Tessellation, factor: f64, t: u32) {
        for (other, side) in mesh.across(t).filter(|&(other, _)| other > t) {
            if mesh.normals[t as usize].dot(&mesh.normals[other as usize]) < LEAST_COSINE {
                continue;
            }
            match bend(mesh, factor, t, other, side) {
                Some(z) if z <= 1.0 => self.exact += 1,
                Some(z) if z <= NEAR => self.near += 1,
                _ => {}
            }
        }
    }

    /// Whether vertices lie on their surfaces within the rounding. `None` if too few pairs tell.
    pub fn is_clean(&self) -> Option<bool> {
        (self.exact + self.near >= FEWEST_PAIRS).then_some(self.exact > self.near)
    }
}

/// How far the four vertices of a pair are from a plane, in units of the bound that their errors set. `None` if the triangles are
/// so small that any turn short of a crease is nearly flat: such a pair tells nothing.
fn bend(mesh: &Tessellation, factor: f64, t: u32, other: u32, side: usize) -> Option<f64> {
    let [a, b] = mesh.ends(side);
    let opposite = |t: u32| mesh.corners(t).into_iter().find(|&v| v != a && v != b);
    let corners = [a, b, opposite(t)?, opposite(other)?];
    let [p, q, r, s] = corners.map(|v| mesh.point(v));
    let volume = (q - p).cross(&(r - p)).dot(&(s - p)).abs();
    let faces = [[q, r, s], [p, r, s], [p, q, s], [p, q, r]];
    let weights = faces.map(|[x, y, z]| (y - x).cross(&(z - x)).norm());
    let bound: f64 = corners.iter().zip(weights).map(|(&v, w)| factor * mesh.error(v) * w).sum();
    // Two triangles that turn by an angle span a volume of this height times its sine.
    let edge = (q - p).norm();
    let most =
        mesh.areas[t as usize] * mesh.areas[other as usize] / edge * LEAST_COSINE.acos().sin();
    (bound > 0.0 && most > NEAR * bound).then(|| volume / bound)
}
