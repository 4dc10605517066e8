//! PCD, the format of the Point Cloud Library: ascii, binary, and compressed with
//! LZF, column by column.

mod header;
mod lzf;
mod value;

use std::io::{ErrorKind, Read};

use self::header::{Encoding, PcdHeader};
use self::value::Slot;
use super::{GridShape, Note, Order, Points, PointsBuilder, ScanEnd};
use crate::damage::{self, SEND_AS_BINARY};
use crate::source::{EXPORT_AGAIN, Source};
use crate::token::{excerpt, number_help, plain_number};
use crate::words::{grouped, plural};
use crate::{Error, Location, Result};

/// So many bytes of points are read at a time.
const BLOCK: usize = 1 << 16;

/// Whether `head` begins a PCD file: with its usual comment, or with a line that
/// only its header has.
pub(super) fn is_pcd(head: &[u8]) -> bool {
    let lines = head.split(|b| matches!(b, b'\r' | b'\n')).map(<[u8]>::trim_ascii);
    let mut lines = lines.filter(|line| !line.is_empty() && !line.starts_with(b"#"));
    let first = lines.next().unwrap_or_default();
    let begins = |word: &&[u8]| first.starts_with(word);
    head.starts_with(b"# .PCD") || [&b"VERSION "[..], b"FIELDS ", b"COLUMNS "].iter().any(begins)
}

pub(super) fn read(source: Source) -> Result<Points> {
    let head = source.head.clone();
    read_points(source).map_err(|error| explain(error, &head))
}

/// The same error, but with its true cause if the binary data were sent as text.
fn explain(mut error: Error, head: &[u8]) -> Error {
    let word = b"\nDATA binary";
    let start = head.windows(word.len()).position(|w| w == word).map(|at| at + word.len());
    let line = start.and_then(|at| Some(at + 1 + head[at..].iter().position(|&b| b == b'\n')?));
    if let Some(damage) = line.and_then(|at| damage::of(&head[at..])) {
        error.what = format!("{}, because {damage}", error.what);
        error.help = SEND_AS_BINARY.into();
    }
    error
}

fn read_points(mut source: Source) -> Result<Points> {
    let header = header::read(&mut source)?;
    let Some(position) = header.slots(["x", "y", "z"]) else {
        let help = "Export the points with their coordinates x, y and z.";
        return Err(Error::new(&source.path, "has no fields x, y and z of one value each", help));
    };
    let normal = header.slots(["normal_x", "normal_y", "normal_z"]);
    let normal = normal.or_else(|| header.slots(["nx", "ny", "nz"]));
    let mut builder = PointsBuilder::new(&source.path, normal.is_some());
    let grid = grid(&header);
    builder.begin_scan(grid.is_some());
    if grid.is_none() && header.is_organised() {
        builder.cloud().notes.push(Note::GridIgnored);
    }
    let mut body = PcdBody { source, header, slots: Slots { position, normal }, builder };
    match body.header.encoding {
        Encoding::Ascii => body.read_ascii()?,
        Encoding::Binary => body.read_binary()?,
        Encoding::Compressed => body.read_compressed()?,
    }
    body.check_end()?;
    // A header that names no place has zeros, which mean something only for a
    // camera's image.
    let viewpoint = body.header.viewpoint.filter(|v| grid.is_some() || *v != [0.0; 3]);
    let names = body.header.fields.iter().map(|field| field.name.as_str());
    body.builder.cloud().lost.count(names.filter(|name| *name != "_"), body.header.points);
    body.builder.end_scan(ScanEnd { viewpoint, pose: None, grid })?;
    body.builder.finish()
}

fn grid(header: &PcdHeader) -> Option<GridShape> {
    let fits = header.width.checked_mul(header.height) == Some(header.points);
    let rows = usize::try_from(header.height).ok()?;
    let columns = usize::try_from(header.width).ok()?;
    let order = Order::Rows;
    (fits && header.is_organised()).then_some(GridShape { rows, columns, order })
}

/// Where the wanted values are in a point.
struct Slots {
    position: [Slot; 3],
    normal: Option<[Slot; 3]>,
}

/// What comes after the header.
struct PcdBody {
    source: Source,
    header: PcdHeader,
    slots: Slots,
    builder: PointsBuilder,
}

impl PcdBody {
    fn read_ascii(&mut self) -> Result<()> {
        let count: u64 = self.header.fields.iter().map(|field| field.count).sum();
        let mut line = Vec::new();
        for i in 0..self.header.points {
            loop {
                if !self.source.next_text_line(&mut line)? {
                    return Err(self.cut(i));
                }
                if !line.trim_ascii().is_empty() && !line.starts_with(b"#") {
                    break;
                }
            }
            let words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
            if words.clone().count() as u64 != count {
                let what = format!("has a point that has not {count} values");
                return Err(self.source.error(what, EXPORT_AGAIN));
            }
            let number = |slot: Slot| number(words.clone().nth(slot.column)?);
            let [x, y, z] = self.slots.position.map(number);
            let normal = self.slots.normal.map(|n| n.map(|slot| number(slot).unwrap_or(0.0)));
            let (Some(x), Some(y), Some(z)) = (x, y, z) else {
                let text = excerpt(&line);
                let what = format!("has an unreadable point \u{201c}{text}\u{201d}");
                return Err(self.source.error(what, number_help(&text)));
            };
            self.builder.push([x, y, z], normal.unwrap_or_default())?;
        }
        Ok(())
    }

