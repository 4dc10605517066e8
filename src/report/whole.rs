//! The picture of an assembly: all parts in their places and colours.

use std::io;

use formats::Scene;
use formats::scene::{NodeId, Placement};

use super::still::{COLUMN, MARGIN, MUTED, Page, SIZE, SMALL, TEXT, TITLE, TOP};
use super::view::ReportView;
use crate::convert::{AssemblyConversion, Options, PartColours};
use crate::geometry::{Point, Vector, box_of};
use crate::mesh::Mesh;
use crate::report::picture::canvas::Canvas;
use crate::report::picture::colour::{BACKGROUND, INK, TINTS, linear, srgb};
use crate::report::picture::lines::{Lines, Pen};
use crate::report::picture::text::Style;
use crate::report::picture::{Camera, Image, sheet};
use crate::words::{box_extents, grouped, plural};

/// The most triangles that a picture draws. Parts in so many places that there would be more are drawn as boxes.
const MOST_DRAWN: usize = 3_000_000;

/// The most points of edges that a picture draws.
const MOST_EDGE_POINTS: usize = 1_000_000;

const EDGE: Pen = Pen { seen: 0.6, ..Pen::solid(0.9) };

/// What the picture of an assembly shows. Lengths are mm.
#[derive(Debug)]
pub struct AssemblyView {
    pub(super) parts: Vec<PartView>,
    /// Whether y points up.
    is_y_up: bool,
}

/// A part in its places.
#[derive(Debug)]
pub(super) struct PartView {
    name: String,
    colours: PartColours,
    /// The faces of each body.
    pub(super) views: Vec<ReportView>,
    places: Vec<(Placement, Option<[u8; 3]>)>,
}

impl AssemblyView {
    /// The view of an assembly. `views` has those of the bodies of each part, in the order of `made.parts`. Those of a
    /// part that was not made are not used.
    pub fn of(
        scene: &Scene,
        made: &AssemblyConversion,
        views: Vec<Vec<ReportView>>,
        options: &Options,
    ) -> Self {
        let (all, scale) = (scene.places(), options.unit_of(scene.unit));
        let place = |&NodeId(node): &NodeId| {
            let Placement { axes, translation } = all[node];
            let place = Placement { axes, translation: translation.map(|x| scale * x) };
            (place, scene.nodes()[node].colour)
        };
        let part = |(part, views): (&crate::convert::ConvertedPart, Vec<ReportView>)| PartView {
            name: part.part.name.clone(),
            colours: part.colours.clone(),
            views,
            places: match part.made {
                Ok(_) => part.part.places.iter().map(place).collect(),
                Err(_) => Vec::new(),
            },
        };
        let parts = made.parts.iter().zip(views).map(part).collect();
        AssemblyView { parts, is_y_up: scene.is_y_up }
    }

    /// The extent of all parts in their places.
    pub(super) fn extent(&self) -> [[f64; 3]; 2] {
        let corners = self.parts.iter().flat_map(|part| {
            let corners = part.corners();
            let places = part.places.iter();
            places.flat_map(move |(place, _)| corners.map(|p| Point::from(place.apply(p))))
        });
        box_of(corners)
    }

    /// The colour of a part by its number: its own one, or a tint.
    pub(super) fn colour(&self, number: usize) -> [u8; 3] {
        let own = self.parts.get(number).and_then(|part| part.colours.part);
        own.unwrap_or_else(|| srgb(TINTS[number % TINTS.len()]))
    }
}

impl PartView {
    fn triangles(&self) -> usize {
        self.views.iter().map(|view| view.drawn().triangles.len()).sum()
    }

    /// The corners of the box around the part.
    fn corners(&self) -> [[f64; 3]; 8] {
        let corners = self.views.iter().flat_map(|view| view.figures.bounds).map(Point::from);
        let [low, high] = box_of(corners);
        let mut number = 0;
        [(); 8].map(|()| {
            number += 1;
            [0, 1, 2].map(|k| if (number - 1) >> k & 1 == 0 { low[k] } else { high[k] })
        })
    }
}

impl ReportView {
    /// The mesh that stands for the faces.
    fn drawn(&self) -> &Mesh {
        self.exact.as_ref().map_or(&self.scan.mesh, |exact| &exact.mesh)
    }
}

