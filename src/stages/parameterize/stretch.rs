//! The stretch of a map (Sander, Snyder, Gortler, Hoppe, "Texture mapping progressive meshes",
//! 2001).

use rayon::prelude::*;

use crate::geometry::{BLOCK, Point, ROUNDING, Uv, Vector};
use crate::mesh::Patch;

/// The stretch of the map from the parameter plane to the measured triangles. It is 1 for an
/// isometry. The unit square is first scaled to the rectangle with the least stretch.
#[derive(Debug, Clone, Copy, Default)]
#[non_exhaustive]
pub struct Stretch {
    /// The root mean square of the stretch over directions and area-weighted triangles.
    pub l2: f64,
    /// The largest singular value of the map of any triangle.
    pub max: f64,
    /// The ratio of width to height of the rectangle.
    pub aspect: f64,
}

/// For one triangle: its area in space, its area in the plane, ∂S/∂u and ∂S/∂v.
pub(crate) type Derivatives = (f64, f64, Vector, Vector);

/// The derivatives on one triangle, from the positions of its corners. Twice its area in the plane
/// is taken to be at least `least`.
pub(crate) fn derivatives([p, q, r]: [Point; 3], [a, b, c]: [Uv; 3], least: f64) -> Derivatives {
    let (d, e) = (b - a, c - a);
    let twice = (d.x * e.y - d.y * e.x).max(least);
    let su = ((q - p) * e.y - (r - p) * d.y) / twice;
    let sv = ((r - p) * d.x - (q - p) * e.x) / twice;
    (0.5 * (q - p).cross(&(r - p)).norm(), 0.5 * twice, su, sv)
}

/// Divides items into blocks whose sums are computed in parallel.
pub(crate) fn blocks<T: Sync>(all: &[T]) -> impl IndexedParallelIterator<Item = &[T]> {
    all.par_chunks(BLOCK)
}

/// The factor by which the width of the parameter plane should grow, with constant area, for the
/// least stretch. The triangles are given in blocks.
pub(crate) fn best_width(
    points: &[Point],
    at: &[Uv],
    blocks: impl IndexedParallelIterator<Item = impl Iterator<Item = [u32; 3]>>,
) -> f64 {
    least(together(blocks.map(|block| sums(derivatives_of(points, at, block))))).0
}

/// The L² stretch of a map, on the rectangle with the least stretch.
pub(super) fn of(points: &[Point], at: &[Uv], triangles: impl Iterator<Item = [u32; 3]>) -> f64 {
    least(sums(derivatives_of(points, at, triangles))).1
}

/// The share of a map's area on which the ratio of the two stretches exceeds `ratio`.
pub(crate) fn drawn_out(
    points: &[Point],
    at: &[Uv],
    triangles: impl Iterator<Item = [u32; 3]>,
    ratio: f64,
) -> f64 {
    let add = |(all, drawn): (f64, f64), t: Derivatives| {
        let [large, small] = squared_stretches(t.2, t.3);
        let is_drawn = large > ratio * ratio * small;
        (all + t.1, if is_drawn { drawn + t.1 } else { drawn })
    };
    let (all, drawn) = derivatives_of(points, at, triangles).fold((0.0, 0.0), add);
    drawn / all
}

/// The squares of the singular values of the map with these derivatives.
fn squared_stretches(su: Vector, sv: Vector) -> [f64; 2] {
    let (a, b, c) = (su.norm_squared(), su.dot(&sv), sv.norm_squared());
    let root = ((a - c).powi(2) + 4.0 * b * b).sqrt();
    [0.5 * (a + c + root), 0.5 * (a + c - root)]
}

/// The area of a surface.
pub(super) fn area(points: &[Point], triangles: impl Iterator<Item = [u32; 3]>) -> f64 {
    triangles
        .map(|t| {
            let [p, q, r] = t.map(|v| points[v as usize]);
            0.5 * (q - p).cross(&(r - p)).norm()
        })
        .sum()
}

fn derivatives_of(
    points: &[Point],
    at: &[Uv],
    triangles: impl Iterator<Item = [u32; 3]>,
) -> impl Iterator<Item = Derivatives> {
    triangles.map(|t| {
        let at = t.map(|v| at[v as usize]);
        derivatives(t.map(|v| points[v as usize]), at, f64::MIN_POSITIVE)
    })
}

/// The area in space, the area in the plane, and the integrals of |∂S/∂u|² and |∂S/∂v|² over the
/// area in space.
fn sums(all: impl Iterator<Item = Derivatives>) -> [f64; 4] {
    let add = |[a, f, u, v]: [f64; 4], t: Derivatives| {
        [a + t.0, f + t.1, u + t.0 * t.2.norm_squared(), v + t.0 * t.3.norm_squared()]
    };
    all.fold([0.0; 4], add)
}

/// The sum over all blocks.
fn together(blocks: impl IndexedParallelIterator<Item = [f64; 4]>) -> [f64; 4] {
    let blocks: Vec<[f64; 4]> = blocks.collect();
    blocks.iter().fold([0.0; 4], |sum, block| std::array::from_fn(|k| sum[k] + block[k]))
}

/// The width w of the rectangle w × 1/w with the least stretch, computed from these sums, and its
/// L² stretch.
fn least([area, flat, along_u, along_v]: [f64; 4]) -> (f64, f64) {
    // The minimum is at w⁴ = along_u / along_v.
    let w = (along_u / along_v).powf(0.25);
    let squares = 0.5 * (along_u / (w * w) + along_v * w * w) / area;
    (w, (flat / area).sqrt() * squares.sqrt())
}

/// Measures the stretch of a map.
pub(crate) fn measure(patch: &Patch, uv: &[Uv]) -> Stretch {
    // A triangle that rounding has flattened still has a finite stretch.
    let flattest = ROUNDING / uv.len() as f64;
    let of = |t: usize| {
        let corners = patch.mesh.triangles[t];
        derivatives(patch.mesh.corners(corners), corners.map(|v| uv[v.index()]), flattest)
    };
    let measured: Vec<usize> = patch.measured_triangles().collect();
    let all: Vec<Derivatives> = measured.into_par_iter().map(of).collect();
    let sums = together(blocks(&all).map(|block| sums(block.iter().copied())));
    let (w, l2) = least(sums);
    let scale = (sums[1] / sums[0]).sqrt();
    let largest = |t: &Derivatives| squared_stretches(t.2 / w, t.3 * w)[0].sqrt();
    Stretch { l2, max: scale * all.par_iter().map(largest).reduce(|| 0.0, f64::max), aspect: w * w }
}
