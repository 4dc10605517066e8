//! The triangulation of least area of a closed polygon (Barequet & Sharir 1995, "Filling gaps
//! in the boundary of a polyhedron"), with a cost for folded edges (as in Liepa 2003, "Filling
//! holes in meshes"), refined to the target edge length. It stays near the polygon, whatever
//! the shape of this.

use crate::geometry::{Point, Vector};
use crate::mesh::remesh::{RimTriangulation, Sizes};

/// The most corners that are triangulated at once, because the time grows with the cube of
/// their number. Of a larger polygon every second corner, or third and so on, is triangulated,
/// and then the corners between two of these.
const MOST_CORNERS: usize = 600;

/// Triangulates a closed polygon, which is counter-clockwise seen from the outer side of the
/// surface. `beside` has the unit normal of the surface beside each side; `joined` says
/// whether two corners are joined by an edge already, or are the same vertex. `None` if a
/// number is not finite.
pub fn triangulate(
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

struct RimPolygon<'a> {
    rim: &'a [Point],
    beside: &'a [Vector],
    joined: &'a dyn Fn(usize, usize) -> bool,
}

/// The part of a polygon between two corners: the least cost of its triangulation, and the
/// third corner and the normal of its triangle at the chord between the two.
#[derive(Clone, Copy)]
struct SubPolygon {
    cost: f64,
    apex: usize,
    normal: Vector,
}

impl RimPolygon<'_> {
    /// `None` if every triangulation would join two corners that are joined already.
    fn triangles(&self) -> Option<Vec<[usize; 3]>> {
        let n = self.rim.len();
        let step = n.div_ceil(MOST_CORNERS);
        let corners: Vec<usize> = (0..n).step_by(step).collect();
        let mut triangles = self.least(&corners)?;
        for (k, &first) in corners.iter().enumerate() {
            let last = corners.get(k + 1).map_or(n, |&next| next);
            let along: Vec<usize> = (first..=last).map(|i| i % n).collect();
            if along.len() > 2 {
                if (self.joined)(first, last % n) {
                    return None;
                }
                triangles.extend(self.least(&along)?);
            }
        }
        Some(triangles)
    }

    /// The triangulation of least cost over some of the corners.
    fn least(&self, corners: &[usize]) -> Option<Vec<[usize; 3]>> {
        let n = corners.len();
        let at = |i: usize| self.rim[corners[i]];
        let beside = |i: usize| {
            let (v, w) = (corners[i], corners[(i + 1) % n]);
            if (v + 1) % self.rim.len() == w { self.beside[v] } else { Vector::zeros() }
        };
        let side = |i: usize| SubPolygon { cost: 0.0, apex: 0, normal: beside(i) };
        let mut best =
            vec![SubPolygon { cost: f64::INFINITY, apex: 0, normal: Vector::zeros() }; n * n];
        (0..n).for_each(|i| best[i * n + (i + 1) % n] = side(i));
        let last = side(n - 1);
        for (i, j) in (2..n).flat_map(|gap| (0..n - gap).map(move |i| (i, i + gap))) {
            let whole = (i, j) == (0, n - 1);
            if !whole && (self.joined)(corners[i], corners[j]) {
                continue;
            }
            let chord = at(j) - at(i);
            let mut least = SubPolygon { cost: f64::INFINITY, ..last };
            for k in i + 1..j {
                let (left, right) = (&best[i * n + k], &best[k * n + j]);
                let cross = (at(k) - at(i)).cross(&chord);
                let area = cross.norm();
                let bound = left.cost + right.cost + area;
                if bound >= least.cost {
                    continue;
                }
                let normal = cross / area.max(f64::MIN_POSITIVE);
                let fold = |other: &Vector, from: usize, to: usize| {
                    (at(to) - at(from)).norm_squared() * (-normal.dot(other)).max(0.0)
                };
                let closing = if whole { fold(&last.normal, j, i) } else { 0.0 };
                let cost = bound + fold(&left.normal, i, k) + fold(&right.normal, k, j) + closing;
                if cost < least.cost {
                    least = SubPolygon { cost, apex: k, normal };
                }
            }
            best[i * n + j] = least;
        }
        let mut triangles = Vec::with_capacity(n - 2);
        let mut open = vec![(0, n - 1)];
        while let Some((i, j)) = open.pop() {
            if j - i > 1 {
                let SubPolygon { cost, apex, .. } = best[i * n + j];
                if !cost.is_finite() {
                    return None;
                }
                triangles.push([i, apex, j].map(|k| corners[k]));
                open.extend([(i, apex), (apex, j)]);
            }
        }
        Some(triangles)
    }
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
