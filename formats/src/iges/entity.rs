//! The entities that the writer uses, and their parameters (IGES 5.3, chapter 4).

use std::borrow::Cow;
use std::io;

use super::compose::{
    arc, counted, curve, curve_end, edge_list, edge_loop, on_surface, points, shell, solid,
    surface, trimmed,
};
use super::parameters::Parameters;
use crate::spline::{SplineCurve, SplineSurface};

/// A pointer to an entity: the number of its first directory line.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Pointer(pub usize);

impl std::fmt::Display for Pointer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

/// An entity and the fields of its directory entry.
pub(super) struct Entity<'a> {
    pub body: EntityData<'a>,
    pub status: EntityStatus,
    /// At most eight letters and digits that CAD programs show as a name.
    pub label: String,
    /// The name property of the entity.
    pub name: Option<Pointer>,
    /// The colour definition of the entity.
    pub colour: Option<Pointer>,
    /// The matrix (124) that places the entity.
    pub matrix: Option<Pointer>,
}

/// The status number of a directory entry (IGES 5.3, clause 2.2.4.4.9). All entities are visible.
/// They differ in their dependency and their use.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum EntityStatus {
    /// An independent entity.
    Independent,
    /// A part of one parent.
    Part,
    /// A part of one parent that is a curve in a parameter plane.
    ParameterPlane,
    /// A part of one parent whose attributes apply to it.
    PartWithParentsAttributes,
    /// A member of a group.
    Member,
    /// A definition of the appearance of other entities.
    Definition,
}

impl EntityStatus {
    pub(super) fn number(self) -> &'static str {
        match self {
            EntityStatus::Independent => "00000000",
            EntityStatus::Part => "00010000",
            EntityStatus::ParameterPlane => "00010500",
            EntityStatus::PartWithParentsAttributes => "00010001",
            EntityStatus::Member => "00020000",
            EntityStatus::Definition => "00000200",
        }
    }
}

/// A use of an edge or of a vertex in a loop.
pub(super) struct LoopUse {
    /// The list of edges (504), or of vertices (502) at a pole.
    pub list: Pointer,
    /// Whether it is a vertex.
    pub is_vertex: bool,
    /// The number in the list, from 0.
    pub number: usize,
    /// Whether the loop runs in the direction of the edge.
    pub forward: bool,
    /// The pcurve in the direction of the loop.
    pub pcurve: Pointer,
}

