//! Ears: corners of the front that a triangle closes.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Front;

impl Front<'_> {
    /// The nodes before, at and after `node`.
    fn ear(&self, node: usize) -> [usize; 3] {
        [self.rings.before(node), node, self.rings.after(node)]
    }

    /// The hole's angle at a node, in the plane across the normal there.
    fn angle(&self, node: usize) -> f64 {
        let [a, b, c] = self.ear(node).map(|n| self.rings.at(n));
        self.plane(b, self.normal(self.rings.vertex(node))).angle(a, b, c)
    }

    /// Whether the ear at a node may be closed.
    fn may_close(&self, node: usize) -> bool {
        let ear = self.ear(node);
        let [a, _, c] = ear.map(|n| self.rings.vertex(n));
        if self.joined(a, c) {
            return false;
        }
        let [a, b, c] = ear.map(|n| self.rings.at(n));
        let longest = (a - b).norm().max((c - b).norm());
        let normal = self.normal(self.rings.vertex(node));
        let near = self.edges_near(b, normal, 2.0 * longest);
        self.plane(b, normal).is_free([c, b, a], &near)
    }

    /// Closes an ear; returns the nodes whose angle it changed.
    fn close(&mut self, node: usize) -> Vec<usize> {
        let [a, b, c] = self.ear(node);
        let [u, v, w] = [a, b, c].map(|n| self.rings.vertex(n));
        self.add([w, v, u]);
        self.rings.cut(b);
        if self.close_triangle(a) { vec![] } else { vec![a, c] }
    }

    /// Fills the ring of a node if it is a triangle.
    pub(super) fn close_triangle(&mut self, node: usize) -> bool {
        let is_triangle = self.rings.is_triangle(node);
        if is_triangle {
            let [a, b, c] = self.ear(node).map(|n| self.rings.vertex(n));
            self.add([c, b, a]);
            self.rings.drop_ring(node);
        }
        is_triangle
    }

    /// Closes ears below `angle`, the narrowest first, until none is left;
    /// returns how many.
    pub(super) fn close_ears(&mut self, angle: f64) -> usize {
        let before = self.fill.triangles.len();
        let mut order: BinaryHeap<Reverse<Ear>> =
            self.rings.all().map(|node| Reverse(Ear { angle: self.angle(node), node })).collect();
        while let Some(Reverse(ear)) = order.pop() {
            let node = ear.node;
            if ear.angle >= angle {
                break;
            }
            // Angles that have changed since were entered anew.
            if !self.rings.is_alive(node) || self.angle(node) != ear.angle {
                continue;
            }
            if self.close_triangle(node) || !self.may_close(node) {
                continue;
            }
            for changed in self.close(node) {
                order.push(Reverse(Ear { angle: self.angle(changed), node: changed }));
            }
        }
        self.fill.triangles.len() - before
    }

    /// For a front that has come to a halt: raises φ until an ear can be closed,
    /// or else leaves a ring to a membrane.
    pub(super) fn close_wide_ears(&mut self, angle: f64) -> Option<()> {
        const STEPS: i32 = 6;
        for step in 1..=STEPS {
            let share = f64::from(step) / f64::from(STEPS);
            let closed = self.close_ears(angle + share * (std::f64::consts::PI - angle));
            self.fill.wide_ears += closed;
            if closed > 0 {
                return Some(());
            }
        }
        let node = self.rings.all().next();
        self.span(node?)
    }
}

/// An ear in the order of its angle.
struct Ear {
    angle: f64,
    node: usize,
}

impl Ord for Ear {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.angle.total_cmp(&other.angle).then(self.node.cmp(&other.node))
    }
}

impl PartialOrd for Ear {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Ear {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Ear {}
