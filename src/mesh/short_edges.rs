//! Edges between vertices that are one point for all that the file knows.

use super::{EdgeMap, Mesh};
use crate::geometry::VertexId;
use crate::geometry::sets::Sets;

impl Mesh {
    /// The mesh with one vertex for the ends of each edge that is no longer than their errors together, and for each of its
    /// vertices the number that it had. None if there is no such edge, or if the closed mesh would not stay closed.
    pub(crate) fn without_short_edges(&self, errors: &[f64]) -> Option<(Mesh, Vec<usize>)> {
        let mut sets = Sets::new(self.points.len());
        let mut count = 0;
        for side in 0..3 * self.triangles.len() {
            let (a, b) = self.side(side);
            let reach = errors[a.index()] + errors[b.index()];
            if (self.point(a) - self.point(b)).norm() <= reach {
                sets.join(a.index(), b.index());
                count += 1;
            }
        }
        if count == 0 {
            return None;
        }
        let home: Vec<VertexId> =
            (0..self.points.len()).map(|v| VertexId::from(sets.find(v))).collect();
        let mut joined = self.clone();
        for members in sets.members() {
            for &v in &members[1..] {
                // A chain of short edges is no point.
                let apart = (self.points[v as usize] - self.points[members[0] as usize]).norm();
                if apart > errors[v as usize] + errors[members[0] as usize] {
                    return None;
                }
            }
        }
        for corners in &mut joined.triangles {
            corners.iter_mut().for_each(|v| *v = home[v.index()]);
        }
        let is_whole = |t: &usize| {
            let [a, b, c] = joined.triangles[*t];
            a != b && b != c && c != a
        };
        let kept: Vec<usize> = (0..joined.triangles.len()).filter(is_whole).collect();
        let (mesh, numbers) = joined.part(kept.into_iter());
        let edges = EdgeMap::new(&mesh);
        let is_closed = edges.open_sides().next().is_none() && edges.is_oriented(&mesh);
        (is_closed && !mesh.triangles.is_empty()).then_some((mesh, numbers))
    }
}

#[cfg(test)]
mod tests {
    use crate::geometry::{Point, VertexId};
    use crate::mesh::Mesh;

    /// A tetrahedron one of whose corners is two points that are `apart`.
    fn split(apart: f64) -> Mesh {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut points: Vec<Point> = points.into_iter().map(Point::from).collect();
        points.push(Point::new(0.0, apart, 1.0));
        let triangles = [[0, 2, 1], [0, 1, 3], [1, 4, 3], [1, 2, 4], [2, 0, 4], [0, 3, 4]];
        let triangles = triangles.map(|t: [u32; 3]| t.map(VertexId)).to_vec();
        Mesh { points, triangles }
    }

    #[test]
    fn points_within_their_errors_are_one() {
        let errors = [1e-6; 5];
        let (mesh, numbers) = split(1.5e-6).without_short_edges(&errors).unwrap();
        assert_eq!((mesh.points.len(), mesh.triangles.len()), (4, 4));
        assert_eq!(numbers, [0, 1, 2, 3]);
        assert!(split(2.5e-6).without_short_edges(&errors).is_none());
    }
}
