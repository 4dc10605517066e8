//! OFF, the Object File Format of Geomview: text with or without colours, normals
//! and texture coordinates, of which only positions and faces are read.

use crate::limits::check_room;
use crate::source::{EXPORT_AGAIN, Source};
use crate::token::{excerpt, number_help, plain_number};
use crate::unit_comment::UnitComments;
use crate::words::plural;
use crate::{Location, Result, Soup};

/// Whether `head` begins an OFF file: with its keyword, which may have prefixes
/// for what the vertices have besides a position.
pub(crate) fn is_off(head: &[u8]) -> bool {
    let mut lines = head.split(|b| matches!(b, b'\r' | b'\n')).map(without_comment);
    let line = lines.find(|line| !line.is_empty()).unwrap_or_default();
    let word = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    prefix(word).is_some()
}

/// What stands before `OFF` in the keyword.
fn prefix(word: &[u8]) -> Option<&[u8]> {
    let prefix = word.strip_suffix(b"OFF")?;
    let rest = prefix.strip_prefix(b"ST").unwrap_or(prefix);
    let rest = rest.strip_prefix(b"C").unwrap_or(rest);
    let rest = rest.strip_prefix(b"N").unwrap_or(rest);
    let rest = rest.strip_prefix(b"4").unwrap_or(rest);
    matches!(rest, b"" | b"n").then_some(prefix)
}

fn without_comment(line: &[u8]) -> &[u8] {
    let end = line.iter().position(|&b| b == b'#').unwrap_or(line.len());
    line[..end].trim_ascii()
}

pub(crate) fn read(source: Source) -> Result<Soup> {
    let mut lines = TextLines { source, line: Vec::new() };
    let [vertices, faces] = read_head(&mut lines)?;
    let mut soup = Soup::default();
    let mut comments = UnitComments::default();
    let of_head = lines.source.head.split(|b| matches!(b, b'\r' | b'\n'));
    of_head.filter_map(|line| line.trim_ascii().strip_prefix(b"#")).for_each(|c| comments.read(c));
    comments.give(&mut soup);
    for i in 0..vertices {
        if !lines.advance()? {
            return Err(lines.cut("vertices", i, vertices).at(Location::Vertex(i)));
        }
        check_room(&lines.source.path, &soup, 1, 0)?;
        soup.points.push(lines.position()?);
    }
    let mut corners = Vec::new();
    for i in 0..faces {
        if !lines.advance()? {
            return Err(lines.cut("faces", i, faces).at(Location::Face(i)));
        }
        lines.corners(vertices, &mut corners)?;
        check_room(&lines.source.path, &soup, 0, corners.len() as u64)?;
        // Points and lines among the faces bound no surface.
        if corners.len() >= 3 {
            soup.polygons.push(corners.iter().copied());
        }
    }
    if lines.advance()? {
        let help = "The header's counts do not match the content: export the scan again.";
        return Err(lines.source.error("has more data than its header announces", help));
    }
    Ok(soup)
}

/// The lines that hold something, without their comments.
struct TextLines {
    source: Source,
    line: Vec<u8>,
}

impl TextLines {
    /// Goes to the next line, if there is one.
    fn advance(&mut self) -> Result<bool> {
        while self.source.next_text_line(&mut self.line)? {
            if !self.current().is_empty() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn current(&self) -> &[u8] {
        without_comment(&self.line)
    }

    fn words(&self) -> impl Iterator<Item = &[u8]> {
        self.current().split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
    }

    /// The first three numbers of a vertex.
    fn position(&self) -> Result<[f64; 3]> {
        let mut words = self.words();
        let mut xyz = [0.0; 3];
        for x in &mut xyz {
            let word = words.next().and_then(|word| std::str::from_utf8(word).ok());
            let number = word.and_then(|word| plain_number(word).parse().ok());
            *x = number.ok_or_else(|| self.unreadable("vertex"))?;
        }
        Ok(xyz)
    }

    /// Puts the corners of a face into `corners`. What follows them is a colour.
    fn corners(&self, vertices: u64, corners: &mut Vec<u32>) -> Result<()> {
        corners.clear();
        let mut words = self.words();
        let count = words.next().and_then(integer).ok_or_else(|| self.unreadable("face"))?;
        for _ in 0..count {
            let corner = words.next().and_then(integer).ok_or_else(|| self.unreadable("face"))?;
            let index = u32::try_from(corner).ok().filter(|_| corner < vertices);
            corners.push(index.ok_or_else(|| {
                let what = format!(
                    "has a face with vertex {corner}, but only {}",
                    plural(vertices, "vertex")
                );
                self.source.error(what, EXPORT_AGAIN)
            })?);
        }
        Ok(())
    }

    fn unreadable(&self, what: &str) -> crate::Error {
        let text = excerpt(&self.line);
        self.source
            .error(format!("has an unreadable {what} \u{201c}{text}\u{201d}"), number_help(&text))
    }

    fn cut(&self, what: &str, read: u64, announced: u64) -> crate::Error {
        let what = format!("ends after {read} of its {announced} {what}");
        crate::Error::new(&self.source.path, what, EXPORT_AGAIN)
    }
}

fn integer(word: &[u8]) -> Option<u64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Reads the keyword, if it is there, and the numbers of vertices and faces. The
/// number of edges, which follows, is wrong in most files and not needed.
fn read_head(lines: &mut TextLines) -> Result<[u64; 2]> {
    let no_counts = |lines: &TextLines| {
        lines.source.error("has no numbers of vertices and faces in its header", EXPORT_AGAIN)
    };
    if !lines.advance()? {
        return Err(no_counts(lines));
    }
    let keyword = lines.words().next().and_then(prefix).map(<[u8]>::to_vec);
    let mut used = 0;
    if let Some(prefix) = keyword {
        let is_binary = lines.words().nth(1) == Some(b"BINARY");
        if is_binary || prefix.ends_with(b"4") || prefix.ends_with(b"n") {
            let what =
                if is_binary { "is binary OFF" } else { "is OFF in four or more dimensions" };
            let help = "Export it as PLY, or as OFF in plain text with three coordinates.";
            return Err(lines.source.error(what, help));
        }
        used = 1;
        if lines.words().nth(1).is_none() {
            used = 0;
            if !lines.advance()? {
                return Err(no_counts(lines));
            }
        }
    }
    let mut counts = lines.words().skip(used).map(integer);
    match (counts.next().flatten(), counts.next().flatten()) {
        (Some(vertices), Some(faces)) => Ok([vertices, faces]),
        _ => Err(no_counts(lines)),
    }
}
