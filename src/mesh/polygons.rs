//! Triangulation of polygons.
//!
//! A polygon that is convex in its plane, by exact predicates, becomes a fan of triangles. Any
//! other polygon is triangulated by the constrained Delaunay triangulation of its outline. The
//! triangles inside the outline remain, where inside means that a ray crosses the outline an odd
//! number of times. An outline may run along an edge twice, as the cut to an island does; such an
//! edge counts twice. An outline that crosses itself bounds no region; it becomes a fan as well.

use formats::Soup;

use super::build::{Repairs, count};
use super::outline;
use super::weld::Welded;
use crate::geometry::{NONE, Point, Uv, Vector, VertexId, orient2d};

/// The triangles of all polygons, in the order of the polygons.
pub(super) fn triangulate(
    soup: &Soup,
    welded: &Welded,
    repairs: &mut Repairs,
) -> Vec<[VertexId; 3]> {
    let mut triangles = Vec::with_capacity(soup.polygons.triangle_count());
    let (mut lost, mut degenerate, mut cut, mut crossed) = (0, 0, 0, 0);
    let mut corners: Vec<u32> = Vec::new();
    for polygon in soup.polygons.iter() {
        corners.clear();
        corners.extend(polygon.iter().map(|&i| welded.number[i as usize]));
        if corners.contains(&NONE) {
            lost += 1;
        } else if corners.len() < 3 {
            degenerate += 1;
        } else if let [a, b, c] = corners[..] {
            triangles.push([a, b, c].map(VertexId));
        } else {
            cut += 1;
            corners.dedup();
            crossed += usize::from(!cut_up(&welded.points, &corners, &mut triangles));
        }
    }
    count(repairs, "faces_with_non_finite_vertices", lost);
    count(repairs, "degenerate_faces", degenerate);
    count(repairs, "polygons_triangulated", cut);
    count(repairs, "polygons_that_cross_themselves", crossed);
    triangles
}

/// Appends the triangles of one polygon. Returns `false` if the outline crosses itself.
pub(crate) fn cut_up(points: &[Point], polygon: &[u32], into: &mut Vec<[VertexId; 3]>) -> bool {
    let flat = flatten(points, polygon);
    let fan = |k| [0, k - 1, k];
    let (triangles, sound) = match is_convex(&flat) {
        true => ((2..polygon.len()).map(fan).collect(), true),
        false => match outline::triangulate(&[&flat], &[]) {
            Some(inside) => (inside, true),
            None => ((2..polygon.len()).map(fan).collect::<Vec<_>>(), false),
        },
    };
    into.extend(triangles.iter().map(|t| t.map(|k| VertexId(polygon[k]))));
    sound
}

/// Projects the polygon along the coordinate axis nearest to its normal (Newell's method), so that
/// it runs counter-clockwise. The projected coordinates are exact.
fn flatten(points: &[Point], polygon: &[u32]) -> Vec<Uv> {
    let at = |k: usize| points[polygon[k % polygon.len()] as usize];
    let origin = at(0);
    let spokes = |k: usize| (at(k) - origin).cross(&(at(k + 1) - origin));
    let normal: Vector = (1..polygon.len()).map(spokes).sum();
    let axis = normal.iamax();
    let (u, v) = match (axis, normal[axis] < 0.0) {
        (0, false) => (1, 2),
        (0, true) => (2, 1),
        (1, false) => (2, 0),
        (1, true) => (0, 2),
        (_, false) => (0, 1),
        (_, true) => (1, 0),
    };
    (0..polygon.len()).map(|k| Uv::new(at(k)[u], at(k)[v])).collect()
}

/// Whether the polygon turns left at every corner and winds around its interior once.
fn is_convex(flat: &[Uv]) -> bool {
    let n = flat.len();
    let left = |k: usize| orient2d(flat[k], flat[(k + 1) % n], flat[(k + 2) % n]) > 0.0;
    // A star polygon turns left at every corner, too. Seen from its first corner, however, its
    // sides go back and forth.
    let fanned = (2..n).all(|k| orient2d(flat[0], flat[k - 1], flat[k]) > 0.0);
    fanned && (0..n).all(left)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[[f64; 2]], polygon: &[u32]) -> (usize, f64, bool) {
        let points: Vec<Point> = points.iter().map(|p| Point::new(p[0], p[1], 0.5)).collect();
        let mut triangles = Vec::new();
        let sound = cut_up(&points, polygon, &mut triangles);
        let area = |t: &[VertexId; 3]| {
            let [a, b, c] = t.map(|v| points[v.index()]);
            (b - a).cross(&(c - a)).z / 2.0
        };
        assert!(!sound || triangles.iter().all(|t| area(t) > 0.0), "{triangles:?}");
        (triangles.len(), triangles.iter().map(area).sum(), sound)
    }

    #[test]
    fn a_convex_polygon_is_fanned() {
        let square = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]];
        assert_eq!(area(&square, &[0, 1, 2, 3]), (2, 1.0, true));
    }

    #[test]
    fn a_dent_and_a_straight_corner_stay_in_the_outline() {
        let dart = [[0., 0.], [2., 1.], [0., 2.], [1., 1.]];
        assert_eq!(area(&dart, &[0, 1, 2, 3]), (2, 1.0, true));
        let straight = [[0., 0.], [1., 0.], [2., 0.], [2., 2.], [0., 2.]];
        assert_eq!(area(&straight, &[0, 1, 2, 3, 4]), (3, 4.0, true));
    }

    #[test]
    fn a_comb_keeps_its_teeth() {
        let mut points = vec![[0., -1.]];
        for tooth in 0..50 {
            let x = f64::from(tooth);
            points.extend([[x + 0.5, -1.0], [x + 0.5, 3.0], [x + 0.75, 0.0]]);
        }
        points.extend([[50., -1.], [50., -2.], [0., -2.]]);
        let all: Vec<u32> = (0..points.len() as u32).collect();
        let turned: Vec<u32> = all.iter().rev().copied().collect();
        let shoelace: f64 = (0..points.len())
            .map(|i| {
                let (p, q) = (points[i], points[(i + 1) % points.len()]);
                (p[0] * q[1] - p[1] * q[0]) / 2.0
            })
            .sum();
        let (count, found, sound) = area(&points, &turned);
        assert!(sound && count == points.len() - 2, "{count} triangles of {}", points.len());
        assert!((found + shoelace).abs() < 1e-9, "{found} not {}", -shoelace);
    }

    #[test]
    fn a_cut_leads_to_an_island() {
        let points =
            [[0., 0.], [4., 0.], [4., 4.], [0., 4.], [1., 1.], [1., 3.], [3., 3.], [3., 1.]];
        let keyhole = [0, 1, 2, 3, 0, 4, 5, 6, 7, 4];
        assert_eq!(area(&points, &keyhole), (8, 12.0, true));
    }

    #[test]
    fn an_outline_that_crosses_itself_is_fanned_and_said() {
        let points = [[0., 0.], [2., 2.], [2., 0.], [0., 1.]];
        let (count, _, sound) = area(&points, &[0, 1, 2, 3]);
        assert_eq!((count, sound), (2, false));
    }
}
