//! The package of a 3MF file: a ZIP archive with parts (ISO/IEC 29500-2, Open Packaging Conventions).

use std::collections::BTreeMap;
use std::io::{self, BufRead, BufReader, Cursor, Read as _};

use percent_encoding::percent_decode_str;
use zip::ZipArchive;

use super::fault::PackageFault;
use super::utf16;
use crate::source::{EXPORT_AGAIN, Source};
use crate::token::excerpt;
use crate::{Error, Result};

/// The most entries of an archive. Slicers write some for each object.
const MOST_ENTRIES: usize = 100_000;

/// The largest ratio of all unpacked bytes to those of the file, and the number of bytes that are always allowed. The
/// text of a mesh packs to an eighth, and that of a regular grid to a fifteenth. Bombs pack to a thousandth.
const MOST_GROWTH: u64 = 32;
const FREE: u64 = 16 << 20;

/// The most bytes of a part between two tags, which bounds names and texts.
const LONGEST_RUN: usize = 4 << 20;

/// An open package.
pub(super) struct Package {
    archive: ZipArchive<Cursor<Vec<u8>>>,
    /// The number of each entry by the name of its part.
    entries: BTreeMap<String, usize>,
    size: u64,
    /// The number of bytes that may still be unpacked.
    left: u64,
}

impl Package {
    pub(super) fn open(mut source: Source) -> Result<Package> {
        let mut bytes = Vec::new();
        source.stream.read_to_end(&mut bytes).map_err(|e| source.io_error(&e))?;
        let size = bytes.len() as u64;
        let unsound = |what: String| Error::new(&source.path, what, EXPORT_AGAIN);
        let archive = ZipArchive::new(Cursor::new(bytes));
        let archive = archive.map_err(|e| unsound(format!("is not a sound ZIP archive: {e}")))?;
        if archive.len() > MOST_ENTRIES {
            return Err(unsound("is a ZIP archive of more than 100,000 files".into()));
        }
        let twice =
            |name: &str| unsound(format!("has two parts of the name {}", excerpt(name.as_bytes())));
        if archive.has_duplicate_names() {
            return Err(unsound("has two parts of the same name".into()));
        }
        let mut entries = BTreeMap::new();
        for number in 0..archive.len() {
            let Some(Ok(name)) = archive.name_for_index(number) else { continue };
            // A name that leads out of the package is that of no part.
            let Some(part) = resolve("", &name) else { continue };
            if entries.insert(part, number).is_some() && !name.ends_with('/') {
                return Err(twice(&name));
            }
        }
        Ok(Package { archive, entries, size, left: FREE.max(MOST_GROWTH.saturating_mul(size)) })
    }

    /// The number of bytes of the file.
    pub(super) fn size(&self) -> u64 {
        self.size
    }

    /// Whether there is a part of this name.
    pub(super) fn has(&self, part: &str) -> bool {
        self.entries.contains_key(part)
    }

    /// The content of a part as UTF-8.
    pub(super) fn part(
        &mut self,
        part: &str,
    ) -> std::result::Result<Box<dyn BufRead + '_>, PackageFault> {
        let Some(&number) = self.entries.get(part) else {
            let what = format!("has no part {}, which it names", excerpt(part.as_bytes()));
            return Err(PackageFault::new(what));
        };
        let broken = |e: &dyn std::fmt::Display| {
            PackageFault::new(format!(
                "has a part {} that cannot be unpacked: {e}",
                excerpt(part.as_bytes())
            ))
        };
        let encrypted = self.archive.by_index_raw(number).map_err(|e| broken(&e))?.encrypted();
        if encrypted {
            return Err(PackageFault::encrypted());
        }
        let entry = self.archive.by_index(number).map_err(|e| broken(&e))?;
        let bounded = Bounded { inner: entry, run: 0, left: &mut self.left };
        let mut content = BufReader::with_capacity(64 << 10, bounded);
        let head = content.fill_buf().map_err(|e| broken(&e))?;
        match utf16::order(head) {
            None => Ok(Box::new(content)),
            Some(order) => {
                let text = utf16::read(content, order).map_err(|e| broken(&e))?;
                Ok(Box::new(Cursor::new(text)))
            }
        }
    }
}

/// The name of the part that `target` means in the folder `folder`, without the first slash and in small letters, because
/// names are compared without case. `None` if it leads out of the package or is no name.
pub(super) fn resolve(folder: &str, target: &str) -> Option<String> {
    let target = percent_decode_str(target).decode_utf8().ok()?;
    if target.contains(['\0', '\\', '?', '#']) {
        return None;
    }
    let folder = if target.starts_with('/') { "" } else { folder };
    let mut names: Vec<&str> = Vec::new();
    for name in folder.split('/').chain(target.split('/')) {
        match name {
            "" | "." => {}
            ".." => drop(names.pop()?),
            name => names.push(name),
        }
    }
    (!names.is_empty()).then(|| names.join("/").to_ascii_lowercase())
}

/// The folder of a part.
pub(super) fn folder(part: &str) -> &str {
    part.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// A stream that ends with an error after so many bytes, or after so many bytes without a tag.
struct Bounded<'a, R> {
    inner: R,
    /// The number of bytes since the last tag began or ended.
    run: usize,
    left: &'a mut u64,
}

impl<R: io::Read> io::Read for Bounded<'_, R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(into)?;
        if n as u64 > *self.left {
            return Err(io::Error::other("it unpacks to far more than the size of the file"));
        }
        *self.left -= n as u64;
        let is_bound = |b: &u8| matches!(b, b'<' | b'>');
        let bytes = &into[..n];
        self.run = match bytes.iter().rposition(is_bound) {
            Some(last) => n - last,
            None => self.run + n,
        };
        if self.run > LONGEST_RUN {
            return Err(io::Error::other("it has a text of more than 4 MiB"));
        }
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use super::{folder, resolve};

    #[test]
    fn names_stay_in_the_package() {
        for (base, target, part) in [
            ("", "/3D/3dModel.model", Some("3d/3dmodel.model")),
            ("", "3D/3dmodel.model", Some("3d/3dmodel.model")),
            ("3d", "parts/a.model", Some("3d/parts/a.model")),
            ("3d", "/parts/%61.model", Some("parts/a.model")),
            ("3d", "../a.model", Some("a.model")),
            ("3d", "../../a.model", None),
            ("", "/../../etc/passwd", None),
            ("", "", None),
            ("", "/", None),
            ("", "a\0b", None),
        ] {
            assert_eq!(resolve(base, target).as_deref(), part, "{target}");
        }
        assert_eq!(folder("3d/parts/a.model"), "3d/parts");
        assert_eq!(folder("a.model"), "");
    }
}