/// The parameters of an entity.
pub(super) enum EntityData<'a> {
    /// 100 or 104, an arc of a circle or of an ellipse in a plane z = 0, counter-clockwise: the
    /// centre, the radii along x and y, the start and the end.
    Arc { centre: [f64; 2], radii: [f64; 2], ends: [[f64; 2]; 2] },
    /// 102, a composite curve.
    Composite(Vec<Pointer>),
    /// 110, a line between two points.
    Line([[f64; 3]; 2]),
    /// 116, a point.
    Point([f64; 3]),
    /// 120, a surface of revolution: the axis (110), the curve that turns, and its angles.
    Revolution { axis: Pointer, curve: Pointer, angles: [f64; 2] },
    /// 122, a tabulated cylinder: the curve that is extruded, and the place to which its start
    /// moves.
    Extrusion { curve: Pointer, end: [f64; 3] },
    /// 123, a direction.
    Direction([f64; 3]),
    /// 124, a matrix: its columns, the last of which is the shift.
    Matrix([[f64; 3]; 4]),
    /// 126, a B-spline curve in space.
    Curve(Cow<'a, SplineCurve<3>>),
    /// 126, a B-spline curve in a parameter plane.
    PCurve(Cow<'a, SplineCurve<2>>),
    /// 128, a B-spline surface.
    Surface(&'a SplineSurface),
    /// 142, a curve on a surface, as a pcurve and as a curve in space.
    OnSurface { surface: Pointer, flat: Pointer, space: Pointer },
    /// 144, a trimmed surface.
    Trimmed { surface: Pointer, loops: Vec<Pointer> },
    /// 186, a solid: its shells, whose normals point out of the material.
    Solid { outer: Pointer, voids: Vec<Pointer> },
    /// 190 to 198 form 1, a surface with parameters: its number, its origin (116), the directions of
    /// its z and x axes (123), and its measures.
    Elementary { number: u16, origin: Pointer, z: Pointer, x: Pointer, measures: Vec<f64> },
    /// 308, a subfigure: the depth of subfigures in it, its name and what is in it.
    Subfigure { depth: usize, name: &'a str, members: Vec<Pointer> },
    /// 314, a colour in percent of red, green and blue.
    Colour([f64; 3]),
    /// 402 form 7, a group.
    Group(Vec<Pointer>),
    /// 408, a subfigure in the place of its matrix.
    Instance(Pointer),
    /// 406 form 15, a name of any length.
    Name(&'a str),
    /// 502, the vertices.
    Vertices(&'a [[f64; 3]]),
    /// 504, the edges: the curve and the vertices at its start and end.
    Edges { vertices: Pointer, edges: Vec<(Pointer, [usize; 2])> },
    /// 508, a loop.
    Loop(Vec<LoopUse>),
    /// 510, a face. Its outer loop comes first.
    Face { surface: Pointer, loops: Vec<Pointer> },
    /// 514 form 1 or 2, a closed or an open shell: the faces, and whether they keep their
    /// orientation.
    Shell { faces: Vec<(Pointer, bool)>, closed: bool },
}

/// The number of a sphere.
const SPHERE: u16 = 196;

impl EntityData<'_> {
    /// The entity type and form number.
    pub(super) fn kind(&self) -> (u16, u16) {
        match self {
            EntityData::Arc { radii: [a, b], .. } => {
                if a == b {
                    (100, 0)
                } else {
                    (104, 1)
                }
            }
            EntityData::Composite(_) => (102, 0),
            EntityData::Line(_) => (110, 0),
            EntityData::Point(_) => (116, 0),
            EntityData::Revolution { .. } => (120, 0),
            EntityData::Extrusion { .. } => (122, 0),
            EntityData::Direction(_) => (123, 0),
            EntityData::Matrix(_) => (124, 0),
            EntityData::Elementary { number, .. } => (*number, 1),
            EntityData::Curve(_) | EntityData::PCurve(_) => (126, 0),
            EntityData::Surface(_) => (128, 0),
            EntityData::OnSurface { .. } => (142, 0),
            EntityData::Trimmed { .. } => (144, 0),
            EntityData::Solid { .. } => (186, 0),
            EntityData::Subfigure { .. } => (308, 0),
            EntityData::Colour(_) => (314, 0),
            EntityData::Group(_) => (402, 7),
            EntityData::Instance(_) => (408, 0),
            EntityData::Name(_) => (406, 15),
            EntityData::Vertices(_) => (502, 1),
            EntityData::Edges { .. } => (504, 1),
            EntityData::Loop(_) => (508, 1),
            EntityData::Face { .. } => (510, 1),
            EntityData::Shell { closed, .. } => (514, if *closed { 1 } else { 2 }),
        }
    }
}

impl Entity<'_> {
    /// Composes the whole record: the type, the parameters, and the pointers to properties.
    pub(super) fn compose(&self, mut p: Parameters<'_>) -> io::Result<()> {
        p.add(self.body.kind().0)?;
        self.body.compose(&mut p)?;
        if let Some(name) = self.name {
            // There are no associativities and one property (clause 2.2.4.5.2).
            p.add(0)?;
            p.add(1)?;
            p.add(name)?;
        }
        p.end()
    }
}

impl EntityData<'_> {
    fn compose(&self, p: &mut Parameters<'_>) -> io::Result<()> {
        match self {
            EntityData::Arc { centre, radii, ends } => arc(p, *centre, *radii, ends),
            EntityData::Composite(parts) | EntityData::Group(parts) => counted(p, parts),
            EntityData::Line(ends) => points(p, ends),
            EntityData::Point(at) => {
                p.reals(at)?;
                p.add(0) // no symbol
            }
            EntityData::Direction(along) => p.reals(along),
            EntityData::Revolution { axis, curve, angles } => {
                p.add(axis)?;
                p.add(curve)?;
                p.reals(angles)
            }
            EntityData::Extrusion { curve, end } => {
                p.add(curve)?;
                p.reals(end)
            }
            EntityData::Matrix(columns) => {
                (0..3).try_for_each(|i| p.reals(&columns.map(|column| column[i])))
            }
            EntityData::Elementary { number, origin, z, x, measures } => {
                p.add(origin)?;
                // The radius of a sphere comes before its axis.
                let (before, after) = measures.split_at(usize::from(*number == SPHERE));
                p.reals(before)?;
                p.add(z)?;
                p.reals(after)?;
                p.add(x)
            }
            EntityData::Curve(c) => {
                curve(p, c, false)?;
                points(p, c.poles())?;
                curve_end(p, c, 0.0)
            }
            EntityData::PCurve(c) => {
                curve(p, c, true)?;
                c.poles().iter().try_for_each(|[u, v]| p.reals(&[*u, *v, 0.0]))?;
                curve_end(p, c, 1.0)
            }
            EntityData::Surface(s) => surface(p, s),
            EntityData::OnSurface { surface, flat, space } => on_surface(p, [surface, flat, space]),
            EntityData::Trimmed { surface, loops } => trimmed(p, *surface, loops),
            EntityData::Subfigure { depth, name, members } => {
                p.add(depth)?;
                p.text(name)?;
                counted(p, members)
            }
            EntityData::Instance(subfigure) => {
                p.add(subfigure)?;
                // No shift besides that of the matrix, and no scaling.
                p.reals(&[0.0, 0.0, 0.0, 1.0])
            }
            EntityData::Colour(percent) => p.reals(percent),
            EntityData::Name(name) => {
                p.add(1)?;
                p.text(name)
            }
            EntityData::Vertices(vertices) => {
                p.add(vertices.len())?;
                points(p, vertices)
            }
            EntityData::Edges { vertices, edges } => edge_list(p, *vertices, edges),
            EntityData::Loop(uses) => edge_loop(p, uses),
            EntityData::Face { surface, loops } => {
                p.add(surface)?;
                p.add(loops.len())?;
                p.add(1)?; // the first loop is the outer one
                loops.iter().try_for_each(|l| p.add(l))
            }
            EntityData::Shell { faces, .. } => shell(p, faces),
            EntityData::Solid { outer, voids } => solid(p, *outer, voids),
        }
    }
}
