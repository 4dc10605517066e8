//! The reason why a file contains no triangles.

use ::gltf::json::Root;
use ::gltf::json::mesh::Primitive;

use super::{Gear, primitive};
use crate::source::EXPORT_AGAIN;
use crate::{Error, Location, Result};

/// The error for a file whose scene has no triangles. `placed` tells whether the scene has a mesh.
/// The error is the first fault of the content, or it says what is missing.
pub(super) fn explain(gear: &mut Gear<'_>, placed: bool) -> Error {
    let checked = check_references(gear).and_then(|()| check_meshes(gear));
    checked.err().unwrap_or_else(|| missing(gear, placed))
}

fn missing(gear: &Gear<'_>, placed: bool) -> Error {
    let root = gear.document.as_json();
    let place = "Export the meshes with faces, as nodes of the file's default scene.";
    let mesh = "Mesh the points first, for example in MeshLab, and export them with faces.";
    let (why, help) = if root.meshes.is_empty() {
        ("it has no meshes", place)
    } else if root.nodes.is_empty() {
        ("it has no nodes, which would place its meshes", place)
    } else if !placed {
        ("none of the scene's nodes has a mesh", place)
    } else if !has_faces(root) {
        ("its meshes are only points or lines", mesh)
    } else {
        ("its meshes have no whole triangle", EXPORT_AGAIN)
    };
    let what = format!("has no triangles in its default scene: {why}");
    Error::new(gear.buffers.path, what, help)
}

fn has_faces(root: &Root) -> bool {
    root.meshes.iter().flat_map(|mesh| &mesh.primitives).any(primitive::is_of_triangles)
}

/// Checks that accessors and buffer views refer to existing elements.
fn check_references(gear: &Gear<'_>) -> Result<()> {
    let root = gear.document.as_json();
    let dangling = |kind, index: usize, what: String| {
        let error = Error::new(gear.buffers.path, what, EXPORT_AGAIN);
        Err(error.at(Location::Element(kind, index as u64)))
    };
    for (i, accessor) in root.accessors.iter().enumerate() {
        let view = accessor.buffer_view.map_or(0, |view| view.value());
        if accessor.buffer_view.is_some() && view >= root.buffer_views.len() {
            let what = format!("has an accessor in buffer view {view}, which does not exist");
            return dangling("accessor", i, what);
        }
    }
    for (i, view) in root.buffer_views.iter().enumerate() {
        let buffer = view.buffer.value();
        if buffer >= root.buffers.len() {
            let what = format!("has a buffer view of buffer {buffer}, which does not exist");
            return dangling("bufferView", i, what);
        }
    }
    Ok(())
}

/// Checks all meshes as if the scene contained them.
fn check_meshes(gear: &mut Gear<'_>) -> Result<()> {
    let document = gear.document;
    let mut taken = 0;
    for (i, mesh) in document.as_json().meshes.iter().enumerate() {
        for primitive in &mesh.primitives {
            check_counts(gear, i, primitive)?;
            taken += primitive::size(gear, i, primitive)?;
            // Many meshes may share their data, so the amount that is read has a limit.
            if taken > primitive::budget(gear) {
                return Ok(());
            }
        }
    }
    Ok(())
}

/// Checks that all attributes of a primitive of mesh `index` have the same number of vertices.
fn check_counts(gear: &Gear<'_>, index: usize, primitive: &Primitive) -> Result<()> {
    let accessors = &gear.document.as_json().accessors;
    let accessor = |i: usize| accessors.get(i).map(|accessor| (i, accessor.count.0));
    let mut counts = primitive.attributes.values().filter_map(|i| accessor(i.value()));
    let Some((first, count)) = counts.next() else { return Ok(()) };
    let Some((other, wrong)) = counts.find(|&(_, other)| other != count) else { return Ok(()) };
    let what = format!(
        "has a mesh whose attributes differ in count: accessor {first} has {count} items, \
         accessor {other} has {wrong}"
    );
    Err(Error::new(gear.buffers.path, what, EXPORT_AGAIN)
        .at(Location::Element("mesh", index as u64)))
}
