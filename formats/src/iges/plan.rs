//! The list of entities of a file in their order.

use std::borrow::Cow;

use super::entity::{Entity, EntityData, EntityStatus, Pointer};
use super::parameters::ascii;
use crate::brep::{Brep, BrepCurve, EdgeUse, Face, FaceId, ShellId};
use crate::spline::SplineCurve;

/// The entities in the order of their directory entries.
struct Plan<'a> {
    entities: Vec<Entity<'a>>,
    label: String,
    name: Option<Pointer>,
    colour: Option<Pointer>,
}

/// The faces as trimmed surfaces (144). Several of them are in a group (402), because some programs
/// crash if there is more than one independent entity.
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

/// Solids (186) and open shells (514 form 2) for sheets, with shared edges. Several of them are in
/// a group (402).
pub(super) fn bodies(brep: &Brep, colour: Option<[u8; 3]>) -> Vec<Entity<'_>> {
    let mut plan = Plan::new(&brep.name, colour);
    let edges = plan.edge_list(brep);
    let surfaces = plan.surfaces(brep);
    let mut faces = Vec::with_capacity(brep.faces.len());
    for data in &brep.faces {
        let face = plan.shell_face(data, surfaces[data.surface.0], edges);
        faces.push((plan.coloured(EntityStatus::Part, face), data.forward));
    }
    let shell = |ShellId(shell): ShellId| {
        let shell = &brep.shells[shell];
        let faces = shell.faces.iter().map(|FaceId(face)| faces[*face]).collect();
        EntityData::Shell { faces, closed: shell.closed }
    };
    let mut roots = Vec::new();
    for solid in &brep.solids {
        let outer = plan.coloured(EntityStatus::Part, shell(solid.outer));
        let mut voids = Vec::with_capacity(solid.voids.len());
        for void in &solid.voids {
            voids.push(plan.coloured(EntityStatus::Part, shell(*void)));
        }
        roots.push(EntityData::Solid { outer, voids });
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
            plan.colour = Some(plan.add(EntityStatus::Definition, EntityData::Colour(percent)));
        }
        if !name.is_empty() {
            plan.name = Some(plan.add(EntityStatus::Part, EntityData::Name(name)));
        }
        plan
    }

    fn add(&mut self, status: EntityStatus, body: EntityData<'a>) -> Pointer {
        self.entities.push(Entity { body, status, label: String::new(), name: None, colour: None });
        Pointer(2 * self.entities.len() - 1)
    }

    fn coloured(&mut self, status: EntityStatus, body: EntityData<'a>) -> Pointer {
        let colour = self.colour;
        self.entities.push(Entity { body, status, label: String::new(), name: None, colour });
        Pointer(2 * self.entities.len() - 1)
    }

    /// Adds an entity that users see, with its label, name and colour.
    fn named(&mut self, status: EntityStatus, body: EntityData<'a>) -> Pointer {
        let (label, name, colour) = (self.label.clone(), self.name, self.colour);
        self.entities.push(Entity { body, status, label, name, colour });
        Pointer(2 * self.entities.len() - 1)
    }

    /// Adds the root entities: a single one, or several in a group.
    fn roots(&mut self, bodies: Vec<EntityData<'a>>) {
        let alone = bodies.len() == 1;
        let status = if alone { EntityStatus::Independent } else { EntityStatus::Member };
        let mut members = Vec::with_capacity(bodies.len());
        for body in bodies {
            members.push(self.named(status, body));
        }
        if !alone {
            self.named(EntityStatus::Independent, EntityData::Group(members));
        }
    }

    fn surfaces(&mut self, brep: &'a Brep) -> Vec<Pointer> {
        let surfaces = brep.surfaces.iter();
        surfaces.map(|surface| self.add(EntityStatus::Part, EntityData::Surface(surface))).collect()
    }

    fn trimmed_face(&mut self, brep: &'a Brep, data: &'a Face, surface: Pointer) -> EntityData<'a> {
        let mut loops = Vec::with_capacity(data.loops.len());
        for uses in loops_of_surface(data) {
            let (mut flat, mut space) = (Vec::new(), Vec::new());
            for (EdgeUse { edge, pcurve, .. }, forward) in uses {
                let BrepCurve::Spline(curve) = &brep.edges[edge.0].curve;
                let curve = EntityData::Curve(along(curve, forward));
                let pcurve = EntityData::PCurve(along(pcurve, forward));
                flat.push(self.add(EntityStatus::ParameterPlane, pcurve));
                space.push(self.add(EntityStatus::Part, curve));
            }
            let flat = self.composite(EntityStatus::ParameterPlane, flat);
            let space = self.composite(EntityStatus::Part, space);
            loops
                .push(self.add(EntityStatus::Part, EntityData::OnSurface { surface, flat, space }));
        }
        EntityData::Trimmed { surface, loops }
    }

    fn composite(&mut self, status: EntityStatus, parts: Vec<Pointer>) -> Pointer {
        match parts[..] {
            [only] => only,
            _ => self.add(status, EntityData::Composite(parts)),
        }
    }

    fn edge_list(&mut self, brep: &'a Brep) -> Pointer {
        let status = EntityStatus::PartWithParentsAttributes;
        let vertices = self.add(status, EntityData::Vertices(&brep.vertices));
        let mut edges = Vec::with_capacity(brep.edges.len());
        for edge in &brep.edges {
            let BrepCurve::Spline(curve) = &edge.curve;
            let curve = EntityData::Curve(Cow::Borrowed(curve));
            edges.push((self.add(EntityStatus::Part, curve), edge.ends.map(|end| end.0)));
        }
        self.add(status, EntityData::Edges { vertices, edges })
    }

    fn shell_face(&mut self, data: &'a Face, surface: Pointer, edges: Pointer) -> EntityData<'a> {
        let mut loops = Vec::with_capacity(data.loops.len());
        for uses in loops_of_surface(data) {
            let mut listed = Vec::with_capacity(uses.len());
            for (EdgeUse { edge, pcurve, .. }, forward) in uses {
                // Importers expect the pcurve in the direction of the loop, even if the edge has
                // the opposite direction.
                let pcurve = EntityData::PCurve(along(pcurve, forward));
                let pcurve = self.add(EntityStatus::ParameterPlane, pcurve);
                listed.push((edge.0, forward, pcurve));
            }
            loops.push(self.add(EntityStatus::Part, EntityData::Loop { edges, uses: listed }));
        }
        EntityData::Face { surface, loops }
    }
}

/// The loops of a face with the orientation for the normal of the surface. IGES stores elsewhere,
/// or not at all, that a face has the opposite normal.
fn loops_of_surface(data: &Face) -> Vec<Vec<(&EdgeUse, bool)>> {
    let mut loops = Vec::with_capacity(data.loops.len());
    for uses in &data.loops {
        let directed = uses.iter().map(|of_loop| (of_loop, of_loop.forward == data.forward));
        loops.push(if data.forward { directed.collect() } else { directed.rev().collect() });
    }
    loops
}

/// `curve` if `forward`, otherwise the curve in the opposite direction over the same range.
fn along<const D: usize>(curve: &SplineCurve<D>, forward: bool) -> Cow<'_, SplineCurve<D>> {
    if forward { Cow::Borrowed(curve) } else { Cow::Owned(curve.reversed()) }
}

/// The first letters and digits of a name, at most eight.
fn label(name: &str) -> String {
    let text = ascii(name);
    text.chars().filter(|c| c.is_ascii_alphanumeric() || *c == '_').take(8).collect()
}
