//! Reader of PLY files.
//!
//! The ply-rs crate reads the values, binary and ASCII. This module reads the header, because
//! ply-rs does not bound its lines, merges duplicates and refuses Latin-1 comments. It also
//! prepares the ASCII body (see `ascii`).

mod ascii;
mod header;
mod points;
mod rows;

use std::io::{self, Read};

use ply_rs::parser::{ParseError, Parser};
use ply_rs::ply::{ElementDef, Encoding, PropertyAccess, PropertyType, ScalarType};

use self::ascii::AsciiRows;
use self::header::{Element, Header};
use self::rows::{CHANNELS, Ignored, Position, VertexNumbers};
use crate::limits::check_room;
use crate::points::Content;
use crate::read;
use crate::source::{EXPORT_AGAIN, Source};
use crate::words::plural;
use crate::{Error, Location, Result, Soup};

/// Whether `head` is the beginning of a PLY file: a line with the single word `ply`. The free text
/// of a binary STL may begin with this word, too, but then more text follows.
pub(crate) fn is_ply(head: &[u8]) -> bool {
    let Some(rest) = head.strip_prefix(b"ply") else { return false };
    let end = rest.iter().position(|b| matches!(b, b'\r' | b'\n'));
    end.is_some_and(|end| rest[..end].trim_ascii().is_empty())
}

pub(crate) fn read(source: Source) -> Result<Soup> {
    let (header, body) = open(source)?;
    read_mesh(body, &header)
}

/// Reads a mesh, or a cloud of points if the header announces no faces.
pub(crate) fn read_content(source: Source) -> Result<Content> {
    let (header, body) = open(source)?;
    match points::is_cloud(&header) {
        true => points::read(body, &header).map(Content::Points),
        false => read_mesh(body, &header).map(Content::Mesh),
    }
}

fn open(mut source: Source) -> Result<(Header, PlyBody)> {
    let header = header::read(&mut source)?;
    if header.is_packed_splat() {
        let what = "is a compressed Gaussian splat, whose points are packed";
        return Err(Error::new(&source.path, what, read::UNPACK_SPLAT));
    }
    let encoding = header.encoding;
    Ok((header, PlyBody { source, encoding, ascii: AsciiRows::default() }))
}

fn read_mesh(mut body: PlyBody, header: &Header) -> Result<Soup> {
    let mut soup = Soup::default();
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => read_points(&mut body, element, &mut soup)?,
            "face" => read_faces(&mut body, element, &mut soup)?,
            "tristrips" => read_strips(&mut body, element, &mut soup)?,
            _ => skip(&mut body, element)?,
        }
    }
    check_end(&mut body)?;
    check_indices(&body, header, &soup)?;
    (soup.unit, soup.unit_comment) = header.unit.clone().unzip();
    Ok(soup)
}

/// The body of a file, which follows the header.
struct PlyBody {
    source: Source,
    encoding: Encoding,
    ascii: AsciiRows,
}

fn read_points(body: &mut PlyBody, element: &Element, soup: &mut Soup) -> Result<()> {
    if element.count == 0 {
        return Ok(());
    }
    for axis in ["x", "y", "z"] {
        let scalar = |t: &PropertyType| matches!(t, PropertyType::Scalar(_));
        if !element.property(axis).is_some_and(scalar) {
            let what = format!("has vertices without {axis}");
            return Err(Error::new(&body.source.path, what, EXPORT_AGAIN));
        }
    }
    let scale = channel_scale(element);
    let coloured = scale.is_some();
    let wanted =
        |name: &str| matches!(name, "x" | "y" | "z") || (coloured && CHANNELS.contains(&name));
    let mut sums = [0.0; 3];
    each_row(body, element, wanted, |source, _, row: Position| {
        check_room(&source.path, soup, 1, 0)?;
        soup.points.push(row.xyz);
        sums.iter_mut().zip(row.rgb).for_each(|(sum, channel)| *sum += channel);
        Ok(())
    })?;
    // A channel that is not a number becomes 0.
    let mean = |scale: f64| sums.map(|sum| (sum / element.count as f64 * scale).round() as u8);
    soup.colour = scale.map(mean);
    Ok(())
}

