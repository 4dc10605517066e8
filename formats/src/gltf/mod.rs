//! glTF and GLB: the `gltf` crate without its `import`, which leaves the
//! file's folder and needs the textures.
//!
//! The crate parses the JSON and reads the accessors. It trusts both: indices,
//! offsets and counts that do not fit make it panic or silently read nothing.
//! So nothing of it is asked that was not checked here before.

mod accessor;
mod buffers;
mod primitive;
mod scene;
mod transform;

use std::io::Read;
use std::path::Path;

use ::gltf::{Document, Gltf, json};

use self::buffers::Buffers;
use crate::source::{EXPORT_AGAIN, Source};
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
    buffers: Buffers<'a>,
    /// Of one that is used, if any: it explains data that is not there.
    compression: Option<&'a str>,
}

pub(crate) fn read(mut source: Source) -> Result<Soup> {
    let Gltf { document, blob } = {
        // Only for now: the crate copies the binary chunk.
        let bytes = read_bytes(&mut source)?;
        parse(&source, &bytes)?
    };
    let root = document.as_json();
    let compression = refuse_extensions(&source, root)?;
    let buffers = Buffers::new(&source.path, &root.buffers, blob);
    let mut gear = Gear { document: &document, buffers, compression };
    let mut soup = Soup { unit: Some(LengthUnit::Metre), ..Soup::default() };
    scene::read(&mut gear, &mut soup)?;
    if soup.polygons.is_empty() {
        let help = "Export the meshes with faces, as nodes of the file's default scene.";
        return Err(source.error("has no triangles in its default scene", help));
    }
    Ok(soup)
}

/// The whole file; of a GLB just as much as its header says.
fn read_bytes(source: &mut Source) -> Result<Vec<u8>> {
    let length = match source.head.get(8..12) {
        Some(&[a, b, c, d]) if is_glb(&source.head) => u32::from_le_bytes([a, b, c, d]),
        _ => u32::MAX,
    };
    let mut bytes = Vec::new();
    let read = (&mut source.stream).take(u64::from(length)).read_to_end(&mut bytes);
    read.map_err(|e| source.io_error(&e))?;
    if is_glb(&source.head) && (bytes.len() as u64) < u64::from(length) {
        let what = format!("ends after {} of its {length} bytes", bytes.len());
        return Err(source.error(what, EXPORT_AGAIN));
    }
    Ok(bytes)
}

fn is_glb(head: &[u8]) -> bool {
    head.starts_with(b"glTF")
}

fn parse(source: &Source, bytes: &[u8]) -> Result<Gltf> {
    // The crate subtracts a GLB's header from its length without a look.
    if is_glb(bytes) && bytes.len() < 20 {
        return Err(source.error("is no complete GLB file", EXPORT_AGAIN));
    }
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    // Without the crate's validation: it would refuse quantized positions,
    // and much that does not concern the mesh.
    let parsed = Gltf::from_slice_without_validation(text);
    let gltf = parsed
        .map_err(|e| source.error(format!("is no sound glTF 2.0 file: {e}"), EXPORT_AGAIN))?;
    let version = &gltf.as_json().asset.version;
    if version.starts_with("2.") {
        return Ok(gltf);
    }
    let what = format!("is of glTF version {}", excerpt(version.as_bytes()));
    Err(source.error(what, "Export it as glTF 2.0."))
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
