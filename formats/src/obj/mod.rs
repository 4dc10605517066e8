//! Reader of OBJ files.
//!
//! The tobj crate reads only the vertices. For a whole file it would renumber the vertices in the
//! order of their use, remove unused ones, split the file at groups and materials, and keep 80
//! bytes per triangle in memory until the end. So it receives only the `v` statements, some
//! thousands at a time (`vertices`). Faces are only integers, which must be checked here in any
//! case, where the line is known (`faces`). The colours are in files of materials beside the file (`materials`).

mod faces;
mod materials;
mod statements;
mod vertices;

use self::faces::FaceLines;
use self::materials::Materials;
use self::statements::{Statement, Statements};
use self::vertices::Vertices;
use crate::scene::{GroupRuns, Scene, SceneMesh};
use crate::source::Source;
use crate::unit_comment::UnitComments;
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

pub(crate) fn read(source: Source) -> Result<Scene> {
    let mut statements = Statements::new(source);
    let mut read = Read::default();
    let done = read.statements(&mut statements);
    // The vertices that wait are before the place where reading stopped, so their errors come
    // first.
    let source = statements.source();
    read.vertices.flush(source, &mut read.soup)?;
    done?;
    read.faces.check_greatest(source, &read.soup)?;
    read.comments.give(&mut read.soup);
    let count = read.soup.polygons.len();
    let mut mesh = SceneMesh::plain(read.soup);
    let no_materials = read.materials.give(source.folder.as_deref(), count, &mut mesh);
    // Where a file has one object, its groups are what a file with several objects has as objects.
    let by_group = read.groups.has_several() && !read.objects.has_several();
    let [last, first] =
        if by_group { [read.objects, read.groups] } else { [read.groups, read.objects] };
    let name = last.single_name();
    let many_groups = first.give(&mut mesh);
    mesh.name = mesh.name.or(name);
    let mut scene = Scene::of_mesh(&source.path, mesh);
    scene.notes.extend(no_materials.into_iter().chain(many_groups));
    Ok(scene)
}

/// What was read so far.
#[derive(Default)]
struct Read {
    soup: Soup,
    vertices: Vertices,
    faces: FaceLines,
    comments: UnitComments,
    objects: GroupRuns,
    groups: GroupRuns,
    materials: Materials,
}

impl Read {
    fn statements(&mut self, statements: &mut Statements) -> Result<()> {
        while statements.advance()? {
            let source = statements.source();
            match statements.current() {
                Statement::Vertex(text) => {
                    self.vertices.push(source, text)?;
                    if self.vertices.is_full() {
                        self.vertices.flush(source, &mut self.soup)?;
                    }
                }
                Statement::Face(text) => {
                    let count = self.soup.points.len() + self.vertices.len();
                    self.faces.push(source, text, count as u64, &mut self.soup)?;
                }
                Statement::Comment(text) => self.comments.read(text),
                Statement::Object(text) => {
                    self.objects.extend_to(self.soup.polygons.len());
                    self.objects.begin(&String::from_utf8_lossy(text));
                }
                Statement::Group(text) => {
                    self.groups.extend_to(self.soup.polygons.len());
                    self.groups.resume(&String::from_utf8_lossy(text));
                }
                Statement::Material(text) => {
                    self.materials.begin(text, self.soup.polygons.len());
                }
                Statement::Library(text) => self.materials.add_library(text),
                Statement::Other => {}
            }
        }
        let count = self.soup.polygons.len();
        self.objects.extend_to(count);
        self.groups.extend_to(count);
        Ok(())
    }
}
