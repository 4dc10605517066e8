//! The points of a scan in an E57 file.
//!
//! The input is the bytes of the file, the place where the points begin, and the types of their
//! fields. The output is columns of numbers, some points at a time. The points are in packets,
//! and the packets are in pages that end with a checksum (ASTM E2807, 9.2 to 9.6). The crate `e57`
//! reads packets too, but it makes a vector for every point, which takes several times as long.

use ::e57::{Record, RecordDataType};

use super::fields;

/// The bytes of a checksum at the end of a page.
const CHECKSUM: usize = 4;

/// The bytes before the packets of a scan. They begin with [`SECTION`] and hold the place of the
/// first packet at [`FIRST_PACKET`].
const SECTION_HEAD: usize = 32;
const SECTION: u8 = 1;
const FIRST_PACKET: usize = 16;

/// The bytes that every packet begins with: its type, flags, and its length less one.
const PACKET_HEAD: usize = 4;

/// The types of packets: an index of the others, points, and nothing.
const INDEX: u8 = 0;
const POINTS: u8 = 1;
const NOTHING: u8 = 2;

/// What is wrong with the points.
pub(super) type Damage = &'static str;

/// Reads the points of a scan.
pub(super) struct Packets<'a> {
    pages: Pages<'a>,
    /// The bytes of the packet at hand.
    packet: Vec<u8>,
    streams: Vec<Stream>,
}

impl<'a> Packets<'a> {
    /// A reader of the points at `start` in `bytes`. `page` is the number of bytes of a page.
    pub(super) fn new(
        bytes: &'a [u8],
        page: u64,
        start: u64,
        prototype: &[Record],
    ) -> Result<Packets<'a>, Damage> {
        let mut pages = Pages::new(bytes, page)?;
        let mut head = Vec::new();
        pages.seek(start)?;
        pages.read(SECTION_HEAD, &mut head)?;
        let first = head.get(FIRST_PACKET..).and_then(<[u8]>::first_chunk);
        match (head.first(), first) {
            (Some(&SECTION), Some(&first)) => pages.seek(u64::from_le_bytes(first))?,
            _ => return Err("no section of points begins there"),
        }
        let streams = prototype.iter().map(|record| Stream::new(&record.data_type)).collect();
        Ok(Packets { pages, packet: head, streams })
    }

    /// Reads the next points, but no more than `most`, and returns their number, which is at least
    /// one. The values of each field are put into its column if that `is_wanted`.
    pub(super) fn read(
        &mut self,
        most: usize,
        columns: &mut [Vec<f64>],
        is_wanted: impl Fn(usize) -> bool,
    ) -> Result<usize, Damage> {
        let mut count = self.available();
        while count == 0 {
            self.advance()?;
            count = self.available();
        }
        let count = count.min(most);
        for (i, (stream, column)) in self.streams.iter_mut().zip(columns).enumerate() {
            column.clear();
            if is_wanted(i) {
                stream.unpack(count, column);
            }
            stream.at += count * stream.bits;
        }
        Ok(count)
    }

    /// The number of points that all of their values are there of.
    fn available(&self) -> usize {
        self.streams.iter().filter_map(Stream::available).min().unwrap_or(0)
    }

    /// Adds the next packet to the streams.
    fn advance(&mut self) -> Result<(), Damage> {
        self.packet.clear();
        self.pages.read(PACKET_HEAD, &mut self.packet)?;
        let &[kind, _, low, high] = &self.packet[..] else { return Err("the file ends") };
        let length = usize::from(u16::from_le_bytes([low, high])) + 1;
        let rest = length.checked_sub(PACKET_HEAD).filter(|rest| rest % 4 == 0);
        self.pages.read(rest.ok_or("a packet has an impossible length")?, &mut self.packet)?;
        match kind {
            POINTS => self.append().ok_or("a packet does not hold the fields of its scan"),
            INDEX | NOTHING => Ok(()),
            _ => Err("a packet is of an unknown type"),
        }
    }

    /// Adds the packet at hand to the streams. `None` if it does not fit them.
    fn append(&mut self) -> Option<()> {
        let (&count, rest) = self.packet.get(PACKET_HEAD..)?.split_first_chunk()?;
        let count = usize::from(u16::from_le_bytes(count));
        if count != self.streams.len() {
            return None;
        }
        let (lengths, mut rest) = rest.split_at_checked(2 * count)?;
        let lengths = lengths.as_chunks().0.iter().map(|&length| u16::from_le_bytes(length));
        for (stream, length) in self.streams.iter_mut().zip(lengths) {
            let (bytes, after) = rest.split_at_checked(usize::from(length))?;
            stream.append(bytes);
            rest = after;
        }
        Some(())
    }
}

