//! The compressed points of a LAZ file.
//!
//! The input is the bytes after the header. They are chunks of points that are compressed
//! separately (Isenburg, "LASzip: lossless compression of LiDAR data", 2013), and a table of
//! the chunks. The crate `laz` decompresses each chunk, but only after everything that it
//! allocates or relies on was checked here.

use std::io::Cursor;
use std::ops::Range;
use std::panic::{self, AssertUnwindSafe};

use laz::laszip::ChunkTable;
use laz::record::{
    LayeredPointRecordDecompressor, RecordDecompressor, SequentialPointRecordDecompressor,
};
use laz::{DecompressionSelection, LazItem, LazItemType, LazVlr};

use super::header::LasHeader;
use super::records::LasPoints;
use crate::source::EXPORT_AGAIN;
use crate::words::{grouped, plural};
use crate::{Error, Location, Result, limits};

/// The bytes before the first chunk, which say where the table is.
const TABLE_OFFSET: usize = 8;

/// The bytes of the table before its compressed part: its version and the number of chunks.
const TABLE_HEAD: usize = 8;

/// No arithmetic coder begins with these bytes: its first number is less than the length of the
/// first interval, which is this number. `laz` panics on a number that is not.
const NO_CODE: [u8; 4] = [0xff; 4];

/// The points of a file.
pub(super) struct PackedPoints<'a> {
    path: &'a std::path::Path,
    header: &'a LasHeader,
    /// The file from the first point to its end.
    bytes: &'a [u8],
    vlr: LazVlr,
    kind: ChunkKind,
}

/// How points are grouped.
#[derive(Clone, Copy, PartialEq)]
enum ChunkKind {
    /// All points are in one chunk, and there is no table.
    One,
    /// The fields of a point follow each other.
    PointWise,
    /// Each field has a layer with the values of all points.
    Layered,
}

/// The bytes of a chunk and the number of its points.
struct Chunk {
    bytes: Range<usize>,
    count: u64,
}

impl<'a> PackedPoints<'a> {
    /// Checks the record about the compression.
    pub(super) fn new(
        path: &'a std::path::Path,
        header: &'a LasHeader,
        bytes: &'a [u8],
    ) -> Result<Self> {
        let bad = |what: &str| Error::new(path, what, EXPORT_AGAIN);
        let is_laszip = |user: &str, id| user == LazVlr::USER_ID && id == LazVlr::RECORD_ID;
        let record = header.records.iter().find(|vlr| is_laszip(&vlr.user_id, vlr.record_id));
        let record = record.ok_or_else(|| bad("has compressed points, but does not say how"))?;
        let vlr = LazVlr::from_buffer(&record.data)
            .map_err(|e| bad(&format!("has points of an unknown compression: {e}")))?;
        // `LazVlr` does not tell its compressor, which is the first number of the record.
        let kind = match record.data.first_chunk().map(|&number| u16::from_le_bytes(number)) {
            Some(1) => ChunkKind::One,
            Some(2) => ChunkKind::PointWise,
            Some(3) => ChunkKind::Layered,
            _ => return Err(bad("has points of an unknown compression")),
        };
        check_items(vlr.items(), kind, header)
            .ok_or_else(|| bad("has compressed fields that do not fit its format of points"))?;
        limits::check_density(path, header.announced, bytes.len())?;
        Ok(PackedPoints { path, header, bytes, vlr, kind })
    }

    /// Decompresses all points.
    pub(super) fn read(&self, points: &mut LasPoints) -> Result<()> {
        let mut first = 0;
        for chunk in self.chunks()? {
            self.read_chunk(&chunk, first, points)?;
            first += chunk.count;
        }
        Ok(())
    }

