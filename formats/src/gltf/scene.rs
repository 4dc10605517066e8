//! The nodes of the scene, and the meshes that they place.

use ::gltf::json::Root;

use super::transform::Affine;
use super::{Gear, primitive};
use crate::source::EXPORT_AGAIN;
use crate::{Error, Place, Result, Soup};

/// Reads the default scene into `soup`.
pub(super) fn read(gear: &mut Gear<'_>, soup: &mut Soup) -> Result<()> {
    let root = gear.document.as_json();
    let mut seen = vec![false; root.nodes.len()];
    // A stack, not recursion: the tree may be as deep as the file likes.
    let mut open: Vec<(usize, Affine)> = Vec::new();
    open.extend(roots(gear)?.into_iter().rev().map(|node| (node, Affine::IDENTITY)));
    while let Some((index, outer)) = open.pop() {
        let Some(node) = root.nodes.get(index) else {
            return Err(bad(gear, "node", index, "does not exist"));
        };
        // Every node has one parent: this ends, cycles or not.
        if std::mem::replace(&mut seen[index], true) {
            return Err(bad(gear, "node", index, "is in the scene twice or below itself"));
        }
        let place = outer.after(&Affine::of(node));
        if !place.is_finite() {
            return Err(bad(gear, "node", index, "is scaled or moved to infinity"));
        }
        if let Some(mesh) = node.mesh {
            read_mesh(gear, mesh.value(), &place, soup)?;
        }
        let children = node.children.iter().flatten().rev();
        open.extend(children.map(|child| (child.value(), place)));
    }
    Ok(())
}

/// The roots of the default scene, of the first, or of all the nodes.
fn roots(gear: &Gear<'_>) -> Result<Vec<usize>> {
    let root = gear.document.as_json();
    let scene = root.scene.map_or(0, |scene| scene.value());
    match root.scenes.get(scene) {
        Some(scene) => Ok(scene.nodes.iter().map(|node| node.value()).collect()),
        None if root.scene.is_some() => Err(bad(gear, "scene", scene, "does not exist")),
        None => Ok(parentless(root)),
    }
}

fn parentless(root: &Root) -> Vec<usize> {
    let mut free = vec![true; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        if let Some(free) = free.get_mut(child.value()) {
            *free = false;
        }
    }
    (0..free.len()).filter(|&node| free[node]).collect()
}

fn read_mesh(gear: &mut Gear<'_>, index: usize, place: &Affine, soup: &mut Soup) -> Result<()> {
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
    error.at(Place::Element(kind, index as u64))
}
