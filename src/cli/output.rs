//! Output files, which appear complete or not at all. Each is written under a temporary name in
//! its folder, or to memory if it goes to standard output. When all of them are complete, they are
//! renamed.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use formats::Error;
use scan2step::is_same_file;
use sha2::{Digest, Sha256};
use tempfile::NamedTempFile;

use super::{streams, temp_files};

/// A complete output that is not in its place yet.
pub(crate) struct Pending {
    place: Place,
    /// Its length.
    pub bytes: u64,
    /// SHA-256 of its content, in hexadecimal.
    pub sha256: String,
}

/// Where an output is, and where it goes.
enum Place {
    /// A file that still has its temporary name.
    File(NamedTempFile, PathBuf),
    /// Memory. It goes to standard output, which must stay empty if the run fails.
    Stdout(Vec<u8>),
}

/// A writer that counts and hashes the bytes that it passes on.
struct Tally<W> {
    inner: W,
    bytes: u64,
    hash: Sha256,
}

impl<W: Write> Write for Tally<W> {
    fn write(&mut self, buffer: &[u8]) -> std::io::Result<usize> {
        let n = self.inner.write(buffer)?;
        self.bytes += n as u64;
        self.hash.update(&buffer[..n]);
        Ok(n)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.inner.flush()
    }
}

/// The files that the run reads.
static INPUTS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// From now on no output may replace this file, nor a link to it.
pub(crate) fn protect(input: &Path) {
    INPUTS.lock().unwrap_or_else(PoisonError::into_inner).push(input.to_owned());
}

/// Refuses an output that is a file which the run reads, under whatever name.
pub(crate) fn check_replaces_no_input(path: &Path) -> Result<(), Error> {
    let inputs = INPUTS.lock().unwrap_or_else(PoisonError::into_inner);
    match !streams::is_stdout(path) && inputs.iter().any(|input| is_same_file(input, path)) {
        true => {
            let help = "name a scan first, then other outputs";
            Err(Error::new(path, "is the scan, which no output may replace", help))
        }
        false => Ok(()),
    }
}

/// Checks whether a file can be made at `path`, by making a temporary file beside it.
pub(crate) fn check(path: &Path) -> Result<(), Error> {
    if streams::is_stdout(path) {
        return Ok(());
    }
    let target = target(path)?;
    temporary(&target).map(drop).map_err(|e| failed(path, e))
}

/// Writes a file under a temporary name in the folder of `path`, or to memory if it goes to standard
/// output.
pub(super) fn write(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<Pending, Error> {
    let failed = |e: std::io::Error| failed(path, e);
    if streams::is_stdout(path) {
        let mut memory = Vec::new();
        let (bytes, sha256) = tally(&mut memory, content).map_err(failed)?;
        return Ok(Pending { place: Place::Stdout(memory), bytes, sha256 });
    }
    check_replaces_no_input(path)?;
    let target = target(path)?;
    let file = temporary(&target).map_err(failed)?;
    let (bytes, sha256) = tally(BufWriter::new(file.as_file()), content).map_err(failed)?;
    Ok(Pending { place: Place::File(file, target), bytes, sha256 })
}

/// Writes content, and returns its length and its hash.
fn tally(
    inner: impl Write,
    content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> std::io::Result<(u64, String)> {
    let mut tally = Tally { inner, bytes: 0, hash: Sha256::new() };
    content(&mut tally).and_then(|()| tally.flush())?;
    Ok((tally.bytes, hexadecimal(&tally.hash.finalize())))
}

/// Bytes in hexadecimal.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The error of a file that cannot be written.
pub(crate) fn failed(path: &Path, e: std::io::Error) -> Error {
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty() && !f.exists()) {
        let what = format!("cannot be written: the folder {} does not exist", folder.display());
        return Error::new(path, what, "make the folder first, or name another one");
    }
    // The error of a temporary file ends with its name, which tells the user nothing.
    let text = e.to_string();
    let wrong = text.split(" at path ").next().unwrap_or(&text);
    let help = "check that the folder exists, can be written to and has room";
    Error::new(path, format!("cannot be written: {wrong}"), help)
}

/// The file that a path leads to, links followed. A device, a pipe or a folder is refused,
/// because the rename would replace it.
fn target(path: &Path) -> Result<PathBuf, Error> {
    let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if target.exists() && !target.is_file() {
        let help = "name a file";
        return Err(Error::new(path, "cannot be written: it is not an ordinary file", help));
    }
    Ok(target)
}

/// A temporary file beside a path. It is deleted when it is dropped or the run is stopped.
fn temporary(path: &Path) -> std::io::Result<NamedTempFile> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".scan2step-").suffix(".part");
    #[cfg(unix)]
    {
        // A temporary file is private by default. The result has the rights of an ordinary
        // file, which the user's umask limits.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    temp_files::made(|| {
        let file = builder.tempfile_in(folder)?;
        let path = file.path().to_owned();
        Ok((file, path))
    })
}

impl Pending {
    /// Puts outputs into their places. Files are renamed: all of them, even if the run is stopped
    /// meanwhile. Standard output comes before them and can be stopped, because its reader may be
    /// slow.
    pub(crate) fn publish(outputs: Vec<Pending>) -> Result<(), Error> {
        let mut files = Vec::new();
        for output in outputs {
            match output.place {
                Place::Stdout(content) => streams::print(&content)?,
                Place::File(file, path) => files.push((file, path)),
            }
        }
        temp_files::uninterrupted(|| {
            files.into_iter().try_for_each(|(file, path)| {
                file.persist(&path).map(drop).map_err(|e| {
                    let help = "check that it is not a folder and can be replaced";
                    Error::new(path, format!("cannot be written: {}", e.error), help)
                })
            })
        })
    }
}