    fn chunks(&self) -> Result<Vec<Chunk>> {
        let announced = self.header.announced;
        if self.kind == ChunkKind::One {
            return Ok(vec![Chunk { bytes: 0..self.bytes.len(), count: announced }]);
        }
        let (at, table) = self.table()?;
        let mut left = announced;
        let mut chunks = Vec::new();
        let mut start = TABLE_OFFSET;
        for entry in table.as_ref() {
            let size = usize::try_from(entry.byte_count).ok();
            let end = size.and_then(|size| start.checked_add(size)).filter(|&end| end <= at);
            let Some(end) = end else {
                return Err(self.bad_table("chunks beyond its table"));
            };
            let count = match self.vlr.uses_variable_size_chunks() {
                true => entry.point_count,
                false => u64::from(self.vlr.chunk_size()),
            };
            let count = count.min(left);
            if count > 0 {
                chunks.push(Chunk { bytes: start..end, count });
            }
            (start, left) = (end, left - count);
        }
        if left > 0 {
            let missing = format!(
                "chunks for {} of {}",
                grouped(announced - left),
                plural(announced, "point")
            );
            return Err(self.bad_table(&missing));
        }
        Ok(chunks)
    }

    /// The table of chunks, and where it begins in the bytes.
    fn table(&self) -> Result<(usize, ChunkTable)> {
        let at = self.table_start().ok_or_else(|| self.bad_table("no table of its chunks"))?;
        let mut table = Cursor::new(&self.bytes[at..]);
        let count = self.bytes.get(at + 4..at + TABLE_HEAD).and_then(|n| n.first_chunk());
        let count = count.map_or(0, |&number| u32::from_le_bytes(number));
        // The first point of each chunk is not compressed.
        if self.bytes[at + TABLE_HEAD..].starts_with(&NO_CODE) {
            return Err(self.bad_table("an unreadable table of its chunks"));
        }
        if count as usize > at / self.header.record {
            return Err(self.bad_table(&format!("{count} chunks of points in {at} bytes")));
        }
        let is_variable = self.vlr.uses_variable_size_chunks();
        let table = ChunkTable::read(&mut &mut table, is_variable)
            .map_err(|e| self.bad_table(&format!("an unreadable table of its chunks: {e}")))?;
        Ok((at, table))
    }

    /// Where the table begins. Writers that could not go back have this at the end of the file.
    fn table_start(&self) -> Option<usize> {
        let number = |bytes: &[u8]| Some(i64::from_le_bytes(*bytes.first_chunk()?));
        let inside = |offset: i64| {
            let at = u64::try_from(offset).ok()?.checked_sub(self.header.start)?;
            let at = usize::try_from(at).ok()?;
            (at >= TABLE_OFFSET && at.checked_add(TABLE_HEAD)? <= self.bytes.len()).then_some(at)
        };
        let last = self.bytes.len().checked_sub(8)?;
        let first = number(self.bytes).and_then(inside);
        first.or_else(|| number(&self.bytes[last..]).and_then(inside))
    }

    fn read_chunk(&self, chunk: &Chunk, first: u64, points: &mut LasPoints) -> Result<()> {
        let bytes = &self.bytes[chunk.bytes.clone()];
        let damaged = || {
            let error = Error::new(self.path, "has a damaged chunk of points", EXPORT_AGAIN);
            error.at(Location::Element("point", first))
        };
        let is_sound = match self.kind {
            ChunkKind::Layered => self.layers_are_sound(bytes),
            ChunkKind::One | ChunkKind::PointWise => {
                let code = bytes.get(self.header.record..);
                code.is_some_and(|code| !code.starts_with(&NO_CODE))
            }
        };
        if !is_sound {
            return Err(damaged());
        }
        // `laz` asserts that codes are sound where it is built for debugging. No check of ours can
        // tell before it decodes them.
        let unpacked = panic::catch_unwind(AssertUnwindSafe(|| match self.kind {
            ChunkKind::Layered => {
                let unpacker = LayeredPointRecordDecompressor::new(Cursor::new(bytes));
                self.unpack(unpacker, chunk.count, points)
            }
            ChunkKind::One | ChunkKind::PointWise => {
                let unpacker = SequentialPointRecordDecompressor::new(bytes);
                self.unpack(unpacker, chunk.count, points)
            }
        }));
        unpacked.map_err(|_| damaged())?.map_err(|(done, error)| {
            let error = error.unwrap_or_else(|| {
                let announced = self.header.announced;
                let what = format!(
                    "ends after {} of its {}",
                    grouped(first + done),
                    plural(announced, "point")
                );
                Error::new(self.path, what, EXPORT_AGAIN)
            });
            error.at(Location::Element("point", first + done))
        })
    }

