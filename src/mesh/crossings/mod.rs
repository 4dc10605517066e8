//! Triangles that go through each other.

mod box_blocks;

use robust::{Coord3D, orient3d};

pub(crate) use box_blocks::{BoxBlock, BoxBlocks, NumberedBox, around, overlap};

use super::Mesh;
use crate::geometry::{Point, ROUNDING, VertexId};

/// The pairs of triangles of a mesh that go through each other.
pub fn crossings(mesh: &Mesh) -> Vec<[usize; 2]> {
    let corners = |t: u32| mesh.corners(mesh.triangles[t as usize]);
    let boxes = (0..mesh.triangles.len() as u32).map(|t| (t, extent(corners(t))));
    let mut found = Vec::new();
    BoxBlocks::new(boxes.collect()).pairs(|s, t| {
        let names = [s, t].map(|t| mesh.triangles[t as usize]);
        if cut(names, [corners(s), corners(t)]) {
            found.push([s.min(t), s.max(t)].map(|t| t as usize));
        }
    });
    found
}

/// The bounding box of a triangle.
pub(crate) fn extent([a, b, c]: [Point; 3]) -> [Point; 2] {
    [a.inf(&b).inf(&c), a.sup(&b).sup(&c)]
}

/// Whether an edge of one of two triangles goes through the other. Edges that end at a common
/// vertex do not count.
pub fn cut([s, t]: [[VertexId; 3]; 2], [at_s, at_t]: [[Point; 3]; 2]) -> bool {
    let shared = s.iter().filter(|v| t.contains(v)).count();
    if shared > 1 || is_beside(at_s, at_t) || is_beside(at_t, at_s) {
        return false;
    }
    let pierces = |s: [VertexId; 3], at_s: [Point; 3], t: [VertexId; 3], at_t| {
        (0..3).any(|k| {
            let l = (k + 1) % 3;
            !t.contains(&s[k]) && !t.contains(&s[l]) && goes_through([at_s[k], at_s[l]], at_t)
        })
    };
    pierces(s, at_s, t, at_t) || pierces(t, at_t, s, at_s)
}

/// Whether a triangle is beyond a side of another one, seen along the normal of the latter, up
/// to rounding. Neighbours are.
fn is_beside([a, b, c]: [Point; 3], other: [Point; 3]) -> bool {
    let normal = (b - a).cross(&(c - a));
    let rounding = ROUNDING * normal.norm();
    [(a, b), (b, c), (c, a)].into_iter().any(|(p, q)| {
        let inwards = normal.cross(&(q - p));
        let nothing = rounding * (q - p).norm_squared();
        other.iter().all(|x| inwards.dot(&(x - p)) <= nothing)
    })
}

/// Whether a segment goes through the interior of a triangle.
fn goes_through([p, q]: [Point; 2], [a, b, c]: [Point; 3]) -> bool {
    if side([a, b, c, p]) * side([a, b, c, q]) >= 0.0 {
        return false;
    }
    let around = [side([p, q, a, b]), side([p, q, b, c]), side([p, q, c, a])];
    around.iter().all(|x| *x > 0.0) || around.iter().all(|x| *x < 0.0)
}

/// The side of a triangle on which a fourth point is, as the sign of the result.
fn side(corners: [Point; 4]) -> f64 {
    let [a, b, c, d] = corners.map(|p| Coord3D { x: p.x, y: p.y, z: p.z });
    orient3d(a, b, c, d)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;

    /// Two tetrahedra, the second one moved.
    fn two(by: Vector) -> Mesh {
        let corners =
            [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point::from);
        let sides = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let moved = corners.map(|p| p + by);
        let triangle = |first: usize| move |t: [usize; 3]| t.map(|v| VertexId::from(v + first));
        Mesh {
            points: corners.into_iter().chain(moved).collect(),
            triangles: sides.map(triangle(0)).into_iter().chain(sides.map(triangle(4))).collect(),
        }
    }

    #[test]
    fn bodies_that_overlap_cross_and_others_do_not() {
        assert!(!crossings(&two(Vector::new(0.2, 0.15, 0.1))).is_empty());
        assert!(crossings(&two(Vector::new(1.1, 0.0, 0.0))).is_empty());
        // One body inside the other does not cross it.
        let mut inside = two(Vector::zeros());
        inside.points[4..].iter_mut().for_each(|p| *p = Point::new(0.1, 0.1, 0.1) + 0.1 * p.coords);
        assert!(crossings(&inside).is_empty());
    }
}
