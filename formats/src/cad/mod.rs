//! Reading CAD files: STEP and IGES, the trimmed faces in them.
//!
//! Read are the faces of every shell and every trimmed surface on B-spline
//! surfaces (rational or not), planes, cylinders, surfaces of linear extrusion
//! and offsets of these, with edges on lines, circles, ellipses, polylines and
//! B-spline curves, with pcurves or without. A face on anything else is an error
//! that names it: a face left out in silence would look like a hole.

pub(crate) mod affine;
mod model;

use std::path::Path;

pub use model::{CadCurve, CadEdge, CadFace, CadModel, CadShell, CadSolid, CadSurface, CurveShape};

use crate::{Error, Result, iges, step};

/// Larger files are refused.
const MOST_BYTES: u64 = 4 << 30;

/// Reads the faces in the STEP or IGES file at `path`; its content says which it
/// is.
///
/// # Errors
/// The file cannot be read, is neither, is damaged, has no face, or one that is
/// not read here. Memory grows with what the file really holds, whatever it
/// claims.
pub fn read_cad(path: &Path) -> Result<CadModel> {
    let cannot = |e: std::io::Error| {
        let what = format!("cannot be opened: {e}");
        Error::new(path, what, "Check the path and the permissions of the file.")
    };
    let length = std::fs::metadata(path).map_err(cannot)?.len();
    if length > MOST_BYTES {
        let what = format!("has {length} bytes, more than are read of a CAD file");
        return Err(Error::new(path, what, "Export the faces in several files."));
    }
    read_cad_from(path, &std::fs::read(path).map_err(cannot)?)
}

/// Reads CAD faces as [`read_cad`] does, but from memory; `name` is what errors
/// call the file.
///
/// # Errors
/// Those of [`read_cad`].
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
