//! The meshes of a glTF file. Each is held once, and so are meshes that share all their data.

use super::scene::bad;
use super::{Gear, primitive};
use crate::scene::{ColourRuns, MeshId, Scene, SceneMesh, SceneNote, clean_name};
use crate::{Result, Soup};

/// What a mesh is made of: its name, and for each primitive its data and its material.
pub(super) type MeshKey = (Option<String>, Vec<[Option<usize>; 5]>);

/// The number in `scene` of mesh `index`, which is read if no mesh before is the same. `None` if it has no points.
pub(super) fn read(gear: &mut Gear<'_>, index: usize, scene: &mut Scene) -> Result<Option<MeshId>> {
    let Some(json) = gear.document.as_json().meshes.get(index) else {
        return Err(bad(gear, "mesh", index, "does not exist"));
    };
    let name = json.name.as_deref().and_then(clean_name);
    let of_primitive = |(number, primitive)| gear.key(index, number, primitive);
    let key: MeshKey = (name, json.primitives.iter().enumerate().map(of_primitive).collect());
    if let Some(&known) = gear.meshes.get(&key) {
        return Ok(known);
    }
    let mut mesh = SceneMesh::plain(Soup { unit: scene.unit, ..Soup::default() });
    let mut colours = ColourRuns::default();
    for (number, primitive) in json.primitives.iter().enumerate() {
        primitive::read(gear, (index, number), primitive, &mut mesh.soup)?;
        let material = primitive.material.map(|material| material.value());
        let colour = material.and_then(|material| gear.extras.colours.get(material).copied());
        colours.extend_to(mesh.soup.polygons.len(), colour.flatten());
        if primitive.targets.is_some() && !scene.notes.contains(&SceneNote::Undeformed) {
            scene.notes.push(SceneNote::Undeformed);
        }
    }
    colours.give(&mut mesh);
    mesh.name.clone_from(&key.0);
    let is_empty = mesh.soup.points.is_empty();
    let number = (!is_empty).then(|| scene.add_mesh(mesh));
    gear.meshes.insert(key, number);
    Ok(number)
}
