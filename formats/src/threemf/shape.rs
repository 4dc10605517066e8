//! The vertices and triangles of an object.

use super::fault::PackageFault;
use super::properties::{Irregularities, Properties, Srgb, mean};
use super::value;
use super::xml::{XmlElement, unescaped};
use crate::scene::{ColourRuns, SceneMesh};
use crate::words::plural;

/// A mesh while it is read.
#[derive(Default)]
pub(super) struct MeshDraft {
    mesh: SceneMesh,
    colours: ColourRuns,
    /// The colour of triangles that have none of their own.
    colour: Option<Srgb>,
    /// The greatest vertex number, and the triangle that has it.
    greatest: Option<(u32, usize)>,
}

impl MeshDraft {
    pub(super) fn new(colour: Option<Srgb>) -> Self {
        MeshDraft { colour, ..MeshDraft::default() }
    }

    pub(super) fn vertex(&mut self, element: &XmlElement<'_>) -> Result<(), PackageFault> {
        let mut xyz = [None; 3];
        let mut fault = None;
        element.each_attribute(|key, value| {
            let axis = match key {
                "x" => 0,
                "y" => 1,
                "z" => 2,
                _ => return,
            };
            match unescaped(value).and_then(|value| value::number(&value)) {
                Ok(number) => xyz[axis] = Some(number),
                Err(e) => fault = Some(e),
            }
        })?;
        let number = self.mesh.soup.points.len();
        match (fault, xyz) {
            (None, [Some(x), Some(y), Some(z)]) => self.mesh.soup.points.push([x, y, z]),
            (Some(fault), _) => return Err(at(fault, "vertex", number)),
            (None, _) => {
                let what = "has a vertex with fewer than three coordinates";
                return Err(at(PackageFault::new(what), "vertex", number));
            }
        }
        if self.mesh.soup.points.len() as u64 > u64::from(i32::MAX as u32) {
            return Err(PackageFault::new("has more than two billion vertices"));
        }
        Ok(())
    }

    pub(super) fn triangle(
        &mut self,
        element: &XmlElement<'_>,
        properties: &Properties,
        odd: &mut Irregularities,
    ) -> Result<(), PackageFault> {
        const KEYS: [&str; 7] = ["v1", "v2", "v3", "pid", "p1", "p2", "p3"];
        let number = self.mesh.soup.polygons.len();
        let mut values = [None; 7];
        let mut fault = None;
        element.each_attribute(|key, value| {
            let Some(at) = KEYS.iter().position(|known| *known == key) else { return };
            match unescaped(value).and_then(|value| value::index(&value)) {
                Ok(index) => values[at] = Some(index),
                // Whatever a colour is, the shape is not concerned.
                Err(_) if at > 2 => odd.add("triangles whose properties are none"),
                Err(e) => fault = Some(e),
            }
        })?;
        let [v1, v2, v3, group, p1, p2, p3] = values;
        let corners = match (fault, [v1, v2, v3]) {
            (None, [Some(a), Some(b), Some(c)]) => [a, b, c],
            (Some(fault), _) => return Err(at(fault, "triangle", number)),
            (None, _) => {
                let what = "has a triangle with fewer than three corners";
                return Err(at(PackageFault::new(what), "triangle", number));
            }
        };
        for corner in corners {
            if self.greatest.is_none_or(|(greatest, _)| corner > greatest) {
                self.greatest = Some((corner, number));
            }
        }
        if self.mesh.soup.polygons.corner_count() as u64 + 3 > u64::from(u32::MAX) {
            return Err(PackageFault::new("has more than four billion corners"));
        }
        self.mesh.soup.polygons.push(corners);
        let colour = match (group, p1) {
            (Some(group), Some(first)) => {
                let indices = [first, p2.unwrap_or(first), p3.unwrap_or(first)];
                self.property(group, indices, properties, odd)
            }
            _ => self.colour,
        };
        self.colours.extend_to(number + 1, colour);
        Ok(())
    }

    fn property(
        &self,
        group: u32,
        indices: [u32; 3],
        properties: &Properties,
        odd: &mut Irregularities,
    ) -> Option<Srgb> {
        let corners = indices.map(|index| properties.colour(group, index));
        if corners.iter().any(Result::is_err) {
            odd.add("triangles of properties that do not exist");
            return self.colour;
        }
        mean(corners.map(Result::unwrap_or_default))
    }

    /// The mesh, after all its triangles are known to have vertices.
    pub(super) fn finish(mut self) -> Result<SceneMesh, PackageFault> {
        let count = self.mesh.soup.points.len();
        if let Some((greatest, number)) =
            self.greatest.filter(|(greatest, _)| *greatest as usize >= count)
        {
            let what = format!(
                "has a triangle with vertex {greatest}, but only {}",
                plural(count, "vertex")
            );
            return Err(at(PackageFault::new(what), "triangle", number));
        }
        self.colours.give(&mut self.mesh);
        Ok(self.mesh)
    }
}

/// The fault in an element of a mesh. The object is the place, so that the element is in the text.
fn at(fault: PackageFault, kind: &str, number: usize) -> PackageFault {
    PackageFault { what: format!("{}, at {kind} {number}", fault.what), ..fault }
}
