//! From a scan's file to a CAD file.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use formats::{iges, step};

use super::{Conversion, Options, Part, Scan, convert};
use crate::error::{Error, Result};

/// A format of CAD files.
#[derive(Clone, Copy)]
enum CadFormat {
    Step,
    Iges,
}

impl Scan<'_> {
    /// Reads a mesh or a cloud of points. The content of the file decides which it is.
    ///
    /// # Errors
    /// [`Error::File`]: the file cannot be read.
    pub fn read(file: impl AsRef<Path>) -> Result<Self> {
        Ok(formats::read_content(file.as_ref())?.into())
    }
}

impl Conversion {
    /// Writes all parts: STEP, or IGES where the name of `out` ends so (`.step`, `.stp`, `.igs`, `.iges`).
    /// The file appears whole or not at all: it is written under another name in the same folder first.
    ///
    /// # Errors
    /// [`Error::File`]: the file cannot be written.
    pub fn write(&self, out: impl AsRef<Path>) -> Result<()> {
        let out = out.as_ref();
        let (kind, colour) = (kind(out)?, self.colour);
        let Some(Part { brep, .. }) = self.parts.first() else { return Ok(()) };
        let content = |to: &mut dyn Write| match kind {
            CadFormat::Step => {
                step::write(brep, &step::Options { colour, ..step::Options::default() }, to)
            }
            CadFormat::Iges => {
                let file_name = out.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let options = iges::Options { colour, file_name, ..iges::Options::default() };
                iges::write(brep, &options, to)
            }
        };
        whole(out, content).map_err(|e| {
            let help = "check that the folder exists, can be written to and has room";
            formats::Error::new(out, format!("cannot be written: {e}"), help).into()
        })
    }
}

/// Reads a scan, converts it and writes the result ([`Scan::read`], [`convert`], [`Conversion::write`]).
///
/// # Errors
/// Each names the file that it is about: [`Error::File`] for one that cannot be read or
/// written, [`Error::Scan`] for a scan that cannot be converted.
pub fn convert_file(
    scan: impl AsRef<Path>,
    out: impl AsRef<Path>,
    options: &Options,
) -> Result<Conversion> {
    // A name that no writer takes is refused before the work begins.
    kind(out.as_ref())?;
    let file = scan.as_ref().to_owned();
    if is_same_file(&file, out.as_ref()) {
        let what = "is the scan, which no output may replace";
        return Err(formats::Error::new(out.as_ref(), what, "name another file").into());
    }
    let made = convert(Scan::read(&file)?, options, &mut |_| Ok(()));
    let conversion = made.map_err(|error| Error::Scan { file, error: Box::new(error) })?;
    conversion.write(out)?;
    Ok(conversion)
}

/// Whether two paths lead to the same file, through links of either kind. Files that do not exist are not the same.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let place = |path: &Path| fs::metadata(path).ok().map(|meta| (meta.dev(), meta.ino()));
        place(a).is_some_and(|of_a| place(b) == Some(of_a))
    }
    #[cfg(not(unix))]
    {
        let place = |path: &Path| fs::canonicalize(path).ok();
        place(a).is_some_and(|of_a| place(b) == Some(of_a))
    }
}

/// What the name of a file says that it is.
fn kind(out: &Path) -> Result<CadFormat> {
    let extension = out.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("step" | "stp") => Ok(CadFormat::Step),
        Some("igs" | "iges") => Ok(CadFormat::Iges),
        _ => {
            let help = "name a file that ends in one of these";
            Err(formats::Error::new(out, "not .step, .stp, .igs or .iges", help).into())
        }
    }
}

/// Writes a file beside its place, and puts it there once it is complete.
fn whole(out: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    // Through links, which stay.
    let place = fs::canonicalize(out).unwrap_or_else(|_| out.to_owned());
    let part = part(&place);
    let mut file = BufWriter::new(File::create_new(&part)?);
    let written = content(&mut file).and_then(|()| file.flush());
    drop(file);
    let done = written.and_then(|()| fs::rename(&part, &place));
    if done.is_err() {
        // What stopped it says more than that this failed, too.
        let _ = fs::remove_file(&part);
    }
    done
}

/// A name beside a file that no other process has, nor another thread writing elsewhere.
fn part(place: &Path) -> PathBuf {
    let name = place.file_name().unwrap_or_default().to_string_lossy();
    place.with_file_name(format!(".scan2step-{}-{name}.part", std::process::id()))
}