    /// Takes the points of a chunk. On error it returns how many there were, and an error
    /// unless the data ended.
    fn unpack<R>(
        &self,
        mut unpacker: impl RecordDecompressor<R>,
        count: u64,
        points: &mut LasPoints,
    ) -> std::result::Result<(), (u64, Option<Error>)> {
        if unpacker.set_fields_from(self.vlr.items()).is_err() {
            let what = "has points of an unknown compression";
            return Err((0, Some(Error::new(self.path, what, EXPORT_AGAIN))));
        }
        let wanted = DecompressionSelection::Z
            | DecompressionSelection::CLASSIFICATION
            | DecompressionSelection::FLAGS
            | DecompressionSelection::INTENSITY;
        unpacker.set_selection(DecompressionSelection(wanted));
        let mut record = vec![0; self.header.record];
        for done in 0..count {
            unpacker.decompress_next(&mut record).map_err(|_| (done, None))?;
            points.push(&record).map_err(|error| (done, Some(error)))?;
        }
        Ok(())
    }

    /// Whether the layers of a chunk are within the chunk, and each may be a code.
    fn layers_are_sound(&self, chunk: &[u8]) -> bool {
        let layers: usize = self.vlr.items().iter().map(|item| layers(item.item_type())).sum();
        // The first point and the number of points are before the sizes.
        let rest = chunk.get(self.header.record + 4..);
        let Some((sizes, mut content)) = rest.and_then(|rest| rest.split_at_checked(4 * layers))
        else {
            return false;
        };
        sizes.as_chunks().0.iter().all(|&size| {
            let layer = content.split_at_checked(u32::from_le_bytes(size) as usize);
            layer.is_some_and(|(layer, after)| {
                content = after;
                !layer.starts_with(&NO_CODE)
            })
        })
    }

    fn bad_table(&self, what: &str) -> Error {
        Error::new(self.path, format!("has {what}"), EXPORT_AGAIN)
    }
}

/// The number of layers of a field.
fn layers(item: LazItemType) -> usize {
    match item {
        LazItemType::Point14 => 9,
        LazItemType::RGBNIR14 => 2,
        LazItemType::Byte14(count) => usize::from(count),
        _ => 1,
    }
}

/// Checks that the fields make up the points of the header. `None` if they do not.
fn check_items(items: &[LazItem], kind: ChunkKind, header: &LasHeader) -> Option<()> {
    let is_layered = kind == ChunkKind::Layered;
    let first = items.first()?.item_type();
    let is_extended = first == LazItemType::Point14;
    if !is_extended && first != LazItemType::Point10
        || is_extended != is_layered
        || is_extended != header.format.is_extended
    {
        return None;
    }
    let mut sum = 0;
    for item in items {
        // The versions of the compression that are layered.
        let fits = is_layered == matches!(item.version(), 3 | 4);
        (fits && size(item.item_type()) == item.size()).then_some(())?;
        sum += usize::from(item.size());
    }
    (sum == header.record).then_some(())
}

/// The bytes of a field.
fn size(item: LazItemType) -> u16 {
    match item {
        LazItemType::Byte(count) | LazItemType::Byte14(count) => count,
        LazItemType::Point10 => 20,
        LazItemType::GpsTime => 8,
        LazItemType::RGB12 | LazItemType::RGB14 => 6,
        LazItemType::RGBNIR14 => 8,
        LazItemType::WavePacket13 | LazItemType::WavePacket14 => 29,
        LazItemType::Point14 => 30,
    }
}
