//! The chunks of a binary glTF file (glTF 2.0 specification, section 4).
//!
//! The reader of the gltf crate is not used. It refuses chunks of unknown types, which the
//! specification tells readers to ignore, and it copies the binary chunk.

use std::io::{BufRead as _, Read};
use std::ops::Range;

use crate::damage::{self, SEND_AS_BINARY};
use crate::source::{EXPORT_AGAIN, Source};
use crate::{Error, Location, Result};

/// The size in bytes of the header, which has three words.
const HEADER: usize = 12;

/// The size in bytes of the length and the type at the beginning of a chunk.
const CHUNK: usize = 8;

pub(super) fn is_glb(head: &[u8]) -> bool {
    head.starts_with(b"glTF")
}

/// Returns the JSON and the binary chunk, if there is one.
pub(super) fn read(source: &mut Source) -> Result<(Vec<u8>, Option<Vec<u8>>)> {
    let mut bytes = read_bytes(source)?;
    let (json, after) = json(source, &bytes)?;
    check_damage(source, &bytes[json.end..])?;
    let json = bytes[json].to_vec();
    let Some(binary) = binary(source, &bytes, after)? else { return Ok((json, None)) };
    bytes.truncate(binary.end);
    bytes.drain(..binary.start);
    Ok((json, Some(bytes)))
}

/// Reads as many bytes of the file as its header declares.
fn read_bytes(source: &mut Source) -> Result<Vec<u8>> {
    let version = word(&source.head, 4).unwrap_or(2);
    if version != 2 {
        return Err(super::wrong_version(source, &version.to_string()));
    }
    let length = word(&source.head, 8).unwrap_or(0);
    if (length as usize) < HEADER + CHUNK {
        let what = format!("is not a complete GLB file: its header declares {length} bytes");
        return Err(source.error(what, EXPORT_AGAIN).at(Location::Byte(8)));
    }
    let mut bytes = Vec::new();
    let read = (&mut source.stream).take(u64::from(length)).read_to_end(&mut bytes);
    read.map_err(|e| source.io_error(&e))?;
    if bytes.len() == length as usize {
        return Ok(bytes);
    }
    let what = format!("ends after {} of its {length} bytes", bytes.len());
    Err(source.error(what, EXPORT_AGAIN))
}

/// The range of the JSON, and the start of the next chunk.
fn json(source: &Source, bytes: &[u8]) -> Result<(Range<usize>, usize)> {
    match chunk(source, bytes, HEADER)? {
        Some((b"JSON", data)) => Ok((data.clone(), data.end)),
        _ => Err(bad(source, "its first chunk is not JSON", HEADER)),
    }
}

/// The range of the binary chunk among the chunks from byte `at` on.
fn binary(source: &Source, bytes: &[u8], mut at: usize) -> Result<Option<Range<usize>>> {
    while let Some((kind, data)) = chunk(source, bytes, at)? {
        match kind {
            b"BIN\0" => return Ok(Some(data)),
            b"JSON" => return Err(bad(source, "it has two JSON chunks", at)),
            _ => at = data.end,
        }
    }
    Ok(None)
}

/// The type and the range of the chunk that begins at byte `at`, if there is one.
fn chunk<'a>(
    source: &Source,
    bytes: &'a [u8],
    at: usize,
) -> Result<Option<(&'a [u8; 4], Range<usize>)>> {
    let start = at + CHUNK;
    let kind = bytes.get(at + 4..start).and_then(|kind| kind.first_chunk());
    let (Some(length), Some(kind)) = (word(bytes, at), kind) else { return Ok(None) };
    match start.checked_add(length as usize) {
        Some(end) if end <= bytes.len() => Ok(Some((kind, start..end))),
        _ => Err(bad(source, "it has a chunk whose length exceeds the file's", at)),
    }
}

/// Refuses a file that is longer than its header declares because its binary chunk, which is
/// somewhere in `rest`, was converted to text.
fn check_damage(source: &mut Source, rest: &[u8]) -> Result<()> {
    let surplus = source.stream.fill_buf().map(|bytes| !bytes.is_empty());
    if !surplus.map_err(|e| source.io_error(&e))? {
        return Ok(());
    }
    match damage::of(rest) {
        Some(damage) => {
            let what = format!("is longer than its header declares, because {damage}");
            Err(source.error(what, SEND_AS_BINARY))
        }
        None => Ok(()),
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|word| u32::from_le_bytes(*word))
}

fn bad(source: &Source, what: &str, at: usize) -> Error {
    let what = format!("is not a valid glTF 2.0 file: {what}");
    source.error(what, EXPORT_AGAIN).at(Location::Byte(at as u64))
}
