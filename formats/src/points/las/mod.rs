//! LAS 1.0 to 1.4 of all formats of points, and LAZ, which is compressed LAS. COPC is LAZ
//! with an index, which is not needed here.
//!
//! The input is a file. The output is [`Points`] in the unit of its coordinate system. Points
//! that are withheld or noise are left out. A file that is cut gives what it holds if it is
//! not compressed.

mod crs;
mod header;
mod packed;
mod records;
mod wkt;

use std::io::{self, Read};

use self::crs::CrsUnit;
use self::header::LasHeader;
use self::packed::PackedPoints;
use self::records::LasPoints;
use super::degrees::{self, FINER, PROJECT};
use super::{Note, Points, PointsBuilder, ReadOptions, ScanEnd};
use crate::source::Source;
use crate::{Error, LengthUnit, Result};

/// The first bytes of every file.
pub(super) const SIGNATURE: &[u8] = b"LASF";

pub(super) fn read(mut source: Source, options: &ReadOptions) -> Result<Points> {
    let mut header = header::read(&mut source)?;
    let mut builder = PointsBuilder::new(&source.path, false);
    builder.begin_scan(false);
    let mut points = LasPoints::new(builder, &header, options);
    let found = match header.format.is_compressed {
        true => read_packed(&mut source, &mut header, &mut points)?,
        false => read_plain(&mut source, &mut header, &mut points)?,
    };
    finish(&source, header, points, found)
}

/// Reads points that are not compressed, and the records after them.
fn read_plain(source: &mut Source, header: &mut LasHeader, points: &mut LasPoints) -> Result<u64> {
    let found = points.read_plain(source, header)?;
    let Some((start, count)) = header.extended else { return Ok(found) };
    let length = (header.record as u64).checked_mul(found);
    let end = length.and_then(|length| length.checked_add(header.start));
    let Some(gap) = end.and_then(|end| start.checked_sub(end)) else {
        header.is_cut = true;
        return Ok(found);
    };
    let skipped = io::copy(&mut (&mut source.stream).take(gap), &mut io::sink());
    let all = skipped
        .and_then(|_| header::read_records(&mut source.stream, count, true, &mut header.records));
    header.is_cut |= !all.map_err(|e| source.io_error(&e))?;
    Ok(found)
}

/// Reads compressed points, and the records after them.
fn read_packed(source: &mut Source, header: &mut LasHeader, points: &mut LasPoints) -> Result<u64> {
    let mut bytes = Vec::new();
    source.stream.read_to_end(&mut bytes).map_err(|e| source.io_error(&e))?;
    PackedPoints::new(&source.path, header, &bytes)?.read(points)?;
    if let Some((start, count)) = header.extended {
        let at = start.checked_sub(header.start).and_then(|at| usize::try_from(at).ok());
        let records = at.and_then(|at| bytes.get(at..)).unwrap_or_default();
        let all = header::read_records(records, count, true, &mut header.records);
        header.is_cut |= !all.map_err(|e| source.io_error(&e))?;
    }
    Ok(header.announced)
}

/// Says what the points are.
fn finish(source: &Source, header: LasHeader, mut points: LasPoints, found: u64) -> Result<Points> {
    let format = header.format;
    let is_fine = header.transforms.x.scale.abs() * FINER <= header.transforms.z.scale.abs();
    let prefers_text = format.is_extended;
    let mut unit = crs::unit(header.records, prefers_text);
    let cloud = points.builder.cloud();
    if unit == CrsUnit::Unknown && is_fine && degrees::are_in_range(&cloud.positions, [0, 1]) {
        unit = CrsUnit::Degrees;
    }
    cloud.unit = Some(length_unit(source, unit)?);
    if unit == CrsUnit::Unknown {
        cloud.notes.push(Note::MetresByCustom);
    }
    if found < header.announced {
        cloud.notes.push(Note::CountDiffers { announced: header.announced, found });
    }
    if header.is_cut {
        cloud.notes.push(Note::RecordsCut);
    }
    cloud.lost.intensities = points.intensities;
    cloud.lost.colours = if format.has_color { cloud.len() as u64 } else { 0 };
    let others = [
        (true, "returns"),
        (true, "scan_angle"),
        (true, "user_data"),
        (true, "point_source_id"),
        (format.has_gps_time, "gps_time"),
        (format.has_nir, "near_infrared"),
        (format.has_waveform, "waveform"),
        (format.extra_bytes > 0, "extra_bytes"),
    ];
    let others = others.into_iter().filter(|(has, _)| *has);
    cloud.lost.columns = others.map(|(_, name)| name.to_owned()).collect();
    points.builder.end_scan(ScanEnd::default())?;
    points.builder.finish()
}

fn length_unit(source: &Source, unit: CrsUnit) -> Result<LengthUnit> {
    let what = match unit {
        CrsUnit::Unknown => return Ok(LengthUnit::Metre),
        CrsUnit::Length(unit) => return Ok(unit),
        CrsUnit::Degrees => "has coordinates in degrees".to_owned(),
        CrsUnit::Other(metres) => format!("has coordinates in a unit of {metres} m"),
        CrsUnit::Mixed([plane, heights]) => {
            format!("has coordinates in units of {plane} m, but heights in units of {heights} m")
        }
    };
    Err(Error::new(&source.path, what, PROJECT))
}