/// Draws a picture of an assembly of 1600 × 1000 pixels as PNG: all parts in their places and colours from three sides,
/// and a list of the parts. `name` stands above them.
///
/// # Errors
/// The font cannot be read, or the image cannot be encoded.
pub fn assembly_png(name: &str, view: &AssemblyView) -> io::Result<Vec<u8>> {
    let mut page = Page::new()?;
    let places: usize = view.parts.iter().map(|part| part.places.len()).sum();
    let drawn: usize = view.parts.iter().map(|part| part.triangles() * part.places.len()).sum();
    let as_boxes = drawn > MOST_DRAWN;
    let width = (SIZE[0] - 2 * MARGIN) as f32;
    let title = page.letters.fit(name, TITLE, width);
    page.write(&title, [MARGIN as f32, 62.0], TITLE);
    let parts = plural(view.parts.len(), "part");
    let mut line = format!("{parts} in {}", plural(places, "place"));
    if places > 0 {
        line += &format!("  ·  {}", box_extents(view.extent()));
    }
    if as_boxes {
        line += "  ·  drawn as boxes";
    }
    page.write_within(&line, [MARGIN as f32, 102.0], Style { colour: MUTED, ..TEXT });
    page.rule();
    let size = [COLUMN - MARGIN, SIZE[1] - TOP - 10];
    let upright = match view.is_y_up {
        true => Placement {
            axes: [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
            ..Placement::IDENTITY
        },
        false => Placement::IDENTITY,
    };
    let extent = || {
        view.parts.iter().flat_map(|part| {
            let corners = part.corners();
            let places = part.places.iter().map(move |(place, _)| upright.after(place));
            places.flat_map(move |place| corners.map(|p| Point::from(place.apply(p))))
        })
    };
    let camera = Camera::isometric(extent(), size);
    let image = drawn_from(view, &camera, (size, &upright, as_boxes));
    page.image.lay(&image, [MARGIN / 2, TOP]);
    page.parts(view, [COLUMN, TOP + 40]);
    let mut bytes = Vec::new();
    page.image.write(&mut bytes)?;
    Ok(bytes)
}

/// The assembly from one side.
fn drawn_from(
    view: &AssemblyView,
    camera: &Camera,
    (size, upright, as_boxes): ([usize; 2], &Placement, bool),
) -> Image {
    if size.contains(&0) {
        return Image::blank(size, BACKGROUND);
    }
    let mut canvas = Canvas::new(size);
    for (number, part) in view.parts.iter().enumerate() {
        let base = view.colour(number);
        let own: std::collections::HashMap<usize, [u8; 3]> =
            part.colours.faces.iter().map(|(face, colour)| (face.0, *colour)).collect();
        for (place, colour) in &part.places {
            let place = upright.after(place);
            if as_boxes {
                let mesh = box_mesh(part.corners().map(|p| place.apply(p)));
                let paint = linear(colour.unwrap_or(base));
                let flat = |t: usize| {
                    let normal = mesh.area_vector(mesh.triangles[t]);
                    (paint, [normal.try_normalize(0.0).unwrap_or_default(); 3])
                };
                sheet::draw_tinted(&mut canvas, &mesh, camera, flat);
                continue;
            }
            let mut first = 0;
            for body in &part.views {
                let mesh = placed(body.drawn(), &place);
                let paint = |t: usize| {
                    let face = body.exact.as_ref().map(|exact| first + exact.face_of[t] as usize);
                    let of_face = face.and_then(|face| own.get(&face)).copied();
                    let normals = match &body.exact {
                        Some(exact) => exact.normals(t).map(|n| Vector::from(place.turn(n.into()))),
                        None => {
                            let normal = mesh.area_vector(mesh.triangles[t]);
                            [normal.try_normalize(0.0).unwrap_or_default(); 3]
                        }
                    };
                    (linear(colour.or(of_face).unwrap_or(base)), normals)
                };
                sheet::draw_tinted(&mut canvas, &mesh, camera, paint);
                first += body.exact.as_ref().map_or(0, |exact| exact.counts.iter().sum());
            }
        }
    }
    if !as_boxes {
        let mut left = MOST_EDGE_POINTS;
        let mut lines = Lines::over(&canvas);
        for part in &view.parts {
            for (place, _) in &part.places {
                let place = upright.after(place);
                for edge in part.views.iter().flat_map(|body| &body.seams) {
                    let Some(rest) = left.checked_sub(edge.len()) else { continue };
                    left = rest;
                    let point = |p: &Point| camera.project(&Point::from(place.apply((*p).into())));
                    lines.polyline(&canvas, edge.iter().map(point), EDGE);
                }
            }
        }
        lines.ink(&mut canvas, linear(INK));
    }
    canvas.image()
}

fn placed(mesh: &Mesh, place: &Placement) -> Mesh {
    let point = |p: &Point| Point::from(place.apply((*p).into()));
    Mesh { points: mesh.points.iter().map(point).collect(), triangles: mesh.triangles.clone() }
}

/// A box with these corners, of which the bits of the number of each say on which side it is.
fn box_mesh(corners: [[f64; 3]; 8]) -> Mesh {
    const QUADS: [[usize; 4]; 6] =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = QUADS.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    Mesh {
        points: corners.map(Point::from).to_vec(),
        triangles: triangles.map(|t| t.map(crate::geometry::VertexId::from)).collect(),
    }
}

impl Page {
    /// The parts with their colours, as far as there is room.
    fn parts(&mut self, view: &AssemblyView, [x, y]: [usize; 2]) {
        const ROW: usize = 40;
        self.write("Parts", [x as f32, y as f32 - 14.0], Style { bold: true, ..SMALL });
        let room = (SIZE[1] - MARGIN - y) / ROW;
        let shown = if view.parts.len() > room { room.saturating_sub(1) } else { view.parts.len() };
        let left = x as f32 + 34.0;
        for (number, part) in view.parts.iter().take(shown).enumerate() {
            let row = y + 8 + ROW * number;
            self.image.fill([x, row], [22, 22], view.colour(number));
            let made = match part.views.as_slice() {
                [] => "not made".into(),
                [only] => only.figures.made.clone(),
                several => plural(several.len(), "body"),
            };
            let name = self.letters.fit(&part.name, SMALL, 220.0);
            let text = format!("{} × {name}: {made}", grouped(part.places.len()));
            self.write_within(&text, [left, row as f32 + 18.0], SMALL);
        }
        if shown < view.parts.len() {
            let more = format!("and {} more in the report", view.parts.len() - shown);
            self.write(&more, [left, (y + 26 + ROW * shown) as f32], SMALL);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_box_of_a_part_faces_outwards() {
        let mut number = 0;
        let corners = [(); 8].map(|()| {
            number += 1;
            [0, 1, 2].map(|k| f64::from((number - 1) >> k & 1))
        });
        let mesh = box_mesh(corners);
        let volume: f64 = mesh
            .triangles
            .iter()
            .map(|&t| mesh.area_vector(t).dot(&mesh.corners(t)[0].coords) / 3.0)
            .sum();
        // Area vectors may be twice the area.
        assert!(volume > 0.9, "{volume}");
    }
}
