//! Writer of the shape: vertices, edges, faces, shells, solids and their representation (ISO
//! 10303-42, clause 5; ISO 10303-509 and 10303-514).

use std::borrow::Cow;
use std::io;

use super::analytic;
use super::geometry::{self, logical};
use super::part21::{Id, List, Part21, Text, add};
use super::seams::{self, SeamOrder};
use super::style;
use crate::brep::{BoundedCurve, Brep, Edge, EdgeUse, Face, FaceId, ShellId, Solid, SurfaceId};
use crate::number::StepReal;

/// The colours of a part: its own, and those of faces that differ.
#[derive(Clone, Copy, Default)]
pub(super) struct StepColours<'a> {
    pub(super) part: Option<[u8; 3]>,
    pub(super) faces: &'a [(FaceId, [u8; 3])],
}

/// The shape of a product that was written.
#[derive(Debug, Clone)]
pub(super) struct ShapeEntity {
    /// Its representation.
    pub(super) representation: Id,
    /// The placement in it that is at its origin.
    pub(super) origin: Id,
    /// The items that have the colour of the part, each with its `STYLED_ITEM`.
    pub(super) coloured: Vec<[Id; 2]>,
    /// The context of the representation.
    pub(super) space: Id,
}

/// Writes the shape, connects it to the product's `PRODUCT_DEFINITION_SHAPE`, and gives it its
/// colours.
pub(super) fn write(
    file: &mut Part21<'_>,
    brep: &Brep,
    (definition, colours): (Id, StepColours<'_>),
) -> io::Result<ShapeEntity> {
    let space = space(file, brep.uncertainty_mm)?;
    let plane = add!(
        file,
        "(GEOMETRIC_REPRESENTATION_CONTEXT(2)\nPARAMETRIC_REPRESENTATION_CONTEXT()\n\
         REPRESENTATION_CONTEXT('2D SPACE',''))"
    )?;
    let (shells, faces) = shells(file, brep, plane)?;
    let name = Text(&brep.name);
    let mut models = Vec::new();
    for body in &brep.solids {
        models.push(solid(file, body, &shells, &brep.name)?);
    }
    let sheets: Vec<Id> = brep.sheets().map(|ShellId(shell)| shells[shell]).collect();
    if !sheets.is_empty() {
        models.push(add!(file, "SHELL_BASED_SURFACE_MODEL({name},{})", List(&sheets))?);
    }
    let origin = origin(file)?;
    let kind = match (brep.solids.is_empty(), sheets.is_empty()) {
        (true, _) => "MANIFOLD_SURFACE_SHAPE_REPRESENTATION",
        (false, true) => "ADVANCED_BREP_SHAPE_REPRESENTATION",
        // The other representations allow only one kind of model.
        (false, false) => "SHAPE_REPRESENTATION",
    };
    let items: Vec<Id> = models.iter().copied().chain([origin]).collect();
    let shape = add!(file, "{kind}({name},{},{space})", List(&items))?;
    add!(file, "SHAPE_DEFINITION_REPRESENTATION({definition},{shape})")?;
    let of_part = models.iter().filter_map(|&model| Some((model, colours.part?)));
    let of_faces = colours
        .faces
        .iter()
        .filter_map(|(face, colour)| faces.get(face.0).map(|&face| (face, *colour)));
    let styled: Vec<(Id, [u8; 3])> = of_part.chain(of_faces).collect();
    let mut coloured = Vec::new();
    if !styled.is_empty() {
        let items = style::write(file, &styled, space)?;
        let of_part = if colours.part.is_some() { models.len() } else { 0 };
        coloured.extend(models.iter().zip(items).take(of_part).map(|(&model, item)| [model, item]));
    }
    Ok(ShapeEntity { representation: shape, origin, coloured, space })
}

/// Writes a `MANIFOLD_SOLID_BREP`, or a `BREP_WITH_VOIDS` if the solid has voids. The normals of
/// all faces point out of the material, as ISO 10303-42 requires.
fn solid(file: &mut Part21<'_>, solid: &Solid, shells: &[Id], name: &str) -> io::Result<Id> {
    let (name, outer) = (Text(name), shells[solid.outer.0]);
    if solid.voids.is_empty() {
        return add!(file, "MANIFOLD_SOLID_BREP({name},{outer})");
    }
    let mut voids = Vec::with_capacity(solid.voids.len());
    for ShellId(shell) in &solid.voids {
        voids.push(add!(file, "ORIENTED_CLOSED_SHELL('',*,{},.T.)", shells[*shell])?);
    }
    add!(file, "BREP_WITH_VOIDS({name},{outer},{})", List(&voids))
}

/// Writes the geometric context: three dimensions, millimetres, and the uncertainty.
pub(super) fn space(file: &mut Part21<'_>, uncertainty: f64) -> io::Result<Id> {
    let length = add!(file, "(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")?;
    let angle = add!(file, "(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")?;
    let solid = add!(file, "(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")?;
    let bound = add!(
        file,
        "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({}),{length},'distance_accuracy_value',\
         '3D curve against pcurve')",
        StepReal(uncertainty)
    )?;
    add!(
        file,
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3)\nGLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({bound}))\n\
         GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid}))\n\
         REPRESENTATION_CONTEXT('3D SPACE',''))"
    )
}

