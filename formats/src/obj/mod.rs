//! OBJ: tobj, behind a filter.
//!
//! tobj renumbers the vertices by first use, drops unused ones, and splits a
//! file at groups and materials. The filter (`statements`) therefore hands it
//! nothing but `v` and `f` lines, each `v` with its number in place of a
//! colour, and at the end a few faces that use every vertex once; from these
//! the file's own numbering is restored.

mod statements;

use tobj::{LoadError, LoadOptions, Mesh};

use self::statements::Statements;
use crate::source::{EXPORT_AGAIN, Source};
use crate::{Error, Result, Soup};

/// Whether `head` has a line that only an OBJ file has.
pub(crate) fn is_obj(head: &[u8]) -> bool {
    head.split(|b| matches!(b, b'\r' | b'\n')).take(500).any(|line| {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        match words.next() {
            Some(b"v") => words.take(3).filter(|w| is_number(w)).count() == 3,
            Some(b"mtllib" | b"usemtl") => words.next().is_some(),
            _ => false,
        }
    })
}

fn is_number(word: &[u8]) -> bool {
    std::str::from_utf8(word).is_ok_and(|word| word.parse::<f64>().is_ok())
}

pub(crate) fn read(source: Source) -> Result<Soup> {
    let mut statements = Statements::new(source);
    // Every face as it is; materials do not matter and their files stay closed.
    let options = LoadOptions::default();
    let loaded = tobj::load_obj_buf(&mut statements, &options, |_| Ok(Default::default()));
    let (models, _) = loaded.map_err(|e| statements.failure(|s| refusal(s, e)))?;
    let mut models = models.into_iter();
    let mesh = models.next().map(|model| model.mesh).unwrap_or_default();
    if models.next().is_some() {
        // Not reached: the filter lets no group through.
        return Err(statements.failure(|s| refusal(s, LoadError::GenericFailure)));
    }
    let points = statements.vertices();
    restore(mesh, points)
        .ok_or_else(|| statements.failure(|s| refusal(s, LoadError::GenericFailure)))
}

/// The error for what tobj refused. It names no line, but it reads one line
/// at a time.
fn refusal(statements: &Statements, e: LoadError) -> Error {
    let (text, help) = statements.current();
    let what = match e {
        LoadError::PositionParseError => format!("has an unreadable vertex \u{201c}{text}\u{201d}"),
        LoadError::FaceParseError => format!("has an unreadable face \u{201c}{text}\u{201d}"),
        other => format!("cannot be read: {other}"),
    };
    statements.source().error(what, help)
}

/// The soup of `mesh`, numbered as the file is, which has `count` vertices.
/// `None` if tobj lost one.
fn restore(mesh: Mesh, count: usize) -> Option<Soup> {
    let numbers: Vec<u32> = mesh.vertex_color.chunks_exact(3).map(|c| c[0] as u32).collect();
    let mut soup = Soup { points: vec![[f64::NAN; 3]; count], ..Soup::default() };
    if numbers.len() != count || mesh.positions.len() != 3 * count {
        return None;
    }
    for (xyz, &number) in mesh.positions.chunks_exact(3).zip(&numbers) {
        *soup.points.get_mut(number as usize)? = [xyz[0], xyz[1], xyz[2]];
    }
    // Without the faces at the end that the filter added.
    let mut rest = mesh.indices.get(..mesh.indices.len().checked_sub(count)?)?;
    let mut sizes = mesh.face_arities.iter();
    while !rest.is_empty() {
        let size = sizes.next().map_or(3, |&n| n as usize);
        let (face, after) = rest.split_at_checked(size)?;
        let corners = face.iter().map(|&local| numbers.get(local as usize).copied());
        soup.polygons.push(corners.collect::<Option<Vec<u32>>>()?);
        rest = after;
    }
    Some(soup)
}

/// What to say of a vertex number that no vertex has.
fn out_of_range(source: &Source, line: u64, number: i64, count: u64) -> Error {
    let what = match number {
        0 => "has a face with vertex 0, but OBJ counts from 1".into(),
        n if n < 0 => format!("has a face with vertex {n}, but only {count} vertices before it"),
        n => format!("has a face with vertex {n}, but only {count} vertices"),
    };
    Error::new(&source.path, what, EXPORT_AGAIN).at(crate::Place::Line(line))
}
