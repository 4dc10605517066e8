//! glTF and GLB: the `gltf` crate without its `import`, which leaves the
//! file's folder and needs the textures.
//!
//! The crate parses the JSON and reads the accessors. It trusts both: indices,
//! offsets and counts that do not fit make it panic or silently read nothing.
//! So nothing of it is asked that was not checked here before.

mod accessor;
mod buffers;
mod fault;
mod glb;
mod graph;
mod primitive;
mod scene;
mod text;
mod transform;

use std::io::Read;
use std::path::Path;

use ::gltf::{Document, json};

use self::buffers::Buffers;
use self::text::Scenes;
use crate::source::Source;
use crate::token::excerpt;
use crate::{Error, LengthUnit, Result, Soup};

/// Compressions of geometry: what needs them cannot be read.
const COMPRESSIONS: [&str; 3] =
    ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Extensions that a file may require without the geometry changing.
const HARMLESS: [&str; 7] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_",
    "KHR_animation_",
    "KHR_xmp",
];

/// The parts of the crate's document that the readers share.
struct Gear<'a> {
    document: &'a Document,
    scenes: Scenes,
    buffers: Buffers<'a>,
    /// Of one that is used, if any: it explains data that is not there.
    compression: Option<&'a str>,
}

pub(crate) fn read(mut source: Source) -> Result<Soup> {
    let (text, blob) = match glb::is_glb(&source.head) {
        true => glb::read(&mut source)?,
        false => (read_text(&mut source)?, None),
    };
    let (root, scenes) = text::parse(&source, text)?;
    // Without the crate's validation: it would refuse quantized positions,
    // and much that does not concern the mesh.
    let document = Document::from_json_without_validation(root);
    let root = document.as_json();
    let compression = refuse_extensions(&source, root)?;
    let buffers = Buffers::new(&source, &root.buffers, blob);
    let mut gear = Gear { document: &document, scenes, buffers, compression };
    let mut soup = Soup { unit: Some(LengthUnit::Metre), ..Soup::default() };
    let placed = scene::read(&mut gear, &mut soup)?;
    if soup.polygons.is_empty() {
        return Err(fault::explain(&mut gear, placed));
    }
    Ok(soup)
}

/// A file that is all JSON, which is no longer than a GLB can be.
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

/// Refuses what changes the geometry in ways that are not read here. Returns
/// the name of a compression that the file could do without.
fn refuse_extensions<'a>(source: &Source, root: &'a json::Root) -> Result<Option<&'a str>> {
    for name in root.extensions_required.iter().map(String::as_str) {
        if COMPRESSIONS.contains(&name) {
            return Err(compressed(&source.path, name));
        }
        let harmless = HARMLESS.iter().any(|prefix| name.starts_with(prefix));
        if !harmless && name != "KHR_mesh_quantization" {
            let what = format!("requires the extension {}", excerpt(name.as_bytes()));
            let help = "Export it without this extension, or as PLY, OBJ or STL.";
            return Err(source.error(what, help));
        }
    }
    let used = root.extensions_used.iter().map(String::as_str);
    Ok(used.into_iter().find(|name| COMPRESSIONS.contains(name)))
}

fn compressed(path: &Path, name: &str) -> Error {
    let help = "Decompress it first (for example: gltf-transform copy in.glb out.glb), or \
                export it without compression.";
    Error::new(path, format!("is compressed with {name}, which is not supported"), help)
}
