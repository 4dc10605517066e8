//! Reader of the faces of an OBJ file.

use super::statements::words;
use crate::limits::check_room;
use crate::source::{EXPORT_AGAIN, Source};
use crate::token::excerpt;
use crate::words::plural;
use crate::{Error, Location, Result, Soup};

/// Reads face statements. Of a corner `1/2/3` it reads only the vertex number.
#[derive(Default)]
pub(super) struct FaceLines {
    /// The corners of the current face.
    corners: Vec<u32>,
    /// The largest vertex number so far and its line.
    greatest: (i64, u64),
}

impl FaceLines {
    /// Adds the face in the current line of `source` to `soup`. There are `count` vertices before
    /// this line.
    pub(super) fn push(
        &mut self,
        source: &Source,
        text: &[u8],
        count: u64,
        soup: &mut Soup,
    ) -> Result<()> {
        self.corners.clear();
        for word in words(text) {
            let number = vertex_number(word).ok_or_else(|| unreadable(source, word))?;
            if number == 0 || number < 0 && number.unsigned_abs() > count {
                return Err(out_of_range(source, source.line, number, count));
            }
            self.push_corner(number, count, source.line);
        }
        if self.corners.len() < 3 {
            return check_small(source);
        }
        check_room(&source.path, soup, 0, self.corners.len() as u64)
            .map_err(|e| e.at(Location::Line(source.line)))?;
        soup.polygons.push(self.corners.iter().copied());
        Ok(())
    }

    fn push_corner(&mut self, number: i64, count: u64, line: u64) {
        let index = if number < 0 { count as i64 + number } else { number - 1 };
        // A face may come before its vertices, so the largest number can be checked only at the
        // end.
        if number >= self.greatest.0 {
            self.greatest = (number, line);
        }
        self.corners.push(index as u32);
    }

    /// Checks that the file has all vertices that its faces refer to.
    pub(super) fn check_greatest(&self, source: &Source, soup: &Soup) -> Result<()> {
        let (number, line) = self.greatest;
        let count = soup.points.len() as u64;
        if number > count as i64 {
            return Err(out_of_range(source, line, number, count));
        }
        Ok(())
    }
}

/// The vertex number of `1/2/3`.
fn vertex_number(word: &[u8]) -> Option<i64> {
    let number = word.split(|&b| b == b'/').next()?;
    std::str::from_utf8(number).ok()?.parse().ok()
}

fn unreadable(source: &Source, word: &[u8]) -> Error {
    let text = excerpt(word);
    let what = format!("has a face with the unreadable corner \u{201c}{text}\u{201d}");
    source.error(what, EXPORT_AGAIN)
}

/// Points and lines among the faces bound no surface and are skipped. But a last line without a
/// line end may be half of a triangle, which is an error.
fn check_small(source: &Source) -> Result<()> {
    if !source.ended_line {
        return Err(source.error("ends in the middle of a face", EXPORT_AGAIN));
    }
    Ok(())
}

/// The error for a vertex number that no vertex has.
fn out_of_range(source: &Source, line: u64, number: i64, count: u64) -> Error {
    let vertices = plural(count, "vertex");
    let what = match number {
        0 => "has a face with vertex 0, but OBJ counts from 1".into(),
        n if n < 0 => format!("has a face with vertex {n}, but only {vertices} before it"),
        n => format!("has a face with vertex {n}, but only {vertices}"),
    };
    Error::new(&source.path, what, EXPORT_AGAIN).at(Location::Line(line))
}
