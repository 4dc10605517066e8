//! The list of entities of a file in their order.

use std::collections::BTreeMap;

use super::entity::{Entity, EntityData, EntityStatus, LoopUse, Pointer};
use super::parameters::ascii;
use super::surfaces::PlannedSurface;
use super::{Form, Options};
use crate::assembly::{Assembly, AssemblyPart, Member, Product};
use crate::brep::{Brep, EdgeUse, Face, FaceId, ShellId};
use crate::scene::Placement;

/// The entities in the order of their directory entries, and what those that come next have.
#[derive(Default)]
pub(super) struct Plan<'a> {
    entities: Vec<Entity<'a>>,
    label: String,
    name: Option<Pointer>,
    colour: Option<Pointer>,
    /// The colours of faces that have another one, by the number of the face.
    face_colours: BTreeMap<usize, Pointer>,
    /// The colours that are there.
    colours: BTreeMap<[u8; 3], Pointer>,
}

/// A root entity, and the number of the face that it is.
type Root<'a> = (EntityData<'a>, Option<usize>);

/// The entities of a part. Several roots are in a group (402), because some programs crash if there is more than
/// one independent entity.
pub(super) fn part<'a>(brep: &'a Brep, options: &Options) -> Vec<Entity<'a>> {
    let mut plan = Plan::default();
    plan.begin_part(&brep.name, options.colour, &options.face_colours);
    let roots = plan.of_brep(brep, options.form);
    plan.roots(roots);
    plan.entities
}

/// The entities of an assembly. The whole is one instance, so that there is one independent entity.
pub(super) fn assembly(assembly: &Assembly, form: Form) -> Vec<Entity<'_>> {
    let mut plan = Plan::default();
    let mut parts = Vec::with_capacity(assembly.parts.len());
    for AssemblyPart { brep, colour, face_colours } in &assembly.parts {
        plan.begin_part(&brep.name, *colour, face_colours);
        let roots = plan.of_brep(brep, form);
        let members = roots.into_iter().map(|root| plan.root(EntityStatus::Part, root)).collect();
        parts.push(plan.subfigure((&brep.name, 0), members));
    }
    let mut groups: Vec<(Pointer, usize)> = Vec::with_capacity(assembly.groups.len());
    for group in &assembly.groups {
        let (mut members, mut depth) = (Vec::with_capacity(group.members.len()), 0);
        for Member { name, placement, colour, product } in &group.members {
            let (subfigure, own_depth) = match product {
                Product::Part(part) => (parts[*part], 0),
                Product::Group(inner) => groups[*inner],
            };
            depth = depth.max(own_depth + 1);
            let [x, y, z] = placement.axes;
            let columns = EntityData::Matrix([x, y, z, placement.translation]);
            let matrix =
                (*placement != Placement::IDENTITY).then(|| plan.add(EntityStatus::Part, columns));
            plan.begin_part(name, *colour, &[]);
            members.push(plan.instance(EntityStatus::Part, subfigure, matrix));
        }
        plan.begin_part(&group.name, None, &[]);
        groups.push((plan.subfigure((&group.name, depth), members), depth));
    }
    if let (Some(&(whole, _)), Some(group)) = (groups.last(), assembly.groups.last()) {
        plan.begin_part(&group.name, None, &[]);
        plan.instance(EntityStatus::Independent, whole, None);
    }
    plan.entities
}

impl<'a> Plan<'a> {
    /// What is added from now on has this name, and these colours.
    fn begin_part(
        &mut self,
        name: &'a str,
        colour: Option<[u8; 3]>,
        face_colours: &[(FaceId, [u8; 3])],
    ) {
        self.label = label(name);
        self.colour = colour.map(|colour| self.colour(colour));
        let of_faces = face_colours.iter().map(|(face, colour)| (face.0, self.colour(*colour)));
        self.face_colours = of_faces.collect();
        let named = || self.add(EntityStatus::Part, EntityData::Name(name));
        self.name = (!name.is_empty()).then(named);
    }

    /// The definition of a colour, which is there once.
    fn colour(&mut self, rgb: [u8; 3]) -> Pointer {
        if let Some(&known) = self.colours.get(&rgb) {
            return known;
        }
        let percent = rgb.map(|channel| f64::from(channel) / 2.55);
        let colour = self.add(EntityStatus::Definition, EntityData::Colour(percent));
        self.colours.insert(rgb, colour);
        colour
    }

