//! The shape: vertices, edges, faces, shell and their representation
//! (ISO 10303-42, clause 5; ISO 10303-509).

use std::io;

use super::geometry::{self, logical};
use super::part21::{Id, List, Part21, Text, add};
use super::style;
use crate::brep::Brep;
use crate::number::StepReal;
use crate::topology::{EdgeData, EdgeUse, FaceData, Topology};

/// Writes the shape, ties it to the product's `PRODUCT_DEFINITION_SHAPE`, and
/// gives it its colour.
pub(super) fn write(
    file: &mut Part21<'_>,
    topology: &Topology<'_>,
    brep: &Brep,
    (definition, colour): (Id, Option<[u8; 3]>),
) -> io::Result<()> {
    let space = space(file, brep.uncertainty_mm)?;
    let plane = add!(
        file,
        "(GEOMETRIC_REPRESENTATION_CONTEXT(2)\nPARAMETRIC_REPRESENTATION_CONTEXT()\n\
         REPRESENTATION_CONTEXT('2D SPACE',''))"
    )?;
    let shells = shells(file, topology, plane)?;
    let name = Text(&brep.name);
    let model = add!(file, "SHELL_BASED_SURFACE_MODEL({name},{})", List(&shells))?;
    let origin = origin(file)?;
    let shape =
        add!(file, "MANIFOLD_SURFACE_SHAPE_REPRESENTATION({name},({model},{origin}),{space})")?;
    add!(file, "SHAPE_DEFINITION_REPRESENTATION({definition},{shape})")?;
    colour.map_or(Ok(()), |colour| style::write(file, model, colour, space))
}

/// The geometric context: three dimensions, millimetres, an uncertainty.
fn space(file: &mut Part21<'_>, uncertainty: f64) -> io::Result<Id> {
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

fn origin(file: &mut Part21<'_>) -> io::Result<Id> {
    let point = add!(file, "CARTESIAN_POINT('',(0.,0.,0.))")?;
    let z = add!(file, "DIRECTION('',(0.,0.,1.))")?;
    let x = add!(file, "DIRECTION('',(1.,0.,0.))")?;
    add!(file, "AXIS2_PLACEMENT_3D('',{point},{z},{x})")
}

/// An `OPEN_SHELL` for every group of faces that hang together: one whose faces
/// do not is invalid.
fn shells(file: &mut Part21<'_>, topology: &Topology<'_>, plane: Id) -> io::Result<Vec<Id>> {
    let mut surfaces = Vec::with_capacity(topology.faces.len());
    for face in &topology.faces {
        surfaces.push(geometry::surface(file, &face.surface)?);
    }
    let edges = edges(file, topology, &surfaces, plane)?;
    let mut faces = Vec::with_capacity(surfaces.len());
    for (data, surface) in topology.faces.iter().zip(&surfaces) {
        faces.push(face(file, data, *surface, &edges)?);
    }
    let mut shells = Vec::new();
    for members in topology.shells() {
        let members: Vec<Id> = members.into_iter().map(|f| faces[f]).collect();
        shells.push(add!(file, "OPEN_SHELL('',{})", List(&members))?);
    }
    Ok(shells)
}

/// An `EDGE_CURVE` for every edge, between `VERTEX_POINT`s that edges share.
fn edges(
    file: &mut Part21<'_>,
    topology: &Topology<'_>,
    surfaces: &[Id],
    plane: Id,
) -> io::Result<Vec<Id>> {
    let mut vertices = Vec::with_capacity(topology.vertices.len());
    for vertex in &topology.vertices {
        let point = geometry::point(file, *vertex)?;
        vertices.push(add!(file, "VERTEX_POINT('',{point})")?);
    }
    let mut edges = Vec::with_capacity(topology.edges.len());
    for edge in &topology.edges {
        let [start, end] = edge.ends.map(|i| vertices[i]);
        let curve = edge_geometry(file, edge, surfaces, plane)?;
        edges.push(add!(file, "EDGE_CURVE('',{start},{end},{curve},.T.)")?);
    }
    Ok(edges)
}

/// `SURFACE_CURVE` (`SEAM_CURVE` where a face uses the edge twice): the 3D
/// curve, which is the master, and a `PCURVE` for every use.
fn edge_geometry(
    file: &mut Part21<'_>,
    edge: &EdgeData<'_>,
    surfaces: &[Id],
    plane: Id,
) -> io::Result<Id> {
    let curve = geometry::curve(file, &edge.curve)?;
    let mut pcurves = Vec::with_capacity(edge.uses.len());
    for (face, pcurve) in &edge.uses {
        let flat = geometry::pcurve(file, pcurve)?;
        let flat = add!(file, "DEFINITIONAL_REPRESENTATION('',({flat}),{plane})")?;
        pcurves.push(add!(file, "PCURVE('',{},{flat})", surfaces[*face])?);
    }
    let seam = matches!(edge.uses[..], [(a, _), (b, _)] if a == b);
    let kind = if seam { "SEAM_CURVE" } else { "SURFACE_CURVE" };
    add!(file, "{kind}('',{curve},{},.PCURVE_S1.)", List(&pcurves))
}

/// `ADVANCED_FACE`, the outer bound first.
fn face(file: &mut Part21<'_>, data: &FaceData<'_>, surface: Id, edges: &[Id]) -> io::Result<Id> {
    let mut bounds = Vec::with_capacity(data.loops.len());
    for (i, uses) in data.loops.iter().enumerate() {
        let edge_loop = edge_loop(file, uses, edges)?;
        let kind = if i == 0 { "FACE_OUTER_BOUND" } else { "FACE_BOUND" };
        bounds.push(add!(file, "{kind}('',{edge_loop},.T.)")?);
    }
    add!(file, "ADVANCED_FACE('',{},{surface},{})", List(&bounds), logical(data.forward))
}

fn edge_loop(file: &mut Part21<'_>, uses: &[EdgeUse<'_>], edges: &[Id]) -> io::Result<Id> {
    let mut oriented = Vec::with_capacity(uses.len());
    for EdgeUse { edge, forward, .. } in uses {
        let direction = logical(*forward);
        oriented.push(add!(file, "ORIENTED_EDGE('',*,*,{},{direction})", edges[*edge])?);
    }
    add!(file, "EDGE_LOOP('',{})", List(&oriented))
}
