//! Subdivision of triangles whose sides are halved.

use foldhash::{HashMap, HashMapExt};

use super::{Mesh, Patch};
use crate::geometry::{Point, VertexId};

type VertexPair = (VertexId, VertexId);

fn edge(a: VertexId, b: VertexId) -> VertexPair {
    (a.min(b), a.max(b))
}

/// Edges with the vertices in their middles.
#[derive(Default)]
pub(crate) struct EdgeMidpoints(HashMap<VertexPair, VertexId>);

impl EdgeMidpoints {
    /// Adds a vertex to the mesh in the middle of each edge that one of the `sides` lies on.
    /// `place` gives its position.
    pub(crate) fn new(
        mesh: &mut Mesh,
        sides: impl IntoIterator<Item = usize>,
        mut place: impl FnMut(&Mesh, VertexId, VertexId) -> Point,
    ) -> Self {
        let mut midpoints = HashMap::new();
        for side in sides {
            let (a, b) = mesh.side(side);
            midpoints.entry(edge(a, b)).or_insert_with(|| {
                let middle = place(mesh, a, b);
                mesh.points.push(middle);
                VertexId::from(mesh.points.len() - 1)
            });
        }
        EdgeMidpoints(midpoints)
    }

    /// The number of halved edges.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    fn of(&self, a: VertexId, b: VertexId) -> Option<VertexId> {
        self.0.get(&edge(a, b)).copied()
    }
}

impl Patch {
    /// Divides the triangles that have halved edges. The new vertices of boundary edges become part
    /// of the outer boundary. `touched` must ascend and name every triangle that has a halved edge.
    pub(crate) fn divide(
        &mut self,
        midpoints: &EdgeMidpoints,
        touched: impl IntoIterator<Item = usize>,
    ) {
        let old = std::mem::take(&mut self.mesh.triangles);
        let origins = std::mem::take(&mut self.origin);
        let mut touched = touched.into_iter().peekable();
        for (number, (t, origin)) in old.into_iter().zip(origins).enumerate() {
            let may_be_divided = touched.peek() == Some(&number);
            while touched.next_if_eq(&number).is_some() {}
            if may_be_divided {
                self.mesh.triangles.extend(divided(t, midpoints));
            } else {
                self.mesh.triangles.push(t);
            }
            self.origin.resize(self.mesh.triangles.len(), origin);
        }
        let next = self.outer.iter().cycle().skip(1);
        let with_middle = |(&a, &b)| [Some(a), midpoints.of(a, b)];
        self.outer = self.outer.iter().zip(next).flat_map(with_middle).flatten().collect();
    }
}

/// The triangles into which a triangle is divided.
fn divided(t: [VertexId; 3], midpoints: &EdgeMidpoints) -> Vec<[VertexId; 3]> {
    let middle = |k: usize| midpoints.of(t[k % 3], t[(k + 1) % 3]);
    let halved = (0..3).filter(|&k| middle(k).is_some()).count();
    // Start at a side for which the cases below apply: the only halved one, or the first of two
    // consecutive ones.
    let start = (0..3).find(|&k| middle(k).is_some() && (halved != 2 || middle(k + 1).is_some()));
    let s = start.unwrap_or(0);
    let (a, b, c) = (t[s], t[(s + 1) % 3], t[(s + 2) % 3]);
    match (middle(s), middle(s + 1), middle(s + 2)) {
        (Some(ab), None, _) => vec![[a, ab, c], [ab, b, c]],
        (Some(ab), Some(bc), None) => vec![[ab, b, bc], [a, ab, bc], [a, bc, c]],
        (Some(ab), Some(bc), Some(ca)) => {
            vec![[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        }
        (None, _, _) => vec![t],
    }
}