/// The values of a field, one after the other, without space between their bits.
struct Stream {
    kind: RecordDataType,
    /// The bits of a value. It is 0 if all values are the same.
    bits: usize,
    bytes: Vec<u8>,
    /// The first bit that was not read yet.
    at: usize,
}

impl Stream {
    fn new(kind: &RecordDataType) -> Stream {
        let bits = fields::bits(kind) as usize;
        Stream { kind: kind.clone(), bits, bytes: Vec::new(), at: 0 }
    }

    /// The number of values that are there. `None` if these are as many as wanted.
    fn available(&self) -> Option<usize> {
        (8 * self.bytes.len()).saturating_sub(self.at).checked_div(self.bits)
    }

    fn append(&mut self, more: &[u8]) {
        // So that every byte is moved a few times at most.
        let read = self.at / 8;
        if read >= self.bytes.len() / 2 {
            self.bytes.drain(..read.min(self.bytes.len()));
            self.at -= 8 * read;
        }
        self.bytes.extend_from_slice(more);
    }

    /// Adds the next `count` values to `column`.
    fn unpack(&self, count: usize, column: &mut Vec<f64>) {
        let raw = (0..count).map(|i| bits_at(&self.bytes, self.at + i * self.bits, self.bits));
        match self.kind {
            RecordDataType::Single { .. } => {
                column.extend(raw.map(|raw| f64::from(f32::from_bits(raw as u32))));
            }
            RecordDataType::Double { .. } => column.extend(raw.map(f64::from_bits)),
            RecordDataType::Integer { min, .. } => {
                column.extend(raw.map(|raw| min.wrapping_add(raw as i64) as f64));
            }
            RecordDataType::ScaledInteger { min, scale, offset, .. } => {
                let value = |raw| min.wrapping_add(raw as i64) as f64 * scale + offset;
                column.extend(raw.map(value));
            }
        }
    }
}

/// The number of `bits` bits that begins with bit `at`. Bits behind the end are zero.
fn bits_at(bytes: &[u8], at: usize, bits: usize) -> u64 {
    let rest = bytes.get(at / 8..).unwrap_or_default();
    let word = rest.first_chunk().copied().unwrap_or_else(|| {
        let mut word = [0; 16];
        word[..rest.len()].copy_from_slice(rest);
        word
    });
    let mask = u64::MAX.checked_shr(64 - bits as u32).unwrap_or(0);
    (u128::from_le_bytes(word) >> (at % 8)) as u64 & mask
}

/// The content of a file without the checksums of its pages, each of which is checked.
struct Pages<'a> {
    /// What was not reached yet. It begins with a page.
    rest: &'a [u8],
    bytes: &'a [u8],
    size: usize,
    /// What was not read yet of the page at hand.
    page: &'a [u8],
}

impl<'a> Pages<'a> {
    fn new(bytes: &'a [u8], size: u64) -> Result<Pages<'a>, Damage> {
        let size = usize::try_from(size).ok().filter(|&size| size > CHECKSUM);
        let size = size.ok_or("its pages have no content")?;
        Ok(Pages { rest: bytes, bytes, size, page: &[] })
    }

    /// Goes on at byte `at` of the file.
    fn seek(&mut self, at: u64) -> Result<(), Damage> {
        let at = usize::try_from(at).map_err(|_| "the file ends before")?;
        let within = at % self.size;
        self.rest = self.bytes.get(at - within..).ok_or("the file ends before")?;
        self.turn()?;
        self.page = self.page.get(within..).ok_or("a checksum is where points should be")?;
        Ok(())
    }

    /// Goes to the next page.
    fn turn(&mut self) -> Result<(), Damage> {
        let (page, rest) = self.rest.split_at_checked(self.size).ok_or("the file ends")?;
        let (page, sum) = page.split_last_chunk::<CHECKSUM>().ok_or("the file ends")?;
        if crc32c::crc32c(page) != u32::from_be_bytes(*sum) {
            return Err("the checksum of a page is wrong");
        }
        (self.page, self.rest) = (page, rest);
        Ok(())
    }

    /// Adds the next `count` bytes to `bytes`.
    fn read(&mut self, mut count: usize, bytes: &mut Vec<u8>) -> Result<(), Damage> {
        while count > 0 {
            if self.page.is_empty() {
                self.turn()?;
            }
            let (some, rest) = self.page.split_at(count.min(self.page.len()));
            bytes.extend_from_slice(some);
            self.page = rest;
            count -= some.len();
        }
        Ok(())
    }
}
