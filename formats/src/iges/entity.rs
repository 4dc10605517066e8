//! The entities that a file may hold, and their parameters.

use std::borrow::Cow;
use std::io;

use truck_modeling::{BSplineCurve, BSplineSurface, Point3};

use super::parameters::Parameters;
use crate::brep::PCurve;
use crate::topology::ends;

/// Points to an entity: the number of its first directory line.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Pointer(pub usize);

impl std::fmt::Display for Pointer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

/// An entity with what its directory entry says of it.
pub(super) struct Entity<'a> {
    pub body: Body<'a>,
    pub status: Status,
    /// Up to eight letters and digits, which CAD programs show as a name.
    pub label: String,
    /// The name property that belongs to the entity.
    pub name: Option<Pointer>,
    /// The definition of its colour.
    pub colour: Option<Pointer>,
}

/// The status number of a directory entry (IGES 5.3, clause 2.2.4.4.9): all
/// entities are visible; they differ in what they depend on and are used for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Status {
    /// Stands for itself.
    Independent,
    /// Part of one parent.
    Part,
    /// Part of one parent, a curve in a parameter plane.
    ParameterPlane,
    /// Part of a parent whose own attributes hold for it.
    PartWithParentsAttributes,
    /// Member of a group.
    Member,
    /// Says how others look.
    Definition,
}

impl Status {
    pub(super) fn number(self) -> &'static str {
        match self {
            Status::Independent => "00000000",
            Status::Part => "00010000",
            Status::ParameterPlane => "00010500",
            Status::PartWithParentsAttributes => "00010001",
            Status::Member => "00020000",
            Status::Definition => "00000200",
        }
    }
}

