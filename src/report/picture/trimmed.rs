//! The trimmed face as triangles.

use crate::geometry::{Uv, VertexId};
use crate::mesh::outline;
use crate::spline::{Curve, KnotVector, Surface};
use crate::stages::trim::TrimLoop;

/// Chords of a knot span of a trim curve: enough to look smooth at any size.
const CHORDS: u32 = 16;

/// Points of each side of the domain, about, and chords of a knot span of it, both
/// at the least.
const SIDE: usize = 256;
const SIDE_CHORDS: usize = 6;

/// Points along a curve, both ends included.
pub fn polyline<const D: usize>(curve: &Curve<D>) -> Vec<nalgebra::SVector<f64, D>> {
    let breaks = curve.knots.breaks();
    let mut line = Vec::with_capacity(CHORDS as usize * breaks.len());
    for span in breaks.windows(2) {
        let at = |i: u32| span[0] + (span[1] - span[0]) * f64::from(i) / f64::from(CHORDS);
        line.extend((0..CHORDS).map(|i| curve.point(at(i))));
    }
    line.extend(breaks.last().map(|&t| curve.point(t)));
    line
}

/// The trim loops in the parameter plane, as closed polylines.
pub fn outlines(loops: &[TrimLoop]) -> Vec<Vec<Uv>> {
    let arc = |c: &Curve<2>| {
        let mut line = polyline(c);
        // It is the next one's first.
        line.pop();
        line
    };
    let outline = |l: &TrimLoop| l.pcurves.iter().flat_map(arc).map(Uv::from).collect();
    loops.iter().map(outline).collect()
}

/// The face that the outlines leave of a surface, as triangles over the parameter
/// points `inner` and points of the outlines, and of the surface's sides if these
/// bound the face (`to_sides`), and the parameters of their corners. `None` where two of these cross.
pub fn tessellate(
    surface: &Surface,
    to_sides: bool,
    outlines: &[Vec<Uv>],
    inner: &[Uv],
) -> Option<(Vec<[VertexId; 3]>, Vec<Uv>)> {
    let sides = to_sides.then(|| sides(surface));
    let rings: Vec<&[Uv]> = sides.iter().chain(outlines).map(Vec::as_slice).collect();
    let inner: Vec<Uv> = inner.iter().map(|&uv| surface.clamp(uv)).collect();
    let triangles = outline::triangulate(&rings, &inner)?;
    let places: Vec<Uv> = rings.iter().copied().flatten().chain(&inner).copied().collect();
    Some((triangles.into_iter().map(|t| t.map(VertexId::from)).collect(), places))
}

/// The domain's outline, counter-clockwise, as dense as its knots.
fn sides(surface: &Surface) -> Vec<Uv> {
    let [us, vs] = [&surface.u, &surface.v].map(parameters);
    let ((u0, u1), (v0, v1)) = (surface.u.range(), surface.v.range());
    // Each side without its last corner, which is the next one's first.
    let lower = us.iter().map(|&u| Uv::new(u, v0)).take(us.len() - 1);
    let right = vs.iter().map(|&v| Uv::new(u1, v)).take(vs.len() - 1);
    let upper = us.iter().rev().map(|&u| Uv::new(u, v1)).take(us.len() - 1);
    let left = vs.iter().rev().map(|&v| Uv::new(u0, v)).take(vs.len() - 1);
    lower.chain(right).chain(upper).chain(left).collect()
}

/// Parameters from end to end, a few a knot span.
fn parameters(knots: &KnotVector) -> Vec<f64> {
    let breaks = knots.breaks();
    let chords = (SIDE / breaks.len()).max(SIDE_CHORDS);
    let within = |w: &[f64]| {
        let (from, to) = (w[0], w[1]);
        (0..chords).map(move |i| from + (to - from) * i as f64 / chords as f64)
    };
    breaks.windows(2).flat_map(within).chain(breaks.last().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;
    use crate::mesh::Mesh;

    #[test]
    fn the_face_has_the_area_that_the_loop_leaves() {
        let k = KnotVector::uniform(3, 5);
        let place = |n: usize| [10.0 * k.greville(n / 5), 10.0 * k.greville(n % 5)];
        let net = (0..25).map(place).map(|[x, y]| Vector::new(x, y, 0.0));
        let surface = Surface::new(k.clone(), k.clone(), net.collect());
        let square = [(0.25, 0.25), (0.25, 0.75), (0.75, 0.75), (0.75, 0.25)];
        let square = vec![square.map(|(u, v)| Uv::new(u, v)).to_vec()];
        let inner: Vec<Uv> =
            (0..100).map(|k| Uv::new((k / 10) as f64 / 9.0, (k % 10) as f64 / 9.0)).collect();
        let (triangles, places) = tessellate(&surface, true, &square, &inner).unwrap();
        let points = places.into_iter().map(|at| surface.point(at)).collect();
        let face = Mesh { points, triangles };
        let area = face.area();
        assert!((area - 75.0).abs() < 1e-9, "{area}");
        assert!(face.triangles.iter().all(|&t| face.area_vector(t).z >= 0.0));
        let crossing =
            vec![vec![Uv::new(0.1, 0.1), Uv::new(0.9, 0.9), Uv::new(0.9, 0.1), Uv::new(0.1, 0.9)]];
        assert!(tessellate(&surface, true, &crossing, &inner).is_none());
    }
}