/// Writes the placement at the origin.
pub(super) fn origin(file: &mut Part21<'_>) -> io::Result<Id> {
    let point = add!(file, "CARTESIAN_POINT('',(0.,0.,0.))")?;
    let z = add!(file, "DIRECTION('',(0.,0.,1.))")?;
    let x = add!(file, "DIRECTION('',(1.,0.,0.))")?;
    add!(file, "AXIS2_PLACEMENT_3D('',{point},{z},{x})")
}

/// Writes an `OPEN_SHELL` or a `CLOSED_SHELL` for every shell. Returns the faces, too.
fn shells(file: &mut Part21<'_>, brep: &Brep, plane: Id) -> io::Result<(Vec<Id>, Vec<Id>)> {
    let surfaces = surfaces(file, brep)?;
    let order = SeamOrder::new(brep);
    let vertices = vertices(file, brep)?;
    let edges = edges(file, brep, &order, (&vertices, &surfaces, plane))?;
    let mut faces = Vec::with_capacity(brep.faces.len());
    for (data, &surface) in brep.faces.iter().zip(&surfaces) {
        faces.push(face(file, (brep, data, surface), &order, (&vertices, &edges))?);
    }
    let mut shells = Vec::with_capacity(brep.shells.len());
    for shell in &brep.shells {
        let members: Vec<Id> = shell.faces.iter().map(|FaceId(face)| faces[*face]).collect();
        let kind = if shell.closed { "CLOSED_SHELL" } else { "OPEN_SHELL" };
        shells.push(add!(file, "{kind}('',{})", List(&members))?);
    }
    Ok((shells, faces))
}

/// Writes the surfaces and returns that of each face. Faces share a B-spline surface, because it is
/// large. Of other surfaces each face has its own one. Then it is clear which pcurve of an edge
/// between two faces on one surface belongs to which face.
fn surfaces(file: &mut Part21<'_>, brep: &Brep) -> io::Result<Vec<Id>> {
    let mut written = Vec::with_capacity(brep.surfaces.len());
    for surface in &brep.surfaces {
        written.push(analytic::surface(file, surface)?);
    }
    let mut taken = vec![false; brep.surfaces.len()];
    let mut surfaces = Vec::with_capacity(brep.faces.len());
    for SurfaceId(number) in brep.faces.iter().map(|face| face.surface) {
        let surface = &brep.surfaces[number];
        surfaces.push(match taken[number] && surface.spline().is_none() {
            true => analytic::surface(file, surface)?,
            false => written[number],
        });
        taken[number] = true;
    }
    Ok(surfaces)
}

/// Writes a `VERTEX_POINT` for every vertex.
fn vertices(file: &mut Part21<'_>, brep: &Brep) -> io::Result<Vec<Id>> {
    let mut vertices = Vec::with_capacity(brep.vertices.len());
    let splines_only = brep.has_splines_only();
    for vertex in &brep.vertices {
        // Lines begin at vertices and share their points.
        let point = match splines_only {
            true => geometry::point(file, *vertex)?,
            false => analytic::point(file, *vertex)?,
        };
        vertices.push(add!(file, "VERTEX_POINT('',{point})")?);
    }
    Ok(vertices)
}

