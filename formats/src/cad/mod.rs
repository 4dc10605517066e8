//! Readers of CAD files: the trimmed faces of STEP and IGES files.
//!
//! The readers return the faces of every shell, every trimmed surface and every free surface, with their places in the
//! assembly. The surfaces may be B-spline surfaces (rational or not), planes, cylinders, cones, spheres, tori, surfaces of
//! revolution and of linear extrusion, offsets of these, and parts of these. The edges may be lines, conics, polylines and
//! B-spline curves, with or without pcurves. A face on any other surface is an error that names it, because a missing
//! face would look like a hole, and so is a part whose place is unknown.

pub(crate) mod affine;
mod model;

use std::fs::File;
use std::io::Read;
use std::path::Path;

pub use model::{
    CadCurve, CadEdge, CadFace, CadModel, CadPlace, CadShell, CadSolid, CadSurface, CurveShape,
};

use crate::words::plural;
use crate::{Error, Result, iges, step};

/// The size in bytes of the largest file that is read.
const MOST_BYTES: u64 = 4 << 30;

/// The number of bytes that tell the format.
const HEAD: u64 = 8192;

/// Reads the faces in the STEP or IGES file at `path`. The content of the file decides on the
/// format.
///
/// # Errors
/// The file cannot be read, has neither format, is damaged, has no face, or has a face that is not
/// supported. The memory depends on the actual content of the file, whatever counts it claims.
pub fn read_cad(path: &Path) -> Result<CadModel> {
    let cannot = |e: std::io::Error| {
        let what = format!("cannot be opened: {e}");
        Error::new(path, what, "Check the path and the permissions of the file.")
    };
    let file = File::open(path).map_err(cannot)?;
    let meta = file.metadata().map_err(cannot)?;
    crate::source::check_kind(path, &meta, "Name the CAD file itself.")?;
    let length = meta.len();
    if length > MOST_BYTES {
        let what =
            format!("has {}, which is more than the limit for CAD files", plural(length, "byte"));
        return Err(too_long(path, what));
    }
    read_cad_stream(path, file)
}

/// Reads CAD faces from a stream as [`read_cad`] does. Errors call it `name`.
///
/// # Errors
/// The same as those of [`read_cad`].
pub fn read_cad_stream(name: &Path, mut content: impl Read) -> Result<CadModel> {
    let mut bytes = Vec::new();
    let cannot = |e: std::io::Error| {
        let what = format!("cannot be read to its end: {e}");
        Error::new(name, what, "Send the whole file again.")
    };
    content.by_ref().take(HEAD).read_to_end(&mut bytes).map_err(cannot)?;
    // Whatever has no end, as a device, is not read to its end.
    if !is_step(&bytes) && !iges::read::is_iges(&bytes) {
        return Err(neither(name, &bytes));
    }
    content.take(MOST_BYTES + 1 - HEAD).read_to_end(&mut bytes).map_err(cannot)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(too_long(name, "has more bytes than the limit for CAD files"));
    }
    read_cad_from(name, &bytes)
}

/// Whether bytes begin as a STEP file does, perhaps after a byte order mark, blanks or a comment.
fn is_step(bytes: &[u8]) -> bool {
    let head = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = head.trim_ascii_start();
    text.starts_with(b"ISO-10303-21") || text.starts_with(b"/*")
}

fn neither(name: &Path, bytes: &[u8]) -> Error {
    let what = if bytes.is_empty() { "is empty" } else { "is neither STEP nor IGES" };
    let help = "Name a CAD file: .step, .stp, .igs or .iges, as text and not zipped.";
    Error::new(name, what, help)
}

fn too_long(name: &Path, what: impl Into<String>) -> Error {
    Error::new(name, what, "Export the faces in several files.")
}

/// Reads CAD faces from memory as [`read_cad`] does. Errors call the file `name`.
///
/// # Errors
/// The same as those of [`read_cad`].
pub fn read_cad_from(name: &Path, bytes: &[u8]) -> Result<CadModel> {
    let model = if is_step(bytes) {
        step::read::read(name, bytes)?
    } else if iges::read::is_iges(bytes) {
        iges::read::read(name, bytes)?
    } else {
        return Err(neither(name, bytes));
    };
    if model.faces.is_empty() {
        let help = "Export the faces themselves: a shell, a solid, or trimmed surfaces.";
        return Err(Error::new(name, "has no faces", help));
    }
    Ok(model)
}
