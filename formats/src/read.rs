//! Reading of a scan in any supported format.
//!
//! The input is a file or a stream. The output is a [`Soup`]. The content decides on the format
//! where possible, otherwise the extension of the name does.

use std::io::Read;
use std::path::Path;

use crate::scene::{Scene, SceneMesh};
use crate::source::Source;
use crate::{Error, Result, Soup, damage, gltf, obj, off, ply, stl, threemf};

/// A mesh format that [`read_scan`] reads, plain or gzipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// Stanford polygon format, ASCII or binary.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// glTF 2.0 as JSON text.
    Gltf,
    /// glTF 2.0 as one binary file.
    Glb,
    /// Stereolithography format, ASCII or binary.
    Stl,
    /// Object File Format of Geomview, as text.
    Off,
    /// 3D Manufacturing Format.
    ThreeMf,
}

impl Format {
    /// The format of the file at `path`. The content of the file decides. If it is ambiguous, the
    /// extension does.
    ///
    /// # Errors
    /// The file cannot be opened, or its format is not supported.
    pub fn of(path: &Path) -> Result<Format> {
        recognise(&Source::open(path)?)
    }

    /// The format that the extension of `path` stands for, if it stands for one. A second extension
    /// for gzip is ignored. The file is not opened.
    pub fn by_extension(path: &Path) -> Option<Format> {
        let name = path.file_name()?.to_string_lossy().to_ascii_lowercase();
        let name = name.strip_suffix(".gz").unwrap_or(&name);
        match name.rsplit_once('.')?.1 {
            "ply" => Some(Format::Ply),
            "obj" => Some(Format::Obj),
            "gltf" => Some(Format::Gltf),
            "glb" => Some(Format::Glb),
            "stl" => Some(Format::Stl),
            "off" => Some(Format::Off),
            "3mf" => Some(Format::ThreeMf),
            _ => None,
        }
    }
}

/// Reads the scene in the file at `path`: meshes, their names and colours, and where they are placed. A file with one
/// mesh is a scene with one node.
///
/// # Errors
/// Those of [`read_scan`], but a scene may place its meshes as often as it likes.
pub fn read_scene(path: &Path) -> Result<Scene> {
    checked(Source::open(path)?)
}

/// Reads a scene from memory or any other stream, as [`read_scan_from`] does.
///
/// # Errors
/// Those of [`read_scan_from`].
pub fn read_scene_from(
    name: &Path,
    content: impl Read + 'static,
    folder: Option<&Path>,
) -> Result<Scene> {
    checked(Source::new(name, content, None, folder)?)
}

/// Reads the mesh in the file at `path`: its scene as one mesh ([`Scene::into_soup`]).
///
/// The result has all points in the order of the file, including unused ones, and the polygons of
/// three or more corners without any change. For a glTF file this is the default scene with the
/// transforms of its nodes applied. Skins and morph targets are ignored.
///
/// # Errors
/// The file cannot be read, is damaged, is inconsistent, requires an unsupported feature, or has no
/// polygons. The memory depends on the actual content of the file, whatever counts it claims.
pub fn read_scan(path: &Path) -> Result<Soup> {
    checked(Source::open(path)?)?.into_soup()
}

/// Reads a mesh from memory or any other stream as [`read_scan`] does. Use a
/// [`Cursor`](std::io::Cursor) that owns the bytes to read from memory.
///
/// Errors call the file `name`. Its extension decides on the format if the content is ambiguous.
/// A binary STL has no mark, and its length is not known in a stream. Without an extension it is
/// recognized by its first triangles. No file with this name is opened.
///
/// `folder` is the folder in which a glTF file may have its buffers. With `None` it may not refer
/// to any file. This is the right choice for content from an untrusted source.
///
/// ```
/// let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// let content = std::io::Cursor::new(text);
/// let soup = formats::read_scan_from("upload.obj".as_ref(), content, None)?;
/// assert_eq!((soup.points.len(), soup.polygons.len()), (3, 1));
/// # Ok::<(), formats::Error>(())
/// ```
///
/// # Errors
/// The same as those of [`read_scan`]. In addition, a glTF file may need a buffer in another file
/// although `folder` is `None`.
pub fn read_scan_from(
    name: &Path,
    content: impl Read + 'static,
    folder: Option<&Path>,
) -> Result<Soup> {
    checked(Source::new(name, content, None, folder)?)?.into_soup()
}

