//! Reading a scan of whichever format.

use std::path::Path;

use crate::source::Source;
use crate::{Error, Result, Soup, gltf, obj, ply, stl};

/// A mesh format that [`read_scan`] reads, plain or gzipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Stanford polygon file, ascii or binary.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// glTF 2.0 as JSON text.
    Gltf,
    /// glTF 2.0 in one binary file.
    Glb,
    /// Stereolithography, ascii or binary.
    Stl,
}

impl Format {
    /// The format of the file at `path`: what its content says or, where that
    /// is silent, what its extension says.
    ///
    /// # Errors
    /// The file cannot be opened, or is of no format that is read here.
    pub fn of(path: &Path) -> Result<Format> {
        recognise(&Source::open(path)?)
    }
}

/// Reads the mesh in the file at `path`: its points in the file's order,
/// unused ones included, and its polygons (of three corners or more) as they
/// are. Of a glTF file that is the default scene, with the nodes' transforms
/// applied, but neither skins nor morph targets.
///
/// # Errors
/// The file cannot be read, is damaged, contradicts itself, needs what is not
/// supported, or has no polygons. Memory grows with what the file really
/// holds, whatever it claims.
pub fn read_scan(path: &Path) -> Result<Soup> {
    let source = Source::open(path)?;
    let soup = match recognise(&source)? {
        Format::Ply => ply::read(source),
        Format::Obj => obj::read(source),
        Format::Gltf | Format::Glb => gltf::read(source),
        Format::Stl => stl::read(source),
    }?;
    if !soup.polygons.is_empty() {
        return Ok(soup);
    }
    if soup.points.is_empty() {
        let help = "Check that the right object was exported from the scanner's program.";
        return Err(Error::new(path, "has neither points nor faces", help));
    }
    let help = "Mesh the points first, for example in MeshLab (ball pivoting or screened \
                Poisson), and save them with faces.";
    Err(Error::new(path, "has points but no faces", help))
}

const READABLE: &str = "Convert it to PLY, OBJ, glTF (GLB) or STL, for example with MeshLab.";

fn recognise(source: &Source) -> Result<Format> {
    let head = source.head.as_slice();
    if head.is_empty() {
        return Err(Error::new(&source.path, "is empty", "Copy or export the scan again."));
    }
    if let Some(format) = by_content(source) {
        return Ok(format);
    }
    if let Some(foreign) = foreign(head) {
        return Err(Error::new(&source.path, format!("is {foreign}"), READABLE));
    }
    let unknown = || Error::new(&source.path, "is of no known mesh format", READABLE);
    by_extension(&source.path).ok_or_else(unknown)
}

fn by_content(source: &Source) -> Option<Format> {
    let head = source.head.as_slice();
    if head.starts_with(b"ply") && head.get(3).is_some_and(u8::is_ascii_whitespace) {
        return Some(Format::Ply);
    }
    if head.starts_with(b"glTF") {
        return Some(Format::Glb);
    }
    if stl::is_ascii(head) || stl::is_binary(head, source.len) {
        return Some(Format::Stl);
    }
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    if text.iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'{') {
        return Some(Format::Gltf);
    }
    obj::is_obj(text).then_some(Format::Obj)
}

fn by_extension(path: &Path) -> Option<Format> {
    let name = path.file_name()?.to_string_lossy().to_ascii_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    match name.rsplit_once('.')?.1 {
        "ply" => Some(Format::Ply),
        "obj" => Some(Format::Obj),
        "gltf" => Some(Format::Gltf),
        "glb" => Some(Format::Glb),
        "stl" => Some(Format::Stl),
        _ => None,
    }
}

/// What the file is, if it is something that is often mistaken for a mesh.
fn foreign(head: &[u8]) -> Option<&'static str> {
    let known: [(&[u8], &str); 12] = [
        (b"PK\x03\x04", "a ZIP archive (perhaps 3MF)"),
        (b"\x1f\x8b", "gzipped twice"),
        (b"BZh", "packed with bzip2"),
        (b"\xfd7zXZ", "packed with xz"),
        (b"\x28\xb5\x2f\xfd", "packed with zstd"),
        (b"# .PCD", "a PCD point cloud"),
        (b"OFF", "an OFF mesh"),
        (b"Kaydara FBX", "an FBX scene"),
        (b"ASTM-E57", "an E57 point cloud"),
        (b"LASF", "a LAS point cloud"),
        (b"ISO-10303-21", "a STEP file, not a scan"),
        (b"\xff\xfe", "UTF-16 text"),
    ];
    known.iter().find(|(magic, _)| head.starts_with(magic)).map(|(_, name)| *name)
}
