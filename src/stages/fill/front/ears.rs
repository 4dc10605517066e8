//! Ears of the front: corners that one triangle can close.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::{Advance, Front};
use crate::geometry::OrderedFloat;

impl Front<'_> {
    /// The nodes before, at and after `node`.
    fn ear(&self, node: usize) -> [usize; 3] {
        [self.loops.before(node), node, self.loops.after(node)]
    }

    /// The angle of the hole at a node, in the tangent plane there.
    fn angle(&self, node: usize) -> f64 {
        let [a, b, c] = self.ear(node).map(|n| self.loops.at(n));
        self.plane(b, self.normal(self.loops.vertex(node))).angle(a, b, c)
    }

    /// Whether the ear at a node may be closed.
    fn may_close(&self, node: usize) -> bool {
        let ear = self.ear(node);
        let [a, _, c] = ear.map(|n| self.loops.vertex(n));
        if self.joined(a, c) {
            return false;
        }
        let [a, b, c] = ear.map(|n| self.loops.at(n));
        self.is_free([c, b, a], b, self.normal(self.loops.vertex(node)))
    }

    /// Closes an ear and returns the nodes whose angles this has changed.
    fn close(&mut self, node: usize) -> Vec<usize> {
        let [a, b, c] = self.ear(node);
        let [u, v, w] = [a, b, c].map(|n| self.loops.vertex(n));
        self.add([w, v, u]);
        self.loops.remove_node(b);
        if self.close_triangle(a) { vec![] } else { vec![a, c] }
    }

    /// Closes the loop of a node if it is a triangle, and says whether it did.
    pub(super) fn close_triangle(&mut self, node: usize) -> bool {
        let is_triangle = self.loops.is_triangle(node);
        if is_triangle {
            let [a, b, c] = self.ear(node).map(|n| self.loops.vertex(n));
            self.add([c, b, a]);
            self.loops.remove_loop(node);
        }
        is_triangle
    }

    /// Closes all ears below `angle`, the narrowest first, and returns their number.
    pub(super) fn close_ears(&mut self, angle: f64) -> usize {
        let before = self.fill.triangles.len();
        let ear = |front: &Self, node: usize| {
            let beside = [front.loops.before(node), front.loops.after(node)];
            let own = front.angle(node);
            (own < angle).then_some(Reverse((OrderedFloat(own), node, beside)))
        };
        let mut order: BinaryHeap<_> =
            self.loops.all().filter_map(|node| ear(self, node)).collect();
        while let Some(Reverse((_, node, beside))) = order.pop() {
            // If the ear has changed since, it has a newer entry.
            let now = [self.loops.before(node), self.loops.after(node)];
            if !self.loops.is_alive(node) || now != beside {
                continue;
            }
            if self.close_triangle(node) || !self.may_close(node) {
                continue;
            }
            let changed = self.close(node);
            order.extend(changed.into_iter().filter_map(|node| ear(self, node)));
        }
        self.fill.triangles.len() - before
    }

    /// For a round that added no triangle: raises φ until an ear can be closed. If there is
    /// none, closes a loop of a guided front by least area. `None` for any other front.
    pub(super) fn close_wide_ears(&mut self, angle: f64) -> Option<()> {
        /// The steps from φ to 180°, of 13° each. Fewer can close wider ears than needed. One
        /// and twelve steps change no fill of the hole bench.
        const STEPS: i32 = 6;
        for step in 1..=STEPS {
            let share = f64::from(step) / f64::from(STEPS);
            let closed = self.close_ears(angle + share * (std::f64::consts::PI - angle));
            self.fill.wide_ears += closed;
            if closed > 0 {
                return Some(());
            }
        }
        match self.by {
            Advance::Mls(_) => None,
            Advance::Guided(_) => {
                let node = self.loops.all().next()?;
                self.close_by_least_area(node)
            }
        }
    }
}