/// Reads a scene that has faces.
fn checked(source: Source) -> Result<Scene> {
    let path = source.path.clone();
    let scene = read_unchecked(source)?;
    if scene.has_polygons() {
        return Ok(scene);
    }
    if scene.meshes().iter().all(|mesh| mesh.soup.points.is_empty()) {
        let help = "Check that the right object was exported from the scanner's program.";
        return Err(Error::new(path, "has neither points nor faces", help));
    }
    Err(Error::new(path, "has points but no faces", MESH_FIRST))
}

/// Reads a scene that may have no faces.
pub(crate) fn read_unchecked(source: Source) -> Result<Scene> {
    let (head, path) = (source.head.clone(), source.path.clone());
    let format = recognise(&source)?;
    let alone = |soup: Soup| Scene::of_mesh(&path, SceneMesh::plain(soup));
    let scene = match format {
        Format::Ply => ply::read(source).map(alone),
        Format::Obj => obj::read(source),
        Format::Gltf | Format::Glb => gltf::read(source),
        Format::Stl => stl::read(source),
        Format::Off => off::read(source).map(alone),
        Format::ThreeMf => threemf::read(source),
    };
    scene.map_err(|e| damage::explain(e, format, &head))
}

pub(crate) const READABLE: &str =
    "Convert it to PLY, OBJ, glTF (GLB), 3MF, STL or OFF, for example with MeshLab.";
const MESH_FIRST: &str = "Mesh the points first, for example in MeshLab (ball pivoting or screened \
                          Poisson), and save them with faces as PLY, OBJ, glTF (GLB) or STL.";
const UTF_8: &str = "Save it as plain text (ASCII or UTF-8), or export it as binary PLY.";

fn recognise(source: &Source) -> Result<Format> {
    let head = source.head.as_slice();
    if head.is_empty() {
        return Err(Error::new(&source.path, "is empty", "Copy or export the scan again."));
    }
    if let Some(format) = by_content(source) {
        return Ok(format);
    }
    if let Some((foreign, help)) = foreign(head) {
        return Err(Error::new(&source.path, format!("is {foreign}"), help));
    }
    // OBJ is tested last, because any text may have a line that looks like a vertex.
    if obj::is_obj(after_mark(head)) {
        return Ok(Format::Obj);
    }
    let unknown = || Error::new(&source.path, "is not in a known mesh format", READABLE);
    let by_name = Format::by_extension(&source.path);
    let by_records = || stl::begins_as_binary(head).then_some(Format::Stl);
    by_name.or_else(by_records).ok_or_else(unknown)
}

pub(crate) fn by_content(source: &Source) -> Option<Format> {
    let head = source.head.as_slice();
    // STL is tested first, because a binary file may begin with any word.
    if stl::is_binary(head, source.len) || stl::is_ascii(head) {
        return Some(Format::Stl);
    }
    if head.starts_with(b"glTF") {
        return Some(Format::Glb);
    }
    if threemf::is_zip(head) && !is_usd(head) {
        return Some(Format::ThreeMf);
    }
    let text = after_mark(head);
    if ply::is_ply(text) {
        return Some(Format::Ply);
    }
    if off::is_off(text) {
        return Some(Format::Off);
    }
    let begins = text.iter().find(|b| !b.is_ascii_whitespace());
    // A NUL byte after the brace would mean UTF-16.
    (begins == Some(&b'{') && !text.contains(&0)).then_some(Format::Gltf)
}

/// What to do about a Gaussian splat whose points cannot be read.
pub(crate) const UNPACK_SPLAT: &str = "Open it in SuperSplat (superspl.at/editor) and export it as PLY without compression, or convert it with \
     \u{201c}splat-transform FILE scan.ply\u{201d}: the centres of its splats are then read as a cloud.";