    fn subfigure(&mut self, (name, depth): (&'a str, usize), members: Vec<Pointer>) -> Pointer {
        self.named(EntityStatus::Definition, EntityData::Subfigure { depth, name, members })
    }

    fn instance(
        &mut self,
        status: EntityStatus,
        subfigure: Pointer,
        matrix: Option<Pointer>,
    ) -> Pointer {
        let (label, name, colour) = (self.label.clone(), self.name, self.colour);
        let body = EntityData::Instance(subfigure);
        self.entities.push(Entity { body, status, label, name, colour, matrix });
        self.last()
    }

    /// The root entities of a model, each with the face that it is.
    fn of_brep(&mut self, brep: &'a Brep, form: Form) -> Vec<Root<'a>> {
        match form {
            Form::Trimmed => self.trimmed(brep),
            Form::Brep => self.bodies(brep),
        }
    }

    /// The faces as trimmed surfaces (144).
    fn trimmed(&mut self, brep: &'a Brep) -> Vec<Root<'a>> {
        let surfaces = self.surfaces(brep);
        let mut faces = Vec::with_capacity(brep.faces.len());
        for (number, data) in brep.faces.iter().enumerate() {
            let face = self.trimmed_face(brep, data, &surfaces[data.surface.0]);
            faces.push((face, Some(number)));
        }
        faces
    }

    /// Solids (186) and open shells (514 form 2) for sheets, with shared edges.
    fn bodies(&mut self, brep: &'a Brep) -> Vec<Root<'a>> {
        let lists = self.edge_list(brep);
        let surfaces = self.surfaces(brep);
        let mut faces = Vec::with_capacity(brep.faces.len());
        for (number, data) in brep.faces.iter().enumerate() {
            let surface = &surfaces[data.surface.0];
            let face = self.shell_face(brep, data, surface, lists);
            let forward = surface.agrees(data);
            faces.push((self.coloured(EntityStatus::Part, face, Some(number)), forward));
        }
        let shell = |ShellId(shell): ShellId| {
            let shell = &brep.shells[shell];
            let faces = shell.faces.iter().map(|FaceId(face)| faces[*face]).collect();
            EntityData::Shell { faces, closed: shell.closed }
        };
        let mut roots = Vec::new();
        for solid in &brep.solids {
            let outer = self.coloured(EntityStatus::Part, shell(solid.outer), None);
            let mut voids = Vec::with_capacity(solid.voids.len());
            for void in &solid.voids {
                voids.push(self.coloured(EntityStatus::Part, shell(*void), None));
            }
            roots.push((EntityData::Solid { outer, voids }, None));
        }
        roots.extend(brep.sheets().map(|sheet| (shell(sheet), None)));
        roots
    }

    fn last(&self) -> Pointer {
        Pointer(2 * self.entities.len() - 1)
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
        self.last()
    }

    /// The colour of a face, or that of the part.
    fn colour_of(&self, face: Option<usize>) -> Option<Pointer> {
        face.and_then(|face| self.face_colours.get(&face)).copied().or(self.colour)
    }

    fn coloured(
        &mut self,
        status: EntityStatus,
        body: EntityData<'a>,
        face: Option<usize>,
    ) -> Pointer {
        let (label, name, matrix) = (String::new(), None, None);
        let colour = self.colour_of(face);
        self.entities.push(Entity { body, status, label, name, colour, matrix });
        self.last()
    }

    /// Adds an entity that users see, with its label, name and colour.
    fn named(&mut self, status: EntityStatus, body: EntityData<'a>) -> Pointer {
        self.root(status, (body, None))
    }

    fn root(&mut self, status: EntityStatus, (body, face): Root<'a>) -> Pointer {
        let (label, name, colour) = (self.label.clone(), self.name, self.colour_of(face));
        self.entities.push(Entity { body, status, label, name, colour, matrix: None });
        self.last()
    }

    /// Adds the root entities: a single one, or several in a group.
    fn roots(&mut self, bodies: Vec<Root<'a>>) {
        let alone = bodies.len() == 1;
        let status = if alone { EntityStatus::Independent } else { EntityStatus::Member };
        let mut members = Vec::with_capacity(bodies.len());
        for body in bodies {
            members.push(self.root(status, body));
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