/// Writes an `EDGE_CURVE` for every edge between vertices that edges share. `None` stands for an
/// edge that is left out.
fn edges(
    file: &mut Part21<'_>,
    brep: &Brep,
    order: &SeamOrder,
    (vertices, surfaces, plane): (&[Id], &[Id], Id),
) -> io::Result<Vec<Option<Id>>> {
    let mut edges = Vec::with_capacity(brep.edges.len());
    for (number, uses) in brep.uses().into_iter().enumerate() {
        if order.left_out[number] {
            edges.push(None);
            continue;
        }
        let reversed = order.reversed[number];
        let uses: Vec<Use<'_>> =
            uses.into_iter().map(|(face, of_loop)| (face, surfaces[face.0], of_loop)).collect();
        let edge = &brep.edges[number];
        let [start, end] = edge.ends.map(|end| vertices[end.0]);
        let [start, end] = if reversed { [end, start] } else { [start, end] };
        let curve = edge_geometry(file, edge, &uses, (reversed, plane))?;
        edges.push(Some(add!(file, "EDGE_CURVE('',{start},{end},{curve},.T.)")?));
    }
    Ok(edges)
}

/// A use of an edge: the face, the name of its surface, and the use in a loop.
type Use<'a> = (FaceId, Id, &'a EdgeUse);

/// Writes a `SURFACE_CURVE`, or a `SEAM_CURVE` if a face uses the edge twice. It has the 3D curve
/// and a `PCURVE` for every use.
fn edge_geometry(
    file: &mut Part21<'_>,
    edge: &Edge,
    uses: &[Use<'_>],
    (reversed, plane): (bool, Id),
) -> io::Result<Id> {
    let curve = geometry::curve(file, &*directed(&edge.curve, reversed)?)?;
    let mut pcurves = Vec::with_capacity(uses.len());
    for (_, surface, of_loop) in uses {
        let flat = geometry::pcurve(file, &*directed(&of_loop.pcurve, reversed)?)?;
        let flat = add!(file, "DEFINITIONAL_REPRESENTATION('',({flat}),{plane})")?;
        pcurves.push(add!(file, "PCURVE('',{surface},{flat})")?);
    }
    let seam = matches!(uses, [(a, ..), (b, ..)] if a == b);
    let kind = if seam { "SEAM_CURVE" } else { "SURFACE_CURVE" };
    add!(file, "{kind}('',{curve},{},.PCURVE_S1.)", List(&pcurves))
}

/// A curve in its direction or in the opposite one.
fn directed<const D: usize>(
    curve: &BoundedCurve<D>,
    reversed: bool,
) -> io::Result<Cow<'_, BoundedCurve<D>>> {
    if !reversed {
        return Ok(Cow::Borrowed(curve));
    }
    let invalid = |what| io::Error::new(io::ErrorKind::InvalidInput, what);
    curve.reversed().map(Cow::Owned).map_err(invalid)
}

/// Writes an `ADVANCED_FACE`. The outer bound comes first.
fn face(
    file: &mut Part21<'_>,
    (brep, data, surface): (&Brep, &Face, Id),
    order: &SeamOrder,
    (vertices, edges): (&[Id], &[Option<Id>]),
) -> io::Result<Id> {
    let mut bounds = Vec::with_capacity(data.loops.len());
    for (i, ring) in data.loops.iter().enumerate() {
        let edge_loop = if seams::is_whole(brep, data, ring) {
            let [pole, _] = brep.edges[ring[0].edge.0].ends;
            add!(file, "VERTEX_LOOP('',{})", vertices[pole.0])?
        } else {
            let (before, after) = ring.split_at(order.first(brep, data, ring));
            edge_loop(file, after.iter().chain(before), order, edges)?
        };
        let kind = if i == 0 { "FACE_OUTER_BOUND" } else { "FACE_BOUND" };
        bounds.push(add!(file, "{kind}('',{edge_loop},.T.)")?);
    }
    add!(file, "ADVANCED_FACE('',{},{surface},{})", List(&bounds), logical(data.forward))
}

fn edge_loop<'a>(
    file: &mut Part21<'_>,
    uses: impl Iterator<Item = &'a EdgeUse>,
    order: &SeamOrder,
    edges: &[Option<Id>],
) -> io::Result<Id> {
    let mut oriented = Vec::new();
    for of_loop in uses {
        let direction = logical(order.forward(of_loop));
        let Some(edge) = edges[of_loop.edge.0] else { continue };
        oriented.push(add!(file, "ORIENTED_EDGE('',*,*,{edge},{direction})")?);
    }
    add!(file, "EDGE_LOOP('',{})", List(&oriented))
}
