//! Triangulates the region inside closed polygons in the plane, by a constrained Delaunay
//! triangulation.

use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};

use crate::geometry::{Uv, orient2d};

type Delaunay = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// The triangles inside closed outlines. A point is inside if a ray from it crosses the outlines an
/// odd number of times. Corner numbers count the corners of the outlines in turn and then the
/// `inner` points. Returns `None` if two sides cross or if nothing is inside.
pub(crate) fn triangulate(outlines: &[&[Uv]], inner: &[Uv]) -> Option<Vec<[usize; 3]>> {
    let mut plane = Delaunay::new();
    // For each vertex of the triangulation, the number of a corner at this place.
    let mut corner = Vec::new();
    let mut vertices = Vec::new();
    for (k, p) in outlines.iter().copied().flatten().chain(inner).enumerate() {
        let vertex = plane.insert(Point2::new(p.x, p.y)).ok()?;
        if vertex.index() == corner.len() {
            corner.push(k);
        }
        vertices.push(vertex);
    }
    let sides = sides(outlines, &vertices);
    for &(a, b) in &sides {
        if !plane.can_add_constraint(a, b) {
            return None;
        }
        plane.add_constraint(a, b);
    }
    let mut odd = vec![false; plane.num_undirected_edges()];
    for (a, b) in sides {
        mark(&plane, a, b, &mut odd)?;
    }
    let inside = inside(&plane, &odd).into_iter();
    let triangles: Vec<_> = inside.map(|t| t.map(|vertex| corner[vertex.index()])).collect();
    (!triangles.is_empty()).then_some(triangles)
}

/// The sides of the outlines that have a length above zero.
fn sides(
    outlines: &[&[Uv]],
    vertices: &[FixedVertexHandle],
) -> Vec<(FixedVertexHandle, FixedVertexHandle)> {
    let mut sides = Vec::with_capacity(vertices.len());
    let mut rest = vertices;
    for outline in outlines {
        let (own, others) = rest.split_at(outline.len());
        sides.extend(own.iter().copied().zip(own.iter().copied().cycle().skip(1)));
        rest = others;
    }
    sides.retain(|(a, b)| a != b);
    sides
}

/// Toggles the edges that lie on the side from `a` to `b`. These are several if other corners lie
/// on the side.
fn mark(
    plane: &Delaunay,
    a: FixedVertexHandle,
    b: FixedVertexHandle,
    odd: &mut [bool],
) -> Option<()> {
    let at = |p: Point2<f64>| Uv::new(p.x, p.y);
    let goal = at(plane.vertex(b).position());
    let mut vertex = plane.vertex(a);
    while vertex.fix() != b {
        let here = at(vertex.position());
        let ahead = |p: Uv| orient2d(here, p, goal) == 0.0 && (p - here).dot(&(goal - here)) > 0.0;
        let edge = vertex.out_edges().find(|e| ahead(at(e.to().position())))?;
        odd[edge.as_undirected().fix().index()] ^= true;
        vertex = edge.to();
    }
    Some(())
}

/// The faces that are reached from outside across an odd number of marked edges.
fn inside(plane: &Delaunay, odd: &[bool]) -> Vec<[FixedVertexHandle; 3]> {
    let mut is_inside: Vec<Option<bool>> = vec![None; plane.num_all_faces()];
    is_inside[plane.outer_face().fix().index()] = Some(false);
    let mut edges: Vec<_> = plane.convex_hull().map(|edge| (edge, false)).collect();
    let mut faces = Vec::new();
    while let Some((edge, from_inside)) = edges.pop() {
        let face = edge.rev().face();
        if is_inside[face.fix().index()].is_some() {
            continue;
        }
        let within = from_inside ^ odd[edge.as_undirected().fix().index()];
        is_inside[face.fix().index()] = Some(within);
        let Some(face) = face.as_inner() else { continue };
        edges.extend(face.adjacent_edges().map(|edge| (edge, within)));
        if within {
            faces.push(face);
        }
    }
    // The order must not depend on the order of the traversal.
    faces.sort_unstable_by_key(|face| face.fix().index());
    faces.iter().map(|face| face.vertices().map(|v| v.fix())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_with_points_is_triangulated() {
        let square = |r: f64| [(-r, -r), (r, -r), (r, r), (-r, r)].map(|(x, y)| Uv::new(x, y));
        let (outer, island) = (square(3.0), square(1.0));
        let inner = [Uv::new(2.0, 0.1), Uv::new(-2.0, 0.0)];
        let t = triangulate(&[&outer, &island], &inner).unwrap();
        assert_eq!(t.len(), 8 + 2 * inner.len());
        let at: Vec<Uv> = [outer.as_slice(), &island, &inner].concat();
        let area: f64 = t.iter().map(|t| 0.5 * orient2d(at[t[0]], at[t[1]], at[t[2]])).sum();
        assert!((area - 32.0).abs() < 1e-12);
        assert!(triangulate(&[&outer, &square(4.0)], &[]).is_some());
        let crossing = [outer[0], outer[2], outer[1], outer[3]];
        assert!(triangulate(&[&crossing], &[]).is_none());
    }
}
