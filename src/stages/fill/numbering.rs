//! The vertices of one fill numbered from 0: first those of the rims, then the new ones.

use foldhash::HashMap;

use super::front::{Fill, OpenHole};
use crate::geometry::{Point, VertexId};

pub(crate) struct Numbering<'a> {
    hole: OpenHole<'a>,
    /// The vertices of the rims.
    pub rim: Vec<VertexId>,
    /// The place of each of them in `rim`.
    places: HashMap<VertexId, usize>,
}

impl<'a> Numbering<'a> {
    pub(super) fn new(hole: OpenHole<'a>) -> Self {
        let rim = hole.rims.concat();
        let places = rim.iter().enumerate().map(|(i, &v)| (v, i)).collect();
        Numbering { hole, rim, places }
    }

    /// The number of a vertex of the mesh or of a fill.
    pub(crate) fn local(&self, v: VertexId) -> usize {
        match v.index().checked_sub(self.hole.around.mesh.points.len()) {
            None => self.places[&v],
            Some(new) => self.rim.len() + new,
        }
    }

    fn global(&self, i: usize) -> VertexId {
        match i.checked_sub(self.rim.len()) {
            None => self.rim[i],
            Some(new) => VertexId::from(self.hole.around.mesh.points.len() + new),
        }
    }

    /// The points and the triangles of a fill with its rims.
    pub(crate) fn numbered(&self, fill: &Fill) -> (Vec<Point>, Vec<[usize; 3]>) {
        let of_rim = self.rim.iter().map(|&v| self.hole.around.mesh.point(v));
        let points = of_rim.chain(fill.points.iter().copied()).collect();
        (points, fill.triangles.iter().map(|t| t.map(|v| self.local(v))).collect())
    }

    /// The fill of such points and triangles, which were made from those of another fill.
    pub(super) fn fill(
        &self,
        mut points: Vec<Point>,
        triangles: &[[usize; 3]],
        from: &Fill,
    ) -> Fill {
        Fill {
            points: points.split_off(self.rim.len()),
            triangles: triangles.iter().map(|t| t.map(|i| self.global(i))).collect(),
            ..*from
        }
    }

    /// Whether the mesh joins two vertices by an edge.
    pub(crate) fn joined(&self, i: usize, j: usize) -> bool {
        i.max(j) < self.rim.len() && self.hole.around.joined(self.rim[i], self.rim[j])
    }
}
