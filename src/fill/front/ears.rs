//! Ears: corners of the front that a triangle closes.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::{Front, Way};

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
        self.is_free([c, b, a], b, self.normal(self.rings.vertex(node)))
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
        let ear = |front: &Self, node: usize| {
            let beside = [front.rings.before(node), front.rings.after(node)];
            let ear = Reverse(Ear { angle: front.angle(node), node, beside });
            (ear.0.angle < angle).then_some(ear)
        };
        let mut order: BinaryHeap<Reverse<Ear>> =
            self.rings.all().filter_map(|node| ear(self, node)).collect();
        while let Some(Reverse(Ear { node, beside, .. })) = order.pop() {
            // Ears that have changed since were entered anew.
            let now = [self.rings.before(node), self.rings.after(node)];
            if !self.rings.is_alive(node) || now != beside {
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

    /// For a front that has come to a halt: raises φ until an ear can be closed,
    /// or else spans a ring of a led front by least area; another has gone
    /// astray.
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
        match self.way {
            Way::Mls(_) => None,
            Way::Led(_) => {
                let node = self.rings.all().next()?;
                self.span(node)
            }
        }
    }
}

/// An ear in the order of its angle.
struct Ear {
    angle: f64,
    node: usize,
    /// The nodes before and after it.
    beside: [usize; 2],
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
