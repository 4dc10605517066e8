//! Which entities a file holds, in which order.

use std::borrow::Cow;

use truck_modeling::{BSplineCurve, KnotVec};

use super::entity::{Body, Entity, Pointer, Status};
use super::parameters::ascii;
use crate::topology::{EdgeUse, FaceData, Topology, ends};

/// Entities in the order of their directory entries.
struct Plan<'a> {
    entities: Vec<Entity<'a>>,
    label: String,
    name: Option<Pointer>,
    colour: Option<Pointer>,
}

/// Faces as trimmed surfaces (144), in a group (402) where there are several:
/// some programs crash on more than one free entity.
pub(super) fn trimmed<'a>(
    topology: &'a Topology<'a>,
    name: &'a str,
    colour: Option<[u8; 3]>,
) -> Vec<Entity<'a>> {
    let mut plan = Plan::new(name, colour);
    let mut faces = Vec::with_capacity(topology.faces.len());
    let alone = topology.faces.len() == 1;
    for data in &topology.faces {
        let face = plan.trimmed_face(topology, data);
        faces.push(plan.named(if alone { Status::Independent } else { Status::Member }, face));
    }
    if !alone {
        plan.named(Status::Independent, Body::Group(faces));
    }
    plan.entities
}

/// Faces as open shells (514) over shared edges, one for every group of faces
/// that hang together, in a group (402) where there are several.
pub(super) fn shell<'a>(
    topology: &'a Topology<'a>,
    name: &'a str,
    colour: Option<[u8; 3]>,
) -> Vec<Entity<'a>> {
    let mut plan = Plan::new(name, colour);
    let edges = plan.edge_list(topology);
    let mut faces = Vec::with_capacity(topology.faces.len());
    for data in &topology.faces {
        let face = plan.shell_face(data, edges);
        faces.push((plan.coloured(Status::Part, face), data.forward));
    }
    let shells = topology.shells();
    let alone = shells.len() == 1;
    let mut members = Vec::with_capacity(shells.len());
    for shell in shells {
        let shell = Body::Shell(shell.into_iter().map(|f| faces[f]).collect());
        members.push(plan.named(if alone { Status::Independent } else { Status::Member }, shell));
    }
    if !alone {
        plan.named(Status::Independent, Body::Group(members));
    }
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

    fn trimmed_face(&mut self, topology: &'a Topology<'a>, data: &'a FaceData<'a>) -> Body<'a> {
        let surface = self.add(Status::Part, Body::Surface(&data.surface));
        let mut loops = Vec::with_capacity(data.loops.len());
        for uses in loops_of_surface(data) {
            let (mut flat, mut space) = (Vec::new(), Vec::new());
            for EdgeUse { edge, forward, pcurve } in uses {
                let curve = Body::Curve(along(&topology.edges[edge].curve, forward));
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

    fn edge_list(&mut self, topology: &'a Topology<'a>) -> Pointer {
        let status = Status::PartWithParentsAttributes;
        let vertices = self.add(status, Body::Vertices(&topology.vertices));
        let mut edges = Vec::with_capacity(topology.edges.len());
        for edge in &topology.edges {
            let curve = Body::Curve(Cow::Borrowed(&edge.curve));
            edges.push((self.add(Status::Part, curve), edge.ends));
        }
        self.add(status, Body::Edges { vertices, edges })
    }

    fn shell_face(&mut self, data: &'a FaceData<'a>, edges: Pointer) -> Body<'a> {
        let surface = self.add(Status::Part, Body::Surface(&data.surface));
        let mut loops = Vec::with_capacity(data.loops.len());
        for uses in loops_of_surface(data) {
            let mut listed = Vec::with_capacity(uses.len());
            for EdgeUse { edge, forward, pcurve } in uses {
                // Importers want the pcurve to run along the loop, even where
                // the edge does not.
                let pcurve = Body::PCurve(along(pcurve, forward));
                let pcurve = self.add(Status::ParameterPlane, pcurve);
                listed.push((edge, forward, pcurve));
            }
            loops.push(self.add(Status::Part, Body::Loop { edges, uses: listed }));
        }
        Body::Face { surface, loops }
    }
}

/// A face's loops, turned so that they suit the surface's normal: IGES says
/// elsewhere, or not at all, that a face looks the other way.
fn loops_of_surface<'a>(data: &FaceData<'a>) -> Vec<Vec<EdgeUse<'a>>> {
    let turn = |uses: &Vec<EdgeUse<'a>>| {
        let uses = uses.iter().rev();
        uses.map(|u| EdgeUse { forward: !u.forward, ..*u }).collect()
    };
    if data.forward { data.loops.clone() } else { data.loops.iter().map(turn).collect() }
}

/// `curve`, or the same curve from its end to its start over the same range.
fn along<P: Clone>(curve: &BSplineCurve<P>, forward: bool) -> Cow<'_, BSplineCurve<P>> {
    if forward {
        return Cow::Borrowed(curve);
    }
    let knots = curve.knot_vec();
    let (start, end) = ends(knots);
    // The ends must stay what they are to the last bit.
    let mirror = |&t: &f64| if t == start { end } else { start + (end - t) };
    let knots: Vec<f64> = knots.iter().rev().map(mirror).collect();
    let poles = curve.control_points().iter().rev().cloned().collect();
    Cow::Owned(BSplineCurve::new_unchecked(KnotVec::from(knots), poles))
}

/// At most eight letters and digits of a name.
fn label(name: &str) -> String {
    let text = ascii(name);
    text.chars().filter(|c| c.is_ascii_alphanumeric() || *c == '_').take(8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reversed_curve_keeps_its_range_to_the_last_bit() {
        let knots = vec![0.1, 0.1, 0.3, 0.3000000001, 0.7, 0.7];
        let curve = BSplineCurve::new_unchecked(KnotVec::from(knots), vec![1, 2, 3, 4]);
        let reversed = along(&curve, false);
        assert_eq!(reversed.control_points(), &[4, 3, 2, 1]);
        let knots: &[f64] = reversed.knot_vec();
        assert_eq!((knots[..2].to_vec(), knots[4..].to_vec()), (vec![0.1; 2], vec![0.7; 2]));
        assert!((knots[3] - 0.5).abs() < 1e-15 && knots[2] < knots[3]);
    }
}
