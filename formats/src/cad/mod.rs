//! Readers of CAD files: the trimmed faces of STEP and IGES files.
//!
//! The readers return the faces of every shell and every trimmed surface. The surfaces may be
//! B-spline surfaces (rational or not), planes, cylinders, cones, spheres, tori, surfaces of
//! revolution and of linear extrusion, and offsets of these. The edges may be lines, circles, ellipses, polylines and B-spline curves, with
//! or without pcurves. A face on any other surface is an error that names it, because a missing
//! face would look like a hole.

pub(crate) mod affine;
mod model;

use std::io::Read;
use std::path::Path;

pub use model::{CadCurve, CadEdge, CadFace, CadModel, CadShell, CadSolid, CadSurface, CurveShape};

use crate::words::plural;
use crate::{Error, Result, iges, step};

/// The size in bytes of the largest file that is read.
const MOST_BYTES: u64 = 4 << 30;

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
    let length = std::fs::metadata(path).map_err(cannot)?.len();
    if length > MOST_BYTES {
        let what =
            format!("has {}, which is more than the limit for CAD files", plural(length, "byte"));
        return Err(too_long(path, what));
    }
    read_cad_from(path, &std::fs::read(path).map_err(cannot)?)
}

/// Reads CAD faces from a stream as [`read_cad`] does. Errors call it `name`.
///
/// # Errors
/// The same as those of [`read_cad`].
pub fn read_cad_stream(name: &Path, content: impl Read) -> Result<CadModel> {
    let mut bytes = Vec::new();
    content.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(|e| {
        let what = format!("cannot be read to its end: {e}");
        Error::new(name, what, "Send the whole file again.")
    })?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(too_long(name, "has more bytes than the limit for CAD files"));
    }
    read_cad_from(name, &bytes)
}

fn too_long(name: &Path, what: impl Into<String>) -> Error {
    Error::new(name, what, "Export the faces in several files.")
}

/// Reads CAD faces from memory as [`read_cad`] does. Errors call the file `name`.
///
/// # Errors
/// The same as those of [`read_cad`].
pub fn read_cad_from(name: &Path, bytes: &[u8]) -> Result<CadModel> {
    let head = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = head.trim_ascii_start();
    let model = if text.starts_with(b"ISO-10303-21") || text.starts_with(b"/*") {
        step::read::read(name, bytes)?
    } else if iges::read::is_iges(bytes) {
        iges::read::read(name, bytes)?
    } else {
        let what = if bytes.is_empty() { "is empty" } else { "is neither STEP nor IGES" };
        let help = "Name a CAD file: .step, .stp, .igs or .iges, as text and not zipped.";
        return Err(Error::new(name, what, help));
    };
    if model.faces.is_empty() {
        let help = "Export the faces themselves: a shell, a solid, or trimmed surfaces.";
        return Err(Error::new(name, "has no faces", help));
    }
    Ok(model)
}
