//! E57 (ASTM E2807), the format of terrestrial scanners: one or more scans in metres, each
//! with its pose, and perhaps on a grid.
//!
//! The input is a file. The output is [`Points`] in the frame of the file. The crate `e57`
//! reads the description of the scans, but only after the lengths in the header were checked.
//! The points are read here after their fields were checked: points without any bits would
//! have no bound.

mod fields;
mod grid;
mod packets;

use std::io::{Cursor, Read};

use ::e57::{E57Reader, PointCloud, RecordDataType, Transform};

use self::fields::{Fields, Reading};
use self::grid::GridIndices;
use self::packets::{Damage, Packets};
use super::{LeftOut, Note, Points, PointsBuilder, Pose, ReadOptions, ScanEnd};
use crate::source::{EXPORT_AGAIN, Source};
use crate::words::plural;
use crate::{Error, LengthUnit, Location, Result};

/// The first bytes of every file.
pub(super) const SIGNATURE: &[u8] = b"ASTM-E57";

/// The length of the header in bytes.
const HEADER: usize = 48;

/// No file describes its scans in more bytes of XML. A scan takes some 4 KiB. The parser takes
/// about 20 bytes of memory for each byte.
const MOST_XML: u64 = 16 << 20;

/// A rotation whose quaternion is longer or shorter than 1 by more than this is none. Writers
/// round to six digits or more.
const UNIT_LENGTH: f64 = 1e-3;

/// So many points are unpacked at a time: as many as fit into the nearest memory of a processor.
const BLOCK: u64 = 1024;

pub(super) fn read(mut source: Source, options: &ReadOptions) -> Result<Points> {
    let mut bytes = Vec::new();
    source.stream.read_to_end(&mut bytes).map_err(|e| source.io_error(&e))?;
    check_header(&source, &bytes)?;
    let reader = E57Reader::new(Cursor::new(&bytes))
        .map_err(|e| Error::new(&source.path, format!("is unreadable: {e}"), EXPORT_AGAIN))?;
    let (scans, page) = (reader.pointclouds(), reader.header().page_size);
    drop(reader);
    check_records(&source, &scans, bytes.len() as u64)?;
    let fields: Vec<Fields> = scans.iter().map(|scan| Fields::of(&scan.prototype)).collect();
    let has_normals = fields.iter().any(Fields::has_normals);
    let builder = PointsBuilder::new(&source.path, has_normals);
    let mut body = E57Body { source, bytes, page, builder, options: options.clone() };
    for (number, (scan, fields)) in scans.iter().zip(&fields).enumerate() {
        body.read_scan(number as u64, scan, fields)?;
    }
    let mut names: Vec<&str> =
        fields.iter().flat_map(|fields| &fields.others).map(|n| &**n).collect();
    names.sort_unstable();
    names.dedup();
    let cloud = body.builder.cloud();
    cloud.unit = Some(LengthUnit::Metre);
    cloud.lost.count(names.into_iter(), 0);
    body.builder.finish()
}

fn check_header(source: &Source, bytes: &[u8]) -> Result<()> {
    let bad = |what: String| Err(Error::new(&source.path, what, EXPORT_AGAIN));
    if !bytes.starts_with(SIGNATURE) {
        return bad("does not begin as an E57 file".to_owned());
    }
    let length = bytes.get(32..HEADER).and_then(|rest| rest.first_chunk());
    let Some(length) = length.map(|&number| u64::from_le_bytes(number)) else {
        return bad("ends in its header".to_owned());
    };
    if length > MOST_XML || length > bytes.len() as u64 {
        return bad(format!("has a description of {length} bytes in {} bytes", bytes.len()));
    }
    Ok(())
}

/// Checks that the points that the scans announce fit into the file. Several scans may refer
/// to the same bytes, so that only their sum bounds the memory.
fn check_records(source: &Source, scans: &[PointCloud], length: u64) -> Result<()> {
    let mut bits = 0u128;
    for (number, scan) in scans.iter().enumerate() {
        let record: u128 =
            scan.prototype.iter().map(|record| fields::bits(&record.data_type)).sum();
        let place = Location::Element("scan", number as u64);
        if record == 0 && scan.records > 0 {
            let what = "has points without any bits";
            return Err(Error::new(&source.path, what, EXPORT_AGAIN).at(place));
        }
        bits += record * u128::from(scan.records);
        if bits > 8 * u128::from(length) {
            let what = format!("announces {} that are not there", plural(scan.records, "point"));
            return Err(Error::new(&source.path, what, EXPORT_AGAIN).at(place));
        }
    }
    Ok(())
}

struct E57Body {
    source: Source,
    bytes: Vec<u8>,
    /// The bytes of a page.
    page: u64,
    builder: PointsBuilder,
    options: ReadOptions,
}

