//! What the front cannot close is left to a membrane.

use super::Front;
use crate::fill::membrane;
use crate::geometry::Vector;

impl Front<'_> {
    /// Closes the ring of a node by a membrane.
    pub(super) fn span(&mut self, node: usize) -> Option<()> {
        if self.close_triangle(node) {
            return Some(());
        }
        // The hole lies to the right of its rim.
        let nodes = self.rings.ring(node);
        let ring: Vec<_> =
            nodes.iter().rev().map(|&n| (self.rings.vertex(n), self.rings.at(n))).collect();
        let membrane = membrane::span(&ring, |v, w| self.joined(v, w))?;
        let mean = nodes.iter().map(|&n| self.normal(self.rings.vertex(n))).sum::<Vector>();
        let normal = mean.try_normalize(1e-12).unwrap_or(Vector::z());
        let first: Vec<_> = ring.iter().map(|r| r.0).collect();
        let new: Vec<_> = membrane.points.into_iter().map(|p| self.add_point(p, normal)).collect();
        let vertices = [first, new].concat();
        for t in membrane.triangles {
            self.add(t.map(|i| vertices[i]));
        }
        self.rings.drop_ring(node);
        self.fill.membranes += 1;
        Some(())
    }
}
