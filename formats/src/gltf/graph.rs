//! Check that the nodes are a forest, including nodes outside of all scenes.

use super::Gear;
use super::scene::bad;
use crate::source::EXPORT_AGAIN;
use crate::{Error, Location, Result};

/// The parent of each node. Every node must have at most one parent and must not be its own
/// ancestor. A cycle has no root, so its nodes would be lost without a message.
pub(super) fn parents(gear: &Gear<'_>) -> Result<Vec<Option<usize>>> {
    let nodes = &gear.document.as_json().nodes;
    let mut parents = vec![None; nodes.len()];
    for (i, node) in nodes.iter().enumerate() {
        for child in node.children.iter().flatten().map(|child| child.value()) {
            match parents.get_mut(child) {
                None => return Err(bad(gear, "node", child, "does not exist")),
                Some(Some(other)) => return Err(two_parents(gear, child, [*other, i])),
                Some(parent) => *parent = Some(i),
            }
        }
    }
    match in_loop(&parents) {
        Some(node) => Err(bad(gear, "node", node, "is its own descendant")),
        None => Ok(parents),
    }
}

/// A node that is in a cycle. Every node is visited once, because the way up ends at a visited
/// node.
fn in_loop(parents: &[Option<usize>]) -> Option<usize> {
    let mut seen_from = vec![usize::MAX; parents.len()];
    for start in 0..parents.len() {
        let mut at = start;
        while seen_from[at] == usize::MAX {
            seen_from[at] = start;
            match parents[at] {
                Some(parent) if seen_from[parent] == start => return Some(parent),
                Some(parent) => at = parent,
                None => break,
            }
        }
    }
    None
}

fn two_parents(gear: &Gear<'_>, node: usize, [a, b]: [usize; 2]) -> Error {
    let what = format!("has a node that is in the scene twice, below node {a} and below node {b}");
    Error::new(gear.buffers.path, what, EXPORT_AGAIN).at(Location::Element("node", node as u64))
}
