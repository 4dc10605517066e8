//! Reader of STL files, ASCII and binary.
//!
//! The crate stl_io 0.11 is not used, because it ends after the first of several solids, reads a
//! binary file that begins with "solid" as text, and refuses upper case.

use std::io::{ErrorKind, Read};
use std::str::SplitAsciiWhitespace;

use crate::damage::{SEND_AS_BINARY, TextTrace};
use crate::limits::check_room;
use crate::scene::{GroupRuns, Scene, SceneMesh, SceneNote};
use crate::source::{EXPORT_AGAIN, Source};
use crate::token::{excerpt, number_help, plain_number};
use crate::unit_comment::UnitComments;
use crate::words::{grouped, plural};
use crate::{Error, Location, Result, Soup};

/// The size in bytes of the free text at the beginning of a binary file. The number of triangles
/// follows.
const HEADER: usize = 80;
const PREFIX: usize = HEADER + 4;

/// The size in bytes of a triangle: a normal, three corners and an attribute.
const RECORD: usize = 50;

/// The largest number of bytes after the records that are examined.
const MOST_SURPLUS: u64 = 64 << 20;

/// Whether `head` is the beginning of an ASCII file. A binary file may begin with "solid", too, but
/// it has a zero byte in its number of triangles at the latest.
pub(crate) fn is_ascii(head: &[u8]) -> bool {
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    let solid = head.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    solid && head.get(5).is_none_or(u8::is_ascii_whitespace) && !head.contains(&0)
}

/// Whether a file of `len` bytes that begins with `head` has exactly the length for its number of
/// triangles. A binary file has no other mark.
pub(crate) fn is_binary(head: &[u8], len: Option<u64>) -> bool {
    let Some(count) = head.get(HEADER..PREFIX) else {
        return false;
    };
    let count = count.iter().rev().fold(0, |n, &byte| n << 8 | u64::from(byte));
    count > 0 && len == Some(PREFIX as u64 + count * RECORD as u64)
}

/// The largest coordinate of a binary file without a length that is believed to be one. It is a
/// thousand times the size of the earth in millimetres. Numbers made of random bytes are as often
/// above it as not.
const LARGEST_COORDINATE: f32 = 1.3e13;

/// Whether `head` begins with a number of triangles and with triangles whose numbers may be
/// coordinates. Small integers, which other binary formats have in such places, are denormal numbers.
/// Use it if the length is unknown and no other format is recognized.
pub(crate) fn begins_as_binary(head: &[u8]) -> bool {
    let Some((prefix, records)) = head.split_at_checked(PREFIX) else {
        return false;
    };
    let is_coordinate = |x: f32| x == 0.0 || x.is_normal() && x.abs() <= LARGEST_COORDINATE;
    let is_sound = |record: &[u8; RECORD]| {
        let numbers = record.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
        { numbers }.all(is_coordinate)
    };
    let records = records.as_chunks::<RECORD>().0;
    let has_records = prefix[HEADER..] != [0; 4] && !records.is_empty();
    has_records && !is_text(head) && records.iter().all(is_sound)
}

/// Whether `head` is any text. A binary file has zero bytes in its number of triangles. Text need
/// not begin with "solid".
fn is_text(head: &[u8]) -> bool {
    let is_control = |b: &u8| b.is_ascii_control() && !b.is_ascii_whitespace() && *b != 0x1a;
    is_ascii(head) || !head.iter().any(is_control)
}

pub(crate) fn read(source: Source) -> Result<Scene> {
    let path = source.path.clone();
    if is_binary(&source.head, source.len) || !is_text(&source.head) {
        let mesh = SceneMesh::plain(read_binary(source)?);
        return Ok(Scene::of_mesh(path, mesh));
    }
    let (mesh, note) = Ascii::new(source).read()?;
    let mut scene = Scene::of_mesh(path, mesh);
    scene.notes.extend(note);
    Ok(scene)
}

