//! Reader of OBJ files.
//!
//! The tobj crate reads only the vertices. For a whole file it would renumber the vertices in the
//! order of their use, remove unused ones, split the file at groups and materials, and keep 80
//! bytes per triangle in memory until the end. So it receives only the `v` statements, some
//! thousands at a time (`vertices`). Faces are only integers, which must be checked here in any
//! case, where the line is known (`faces`).

mod faces;
mod statements;
mod vertices;

use self::faces::FaceLines;
use self::statements::{Statement, Statements};
use self::vertices::Vertices;
use crate::source::Source;
use crate::{Result, Soup};

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
    let mut vertices = Vertices::default();
    let mut faces = FaceLines::default();
    let mut soup = Soup::default();
    let done = read_statements(&mut statements, &mut vertices, &mut faces, &mut soup);
    // The vertices that wait are before the place where reading stopped, so their errors come
    // first.
    vertices.flush(statements.source(), &mut soup)?;
    done?;
    faces.check_greatest(statements.source(), &soup)?;
    Ok(soup)
}

fn read_statements(
    statements: &mut Statements,
    vertices: &mut Vertices,
    faces: &mut FaceLines,
    soup: &mut Soup,
) -> Result<()> {
    while statements.advance()? {
        let source = statements.source();
        match statements.current() {
            Statement::Vertex(text) => {
                vertices.push(source, text)?;
                if vertices.is_full() {
                    vertices.flush(source, soup)?;
                }
            }
            Statement::Face(text) => {
                let count = soup.points.len() + vertices.len();
                faces.push(source, text, count as u64, soup)?;
            }
            Statement::Other => {}
        }
    }
    Ok(())
}
