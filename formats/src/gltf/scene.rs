//! The nodes of the default scene and their meshes.

use super::transform::NodeTransform;
use super::{Gear, graph, primitive};
use crate::source::EXPORT_AGAIN;
use crate::{Error, Location, Result, Soup};

/// Reads the default scene into `soup`. Returns whether it has a mesh.
pub(super) fn read(gear: &mut Gear<'_>, soup: &mut Soup) -> Result<bool> {
    let mut placed = false;
    let root = gear.document.as_json();
    let mut seen = vec![false; root.nodes.len()];
    // A stack replaces recursion, because the tree may have any depth.
    let mut open: Vec<(usize, NodeTransform)> = Vec::new();
    open.extend(roots(gear)?.into_iter().rev().map(|node| (node, NodeTransform::IDENTITY)));
    while let Some((index, outer)) = open.pop() {
        let Some(node) = root.nodes.get(index) else {
            return Err(bad(gear, "node", index, "does not exist"));
        };
        // Visit every node once. A scene may list both a node and its ancestor.
        if std::mem::replace(&mut seen[index], true) {
            return Err(bad(gear, "node", index, "is in the scene twice"));
        }
        let place = outer.after(&NodeTransform::of(node));
        if !place.is_finite() {
            return Err(bad(gear, "node", index, "is scaled or moved to infinity"));
        }
        if let Some(mesh) = node.mesh {
            read_mesh(gear, mesh.value(), &place, soup)?;
            placed = true;
        }
        let children = node.children.iter().flatten().rev();
        open.extend(children.map(|child| (child.value(), place)));
    }
    Ok(placed)
}

/// The roots of the default scene. If there is none, those of the first scene, or of all nodes.
fn roots(gear: &Gear<'_>) -> Result<Vec<usize>> {
    let parents = graph::parents(gear)?;
    let chosen = gear.document.as_json().scene.map(|scene| scene.value());
    let scene = chosen.unwrap_or(0);
    match gear.scenes.get(scene) {
        // A number that does not fit is no existing node, either.
        Some(nodes) => {
            Ok(nodes.iter().map(|&i| usize::try_from(i).unwrap_or(usize::MAX)).collect())
        }
        None if chosen.is_some() => Err(bad(gear, "scene", scene, "does not exist")),
        None => Ok((0..parents.len()).filter(|&node| parents[node].is_none()).collect()),
    }
}

fn read_mesh(
    gear: &mut Gear<'_>,
    index: usize,
    place: &NodeTransform,
    soup: &mut Soup,
) -> Result<()> {
    let Some(mesh) = gear.document.as_json().meshes.get(index) else {
        return Err(bad(gear, "mesh", index, "does not exist"));
    };
    for primitive in &mesh.primitives {
        primitive::read(gear, index, primitive, place, soup)?;
    }
    Ok(())
}

pub(super) fn bad(gear: &Gear<'_>, kind: &'static str, index: usize, what: &str) -> Error {
    let error = Error::new(gear.buffers.path, format!("has a {kind} that {what}"), EXPORT_AGAIN);
    error.at(Location::Element(kind, index as u64))
}