fn read_binary(mut source: Source) -> Result<Soup> {
    let mut prefix = [0; PREFIX];
    if let Err(e) = source.stream.read_exact(&mut prefix) {
        return Err(match e.kind() {
            ErrorKind::UnexpectedEof => Error::new(&source.path, "is no STL file", EXPORT_AGAIN),
            _ => source.io_error(&e),
        });
    }
    let [text @ .., a, b, c, d] = prefix;
    let count = u32::from_le_bytes([a, b, c, d]);
    let mut soup = Soup::default();
    let mut comments = UnitComments::default();
    // Materialise writes names and values with binary values between them.
    text.split(|byte| !(b' '..=b'~').contains(byte)).for_each(|piece| comments.read(piece));
    comments.give(&mut soup);
    let mut trace = TextTrace::new();
    let mut record = [0; RECORD];
    for i in 0..count {
        if let Err(e) = source.stream.read_exact(&mut record) {
            return Err(match e.kind() {
                ErrorKind::UnexpectedEof => cut(&source, i, count),
                _ => source.io_error(&e),
            });
        }
        trace.push(&record);
        check_room(&source.path, &soup, 3, 3)?;
        let first = soup.points.len() as u32;
        soup.points.extend([12, 24, 36].map(|at| corner(&record, at)));
        soup.polygons.push(first..first + 3);
    }
    check_surplus(&mut source, count, trace)?;
    Ok(soup)
}

/// Checks the bytes after the records. Padding, text, and a few bytes such as a colour are
/// accepted. Whole records and an appended second file are errors, because triangles would be lost.
/// Additional bytes from a conversion to text are an error, too.
fn check_surplus(source: &mut Source, count: u32, mut trace: TextTrace) -> Result<()> {
    let letters = trace.letters();
    let tail = Tail::read(source, &mut trace)?;
    let damage = (tail.length > 0).then(|| trace.of_surplus(tail.length, letters)).flatten();
    if let Some(damage) = damage {
        let [more, triangles] = [plural(tail.length, "byte"), plural(count, "triangle")];
        let what = format!("is {more} longer than its {triangles}, because {damage}");
        return Err(Error::new(&source.path, what, SEND_AS_BINARY));
    }
    if tail.is_zero || tail.is_text || tail.length < RECORD as u64 {
        return Ok(());
    }
    let end = PREFIX as u64 + u64::from(count) * RECORD as u64;
    let length = source.len.map_or(0, |len| len.saturating_sub(end)).max(tail.length);
    Err(surplus(source, count, length))
}

/// The bytes after the records.
struct Tail {
    length: u64,
    is_zero: bool,
    is_text: bool,
}

impl Tail {
    fn read(source: &mut Source, trace: &mut TextTrace) -> Result<Tail> {
        let mut tail = Tail { length: 0, is_zero: true, is_text: true };
        let mut buffer = [0; 4096];
        while tail.length < MOST_SURPLUS {
            let n = source.stream.read(&mut buffer).map_err(|e| source.io_error(&e))?;
            let bytes = &buffer[..n];
            if bytes.is_empty() {
                break;
            }
            trace.push(bytes);
            tail.length += n as u64;
            tail.is_zero &= bytes.iter().all(|&b| b == 0);
            tail.is_text &= is_text(bytes);
        }
        Ok(tail)
    }
}

/// The error that `length` bytes follow the last of `count` triangles.
fn surplus(source: &Source, count: u32, length: u64) -> Error {
    let (more, rest) = (length / RECORD as u64, length % RECORD as u64);
    let what = match rest {
        0 => format!(
            "declares {}, but its length is that of {}",
            plural(count, "triangle"),
            grouped(u64::from(count) + more)
        ),
        _ => format!(
            "has {} after the {} that it declares",
            plural(length, "byte"),
            plural(count, "triangle")
        ),
    };
    let help = "Its triangle count is wrong, or it is several files in one: export it again.";
    Error::new(&source.path, what, help).at(Location::Byte(HEADER as u64))
}

fn cut(source: &Source, triangle: u32, count: u32) -> Error {
    let what = format!("ends after {} of its {}", grouped(triangle), plural(count, "triangle"));
    Error::new(&source.path, what, EXPORT_AGAIN).at(Location::Face(u64::from(triangle)))
}

fn corner(record: &[u8; RECORD], at: usize) -> [f64; 3] {
    [0, 4, 8].map(|axis| {
        let i = at + axis;
        let bytes = [record[i], record[i + 1], record[i + 2], record[i + 3]];
        f64::from(f32::from_le_bytes(bytes))
    })
}

/// Takes a name. It may have any words, and it ends at the end of the line or at the first facet.
fn take_name(words: &mut SplitAsciiWhitespace) -> String {
    let is_facet = |words: &SplitAsciiWhitespace| {
        let mut ahead = words.clone();
        ["facet", "normal"].iter().all(|w| ahead.next().is_some_and(|a| a.eq_ignore_ascii_case(w)))
    };
    let mut name = String::new();
    while !is_facet(words)
        && let Some(word) = words.next()
    {
        name.push_str(if name.is_empty() { "" } else { " " });
        name.push_str(word);
    }
    name
}

