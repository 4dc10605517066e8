//! Reader of glTF and GLB files.
//!
//! It uses the `gltf` crate without its `import` function, which leaves the folder of the file and
//! needs textures. The crate parses the JSON and reads the accessors. It trusts both of them: wrong
//! indices, offsets or counts make it panic or return nothing. So this module checks everything
//! before it calls the crate.

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

/// Compressions of geometry. Files that require them cannot be read.
const COMPRESSIONS: [&str; 3] =
    ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

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
    buffers: Buffers<'a>,
    /// The name of a compression that the file uses, if any. It explains missing data.
    compression: Option<&'a str>,
}

pub(crate) fn read(mut source: Source) -> Result<Soup> {
    let (text, blob) = match glb::is_glb(&source.head) {
        true => glb::read(&mut source)?,
        false => (read_text(&mut source)?, None),
    };
    let (root, scenes) = text::parse(&source, text)?;
    // Do not use the validation of the crate. It would refuse quantized positions, and many faults
    // that do not concern the mesh.
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

/// Refuses required extensions that change the geometry and are not supported. Returns the name of
/// a compression that the file uses but does not require.
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