/// The factor that converts the channels of vertex colours to bytes. They may be bytes or numbers
/// up to 1. `None` if a channel is missing.
fn channel_scale(element: &Element) -> Option<f64> {
    let kinds = CHANNELS.map(|name| element.property(name).cloned());
    let all = |kinds_of: &[ScalarType]| {
        let is = |t: &ScalarType| kinds_of.contains(t);
        kinds.iter().all(|k| matches!(k, Some(PropertyType::Scalar(t)) if is(t)))
    };
    if all(&[ScalarType::UChar]) {
        return Some(1.0);
    }
    all(&[ScalarType::Float, ScalarType::Double]).then_some(f64::from(u8::MAX))
}

fn read_faces(body: &mut PlyBody, element: &Element, soup: &mut Soup) -> Result<()> {
    let list = match element.index_list() {
        Some(list) => list,
        None if element.count == 0 => return Ok(()),
        None => return Err(no_list(body, element)),
    };
    each_row(
        body,
        element,
        |name| name == list,
        |source, i, row: VertexNumbers| {
            check_room(&source.path, soup, 0, row.len() as u64)?;
            // Points and lines among the faces bound no surface and are skipped.
            if row.len() >= 3 {
                if let Some(c) = row.indices().find(|&c| vertex(c).is_none()) {
                    return Err(negative(source, "face", c, Location::Face(i)));
                }
                match row.triangle() {
                    // Almost all faces are triangles.
                    Some(triangle) => soup.polygons.push(triangle),
                    None => soup.polygons.push(row.indices().filter_map(vertex)),
                }
            }
            Ok(())
        },
    )
}

/// Reads triangle strips as in Stanford's archive: one long list in which -1 begins a new strip.
fn read_strips(body: &mut PlyBody, element: &Element, soup: &mut Soup) -> Result<()> {
    let list = match element.index_list() {
        Some(list) => list,
        None if element.count == 0 => return Ok(()),
        None => return Err(no_list(body, element)),
    };
    each_row(
        body,
        element,
        |name| name == list,
        |source, i, row: VertexNumbers| {
            check_room(&source.path, soup, 0, 3 * row.len() as u64)?;
            let mut strip = Strip::default();
            for index in row.indices() {
                match vertex(index) {
                    Some(corner) => strip.push(corner, soup),
                    None if index == -1 => strip.seen = 0,
                    None => {
                        let place = Location::Element("row of tristrips", i);
                        return Err(negative(source, "strip", index, place));
                    }
                }
            }
            Ok(())
        },
    )
}

/// The last two corners of a triangle strip and the number of its corners.
#[derive(Default)]
struct Strip {
    last: [u32; 2],
    seen: u64,
}

impl Strip {
    fn push(&mut self, c: u32, soup: &mut Soup) {
        let [a, b] = self.last;
        if self.seen >= 2 && self.seen.is_multiple_of(2) {
            soup.polygons.push([a, b, c]);
        } else if self.seen >= 2 {
            soup.polygons.push([b, a, c]);
        }
        self.last = [b, c];
        self.seen += 1;
    }
}

fn skip(body: &mut PlyBody, element: &Element) -> Result<()> {
    // ply-rs would create as many empty rows as the header declares.
    if element.properties.is_empty() {
        return Ok(());
    }
    if let (Some(size), false) = (element.size(), body.encoding == Encoding::Ascii) {
        let wanted = element.count.saturating_mul(size);
        let copied = io::copy(&mut (&mut body.source.stream).take(wanted), &mut io::sink());
        let copied = copied.map_err(|e| body.source.io_error(&e))?;
        return if copied == wanted { Ok(()) } else { Err(cut(body, element, copied / size)) };
    }
    each_row(body, element, |_| false, |_, _, _: Ignored| Ok(()))
}

/// Reads the rows of `element` with ply-rs and passes each one to `each`.
fn each_row<E: PropertyAccess>(
    body: &mut PlyBody,
    element: &Element,
    wanted: impl Fn(&str) -> bool,
    mut each: impl FnMut(&Source, u64, E) -> Result<()>,
) -> Result<()> {
    let parser = Parser::<E>::new();
    let def = element.definition(body.encoding, &wanted);
    for i in 0..element.count {
        let row = read_row(&parser, body, element, &def, &wanted);
        let row = row.map_err(|failure| failure.at(body, element, i))?;
        each(&body.source, i, row)?;
    }
    Ok(())
}

