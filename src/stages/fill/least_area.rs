//! The triangulation of least area of a closed polygon, refined to the target edge length. It stays
//! near the polygon, whatever the shape of this.

use crate::geometry::{Point, Vector};
use crate::mesh::least_area::RimPolygon;
use crate::mesh::remesh::{RimTriangulation, Sizes};

/// Triangulates a closed polygon, which is counter-clockwise seen from the outer side of the
/// surface. `beside` has the unit normal of the surface beside each side; `joined` says
/// whether two corners are joined by an edge already, or are the same vertex. `None` if a
/// number is not finite.
pub(super) fn triangulate(
    rim: &[Point],
    beside: &[Vector],
    joined: impl Fn(usize, usize) -> bool,
    sizes: &Sizes,
) -> Option<RimTriangulation> {
    let polygon = RimPolygon { rim, beside, joined: &joined };
    let triangles = polygon.triangles();
    let (points, triangles) = triangles.map_or_else(|| fan(rim), |t| (rim.to_vec(), t));
    let of_side = |i: usize| ((i, (i + 1) % rim.len()), beside[i]);
    let beside = (0..rim.len()).map(of_side).collect();
    let mut surface = RimTriangulation { points, triangles, rim: rim.len(), beside };
    surface.refine(sizes, |i, j| i.max(j) < rim.len() && joined(i, j));
    surface.points.iter().all(|p| p.iter().all(|x| x.is_finite())).then_some(surface)
}

/// A fan of triangles around the mean of the corners, which joins no two of them.
fn fan(rim: &[Point]) -> (Vec<Point>, Vec<[usize; 3]>) {
    let n = rim.len();
    let mean = rim.iter().map(|p| p.coords).sum::<Vector>() / n as f64;
    let points = [rim, &[Point::from(mean)]].concat();
    (points, (0..n).map(|i| [i, (i + 1) % n, n]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The outline of a bent strip: two arcs.
    fn strip(n: usize) -> Vec<Point> {
        let at = |i: usize, z: f64| {
            let angle = 4.0 * i as f64 / (n - 1) as f64;
            Point::new(10.0 * angle.cos(), 10.0 * angle.sin(), z)
        };
        (0..n).map(|i| at(i, 0.0)).chain((0..n).rev().map(|i| at(i, 1.0))).collect()
    }

    #[test]
    fn a_bent_strip_is_triangulated_along_itself() {
        for (n, within) in [(40, 0.02), (900, 0.2)] {
            let rim = strip(n);
            let outwards = |p: &Point| Vector::new(p.x, p.y, 0.0).normalize();
            let beside: Vec<Vector> = rim.iter().map(outwards).collect();
            let sizes = Sizes::new(std::slice::from_ref(&rim));
            let strip = triangulate(&rim, &beside, |_, _| false, &sizes).unwrap();
            assert_eq!(strip.triangles.len(), 2 * strip.points.len() - rim.len() - 2);
            let area = |t: &[usize; 3]| {
                let [a, b, c] = t.map(|v| strip.points[v]);
                0.5 * (b - a).cross(&(c - a)).norm()
            };
            let total = strip.triangles.iter().map(area).sum::<f64>();
            assert!((total / 40.0 - 1.0).abs() < within, "{total}");
        }
    }

    #[test]
    fn wide_polygons_are_graded() {
        let at = |i: i32| {
            let angle = std::f64::consts::TAU * f64::from(i) / 500.0;
            Point::new(angle.cos(), angle.sin(), 0.1 * (2.0 * angle).cos())
        };
        let rim: Vec<Point> = (0..500).map(at).collect();
        let sizes = Sizes::new(std::slice::from_ref(&rim));
        let disk = triangulate(&rim, &vec![Vector::z(); 500], |_, _| false, &sizes).unwrap();
        // With edges as short as those of the rim there would be 20,000.
        assert!((600..6000).contains(&disk.points.len()), "{}", disk.points.len());
    }

    #[test]
    fn corners_that_may_not_be_joined_are_not() {
        let rim = strip(4);
        let beside = vec![Vector::zeros(); rim.len()];
        let sizes = Sizes::new(std::slice::from_ref(&rim));
        for allowed in [|_, _| false, |i: usize, j: usize| i.min(j) == 0] {
            let surface = triangulate(&rim, &beside, |i, j| !allowed(i, j), &sizes).unwrap();
            let sides = surface.triangles.iter();
            let sides = sides.flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
            for (i, j) in sides.filter(|s| s.0.max(s.1) < 8) {
                assert!(allowed(i, j) || (i + 1) % 8 == j || (j + 1) % 8 == i, "{i} {j}");
            }
        }
    }
}
