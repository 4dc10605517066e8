//! The header of a LAS file and the records about its points.
//!
//! The input is the beginning of a file. The output is a [`LasHeader`]. The crate `las`
//! reads the header, but only after the lengths in it were checked, because that crate
//! allocates what a file claims.

use std::io::{self, Read};

use las::point::Format;
use las::raw;
use las::{Transform, Vector, Vlr};

use super::SIGNATURE;
use crate::source::{EXPORT_AGAIN, Source};
use crate::{Error, Location, Result};

/// The length of the header of LAS 1.0 to 1.2. No header is shorter.
const SHORTEST: usize = 227;

/// No header with its records is longer. The longest known hold a coordinate system as text
/// and take less than 1 MiB. Without this bound, a zipped file could fill the memory.
const LONGEST: u64 = 16 << 20;

/// The bytes of a variable length record before its content, and of an extended one.
const RECORD_HEAD: usize = 54;
const EXTENDED_HEAD: usize = 60;

/// What the header says about the points.
pub(super) struct LasHeader {
    pub(super) format: Format,
    pub(super) transforms: Vector<Transform>,
    /// The length of a point in bytes.
    pub(super) record: usize,
    /// The number of points that the header announces.
    pub(super) announced: u64,
    /// The byte at which the points begin.
    pub(super) start: u64,
    /// The byte at which the extended records begin, and their number.
    pub(super) extended: Option<(u64, u32)>,
    /// The records about the coordinate system and the compression.
    pub(super) records: Vec<Vlr>,
    /// Whether records are cut off.
    pub(super) is_cut: bool,
}

/// Reads up to the first point, and not a byte further.
pub(super) fn read(source: &mut Source) -> Result<LasHeader> {
    let mut head = Vec::new();
    append(source, &mut head, SHORTEST as u64)?;
    if !head.starts_with(SIGNATURE) {
        return Err(bad(source, "does not begin as a LAS file"));
    }
    let start = u64::from(u32_at(&head, 96));
    if start < SHORTEST as u64 || start > LONGEST {
        return Err(bad(source, &format!("has points that begin at byte {start}")));
    }
    append(source, &mut head, start - SHORTEST as u64)?;
    let raw = raw::Header::read_from(head.as_slice())
        .map_err(|e| bad(source, &format!("has an unreadable header: {e}")))?;
    check(source, &raw)?;
    let mut header = header(source, &raw)?;
    let records = head.get(usize::from(raw.header_size)..).unwrap_or_default();
    let count = raw.number_of_variable_length_records;
    let all = read_records(records, count, false, &mut header.records);
    header.is_cut = !all.map_err(|e| source.io_error(&e))?;
    Ok(header)
}

/// Reads `count` more bytes.
fn append(source: &mut Source, head: &mut Vec<u8>, count: u64) -> Result<()> {
    let read = (&mut source.stream).take(count).read_to_end(head);
    if (read.map_err(|e| source.io_error(&e))? as u64) < count {
        let place = Location::Byte(head.len() as u64);
        return Err(bad(source, "ends in its header").at(place));
    }
    Ok(())
}

fn check(source: &Source, raw: &raw::Header) -> Result<()> {
    let version = raw.version;
    if version.major != 1 || version.minor > 4 {
        return Err(bad(source, &format!("is of version {version}, not 1.0 to 1.4")));
    }
    if usize::from(raw.header_size) < SHORTEST {
        return Err(bad(source, &format!("has a header of {} bytes", raw.header_size)));
    }
    let scales = [raw.x_scale_factor, raw.y_scale_factor, raw.z_scale_factor];
    if !scales.iter().all(|scale| scale.is_normal()) {
        return Err(bad(source, &format!("has coordinates with the scales {scales:?}")));
    }
    let offsets = [raw.x_offset, raw.y_offset, raw.z_offset];
    if !offsets.iter().all(|offset| offset.is_finite()) {
        return Err(bad(source, &format!("has coordinates with the offsets {offsets:?}")));
    }
    Ok(())
}

fn header(source: &Source, raw: &raw::Header) -> Result<LasHeader> {
    // The highest two bits say that the points are compressed.
    let number = raw.point_data_record_format & 0x3f;
    let format = Format::new(raw.point_data_record_format).ok().filter(|_| number <= 10);
    let Some(mut format) = format else {
        return Err(bad(source, &format!("has points of the unknown format {number}")));
    };
    let record = raw.point_data_record_length;
    let Some(extra) = record.checked_sub(format.len()) else {
        return Err(bad(source, &format!("has points of {record} bytes in format {number}")));
    };
    format.extra_bytes = extra;
    let large = raw.large_file.map_or(0, |large| large.number_of_point_records);
    let announced = match raw.number_of_point_records {
        0 => large,
        count => u64::from(count),
    };
    let transform = |scale, offset| Transform { scale, offset };
    Ok(LasHeader {
        format,
        transforms: Vector {
            x: transform(raw.x_scale_factor, raw.x_offset),
            y: transform(raw.y_scale_factor, raw.y_offset),
            z: transform(raw.z_scale_factor, raw.z_offset),
        },
        record: usize::from(record),
        announced,
        start: u64::from(raw.offset_to_point_data),
        extended: raw.evlr.map(|evlr| (evlr.start_of_first_evlr, evlr.number_of_evlrs)),
        records: Vec::new(),
        is_cut: false,
    })
}

/// Adds the records of interest among the next `count` ones. Returns whether all were there.
pub(super) fn read_records(
    mut from: impl Read,
    count: u32,
    is_extended: bool,
    found: &mut Vec<Vlr>,
) -> io::Result<bool> {
    let head = if is_extended { EXTENDED_HEAD } else { RECORD_HEAD };
    for _ in 0..count {
        let mut record = Vec::new();
        from.by_ref().take(head as u64).read_to_end(&mut record)?;
        if record.len() < head {
            return Ok(false);
        }
        let length = match is_extended {
            true => u64::from(u32_at(&record, 20)) | u64::from(u32_at(&record, 24)) << 32,
            false => u64::from(u16_at(&record, 20)),
        };
        let users = [&b"LASF_Projection"[..], b"laszip encoded"];
        let is_wanted = users.iter().any(|user| record[2..].starts_with(user)) && length < LONGEST;
        let content = from.by_ref().take(length);
        let read = match is_wanted {
            true => io::copy(&mut { content }, &mut record)?,
            false => io::copy(&mut { content }, &mut io::sink())?,
        };
        if read < length {
            return Ok(false);
        }
        if is_wanted {
            found.extend(raw::Vlr::read_from(record.as_slice(), is_extended).ok().map(Vlr::new));
        }
    }
    Ok(true)
}

fn bad(source: &Source, what: &str) -> Error {
    Error::new(&source.path, what, EXPORT_AGAIN)
}

/// The number at byte `at`, which there is.
fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from(u16_at(bytes, at)) | u32::from(u16_at(bytes, at + 2)) << 16
}