/// The reason why a row cannot be read.
enum RowFailure {
    Ours(Error),
    Theirs(ParseError),
    End,
}

impl RowFailure {
    fn at(self, body: &PlyBody, element: &Element, row: u64) -> Error {
        match self {
            RowFailure::Ours(error) => error,
            RowFailure::End => cut(body, element, row),
            RowFailure::Theirs(e) if e.kind() == io::ErrorKind::UnexpectedEof => {
                cut(body, element, row)
            }
            RowFailure::Theirs(_) if body.encoding == Encoding::Ascii => {
                body.ascii.unreadable(&body.source, &element.name)
            }
            RowFailure::Theirs(e) => {
                let what = format!("has a damaged row {row} of element {}: {e}", element.name);
                Error::new(&body.source.path, what, EXPORT_AGAIN)
            }
        }
    }
}

fn read_row<E: PropertyAccess>(
    parser: &Parser<E>,
    body: &mut PlyBody,
    element: &Element,
    def: &ElementDef,
    wanted: impl Fn(&str) -> bool,
) -> std::result::Result<E, RowFailure> {
    let stream = &mut body.source.stream;
    let row = match body.encoding {
        Encoding::BinaryLittleEndian => parser.read_little_endian_element(stream, def),
        Encoding::BinaryBigEndian => parser.read_big_endian_element(stream, def),
        Encoding::Ascii => {
            let text = body.ascii.next(&mut body.source, element, wanted);
            let text = text.map_err(RowFailure::Ours)?.ok_or(RowFailure::End)?;
            parser.read_ascii_element(text, def)
        }
    };
    row.map_err(RowFailure::Theirs)
}

/// The error that the file ends before the number of rows in the header is reached.
fn cut(body: &PlyBody, element: &Element, row: u64) -> Error {
    let (name, count) = (&element.name, element.count);
    let what = format!("ends after {row} of the {count} rows of element {name}");
    let error = Error::new(&body.source.path, what, EXPORT_AGAIN);
    match name.as_str() {
        "vertex" => error.at(Location::Vertex(row)),
        "face" => error.at(Location::Face(row)),
        _ => error,
    }
}

/// Checks that the file ends after the last row. Otherwise faces could be lost without an error.
fn check_end(body: &mut PlyBody) -> Result<()> {
    let source = &mut body.source;
    let mut rest = [0; 4096];
    let surplus = |byte: &u8| !byte.is_ascii_whitespace() && !matches!(byte, 0 | 0x1a);
    loop {
        let n = source.stream.read(&mut rest).map_err(|e| source.io_error(&e))?;
        if rest[..n].iter().any(surplus) {
            let help = "The header's counts do not match the content: export the scan again.";
            return Err(source.error("has more data than its header declares", help));
        }
        if n == 0 {
            return Ok(());
        }
    }
}

/// Checks all vertex indices. ply-rs does not check them, and faces may come before the vertices.
fn check_indices(body: &PlyBody, header: &Header, soup: &Soup) -> Result<()> {
    let points = soup.points.len();
    for (i, polygon) in soup.polygons.iter().enumerate() {
        if let Some(&index) = polygon.iter().find(|&&c| c as usize >= points) {
            let what =
                format!("has a face with vertex {index}, but only {}", plural(points, "vertex"));
            let error = Error::new(&body.source.path, what, EXPORT_AGAIN);
            // If faces were skipped or strips were unrolled, the numbers of faces differ from those
            // of the file.
            let counted = header
                .elements
                .iter()
                .any(|e| e.name == "face" && e.count == soup.polygons.len() as u64);
            return Err(if counted { error.at(Location::Face(i as u64)) } else { error });
        }
    }
    Ok(())
}

fn no_list(body: &PlyBody, element: &Element) -> Error {
    let what = format!("has element {} without a list vertex_indices", element.name);
    Error::new(&body.source.path, what, EXPORT_AGAIN)
}

fn vertex(index: i64) -> Option<u32> {
    u32::try_from(index).ok()
}

fn negative(source: &Source, of: &str, index: i64, place: Location) -> Error {
    let what = format!("has a {of} with the negative vertex number {index}");
    Error::new(&source.path, what, EXPORT_AGAIN).at(place)
}
