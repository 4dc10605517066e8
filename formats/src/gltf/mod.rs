//! Reader of glTF and GLB files.
//!
//! It uses the `gltf` crate without its `import` function, which leaves the folder of the file and
//! needs textures. The crate parses the JSON and reads the accessors. It trusts both of them: wrong
//! indices, offsets or counts make it panic or return nothing. So this module checks everything
//! before it calls the crate.

mod accessor;
mod buffers;
mod draco;
mod extras;
mod fault;
mod glb;
mod graph;
mod instances;
mod mesh;
mod packed;
mod primitive;
mod scene;
mod text;
mod transform;

use std::collections::BTreeMap;
use std::io::Read;

use ::gltf::json::mesh::{Primitive, Semantic};
use ::gltf::json::validation::Checked;
use ::gltf::{Document, json};

use self::buffers::Buffers;
use self::extras::Extras;
use self::mesh::MeshKey;
use self::text::Scenes;
use crate::scene::{MeshId, Scene, SceneNote};
use crate::source::Source;
use crate::token::excerpt;
use crate::{Error, LengthUnit, Result};

/// Extensions that a file may require because they do not change the geometry.
const HARMLESS: [&str; 7] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_",
    "KHR_animation_",
    "KHR_xmp",
];

/// The data that the readers of this module share.
struct Gear<'a> {
    document: &'a Document,
    scenes: Scenes,
    extras: Extras,
    buffers: Buffers<'a>,
    /// The meshes that were read.
    meshes: BTreeMap<MeshKey, Option<MeshId>>,
    /// The number of bytes that their soups take.
    taken: u64,
}

pub(crate) fn read(mut source: Source) -> Result<Scene> {
    let (text, blob) = match glb::is_glb(&source.head) {
        true => glb::read(&mut source)?,
        false => (read_text(&mut source)?, None),
    };
    let (mut root, scenes, extras) = text::parse(&source, text)?;
    refuse_extensions(&source, &root)?;
    let packed = packed::add_buffers(&mut root, &extras.packed);
    // Do not use the validation of the crate. It would refuse quantized positions, and many faults
    // that do not concern the mesh.
    let document = Document::from_json_without_validation(root);
    let buffers = Buffers::new(&source, &document.as_json().buffers, blob, packed);
    let meshes = BTreeMap::new();
    let mut gear = Gear { document: &document, scenes, extras, buffers, meshes, taken: 0 };
    let mut scene = Scene::new(&source.path, 0);
    (scene.unit, scene.is_y_up) = (Some(LengthUnit::Metre), true);
    if gear.extras.has_bad_materials {
        scene.notes.push(SceneNote::NoMaterials("its materials cannot be read".into()));
    }
    let placed = scene::read(&mut gear, &mut scene)?;
    if !scene.has_polygons() {
        return Err(fault::explain(&mut gear, placed));
    }
    scene.set_bytes(gear.buffers.bytes);
    Ok(scene)
}

impl Gear<'_> {
    /// What tells a primitive from others: its data and its material.
    fn key(&self, mesh: usize, number: usize, primitive: &Primitive) -> [Option<usize>; 5] {
        let position = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
        let mode = match primitive.mode {
            Checked::Valid(mode) => mode as usize,
            // Each such primitive is refused.
            Checked::Invalid => usize::MAX,
        };
        let draco = self.extras.draco.get(&(mesh, number)).map(|draco| draco.buffer_view);
        let indices = primitive.indices.map(|indices| indices.value());
        let material = primitive.material.map(|material| material.value());
        [position.map(|at| at.value()), indices, material, draco, Some(mode)]
    }
}

/// Reads a file that consists of JSON only. Its largest size is that of a GLB.
fn read_text(source: &mut Source) -> Result<Vec<u8>> {
    let mut text = Vec::new();
    let read = (&mut source.stream).take(u64::from(u32::MAX)).read_to_end(&mut text);
    read.map_err(|e| source.io_error(&e))?;
    Ok(text)
}

fn wrong_version(source: &Source, version: &str) -> Error {
    let what = format!("is of glTF version {}", excerpt(version.as_bytes()));
    source.error(what, "Export it as glTF 2.0.")
}

/// Refuses required extensions that change the geometry and are not supported.
fn refuse_extensions(source: &Source, root: &json::Root) -> Result<()> {
    for name in root.extensions_required.iter().map(String::as_str) {
        let harmless = HARMLESS.iter().any(|prefix| name.starts_with(prefix));
        if !harmless && !extras::READ.contains(&name) && name != "KHR_mesh_quantization" {
            let what = format!("requires the extension {}", excerpt(name.as_bytes()));
            let help = "Export it without this extension, or as PLY, OBJ or STL.";
            return Err(source.error(what, help));
        }
    }
    Ok(())
}