    fn read_binary(&mut self) -> Result<()> {
        // It has three numbers at least, and the header's reader bounds it.
        let record = self.header.record();
        let mut block = vec![0; record * (BLOCK / record).max(1)];
        let mut read = 0;
        while read < self.header.points {
            let most = (block.len() / record) as u64;
            let count = most.min(self.header.points - read) as usize;
            let records = &mut block[..count * record];
            let filled = self.fill(records)?;
            for record in records[..filled].chunks_exact(record) {
                let number = |slot: Slot| slot.number(record);
                let normal = self.slots.normal.map(|n| n.map(number));
                self.builder.push(self.slots.position.map(number), normal.unwrap_or_default())?;
                read += 1;
            }
            if filled < count * record {
                return Err(self.cut(read));
            }
        }
        Ok(())
    }

    /// Fills `bytes`, and returns how many of them the file still has.
    fn fill(&mut self, bytes: &mut [u8]) -> Result<usize> {
        let mut filled = 0;
        while filled < bytes.len() {
            match self.source.stream.read(&mut bytes[filled..]) {
                Ok(0) => break,
                Ok(some) => filled += some,
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) => return Err(self.source.io_error(&e)),
            }
        }
        Ok(filled)
    }

    fn read_compressed(&mut self) -> Result<()> {
        let sizes = self.read_sizes()?;
        self.drop_padding(sizes[1]);
        let [packed, unpacked] = sizes;
        let record = self.header.record() as u64;
        if self.header.points.checked_mul(record) != Some(unpacked) {
            let points = self.header.points;
            let what =
                format!("unpacks to {unpacked} bytes, but has {points} points of {record} bytes");
            return Err(Error::new(&self.source.path, what, EXPORT_AGAIN));
        }
        let mut bytes = Vec::new();
        let read = (&mut self.source.stream).take(packed).read_to_end(&mut bytes);
        let read = read.map_err(|e| self.source.io_error(&e))? as u64;
        if read < packed {
            let what = format!("ends after {read} of its {packed} bytes of packed points");
            return Err(Error::new(&self.source.path, what, EXPORT_AGAIN));
        }
        let columns = lzf::unpack(&bytes, unpacked as usize).ok_or_else(|| {
            let what = format!("has packed points that do not unpack to {unpacked} bytes");
            Error::new(&self.source.path, what, EXPORT_AGAIN)
        })?;
        drop(bytes);
        self.push_columns(&columns)
    }

    /// The sizes of the packed points, and of what they unpack to.
    fn read_sizes(&mut self) -> Result<[u64; 2]> {
        let mut sizes = [[0; 4]; 2];
        if let Err(e) = self.source.stream.read_exact(sizes.as_flattened_mut()) {
            return Err(match e.kind() {
                ErrorKind::UnexpectedEof => self.cut(0),
                _ => self.source.io_error(&e),
            });
        }
        Ok(sizes.map(|size| u64::from(u32::from_le_bytes(size))))
    }

    /// PCL names padding in the header of packed points, but does not write it.
    fn drop_padding(&mut self, unpacked: u64) {
        let fields = &mut self.header.fields;
        let bytes = fields.iter().filter(|field| field.name != "_").map(|field| field.bytes());
        if self.header.points.checked_mul(bytes.sum()) != Some(unpacked) {
            return;
        }
        fields.retain(|field| field.name != "_");
        if let Some(position) = self.header.slots(["x", "y", "z"]) {
            self.slots.position = position;
        }
        if self.slots.normal.is_some() {
            let normal = self.header.slots(["normal_x", "normal_y", "normal_z"]);
            self.slots.normal = normal.or_else(|| self.header.slots(["nx", "ny", "nz"]));
        }
    }

    /// Adds points whose fields stand one after the other, each of all points.
    fn push_columns(&mut self, columns: &[u8]) -> Result<()> {
        let count = self.header.points as usize;
        let column = |slot: Slot| {
            let start = columns.get(count * slot.offset..).unwrap_or_default();
            (start, slot.kind)
        };
        let position = self.slots.position.map(column);
        let normal = self.slots.normal.map(|n| n.map(column));
        for i in 0..count {
            let number = |(column, kind): (&[u8], value::Kind)| {
                kind.number(column.get(i * kind.bytes()..).unwrap_or_default())
            };
            let normal = normal.map(|n| n.map(number));
            self.builder.push(position.map(number), normal.unwrap_or_default())?;
        }
        Ok(())
    }

    fn cut(&self, point: u64) -> Error {
        let what =
            format!("ends after {} of its {}", grouped(point), plural(self.header.points, "point"));
        let error = Error::new(&self.source.path, what, EXPORT_AGAIN);
        error.at(Location::Element("point", point))
    }

    /// A header that promises less than the file has would lose points silently.
    fn check_end(&mut self) -> Result<()> {
        let mut rest = [0; 4096];
        let mut line = Vec::new();
        let is_ascii = self.header.encoding == Encoding::Ascii;
        let surplus = |byte: &u8| !byte.is_ascii_whitespace() && !matches!(byte, 0 | 0x1a);
        loop {
            let (more, bytes) = if is_ascii {
                (self.source.next_text_line(&mut line)?, &line[..])
            } else {
                let n = self.source.stream.read(&mut rest);
                let n = n.map_err(|e| self.source.io_error(&e))?;
                (n > 0, &rest[..n])
            };
            if bytes.iter().any(surplus) && !(is_ascii && bytes.starts_with(b"#")) {
                let help = "The header's counts do not match the content: export it again.";
                return Err(self.source.error("has more data than its header announces", help));
            }
            if !more {
                return Ok(());
            }
        }
    }
}

fn number(word: &[u8]) -> Option<f64> {
    let word = std::str::from_utf8(word).ok()?;
    word.parse().ok().or_else(|| plain_number(word).parse().ok())
}
