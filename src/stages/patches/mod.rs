//! Exact patches of a subdivision surface.
//!
//! A subdivision surface over a quad mesh in blocks goes in. A [`Network`] of bicubic B-spline
//! surfaces comes out, one for each block. On quads whose four vertices are regular the patches are
//! the subdivision surface itself. Next to an irregular vertex, where it is no spline, they
//! approximate it: first the sides of the patches (`tracks.rs`), then four control points at each
//! corner (`corners.rs`). Neighbours then agree on their tangent planes (`agreement.rs`). Patches
//! share their sides exactly, as the outer rows of their nets are the control points of the sides
//! (Loop, Schaefer, "Approximating Catmull-Clark subdivision surfaces with bicubic patches", 2008,
//! has the same idea with coarser pieces).

mod agreement;
mod corners;
mod pieces;
mod tracks;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::geometry::{Point, Quarter, Vector, VertexId};
use crate::mesh::QuadMesh;
use crate::spline::subdivision::{SubdivisionSurface, limit_point};
use crate::spline::{KnotVector, Network, Side, Surface, Track};
use corners::CornerFit;
use pieces::Pieces;

/// The results of the extraction.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Report {
    /// The number of patches.
    pub patches: usize,
    /// The number of irregular vertices.
    pub irregular: usize,
}

/// The least number of quads along a side of a block. With fewer, the ends of a side would not be
/// independent of each other.
const LEAST_SIDE: usize = 4;

/// The number by which the control points along a side of a patch exceed its quads: one for each of the two more knots at
/// both ends, and the degree.
const MORE_THAN_QUADS: usize = 7;

/// The number of control points of the patch of a block of `side` × `side` quads.
pub(crate) fn control_points(side: usize) -> usize {
    (side + MORE_THAN_QUADS).pow(2)
}

/// The most quads along a side of a block whose patch has no more than so many control points.
pub(crate) fn largest_side(control_points: usize) -> usize {
    control_points.isqrt().saturating_sub(MORE_THAN_QUADS)
}

/// What the parts of this stage read.
struct PatchSource<'a> {
    mesh: &'a QuadMesh,
    surface: &'a SubdivisionSurface,
    control: &'a [Vector],
    /// The knot vector of all tracks, and of all patches in both directions.
    knots: KnotVector,
}

/// Cuts a subdivision surface into patches. The points of the mesh are its control points.
///
/// # Errors
/// [`Error::Input`] if the blocks have fewer than 4 × 4 quads.
pub fn extract(mesh: &QuadMesh, surface: &SubdivisionSurface) -> Result<(Network, Report)> {
    if mesh.side < LEAST_SIDE {
        return Err(Error::Input("the blocks of a quad mesh are too small for patches"));
    }
    let control: Vec<Vector> = mesh.points.iter().map(|p| p.coords).collect();
    let source = PatchSource { mesh, surface, control: &control, knots: knots(mesh.side) };
    let mut corner_of = vec![usize::MAX; mesh.points.len()];
    let mut corners = Vec::new();
    for v in (0..mesh.blocks()).flat_map(|b| (0..4).map(move |k| mesh.corner(b, k))) {
        if corner_of[v.index()] == usize::MAX {
            corner_of[v.index()] = corners.len();
            corners.push(source.limit(v));
        }
    }
    let (places, sides) = source.sides();
    let track = |&(block, k): &(usize, usize)| Track {
        curve: source.track(block, k),
        ends: [mesh.corner(block, k), mesh.corner(block, (k + 1) % 4)]
            .map(|v| corner_of[v.index()]),
    };
    let tracks: Vec<Track> = places.par_iter().map(track).collect();
    let surfaces = (0..mesh.blocks()).into_par_iter().map(|b| source.patch(b, sides[b], &tracks));
    let mut patches: Vec<FittedPatch> = surfaces.collect();
    agreement::agree(&source, &mut patches);
    let surfaces: Vec<Surface> = patches.into_iter().map(|patch| patch.surface).collect();
    let irregular = mesh.valences().iter().filter(|&&n| n != 4).count();
    let report = Report { patches: surfaces.len(), irregular };
    Ok((Network { surfaces, sides, tracks, corners }, report))
}

/// The knots over a side of `n` quads: the vertices, and two more in the first and the last quad,
/// where the surface near an irregular vertex is no polynomial.
fn knots(n: usize) -> KnotVector {
    let end = n as f64;
    let mut breaks = vec![0.0, 0.25, 0.5];
    breaks.extend((1..n).map(|i| i as f64));
    breaks.extend([end - 0.5, end - 0.25, end]);
    KnotVector::clamped(3, &breaks, 1)
}

/// A patch, and the fits at its corners in irregular vertices.
struct FittedPatch {
    surface: Surface,
    fits: [Option<CornerFit>; 4],
}

impl PatchSource<'_> {
    fn limit(&self, v: VertexId) -> Point {
        let (quad, k) = self.surface.corner(v);
        limit_point(&self.surface.ring(quad, k), self.control)
    }

    /// The quad of a block at step `t` along side `k`, counter-clockwise.
    fn quad_at(&self, block: usize, k: usize, t: usize) -> usize {
        let n = self.mesh.side;
        let [i, j] = Quarter(k).turned(n - 1, [t, 0]);
        n * n * block + n * j + i
    }

    /// The tracks as the block and the side along which they run forward, and the sides of every
    /// block.
    fn sides(&self) -> (Vec<(usize, usize)>, Vec<[Side; 4]>) {
        let per_block = self.mesh.side * self.mesh.side;
        let mut places = Vec::new();
        let none = Side { track: usize::MAX, forward: true };
        let mut sides = vec![[none; 4]; self.mesh.blocks()];
        for (block, k) in (0..4 * self.mesh.blocks()).map(|s| (s / 4, s % 4)) {
            if sides[block][k] != none {
                continue;
            }
            let (quad, other) = self.surface.across(self.quad_at(block, k, 0), k);
            sides[block][k] = Side { track: places.len(), forward: true };
            sides[quad / per_block][other] = Side { track: places.len(), forward: false };
            places.push((block, k));
        }
        (places, sides)
    }

    /// The patch of a block.
    fn patch(&self, block: usize, sides: [Side; 4], tracks: &[Track]) -> FittedPatch {
        let count = self.knots.functions();
        let pieces = Pieces::new(self, block);
        let mut net = vec![Vector::zeros(); count * count];
        for (i, j) in (0..count * count).map(|k| (k / count, k % count)) {
            net[i * count + j] = pieces.control(&self.knots, i, j).unwrap_or_default();
        }
        for (k, side) in sides.into_iter().enumerate() {
            let row = &tracks[side.track].curve.control;
            for t in 0..count {
                let [i, j] = Quarter(k).turned(count - 1, [t, 0]);
                net[i * count + j] = if side.forward { row[t] } else { row[count - 1 - t] };
            }
        }
        let mut surface = Surface::new(self.knots.clone(), self.knots.clone(), net);
        let fits = [0, 1, 2, 3].map(|k| self.fit_corner(block, k, &mut surface));
        FittedPatch { surface, fits }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_control_points_of_a_patch_are_known_before_it_is_made() {
        for side in LEAST_SIDE..20 {
            assert_eq!(control_points(side), knots(side).functions().pow(2));
            assert_eq!(largest_side(control_points(side)), side);
            assert_eq!(largest_side(control_points(side) - 1), side - 1);
        }
    }
}