const USD: &str =
    "Open it in Blender (File > Import > Universal Scene Description) and export it as glTF (GLB).";

/// The name of the first file in a ZIP archive that begins with `head`.
fn first_in_zip(head: &[u8]) -> Option<&[u8]> {
    let head = head.strip_prefix(b"PK\x03\x04")?;
    let length = usize::from(*head.get(22)?) + 256 * usize::from(*head.get(23)?);
    head.get(26..26 + length)
}

/// Whether `head` begins a scene of USD, alone or packed as USDZ.
fn is_usd(head: &[u8]) -> bool {
    let is_usd_name = |name: &[u8]| {
        let name = name.to_ascii_lowercase();
        [&b".usd"[..], b".usda", b".usdc"].iter().any(|extension| name.ends_with(extension))
    };
    head.starts_with(b"PXR-USDC")
        || head.starts_with(b"#usda ")
        || first_in_zip(head).is_some_and(is_usd_name)
}

/// `head` without the byte order mark that some editors insert before text.
pub(crate) fn after_mark(head: &[u8]) -> &[u8] {
    head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head)
}

/// The format of a file that is often mistaken for a mesh, and what to do about it.
pub(crate) fn foreign(head: &[u8]) -> Option<(&'static str, &'static str)> {
    if is_usd(head) {
        return Some(("a scene of Universal Scene Description (USDZ or USD)", USD));
    }
    if head.starts_with(b"NGSP") {
        return Some(("a compressed Gaussian splat (SPZ)", UNPACK_SPLAT));
    }
    let known: [(&[u8], &str); 6] = [
        (b"\x1f\x8b", "gzipped twice"),
        (b"BZh", "packed with bzip2"),
        (b"\xfd7zXZ", "packed with xz"),
        (b"\x28\xb5\x2f\xfd", "packed with zstd"),
        (b"Kaydara FBX", "an FBX scene"),
        (b"ISO-10303-21", "a STEP file, not a scan"),
    ];
    if let Some((_, name)) = known.iter().find(|(magic, _)| head.starts_with(magic)) {
        return Some((name, READABLE));
    }
    let clouds: [(&[u8], &str); 3] = [
        (b"# .PCD", "a PCD point cloud"),
        (b"ASTM-E57", "an E57 point cloud"),
        (b"LASF", "a LAS point cloud"),
    ];
    if let Some((_, name)) = clouds.iter().find(|(magic, _)| head.starts_with(magic)) {
        return Some((name, MESH_FIRST));
    }
    if is_utf_16(head) {
        return Some(("UTF-16 text", UTF_8));
    }
    // The second byte of gzip is not UTF-8, so that a conversion replaced it.
    if head.starts_with(b"\x1f\xef\xbf\xbd") {
        return Some(("gzipped, but its bytes were converted to text", damage::SEND_AS_BINARY));
    }
    if head.starts_with(b"version https://git-lfs.github.com/spec/") {
        let help = "Fetch the file itself with \u{201c}git lfs pull\u{201d}.";
        return Some(("a git-lfs pointer, not the file itself", help));
    }
    let text = after_mark(head).trim_ascii_start();
    let begins =
        |w: &str| text.get(..w.len()).is_some_and(|t| t.eq_ignore_ascii_case(w.as_bytes()));
    let help = "Download the file itself: this is a page about it, or about an error.";
    (begins("<!doctype html") || begins("<html")).then_some(("a web page (HTML)", help))
}

/// Whether `head` begins with the byte order mark of UTF-16, or with ASCII in two bytes per
/// character.
fn is_utf_16(head: &[u8]) -> bool {
    let pairs = head[..head.len().min(64)].as_chunks::<2>().0;
    let is_ascii = |byte: u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    let wide = |high: usize| pairs.iter().all(|p| p[high] == 0 && is_ascii(p[1 - high]));
    head.starts_with(b"\xff\xfe")
        || head.starts_with(b"\xfe\xff")
        || pairs.len() >= 4 && (wide(0) || wide(1))
}
