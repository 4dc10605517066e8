//! The buffers that a glTF file refers to.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use ::gltf::json;
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use super::extras::PackedView;
use crate::scene::budget;
use crate::source::{EXPORT_AGAIN, Source};
use crate::token::excerpt;
use crate::{Error, Location, Result};

/// The largest size in bytes of all buffers together.
const MOST_BYTES: u64 = 8 << 30;

/// The buffers of a file. Each is loaded when it is first needed, so that buffers for textures or
/// animations may be missing.
pub(super) struct Buffers<'a> {
    pub(super) path: &'a Path,
    /// The folder of buffers in other files. `None` for a stream.
    folder: Option<&'a Path>,
    declared: &'a [json::Buffer],
    loaded: Vec<Option<Loaded>>,
    /// The contents of files. Many buffers may refer to one file, but its content is stored once.
    files: BTreeMap<PathBuf, Rc<Vec<u8>>>,
    /// The buffers that are packed in others.
    packed: BTreeMap<usize, PackedView>,
    /// The binary chunk of a GLB. It is buffer 0, unless that has a URI.
    blob: Option<Vec<u8>>,
    /// The number of bytes that are loaded.
    pub(super) bytes: u64,
    /// The number of bytes that were unpacked from them.
    unpacked: u64,
}

/// A loaded buffer: the first `length` of some bytes. The chunk of a GLB is padded, and no accessor
/// may reach into the padding.
struct Loaded {
    bytes: Rc<Vec<u8>>,
    length: usize,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(
        source: &'a Source,
        json: &'a [json::Buffer],
        blob: Option<Vec<u8>>,
        packed: BTreeMap<usize, PackedView>,
    ) -> Self {
        let loaded = json.iter().map(|_| None).collect();
        let folder = source.folder.as_deref();
        let files = BTreeMap::new();
        Buffers {
            path: &source.path,
            folder,
            declared: json,
            loaded,
            files,
            packed,
            blob,
            bytes: 0,
            unpacked: 0,
        }
    }

    /// The content of a buffer. `None` if it has not been loaded.
    pub(super) fn get(&self, index: usize) -> Option<&[u8]> {
        let loaded = self.loaded.get(index)?.as_ref()?;
        loaded.bytes.get(..loaded.length)
    }

    /// Loads a buffer and returns its length.
    pub(super) fn load(&mut self, index: usize) -> Result<u64> {
        if let Some(bytes) = self.get(index) {
            return Ok(bytes.len() as u64);
        }
        let Some(json) = self.declared.get(index) else {
            return Err(self.error(index, "does not exist", EXPORT_AGAIN));
        };
        let bytes = match (&json.uri, self.packed.get(&index).cloned()) {
            (_, Some(packed)) => self.unpack(index, &packed)?,
            (Some(uri), _) => self.fetch(index, uri, json.byte_length.0)?,
            (None, _) if index == 0 && self.blob.is_some() => {
                let blob = self.blob.take().unwrap_or_default();
                self.hold(blob)
            }
            (None, None) => return Err(self.error(index, "has no data", EXPORT_AGAIN)),
        };
        let length = json.byte_length.0;
        if length > bytes.len() as u64 {
            let what = format!("holds {} of {length} bytes", bytes.len());
            return Err(self.error(index, &what, EXPORT_AGAIN));
        }
        self.loaded[index] = Some(Loaded { bytes, length: length as usize });
        Ok(length)
    }

    /// The bytes of a buffer that is packed in another one.
    fn unpack(&mut self, index: usize, packed: &PackedView) -> Result<Rc<Vec<u8>>> {
        let unsound = |buffers: &Self, why: &str| {
            let what = format!("cannot be unpacked ({}): {why}", packed.mode);
            buffers.error(index, &what, EXPORT_AGAIN)
        };
        if self.packed.contains_key(&packed.buffer) {
            return Err(unsound(self, "it is packed in itself"));
        }
        self.load(packed.buffer)?;
        // All of it counts as read, so that many views of the same bytes cannot fill the memory.
        let room = budget(self.bytes).saturating_sub(self.unpacked);
        let length = packed.length().filter(|&length| length <= room);
        let Some(length) = length else { return Err(unsound(self, "it would be too large")) };
        let bytes = self.get(packed.buffer).unwrap_or_default();
        let start = usize::try_from(packed.byte_offset).unwrap_or(usize::MAX);
        let end = usize::try_from(packed.byte_length).ok().and_then(|n| start.checked_add(n));
        let bytes = end.and_then(|end| bytes.get(start..end));
        let Some(bytes) = bytes else { return Err(unsound(self, "it is beyond its buffer")) };
        let unpacked = packed.unpack(bytes).map_err(|why| unsound(self, &why))?;
        self.unpacked += length;
        Ok(Rc::new(unpacked))
    }

