//! Files appear whole or not at all: each is written under a temporary name
//! beside its place and renamed once all are complete.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use formats::Error;
use sha2::{Digest, Sha256};
use tempfile::NamedTempFile;

/// A file that is complete but not yet in its place.
pub struct Pending {
    file: NamedTempFile,
    path: PathBuf,
    /// Its length.
    pub bytes: u64,
    /// SHA-256 of its content, in hexadecimal.
    pub sha256: String,
}

/// Counts and hashes what goes through it.
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

/// Writes a file under a temporary name in the folder of `path`.
pub fn write(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<Pending, Error> {
    let failed = |e: std::io::Error| {
        let help = "check that the folder exists, can be written to and has room";
        Error::new(path, format!("cannot be written: {e}"), help)
    };
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".scan2step-").suffix(".part");
    #[cfg(unix)]
    {
        // A temporary file is private by default; the result is an ordinary
        // file, which the user's umask narrows.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(folder).map_err(failed)?;
    let (bytes, hash) = {
        let inner = BufWriter::new(file.as_file());
        let mut tally = Tally { inner, bytes: 0, hash: Sha256::new() };
        content(&mut tally).and_then(|()| tally.flush()).map_err(failed)?;
        (tally.bytes, tally.hash.finalize())
    };
    let sha256 = hash.iter().map(|byte| format!("{byte:02x}")).collect();
    Ok(Pending { file, path: path.to_owned(), bytes, sha256 })
}

impl Pending {
    /// Puts the file in its place.
    pub fn publish(self) -> Result<(), Error> {
        let path = self.path;
        self.file.persist(&path).map(drop).map_err(|e| {
            let help = "check that it is not a folder and can be replaced";
            Error::new(path, format!("cannot be written: {}", e.error), help)
        })
    }
}