/// What an entity is made of.
pub(super) enum Body<'a> {
    /// 102, a curve of curves.
    Composite(Vec<Pointer>),
    /// 126, a B-spline curve in space.
    Curve(Cow<'a, BSplineCurve<Point3>>),
    /// 126, a B-spline curve in a parameter plane.
    PCurve(Cow<'a, PCurve>),
    /// 128, a B-spline surface.
    Surface(&'a BSplineSurface<Point3>),
    /// 142, a curve on a surface, given twice.
    OnSurface { surface: Pointer, flat: Pointer, space: Pointer },
    /// 144, a trimmed surface.
    Trimmed { surface: Pointer, loops: Vec<Pointer> },
    /// 314, a colour in percent of red, green and blue.
    Colour([f64; 3]),
    /// 402 form 7, a group.
    Group(Vec<Pointer>),
    /// 406 form 15, a name of any length.
    Name(&'a str),
    /// 502, the vertices.
    Vertices(&'a [Point3]),
    /// 504, the edges: curve, start and end.
    Edges { vertices: Pointer, edges: Vec<(Pointer, [usize; 2])> },
    /// 508, a loop: number of the edge, whether along it, pcurve.
    Loop { edges: Pointer, uses: Vec<(usize, bool, Pointer)> },
    /// 510, a face, its outer loop first.
    Face { surface: Pointer, loops: Vec<Pointer> },
    /// 514 form 2, an open shell: faces, and whether they keep their direction.
    Shell(Vec<(Pointer, bool)>),
}

impl Body<'_> {
    /// Entity type and form number.
    pub(super) fn kind(&self) -> (u16, u16) {
        match self {
            Body::Composite(_) => (102, 0),
            Body::Curve(_) | Body::PCurve(_) => (126, 0),
            Body::Surface(_) => (128, 0),
            Body::OnSurface { .. } => (142, 0),
            Body::Trimmed { .. } => (144, 0),
            Body::Colour(_) => (314, 0),
            Body::Group(_) => (402, 7),
            Body::Name(_) => (406, 15),
            Body::Vertices(_) => (502, 1),
            Body::Edges { .. } => (504, 1),
            Body::Loop { .. } => (508, 1),
            Body::Face { .. } => (510, 1),
            Body::Shell(_) => (514, 2),
        }
    }
}

impl Entity<'_> {
    /// Composes the whole record: type, parameters, pointers to properties.
    pub(super) fn compose(&self, mut p: Parameters<'_>) -> io::Result<()> {
        p.add(self.body.kind().0)?;
        self.body.compose(&mut p)?;
        if let Some(name) = self.name {
            // No associativities, one property (clause 2.2.4.5.2).
            p.add(0)?;
            p.add(1)?;
            p.add(name)?;
        }
        p.end()
    }
}

impl Body<'_> {
    fn compose(&self, p: &mut Parameters<'_>) -> io::Result<()> {
        match self {
            Body::Composite(parts) | Body::Group(parts) => counted(p, parts),
            Body::Curve(c) => {
                let poles = c.control_points();
                curve(p, c.knot_vec(), poles.len(), poles.first() == poles.last(), false)?;
                points(p, poles)?;
                curve_end(p, c.knot_vec(), 0.0)
            }
            Body::PCurve(c) => {
                let poles = c.control_points();
                curve(p, c.knot_vec(), poles.len(), poles.first() == poles.last(), true)?;
                poles.iter().try_for_each(|q| p.reals(&[q.x, q.y, 0.0]))?;
                curve_end(p, c.knot_vec(), 1.0)
            }
            Body::Surface(s) => surface(p, s),
            Body::OnSurface { surface, flat, space } => on_surface(p, [surface, flat, space]),
            Body::Trimmed { surface, loops } => trimmed(p, *surface, loops),
            Body::Colour(percent) => p.reals(percent),
            Body::Name(name) => {
                p.add(1)?;
                p.text(name)
            }
            Body::Vertices(vertices) => {
                p.add(vertices.len())?;
                points(p, vertices)
            }
            Body::Edges { vertices, edges } => edge_list(p, *vertices, edges),
            Body::Loop { edges, uses } => edge_loop(p, *edges, uses),
            Body::Face { surface, loops } => {
                p.add(surface)?;
                p.add(loops.len())?;
                p.add(1)?; // the first loop is the outer one
                loops.iter().try_for_each(|l| p.add(l))
            }
            Body::Shell(faces) => shell(p, faces),
        }
    }
}

fn counted(p: &mut Parameters<'_>, parts: &[Pointer]) -> io::Result<()> {
    p.add(parts.len())?;
    parts.iter().try_for_each(|part| p.add(part))
}

fn points(p: &mut Parameters<'_>, points: &[Point3]) -> io::Result<()> {
    points.iter().try_for_each(|q| p.reals(&[q.x, q.y, q.z]))
}

/// Entity 126 up to its poles: all weights are 1.
fn curve(
    p: &mut Parameters<'_>,
    knots: &[f64],
    poles: usize,
    closed: bool,
    planar: bool,
) -> io::Result<()> {
    p.add(poles - 1)?;
    p.add(knots.len() - poles - 1)?;
    // Planar, closed, polynomial, periodic.
    for flag in [planar, closed, true, false] {
        p.add(u8::from(flag))?;
    }
    p.reals(knots)?;
    (0..poles).try_for_each(|_| p.real(1.0))
}

/// Entity 126 after its poles: range, and the normal of a planar curve.
fn curve_end(p: &mut Parameters<'_>, knots: &[f64], normal_z: f64) -> io::Result<()> {
    let (start, end) = ends(knots);
    p.reals(&[start, end, 0.0, 0.0, normal_z])
}

/// Entity 128: in the net the first index, that of u, runs fastest.
fn surface(p: &mut Parameters<'_>, s: &BSplineSurface<Point3>) -> io::Result<()> {
    let net = s.control_points();
    let (rows, columns) = (net.len(), net[0].len());
    for number in [rows - 1, columns - 1, s.udegree(), s.vdegree()] {
        p.add(number)?;
    }
    let u_closed = net.first() == net.last();
    let v_closed = net.iter().all(|row| row.first() == row.last());
    // Closed in u and v, polynomial, periodic in u and v.
    for flag in [u_closed, v_closed, true, false, false] {
        p.add(u8::from(flag))?;
    }
    p.reals(s.uknot_vec())?;
    p.reals(s.vknot_vec())?;
    (0..rows * columns).try_for_each(|_| p.real(1.0))?;
    for j in 0..columns {
        for row in net {
            p.reals(&[row[j].x, row[j].y, row[j].z])?;
        }
    }
    let (u, v) = (ends(s.uknot_vec()), ends(s.vknot_vec()));
    p.reals(&[u.0, u.1, v.0, v.1])
}

fn on_surface(p: &mut Parameters<'_>, parts: [&Pointer; 3]) -> io::Result<()> {
    p.add(0)?; // nothing said about how the curve came about
    parts.into_iter().try_for_each(|part| p.add(part))?;
    p.add(3) // both curves are equally good
}

/// Entity 144 with an explicit outer loop (N1 = 1).
fn trimmed(p: &mut Parameters<'_>, surface: Pointer, loops: &[Pointer]) -> io::Result<()> {
    p.add(surface)?;
    p.add(1)?;
    p.add(loops.len() - 1)?;
    loops.iter().try_for_each(|l| p.add(l))
}

fn edge_list(
    p: &mut Parameters<'_>,
    vertices: Pointer,
    edges: &[(Pointer, [usize; 2])],
) -> io::Result<()> {
    p.add(edges.len())?;
    for (curve, ends) in edges {
        p.add(curve)?;
        for end in ends {
            p.add(vertices)?;
            p.add(end + 1)?;
        }
    }
    Ok(())
}

fn edge_loop(
    p: &mut Parameters<'_>,
    edges: Pointer,
    uses: &[(usize, bool, Pointer)],
) -> io::Result<()> {
    p.add(uses.len())?;
    for (edge, forward, pcurve) in uses {
        p.add(0)?; // an edge, not a vertex
        p.add(edges)?;
        p.add(edge + 1)?;
        p.add(u8::from(*forward))?;
        p.add(1)?; // one pcurve
        p.add(0)?; // not claimed to be an iso-curve
        p.add(pcurve)?;
    }
    Ok(())
}

fn shell(p: &mut Parameters<'_>, faces: &[(Pointer, bool)]) -> io::Result<()> {
    p.add(faces.len())?;
    for (face, forward) in faces {
        p.add(face)?;
        p.add(u8::from(*forward))?;
    }
    Ok(())
}
