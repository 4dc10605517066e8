//! The nodes of the default scene and their meshes.

use ::gltf::json::Node;

use super::{Gear, graph, instances, mesh, transform};
use crate::scene::{
    MOST_DEPTH, MOST_NODES, MeshId, NodeId, Placement, Scene, SceneNote, clean_name,
};
use crate::source::EXPORT_AGAIN;
use crate::{Error, Location, Result};

/// A node that waits, its parent in the scene, and its parent's transform.
type Waiting = (usize, Option<NodeId>, Placement);

/// Reads the default scene into `scene`. Returns whether it has a mesh.
pub(super) fn read(gear: &mut Gear<'_>, scene: &mut Scene) -> Result<bool> {
    let mut placed = false;
    let root = gear.document.as_json();
    let parents = graph::parents(gear)?;
    let roots = roots(gear, &parents)?;
    let leads_to_mesh = leads_to_mesh(&root.nodes, &parents);
    let mut seen = vec![false; root.nodes.len()];
    // A stack replaces recursion, because the tree may have any depth.
    let mut open: Vec<Waiting> = Vec::new();
    open.extend(roots.into_iter().rev().map(|node| (node, None, Placement::IDENTITY)));
    while let Some((index, parent, outer)) = open.pop() {
        let Some(node) = root.nodes.get(index) else {
            return Err(bad(gear, "node", index, "does not exist"));
        };
        // Visit every node once. A scene may list both a node and its ancestor.
        if std::mem::replace(&mut seen[index], true) {
            return Err(bad(gear, "node", index, "is in the scene twice"));
        }
        let own = transform::of_node(node);
        let place = outer.after(&own);
        if !place.is_finite() {
            return Err(bad(gear, "node", index, "is scaled or moved to infinity"));
        }
        let mut as_parent = parent;
        if let Some(of_node) = node.mesh {
            let mesh = mesh::read(gear, of_node.value(), scene)?;
            placed = true;
            as_parent = add_mesh_node(gear, scene, index, (parent, &own), mesh)?;
        } else if leads_to_mesh[index] {
            check_count(gear, scene, 1)?;
            as_parent = Some(scene.add_group(parent, name(node), &own));
        }
        let children = node.children.iter().flatten().rev();
        open.extend(children.map(|child| (child.value(), as_parent, place)));
    }
    if scene.place_count() > 1 && scene.depth() > MOST_DEPTH {
        let what = format!("has nodes in each other more than {MOST_DEPTH} deep");
        let help = "Export it without the groups around its parts.";
        return Err(Error::new(gear.buffers.path, what, help));
    }
    Ok(placed)
}

/// Adds a node with a mesh: a place, or a group of it and of the children, or of its instances. Returns the node that
/// children belong to.
fn add_mesh_node(
    gear: &mut Gear<'_>,
    scene: &mut Scene,
    index: usize,
    (parent, own): (Option<NodeId>, &Placement),
    mesh: Option<MeshId>,
) -> Result<Option<NodeId>> {
    let node = &gear.document.as_json().nodes[index];
    if node.skin.is_some() && !scene.notes.contains(&SceneNote::Undeformed) {
        scene.notes.push(SceneNote::Undeformed);
    }
    let has_children = node.children.as_ref().is_some_and(|children| !children.is_empty());
    let instances = instances::read(gear, index)?;
    check_count(gear, scene, 2 + instances.as_ref().map_or(0, Vec::len))?;
    let name = name(node);
    match (mesh, instances) {
        (Some(mesh), None) if !has_children => Ok(Some(scene.add_place(parent, name, own, mesh))),
        (mesh, instances) => {
            let group = scene.add_group(parent, name, own);
            let places = instances.unwrap_or_else(|| vec![Placement::IDENTITY]);
            for place in places.iter().filter(|_| mesh.is_some()) {
                mesh.map(|mesh| scene.add_place(Some(group), None, place, mesh));
            }
            Ok(Some(group))
        }
    }
}

fn name(node: &Node) -> Option<String> {
    node.name.as_deref().and_then(clean_name)
}

/// Checks that the scene may have so many more nodes.
fn check_count(gear: &Gear<'_>, scene: &Scene, more: usize) -> Result<()> {
    if scene.nodes().len().saturating_add(more) <= MOST_NODES {
        return Ok(());
    }
    let what = format!("has a scene of more than {MOST_NODES} nodes");
    let help = "Export its parts in several files.";
    Err(Error::new(gear.buffers.path, what, help))
}

/// Whether each node has a mesh or leads to a node that has one. Cameras, lights and bones do not.
fn leads_to_mesh(nodes: &[Node], parents: &[Option<usize>]) -> Vec<bool> {
    let mut leads = vec![false; nodes.len()];
    for start in (0..nodes.len()).filter(|&i| nodes[i].mesh.is_some()) {
        let mut at = Some(start);
        // The way up ends at a node that is known.
        while let Some(node) = at.filter(|&node| !leads[node]) {
            leads[node] = true;
            at = parents[node];
        }
    }
    leads
}

/// The roots of the default scene. If there is none, those of the first scene, or of all nodes.
fn roots(gear: &Gear<'_>, parents: &[Option<usize>]) -> Result<Vec<usize>> {
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

pub(super) fn bad(gear: &Gear<'_>, kind: &'static str, index: usize, what: &str) -> Error {
    let error = Error::new(gear.buffers.path, format!("has a {kind} that {what}"), EXPORT_AGAIN);
    error.at(Location::Element(kind, index as u64))
}
