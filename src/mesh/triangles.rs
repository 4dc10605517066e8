//! Distances from points to the triangles of a mesh, by an R-tree.

use rstar::{AABB, PointDistance, RTree, RTreeObject};

use super::Mesh;
use crate::geometry::{Point, bounds};

/// The triangles of a mesh, indexed by their positions.
pub(crate) struct Triangles(RTree<Triangle>);

struct Triangle {
    corners: [Point; 3],
    number: usize,
}

impl Triangles {
    pub(crate) fn new(mesh: &Mesh) -> Self {
        Triangles::some(mesh, 0..mesh.triangles.len())
    }

    /// Those with the given positions.
    pub(crate) fn some(mesh: &Mesh, numbers: impl Iterator<Item = usize>) -> Self {
        let triangle =
            |number: usize| Triangle { corners: mesh.corners(mesh.triangles[number]), number };
        Triangles(RTree::bulk_load(numbers.map(triangle).collect()))
    }

    /// The distance from `p` to the nearest triangle, in mm, and the number of this triangle.
    pub(crate) fn nearest(&self, p: Point) -> (f64, usize) {
        // `nearest_neighbor` of rstar can miss the nearest triangle where distances are nearly
        // equal.
        let nearest = self.0.nearest_neighbor_iter(p.coords.into()).next();
        nearest.map_or((f64::INFINITY, 0), |t| ((nearest_on(t.corners, p) - p).norm(), t.number))
    }
}

impl RTreeObject for Triangle {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        let [low, high] = bounds(self.corners.iter().copied());
        AABB::from_corners(low.coords.into(), high.coords.into())
    }
}

impl PointDistance for Triangle {
    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        let p = Point::from(*point);
        (nearest_on(self.corners, p) - p).norm_squared()
    }
}

/// The point of a triangle nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
pub(crate) fn nearest_on([a, b, c]: [Point; 3], p: Point) -> Point {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(&(p - a)), ac.dot(&(p - a)));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let (d3, d4) = (ab.dot(&(p - b)), ac.dot(&(p - b)));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let (d5, d6) = (ab.dot(&(p - c)), ac.dot(&(p - c)));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vc = d1 * d4 - d3 * d2;
    // A side whose ends are at one place is left to the others.
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        return a + ab * (d1 / (d1 - d3));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 && d4 - d3 > d6 - d5 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    // The sum is zero for a triangle without an area, whose corner `a` is then near enough.
    let sum = (va + vb + vc).max(f64::MIN_POSITIVE);
    a + ab * (vb / sum) + ac * (vc / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_at_one_place_have_a_nearest_point() {
        let [a, b] = [Point::origin(), Point::new(2.0, 0.0, 0.0)];
        for t in [[a, a, b], [a, b, a], [b, a, a], [a, a, a]] {
            let found = nearest_on(t, Point::new(1.0, 1.0, 0.0));
            let on_side = if t == [a; 3] { a } else { Point::new(1.0, 0.0, 0.0) };
            assert!((found - on_side).norm() < 1e-12, "{t:?}: {found}");
        }
    }

    #[test]
    fn the_nearest_point_beats_every_sample() {
        let corner = Point::new;
        let t = [corner(0.0, 0.0, 0.0), corner(4.0, 1.0, 0.5), corner(1.0, 3.0, -1.0)];
        for k in 0..1000 {
            let at = |n: i32| f64::from(k * n % 97) / 12.0 - 4.0;
            let p = Point::new(at(1), at(31), at(59));
            let found = (nearest_on(t, p) - p).norm();
            let mut best = f64::INFINITY;
            for i in 0..=60 {
                for j in 0..=60 - i {
                    let (x, y) = (f64::from(i) / 60.0, f64::from(j) / 60.0);
                    let q = t[0] + (t[1] - t[0]) * x + (t[2] - t[0]) * y;
                    best = best.min((q - p).norm());
                }
            }
            assert!(found <= best + 1e-12 && found > best - 0.1, "{found} against {best}");
        }
    }
}
