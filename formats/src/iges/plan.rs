//! The list of entities of a file in their order.

use super::entity::{Entity, EntityData, EntityStatus, LoopUse, Pointer};
use super::parameters::ascii;
use super::surfaces::PlannedSurface;
use crate::brep::{Brep, EdgeUse, Face, FaceId, ShellId};

/// The entities in the order of their directory entries.
pub(super) struct Plan<'a> {
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
        faces.push(plan.trimmed_face(brep, data, &surfaces[data.surface.0]));
    }
    plan.roots(faces);
    plan.entities
}

/// Solids (186) and open shells (514 form 2) for sheets, with shared edges. Several of them are in
/// a group (402).
pub(super) fn bodies(brep: &Brep, colour: Option<[u8; 3]>) -> Vec<Entity<'_>> {
    let mut plan = Plan::new(&brep.name, colour);
    let lists = plan.edge_list(brep);
    let surfaces = plan.surfaces(brep);
    let mut faces = Vec::with_capacity(brep.faces.len());
    for data in &brep.faces {
        let surface = &surfaces[data.surface.0];
        let face = plan.shell_face(brep, data, surface, lists);
        let forward = surface.agrees(data);
        faces.push((plan.coloured(EntityStatus::Part, face), forward));
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

    pub(super) fn add(&mut self, status: EntityStatus, body: EntityData<'a>) -> Pointer {
        self.placed(status, body, None)
    }

    /// Adds an entity that a matrix places.
    pub(super) fn placed(
        &mut self,
        status: EntityStatus,
        body: EntityData<'a>,
        matrix: Option<Pointer>,
    ) -> Pointer {
        let (label, name, colour) = (String::new(), None, None);
        self.entities.push(Entity { body, status, label, name, colour, matrix });
        Pointer(2 * self.entities.len() - 1)
    }

    fn coloured(&mut self, status: EntityStatus, body: EntityData<'a>) -> Pointer {
        let colour = self.colour;
        let (label, name, matrix) = (String::new(), None, None);
        self.entities.push(Entity { body, status, label, name, colour, matrix });
        Pointer(2 * self.entities.len() - 1)
    }

    /// Adds an entity that users see, with its label, name and colour.
    fn named(&mut self, status: EntityStatus, body: EntityData<'a>) -> Pointer {
        let (label, name, colour) = (self.label.clone(), self.name, self.colour);
        self.entities.push(Entity { body, status, label, name, colour, matrix: None });
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

    fn trimmed_face(
        &mut self,
        brep: &'a Brep,
        data: &'a Face,
        surface: &PlannedSurface,
    ) -> EntityData<'a> {
        let mut loops = Vec::with_capacity(data.loops.len());
        for uses in loops_of_surface(data, surface) {
            let (mut flat, mut space) = (Vec::new(), Vec::new());
            for (EdgeUse { edge, pcurve, .. }, forward) in uses {
                flat.push(self.pcurve(surface, pcurve, forward));
                space.push(self.curve(&brep.edges[edge.0].curve, forward));
            }
            let flat = self.composite(EntityStatus::ParameterPlane, flat);
            let space = self.composite(EntityStatus::Part, space);
            let surface = surface.pointer;
            loops
                .push(self.add(EntityStatus::Part, EntityData::OnSurface { surface, flat, space }));
        }
        EntityData::Trimmed { surface: surface.pointer, loops }
    }

    fn composite(&mut self, status: EntityStatus, parts: Vec<Pointer>) -> Pointer {
        match parts[..] {
            [only] => only,
            _ => self.add(status, EntityData::Composite(parts)),
        }
    }

    /// Adds the vertices and the edges, and returns their lists.
    fn edge_list(&mut self, brep: &'a Brep) -> [Pointer; 2] {
        let status = EntityStatus::PartWithParentsAttributes;
        let vertices = self.add(status, EntityData::Vertices(&brep.vertices));
        let mut edges = Vec::with_capacity(brep.edges.len());
        for edge in &brep.edges {
            edges.push((self.curve(&edge.curve, true), edge.ends.map(|end| end.0)));
        }
        [vertices, self.add(status, EntityData::Edges { vertices, edges })]
    }

    fn shell_face(
        &mut self,
        brep: &'a Brep,
        data: &'a Face,
        surface: &PlannedSurface,
        [vertices, edges]: [Pointer; 2],
    ) -> EntityData<'a> {
        let mut loops = Vec::with_capacity(data.loops.len());
        for (uses, poles) in loops_of_surface(data, surface).into_iter().zip(brep.poles(data)) {
            let mut listed = Vec::with_capacity(uses.len());
            for (of_loop, forward) in uses {
                let EdgeUse { edge, pcurve, .. } = of_loop;
                // Importers expect the pcurve in the direction of the loop, even if the edge has
                // the opposite direction.
                let pcurve = self.pcurve(surface, pcurve, forward);
                listed.push(LoopUse {
                    list: edges,
                    is_vertex: false,
                    number: edge.0,
                    forward,
                    pcurve,
                });
                let end = of_loop.pcurve.ends()[usize::from(forward)];
                let Some([from, to]) = pole_at(&poles, end) else { continue };
                let ends = [from, to].map(|at| surface.parameters(at)).map(|[u, v]| [u, v, 0.0]);
                let pcurve = self.add(EntityStatus::ParameterPlane, EntityData::Line(ends));
                let number = brep.edges[edge.0].ends[usize::from(forward)].0;
                listed.push(LoopUse {
                    list: vertices,
                    is_vertex: true,
                    number,
                    forward: true,
                    pcurve,
                });
            }
            loops.push(self.add(EntityStatus::Part, EntityData::Loop(listed)));
        }
        EntityData::Face { surface: surface.pointer, loops }
    }
}

/// The jump of a loop from a place at a pole, if there is one. The loop may run in either direction.
fn pole_at(poles: &[[[f64; 2]; 2]], end: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    let towards = poles.iter().find(|[from, _]| *from == end);
    let back = poles.iter().find(|[_, to]| *to == end).map(|[from, to]| [*to, *from]);
    towards.copied().or(back)
}

/// The loops of a face with the orientation for the normal of the file's surface. IGES stores
/// elsewhere, or not at all, that a face has the opposite normal.
fn loops_of_surface<'a>(data: &'a Face, surface: &PlannedSurface) -> Vec<Vec<(&'a EdgeUse, bool)>> {
    let agrees = surface.agrees(data);
    let mut loops = Vec::with_capacity(data.loops.len());
    for uses in &data.loops {
        let directed = uses.iter().map(|of_loop| (of_loop, of_loop.forward == agrees));
        loops.push(if agrees { directed.collect() } else { directed.rev().collect() });
    }
    loops
}

/// The first letters and digits of a name, at most eight.
fn label(name: &str) -> String {
    let text = ascii(name);
    text.chars().filter(|c| c.is_ascii_alphanumeric() || *c == '_').take(8).collect()
}
