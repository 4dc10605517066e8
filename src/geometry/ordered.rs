//! Numbers that heaps and sorts can order.

use std::cmp::Ordering;

/// A number in the order of [`f64::total_cmp`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct OrderedFloat(pub f64);

impl Ord for OrderedFloat {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl PartialOrd for OrderedFloat {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for OrderedFloat {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for OrderedFloat {}