    fn hold(&mut self, bytes: Vec<u8>) -> Rc<Vec<u8>> {
        self.bytes += bytes.len() as u64;
        Rc::new(bytes)
    }

    fn fetch(&mut self, index: usize, uri: &str, length: u64) -> Result<Rc<Vec<u8>>> {
        let data = uri.get(..5).filter(|scheme| scheme.eq_ignore_ascii_case("data:"));
        if data.is_some() {
            let unsound = || self.error(index, "is not a valid data URI", EXPORT_AGAIN);
            let decoded = decode_data(&uri[5..]).ok_or_else(unsound)?;
            return Ok(self.hold(decoded));
        }
        let relative = relative(uri).ok_or_else(|| self.outside(index, uri))?;
        if self.bytes.saturating_add(length) > MOST_BYTES {
            return Err(self.error(index, "makes the file exceed 8 GiB", EXPORT_AGAIN));
        }
        let file = self.locate(index, &relative)?;
        if let Some(bytes) = self.files.get(&file) {
            return Ok(bytes.clone());
        }
        let bytes = self.read_file(&file).map_err(|e| self.missing(index, &relative, &e))?;
        let bytes = self.hold(bytes);
        self.files.insert(file, bytes.clone());
        Ok(bytes)
    }

    /// The path of the file `relative`. It must exist in the folder.
    fn locate(&self, index: usize, relative: &Path) -> Result<PathBuf> {
        let Some(folder) = self.folder else {
            let name = excerpt(relative.to_string_lossy().as_bytes());
            let what = format!("is in another file ({name}), but this file is read from a stream");
            return Err(self.error(index, &what, "Read it from its folder, or export one GLB."));
        };
        let missing = |e| self.missing(index, relative, &e);
        let folder = folder.canonicalize().map_err(missing)?;
        let file = folder.join(relative).canonicalize().map_err(missing)?;
        // A link could lead out of the folder although the URI does not.
        if !file.starts_with(&folder) {
            return Err(self.outside(index, &relative.to_string_lossy()));
        }
        if !file.is_file() {
            return Err(self.error(index, "is not in a regular file", EXPORT_AGAIN));
        }
        Ok(file)
    }

    /// Reads as much of `file` as the largest buffer in it needs.
    fn read_file(&self, file: &Path) -> io::Result<Vec<u8>> {
        let wanted = self.declared.iter().map(|json| json.byte_length.0).max().unwrap_or(0);
        let wanted = wanted.min(MOST_BYTES.saturating_sub(self.bytes));
        let mut bytes = Vec::new();
        File::open(file)?.take(wanted).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    fn missing(&self, index: usize, relative: &Path, e: &io::Error) -> Error {
        let name = excerpt(relative.to_string_lossy().as_bytes());
        let what = format!("is in {name}, which cannot be read ({e})");
        self.error(index, &what, "Put the file beside the glTF file, or export one GLB.")
    }

    fn outside(&self, index: usize, uri: &str) -> Error {
        let what = format!("is outside of the file's folder: {}", excerpt(uri.as_bytes()));
        self.error(index, &what, "Put its file beside the glTF file, or export one GLB.")
    }

    fn error(&self, index: usize, what: &str, help: &str) -> Error {
        let error = Error::new(self.path, format!("has a buffer that {what}"), help);
        error.at(Location::Element("buffer", index as u64))
    }
}

/// The path that `uri` refers to, if it is below the folder of the file.
fn relative(uri: &str) -> Option<PathBuf> {
    let path = percent_decode_str(uri).decode_utf8().ok()?;
    // A colon ends a scheme or a drive letter; a backslash separates on Windows.
    let strange = path.contains([':', '\\', '\0']) || path.starts_with('/') || path.is_empty();
    let leaves = path.split('/').any(|part| part == "..");
    (!strange && !leaves).then(|| path.split('/').collect())
}

/// Decodes the text after `data:`, which is a type and, after a comma, the bytes.
fn decode_data(text: &str) -> Option<Vec<u8>> {
    let (kind, data) = text.split_once(',')?;
    let data: Vec<u8> = percent_decode_str(data).collect();
    if !kind.to_ascii_lowercase().ends_with(";base64") {
        return Some(data);
    }
    let padding = DecodePaddingMode::Indifferent;
    let config = GeneralPurposeConfig::new().with_decode_padding_mode(padding);
    GeneralPurpose::new(&STANDARD, config).decode(data.trim_ascii()).ok()
}
