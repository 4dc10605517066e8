//! Which entities a file holds, in which order.

use std::borrow::Cow;

use super::entity::{Body, Entity, Pointer, Status};
use super::parameters::ascii;
use crate::brep::{Brep, Curve, EdgeUse, Face, FaceId, ShellId};
use crate::spline::SplineCurve;

/// Entities in the order of their directory entries.
struct Plan<'a> {
    entities: Vec<Entity<'a>>,
    label: String,
    name: Option<Pointer>,
    colour: Option<Pointer>,
}

/// Faces as trimmed surfaces (144), in a group (402) where there are several:
/// some programs crash on more than one free entity.
pub(super) fn trimmed(brep: &Brep, colour: Option<[u8; 3]>) -> Vec<Entity<'_>> {
    let mut plan = Plan::new(&brep.name, colour);
    let surfaces = plan.surfaces(brep);
    let mut faces = Vec::with_capacity(brep.faces.len());
    for data in &brep.faces {
        faces.push(plan.trimmed_face(brep, data, surfaces[data.surface.0]));
    }
    plan.roots(faces);
    plan.entities
}

/// Solids (186), and open shells (514 form 2) for the sheets, over shared edges; in a group
/// (402) where there are several.
pub(super) fn bodies(brep: &Brep, colour: Option<[u8; 3]>) -> Vec<Entity<'_>> {
    let mut plan = Plan::new(&brep.name, colour);
    let edges = plan.edge_list(brep);
    let surfaces = plan.surfaces(brep);
    let mut faces = Vec::with_capacity(brep.faces.len());
    for data in &brep.faces {
        let face = plan.shell_face(data, surfaces[data.surface.0], edges);
        faces.push((plan.coloured(Status::Part, face), data.forward));
    }
    let shell = |ShellId(shell): ShellId| {
        let shell = &brep.shells[shell];
        let faces = shell.faces.iter().map(|FaceId(face)| faces[*face]).collect();
        Body::Shell { faces, closed: shell.closed }
    };
    let mut roots = Vec::new();
    for solid in &brep.solids {
        let outer = plan.coloured(Status::Part, shell(solid.outer));
        let mut voids = Vec::with_capacity(solid.voids.len());
        for void in &solid.voids {
            voids.push(plan.coloured(Status::Part, shell(*void)));
        }
        roots.push(Body::Solid { outer, voids });
    }
    roots.extend(brep.sheets().map(shell));
    plan.roots(roots);
    plan.entities
}

impl<'a> Plan<'a> {
    fn new(name: &'a str, colour: Option<[u8; 3]>) -> Self {
        let mut plan = Plan { entities: Vec::new(), label: label(name), name: None, colour: None };
        if let Some(rgb) = colour {
            let percent = rgb.map(|channel| f64::from(channel) / 2.55);
            plan.colour = Some(plan.add(Status::Definition, Body::Colour(percent)));
        }
        if !name.is_empty() {
            plan.name = Some(plan.add(Status::Part, Body::Name(name)));
        }
        plan
    }

    fn add(&mut self, status: Status, body: Body<'a>) -> Pointer {
        self.entities.push(Entity { body, status, label: String::new(), name: None, colour: None });
        Pointer(2 * self.entities.len() - 1)
    }

    fn coloured(&mut self, status: Status, body: Body<'a>) -> Pointer {
        let colour = self.colour;
        self.entities.push(Entity { body, status, label: String::new(), name: None, colour });
        Pointer(2 * self.entities.len() - 1)
    }

    /// Adds an entity that people see, with label, name and colour.
    fn named(&mut self, status: Status, body: Body<'a>) -> Pointer {
        let (label, name, colour) = (self.label.clone(), self.name, self.colour);
        self.entities.push(Entity { body, status, label, name, colour });
        Pointer(2 * self.entities.len() - 1)
    }