impl E57Body {
    fn read_scan(&mut self, number: u64, scan: &PointCloud, fields: &Fields) -> Result<()> {
        let bad = |what: &str| {
            let error = Error::new(&self.source.path, format!("has {what}"), EXPORT_AGAIN);
            Err(error.at(Location::Element("scan", number)))
        };
        if scan.records > 0 && !fields.has_position() {
            return bad("a scan without coordinates");
        }
        if self.options.min_intensity.is_some() && scan.records > 0 && !fields.has_intensity() {
            return bad("a scan without intensities");
        }
        if !scan.prototype.iter().all(|record| is_finite(&record.data_type)) {
            return bad("a scale or an offset that is no number");
        }
        let Ok(pose) = scan.transform.as_ref().map(pose).transpose() else {
            return bad("a pose that is none");
        };
        self.builder.begin_scan(fields.has_grid());
        let grid = self.read_points(number, scan, fields)?;
        let shape = match grid.finish() {
            Ok(shape) => shape,
            Err(grid::NoGrid) => {
                self.builder.cloud().notes.push(Note::GridIgnored);
                None
            }
        };
        // A pose that moves nothing may say that the points were moved before.
        let moved = pose.filter(|pose| !pose.is_still());
        let stood = moved.map(|pose| pose.translation);
        let viewpoint = stood.or(fields.is_spherical().then_some([0.0; 3]));
        self.builder.end_scan(ScanEnd { viewpoint, pose, grid: shape })
    }

    fn read_points(
        &mut self,
        number: u64,
        scan: &PointCloud,
        fields: &Fields,
    ) -> Result<GridIndices> {
        let mut grid = GridIndices::default();
        if scan.records == 0 {
            return Ok(grid);
        }
        let path = &self.source.path;
        let unreadable = |at: u64, damage: Damage| {
            let what = format!("has a point in scan {number} that is unreadable: {damage}");
            Error::new(path, what, EXPORT_AGAIN).at(Location::Element("point", at))
        };
        let packets = Packets::new(&self.bytes, self.page, scan.file_offset, &scan.prototype);
        let mut packets = packets.map_err(|damage| unreadable(0, damage))?;
        let mut columns = vec![Vec::new(); scan.prototype.len()];
        let mut read = 0;
        while read < scan.records {
            let most = BLOCK.min(scan.records - read) as usize;
            let count = packets.read(most, &mut columns, |field| fields.is_wanted(field));
            let count = count.map_err(|damage| unreadable(read, damage))?;
            for point in 0..count {
                let reading = Reading { fields, columns: &columns, point };
                push(&mut self.builder, &mut grid, &self.options, &reading)?;
            }
            read += count as u64;
        }
        Ok(grid)
    }
}

/// Adds a point, or counts why it is left out.
fn push(
    builder: &mut PointsBuilder,
    grid: &mut GridIndices,
    options: &ReadOptions,
    reading: &Reading,
) -> Result<()> {
    let position = reading.position();
    if let Some(cell) = reading.cell() {
        grid.push(position.and(Some(cell)));
    }
    let intensity = reading.intensity();
    let is_dark = options.min_intensity.is_some_and(|least| intensity.is_none_or(|i| i < least));
    match position {
        None => builder.leave_out(LeftOut::Marked),
        Some(_) if is_dark => builder.leave_out(LeftOut::Filtered),
        Some(xyz) => {
            let lost = &mut builder.cloud().lost;
            lost.intensities += u64::from(intensity.is_some());
            lost.colours += u64::from(reading.has_colour());
            builder.push(xyz, reading.normal())
        }
    }
}

/// Whether a scale, if there is one, leads to numbers.
fn is_finite(kind: &RecordDataType) -> bool {
    match kind {
        RecordDataType::ScaledInteger { scale, offset, .. } => {
            scale.is_normal() && offset.is_finite()
        }
        RecordDataType::Single { .. }
        | RecordDataType::Double { .. }
        | RecordDataType::Integer { .. } => true,
    }
}

/// The pose with its rotation normalised. `Err` if it has none.
fn pose(transform: &Transform) -> std::result::Result<Pose, ()> {
    let (q, t) = (&transform.rotation, &transform.translation);
    let length = (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z).sqrt();
    let translation = [t.x, t.y, t.z];
    // Also where a number is not finite.
    let is_unit = (length - 1.0).abs() <= UNIT_LENGTH;
    if !is_unit || !translation.iter().all(|x| x.is_finite()) {
        return Err(());
    }
    let [w, x, y, z] = [q.w, q.x, q.y, q.z].map(|part| part / length);
    let axes = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
    ];
    Ok(Pose { axes, translation })
}