/// The reader of ASCII files. It processes words instead of lines: `vertex` and `endloop` define
/// the mesh, and the other words only need to be present.
struct Ascii {
    source: Source,
    soup: Soup,
    comments: UnitComments,
    /// The solids.
    solids: GroupRuns,
    /// The first corner of the current facet.
    first: usize,
    in_facet: bool,
    in_solid: bool,
}

impl Ascii {
    fn new(source: Source) -> Ascii {
        let comments = UnitComments::default();
        Ascii {
            source,
            soup: Soup::default(),
            comments,
            solids: GroupRuns::default(),
            first: 0,
            in_facet: false,
            in_solid: false,
        }
    }

    fn read(mut self) -> Result<(SceneMesh, Option<SceneNote>)> {
        let mut line = Vec::new();
        while self.source.next_text_line(&mut line)? {
            self.read_line(&String::from_utf8_lossy(&line))?;
        }
        if self.in_facet || self.in_solid {
            let help =
                "Export it again; if all facets are there, append a line \u{201c}endsolid\u{201d}.";
            return Err(self.source.error("ends without endsolid", help));
        }
        self.comments.give(&mut self.soup);
        self.solids.extend_to(self.soup.polygons.len());
        let mut mesh = SceneMesh::plain(self.soup);
        let note = self.solids.give(&mut mesh);
        Ok((mesh, note))
    }

    fn read_line(&mut self, line: &str) -> Result<()> {
        let mut words = line.trim_start_matches('\u{feff}').split_ascii_whitespace();
        while let Some(word) = words.next() {
            match word.to_ascii_lowercase().as_str() {
                "solid" => {
                    self.set_solid(true, line)?;
                    self.comments.read(line.as_bytes());
                    self.solids.extend_to(self.soup.polygons.len());
                    self.solids.begin(&take_name(&mut words));
                }
                // The rest of the line is a name of any words.
                "endsolid" => return self.set_solid(false, line),
                // This character marks the end of text in DOS.
                "\u{1a}" if !self.in_solid => return Ok(()),
                "facet" => self.set_facet(true, line)?,
                "endfacet" => self.set_facet(false, line)?,
                // The normal is often wrong. The corners define it.
                "normal" => drop(words.by_ref().take(3).count()),
                "outer" | "loop" => {}
                "vertex" => self.vertex(words.by_ref().take(3), line)?,
                "endloop" => self.end_loop(line)?,
                _ => return Err(self.unreadable(line)),
            }
        }
        Ok(())
    }

    fn set_solid(&mut self, on: bool, line: &str) -> Result<()> {
        if self.in_facet || self.in_solid == on {
            return Err(self.unreadable(line));
        }
        self.in_solid = on;
        Ok(())
    }

    fn set_facet(&mut self, on: bool, line: &str) -> Result<()> {
        if self.in_facet == on || self.first != self.soup.points.len() {
            return Err(self.unreadable(line));
        }
        self.in_facet = on;
        Ok(())
    }

    fn vertex<'a>(&mut self, words: impl Iterator<Item = &'a str>, line: &str) -> Result<()> {
        check_room(&self.source.path, &self.soup, 1, 1)?;
        let xyz = words.map(|w| plain_number(w).parse().ok()).collect::<Option<Vec<f64>>>();
        let xyz = xyz.and_then(|xyz| <[f64; 3]>::try_from(xyz).ok());
        let (Some(xyz), true) = (xyz, self.in_facet) else {
            return Err(self.unreadable(line));
        };
        self.soup.points.push(xyz);
        Ok(())
    }

    fn end_loop(&mut self, line: &str) -> Result<()> {
        let end = self.soup.points.len();
        if end < self.first + 3 {
            return Err(self.unreadable(line));
        }
        // The number is in range, because `check_room` has checked every corner.
        self.soup.polygons.push(self.first as u32..end as u32);
        self.first = end;
        Ok(())
    }

    fn unreadable(&self, line: &str) -> Error {
        let text = excerpt(line.as_bytes());
        let what = format!("is not valid STL text at \u{201c}{text}\u{201d}");
        self.source.error(what, number_help(&text))
    }
}