    /// Adds what is seen: one entity by itself, or several in a group.
    fn roots(&mut self, bodies: Vec<Body<'a>>) {
        let alone = bodies.len() == 1;
        let status = if alone { Status::Independent } else { Status::Member };
        let mut members = Vec::with_capacity(bodies.len());
        for body in bodies {
            members.push(self.named(status, body));
        }
        if !alone {
            self.named(Status::Independent, Body::Group(members));
        }
    }

    fn surfaces(&mut self, brep: &'a Brep) -> Vec<Pointer> {
        let surfaces = brep.surfaces.iter();
        surfaces.map(|surface| self.add(Status::Part, Body::Surface(surface))).collect()
    }

    fn trimmed_face(&mut self, brep: &'a Brep, data: &'a Face, surface: Pointer) -> Body<'a> {
        let mut loops = Vec::with_capacity(data.loops.len());
        for uses in loops_of_surface(data) {
            let (mut flat, mut space) = (Vec::new(), Vec::new());
            for (EdgeUse { edge, pcurve, .. }, forward) in uses {
                let Curve::Spline(curve) = &brep.edges[edge.0].curve;
                let curve = Body::Curve(along(curve, forward));
                let pcurve = Body::PCurve(along(pcurve, forward));
                flat.push(self.add(Status::ParameterPlane, pcurve));
                space.push(self.add(Status::Part, curve));
            }
            let flat = self.composite(Status::ParameterPlane, flat);
            let space = self.composite(Status::Part, space);
            loops.push(self.add(Status::Part, Body::OnSurface { surface, flat, space }));
        }
        Body::Trimmed { surface, loops }
    }

    fn composite(&mut self, status: Status, parts: Vec<Pointer>) -> Pointer {
        match parts[..] {
            [only] => only,
            _ => self.add(status, Body::Composite(parts)),
        }
    }

    fn edge_list(&mut self, brep: &'a Brep) -> Pointer {
        let status = Status::PartWithParentsAttributes;
        let vertices = self.add(status, Body::Vertices(&brep.vertices));
        let mut edges = Vec::with_capacity(brep.edges.len());
        for edge in &brep.edges {
            let Curve::Spline(curve) = &edge.curve;
            let curve = Body::Curve(Cow::Borrowed(curve));
            edges.push((self.add(Status::Part, curve), edge.ends.map(|end| end.0)));
        }
        self.add(status, Body::Edges { vertices, edges })
    }

    fn shell_face(&mut self, data: &'a Face, surface: Pointer, edges: Pointer) -> Body<'a> {
        let mut loops = Vec::with_capacity(data.loops.len());
        for uses in loops_of_surface(data) {
            let mut listed = Vec::with_capacity(uses.len());
            for (EdgeUse { edge, pcurve, .. }, forward) in uses {
                // Importers want the pcurve to run along the loop, even where
                // the edge does not.
                let pcurve = Body::PCurve(along(pcurve, forward));
                let pcurve = self.add(Status::ParameterPlane, pcurve);
                listed.push((edge.0, forward, pcurve));
            }
            loops.push(self.add(Status::Part, Body::Loop { edges, uses: listed }));
        }
        Body::Face { surface, loops }
    }
}

/// A face's loops, turned so that they suit the surface's normal: IGES says
/// elsewhere, or not at all, that a face looks the other way.
fn loops_of_surface(data: &Face) -> Vec<Vec<(&EdgeUse, bool)>> {
    let mut loops = Vec::with_capacity(data.loops.len());
    for uses in &data.loops {
        let directed = uses.iter().map(|of_loop| (of_loop, of_loop.forward == data.forward));
        loops.push(if data.forward { directed.collect() } else { directed.rev().collect() });
    }
    loops
}

/// `curve`, or the same curve from its end to its start over the same range.
fn along<const D: usize>(curve: &SplineCurve<D>, forward: bool) -> Cow<'_, SplineCurve<D>> {
    if forward { Cow::Borrowed(curve) } else { Cow::Owned(curve.reversed()) }
}

/// At most eight letters and digits of a name.
fn label(name: &str) -> String {
    let text = ascii(name);
    text.chars().filter(|c| c.is_ascii_alphanumeric() || *c == '_').take(8).collect()
}
