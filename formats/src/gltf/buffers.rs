//! The bytes that a glTF file refers to.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use ::gltf::json;
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use crate::source::EXPORT_AGAIN;
use crate::token::excerpt;
use crate::{Error, Place, Result};

/// Many buffers may name one file: together they hold no more than this.
const MOST_BYTES: u64 = 8 << 30;

/// The buffers of a file, each loaded when it is first needed: what only
/// textures or animations use need not be there.
pub(super) struct Buffers<'a> {
    pub(super) path: &'a Path,
    declared: &'a [json::Buffer],
    loaded: Vec<Option<Vec<u8>>>,
    /// The binary chunk of a GLB: buffer 0, unless that has a URI.
    blob: Option<Vec<u8>>,
    /// How many bytes are loaded.
    pub(super) bytes: u64,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(path: &'a Path, json: &'a [json::Buffer], blob: Option<Vec<u8>>) -> Self {
        let loaded = json.iter().map(|_| None).collect();
        Buffers { path, declared: json, loaded, blob, bytes: 0 }
    }

    /// The content of a buffer that `load` has loaded.
    pub(super) fn get(&self, index: usize) -> Option<&[u8]> {
        self.loaded.get(index)?.as_deref()
    }

    /// Loads a buffer and returns its length.
    pub(super) fn load(&mut self, index: usize, compression: Option<&str>) -> Result<u64> {
        if let Some(bytes) = self.get(index) {
            return Ok(bytes.len() as u64);
        }
        let Some(json) = self.declared.get(index) else {
            return Err(self.error(index, "does not exist", EXPORT_AGAIN));
        };
        let mut bytes = match (&json.uri, compression) {
            (Some(uri), _) => self.fetch(index, uri, json.byte_length.0)?,
            (None, _) if index == 0 && self.blob.is_some() => self.blob.take().unwrap_or_default(),
            (None, Some(name)) => return Err(super::compressed(self.path, name)),
            (None, None) => return Err(self.error(index, "has no data", EXPORT_AGAIN)),
        };
        // A GLB's chunk is padded, and nothing may reach into the padding.
        bytes.truncate(usize::try_from(json.byte_length.0).unwrap_or(usize::MAX));
        let length = bytes.len() as u64;
        if length < json.byte_length.0 {
            let what = format!("holds {length} of {} bytes", json.byte_length.0);
            return Err(self.error(index, &what, EXPORT_AGAIN));
        }
        self.bytes += length;
        self.loaded[index] = Some(bytes);
        Ok(length)
    }

    fn fetch(&self, index: usize, uri: &str, length: u64) -> Result<Vec<u8>> {
        let data = uri.get(..5).filter(|scheme| scheme.eq_ignore_ascii_case("data:"));
        if data.is_some() {
            let decoded = decode_data(&uri[5..]);
            return decoded.ok_or_else(|| self.error(index, "is no sound data URI", EXPORT_AGAIN));
        }
        let relative = relative(uri).ok_or_else(|| self.outside(index, uri))?;
        if self.bytes.saturating_add(length) > MOST_BYTES {
            return Err(self.error(index, "makes the file exceed 8 GiB", EXPORT_AGAIN));
        }
        self.read_file(index, &relative, length)
    }

    fn read_file(&self, index: usize, relative: &Path, length: u64) -> Result<Vec<u8>> {
        let missing = |e: std::io::Error| {
            let what = format!("is in {}, which cannot be read ({e})", relative.display());
            self.error(index, &what, "Put the file beside the glTF file, or export one GLB.")
        };
        let folder = self.path.parent().filter(|p| !p.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new(".")).canonicalize().map_err(missing)?;
        let file = folder.join(relative).canonicalize().map_err(missing)?;
        // A link could lead out although the URI does not.
        if !file.starts_with(&folder) {
            return Err(self.outside(index, &relative.to_string_lossy()));
        }
        if !file.is_file() {
            return Err(self.error(index, "is in something that is no file", EXPORT_AGAIN));
        }
        let mut bytes = Vec::new();
        File::open(&file).and_then(|f| f.take(length).read_to_end(&mut bytes)).map_err(missing)?;
        Ok(bytes)
    }

    fn outside(&self, index: usize, uri: &str) -> Error {
        let what = format!("is outside of the file's folder: {}", excerpt(uri.as_bytes()));
        self.error(index, &what, "Put its file beside the glTF file, or export one GLB.")
    }

    fn error(&self, index: usize, what: &str, help: &str) -> Error {
        let error = Error::new(self.path, format!("has a buffer that {what}"), help);
        error.at(Place::Element("buffer", index as u64))
    }
}

/// The path that `uri` names, if it stays below the file's folder.
fn relative(uri: &str) -> Option<PathBuf> {
    let path = percent_decode_str(uri).decode_utf8().ok()?;
    // A colon ends a scheme or a drive letter; a backslash separates on Windows.
    let strange = path.contains([':', '\\', '\0']) || path.starts_with('/') || path.is_empty();
    let leaves = path.split('/').any(|part| part == "..");
    (!strange && !leaves).then(|| path.split('/').collect())
}

/// What comes after `data:`: a type and, after a comma, the bytes.
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
