//! Closing a whole loop at once by the triangulation of least area.

use super::Front;
use crate::geometry::{Point, ROUNDING, Vector, VertexId};
use crate::stages::fill::least_area;

impl Front<'_> {
    /// Closes the loop of a node by the triangulation of least area. `None` if a number is not finite.
    pub(super) fn close_by_least_area(&mut self, node: usize) -> Option<()> {
        if self.close_triangle(node) {
            return Some(());
        }
        // The hole is to the right of its rim.
        let nodes: Vec<usize> = self.loops.loop_from(node).into_iter().rev().collect();
        let ring: Vec<VertexId> = nodes.iter().map(|&n| self.loops.vertex(n)).collect();
        let rim: Vec<Point> = nodes.iter().map(|&n| self.loops.at(n)).collect();
        let next = |i: usize| ring[(i + 1) % ring.len()];
        let beside = |i: usize| self.around.normal_at(ring[i], next(i)).unwrap_or_default();
        let beside: Vec<Vector> = (0..ring.len()).map(beside).collect();
        let joined = |i: usize, j: usize| self.joined(ring[i], ring[j]);
        let mut surface = least_area::triangulate(&rim, &beside, joined, self.sizes)?;
        // The loop passes a bridge to an island in both directions.
        surface.divide_doubled(&ring);
        let mean = ring.iter().map(|&v| self.normal(v)).sum::<Vector>();
        let normal = mean.try_normalize(ROUNDING).unwrap_or(Vector::z());
        let inner = surface.points[rim.len()..].iter();
        let new: Vec<_> = inner.map(|&p| self.add_point(p, normal)).collect();
        let vertices = [ring, new].concat();
        let triangles = surface.triangles.iter().map(|t| t.map(|i| vertices[i]));
        triangles.for_each(|t| self.add(t));
        self.loops.remove_loop(node);
        Some(())
    }
}
