//! One attempt: chains, vertices, curves, faces, and the checked solid.

use std::collections::BTreeMap;

use formats::Brep;
use formats::brep::{BrepCurve, BrepElement, FaceId, ModelFault, Shell, VertexId};

use super::chart::array;
use super::crossings::{beside, crossings};
use super::domain::FacePlan;
use super::faces::FaceBuilder;
use super::fallback::SeamFault;
use super::network::{Chain, ChainNetwork};
use super::{EXACT, FacePatch, Work};
use crate::geometry::{Point, Vector};
use crate::primitives::PrimitiveKind;
use crate::primitives::contact::touch;

/// The uncertainty in mm: the precision of modelling kernels.
const KERNEL: f64 = 1e-7;

/// The uncertainty is larger than the largest gap by this factor, as gaps are measured at samples.
const SLACK: f64 = 1.25;

/// A shell that holds.
pub(super) struct BuiltShell {
    pub brep: Brep,
    /// The largest distance in mm between an edge and its faces.
    pub gap: f64,
    /// For each face its triangles and their surface.
    pub patches: Vec<FacePatch>,
}

/// Why a chain becomes no edge, and the place if it is known.
struct EdgeFault {
    why: String,
    at: Option<Point>,
}

impl From<String> for EdgeFault {
    fn from(why: String) -> Self {
        EdgeFault { why, at: None }
    }
}

/// Builds the shell of all patches.
pub(super) fn shell(work: &mut Work) -> Result<BuiltShell, Vec<SeamFault>> {
    let mut network = work.network().map_err(|fault| vec![fault])?;
    work.add_walls(&mut network);
    work.lay_facets();
    work.agree(&network);
    work.place_vertices(&mut network)?;
    work.fit_walls(&network);
    work.fit_facets(&network)?;
    work.raise_arches(&mut network);
    work.fair_borders(&mut network);
    work.refine(&mut network)?;
    let strips = work.strips(&network);
    let plans = work.plans(&mut network)?;
    work.refine(&mut network)?;
    let mut brep = Brep { uncertainty_mm: KERNEL, ..Brep::default() };
    let gap = work.edges(&mut network, &mut brep, &plans)?;
    let (patch_of, triangles) = (Vec::new(), Vec::new());
    let mut builder = FaceBuilder {
        work,
        network: &network,
        brep: &mut brep,
        gap,
        patch_of,
        triangles,
        free: BTreeMap::new(),
    };
    let faces = plans.iter().enumerate().filter(|(i, _)| !work.is_wall(*i));
    none(faces.filter_map(|(i, plan)| builder.face(i, plan).err()).collect())?;
    let FaceBuilder { gap, patch_of, triangles, free, .. } = builder;
    brep.uncertainty_mm = KERNEL.max(SLACK * gap);
    let faces = (0..brep.faces.len()).map(FaceId).collect();
    brep.add_shell(Shell { faces, closed: !work.is_open() });
    let (gap, faults) = work.face_faults(&network, &mut brep, gap);
    let of = |(face, fault): (FaceId, ModelFault)| {
        let vertices = chain_of(&network, &brep, &fault).map_or(&[][..], |c| &c.mesh_vertices);
        SeamFault::near(&[patch_of[face.0]], vertices, fault.to_string())
    };
    none(faults.into_iter().map(of).collect())?;
    none(crossings(work, &brep, &network, &patch_of))?;
    none(corner_poles(work, &brep, &network, &patch_of))?;
    brep.check().map_err(|fault| {
        let faces = faces_of(&brep, &fault).into_iter().map(|face| patch_of[face]);
        let vertices = chain_of(&network, &brep, &fault).map_or(&[][..], |c| &c.mesh_vertices);
        vec![SeamFault::near(&faces.collect::<Vec<_>>(), vertices, fault.to_string())]
    })?;
    work.guard(&brep, &strips, &patch_of, &free)?;
    let of_face =
        |(&i, triangles): (&usize, Vec<u32>)| FacePatch { triangles, ..work.made_patch(i, &free) };
    let patches = patch_of.iter().zip(triangles).map(of_face).collect();
    Ok(BuiltShell { brep, gap, patches })
}

/// An error unless there are no faults.
pub(super) fn none(faults: Vec<SeamFault>) -> Result<(), Vec<SeamFault>> {
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// The faces that have a corner at a pole or an apex. STEP has no edge there, and kernels find no closed loop.
fn corner_poles(
    work: &Work,
    brep: &Brep,
    network: &ChainNetwork,
    patch_of: &[usize],
) -> Vec<SeamFault> {
    let of = |(face, vertex): (FaceId, VertexId)| {
        let i = patch_of[face.0];
        let place =
            if work.patches[i].surface.kind() == PrimitiveKind::Cone { "apex" } else { "pole" };
        let at: Vec<u32> = network.junctions.get(vertex.0).copied().into_iter().collect();
        SeamFault::near(&[i], &at, format!("a border with a corner at the {place}"))
    };
    brep.corner_poles().into_iter().map(of).collect()
}

/// The faces that a fault speaks of.
fn faces_of(brep: &Brep, fault: &ModelFault) -> Vec<usize> {
    let element = match fault {
        ModelFault::Nothing(e) | ModelFault::Range(e) | ModelFault::Leaves(e) => *e,
        ModelFault::Measures(e, _) | ModelFault::OffSurface(e, _) => *e,
        ModelFault::Open(e) | ModelFault::OpenInPlane(e) | ModelFault::Laps(e) => *e,
        ModelFault::WrongWay(e) | ModelFault::Vertex(e, _) => *e,
        ModelFault::Uses { edge, .. } => BrepElement::Edge(edge.0),
        _ => return Vec::new(),
    };
    match element {
        BrepElement::Face(n) | BrepElement::Loop(n, _) | BrepElement::Use(n, ..) => vec![n],
        BrepElement::Surface(n) => vec![n],
        BrepElement::Edge(n) => {
            let uses = brep.uses();
            uses.get(n).into_iter().flatten().map(|(face, _)| face.0).collect()
        }
        _ => Vec::new(),
    }
}

/// The chain of the edge that a fault speaks of.
fn chain_of<'a>(network: &'a ChainNetwork, brep: &Brep, fault: &ModelFault) -> Option<&'a Chain> {
    let edge = match *fault {
        ModelFault::Uses { edge, .. } => edge,
        ModelFault::OffSurface(BrepElement::Use(face, ring, n), _) => {
            brep.faces.get(face)?.loops.get(ring)?.get(n)?.edge
        }
        _ => return None,
    };
    network.chains.get(edge.0)
}

impl Work<'_> {
    /// Puts the points of chains onto both surfaces.
    fn refine(&self, network: &mut ChainNetwork) -> Result<(), Vec<SeamFault>> {
        let vertices = &network.vertices;
        let mut faults = Vec::new();
        for chain in &mut network.chains {
            let sides = [chain.left, chain.right];
            let [a, b] = sides.map(|i| &self.patches[i]);
            if let Some(ends) = chain.ends {
                let last = chain.points.len() - 1;
                chain.points[0] = vertices[ends[0]];
                chain.points[last] = vertices[ends[1]];
            }
            // The plane of a facet cuts the surface next to it.
            if !a.is_facet && !b.is_facet {
                chain.touches |= touch(&a.surface, &b.surface, &chain.points, chain.error);
            }
            let of = chain.clone();
            if let Err(why) = self.pair(&of).refine(chain) {
                faults.push(SeamFault::near(&sides, &chain.mesh_vertices, why));
            }
        }
        none(faults)
    }

    /// Chooses frames and seams, the largest faces first, and gives all closed chains a vertex.
    fn plans(&self, network: &mut ChainNetwork) -> Result<Vec<FacePlan>, Vec<SeamFault>> {
        let areas: Vec<f64> = self.patches.iter().map(|patch| patch.area(self.mesh)).collect();
        let mut order: Vec<usize> = (0..areas.len()).collect();
        order.sort_by(|&i, &j| areas[j].total_cmp(&areas[i]).then(i.cmp(&j)));
        let mut plans: Vec<Option<FacePlan>> = vec![None; areas.len()];
        let mut faults = Vec::new();
        for i in order {
            match self.plan(network, i) {
                Ok(plan) => plans[i] = Some(plan),
                Err(fault) => faults.push(fault),
            }
        }
        none(faults)?;
        for chain in 0..network.chains.len() {
            if network.chains[chain].ends.is_none() {
                let p = network.chains[chain].points[0];
                let vertex = network.vertices.len();
                network.vertices.push(p);
                network.chains[chain].ends = Some([vertex; 2]);
            }
        }
        Ok(plans.into_iter().flatten().collect())
    }

    /// Adds vertices and edges. Returns the largest distance of an edge from its surfaces and its vertices.
    fn edges(
        &self,
        network: &mut ChainNetwork,
        brep: &mut Brep,
        plans: &[FacePlan],
    ) -> Result<f64, Vec<SeamFault>> {
        brep.vertices = network.vertices.iter().map(|&p| array(p)).collect();
        let mut worst: f64 = 0.0;
        let mut faults = Vec::new();
        for number in 0..network.chains.len() {
            match self.edge(network, number, plans) {
                Ok((curve, off)) => {
                    worst = worst.max(off);
                    let ends = network.chains[number].ends.unwrap_or_default();
                    brep.add_edge(curve, ends.map(VertexId));
                }
                Err(EdgeFault { why, at }) => {
                    let chain = &network.chains[number];
                    let sides = [chain.left, chain.right];
                    let near = at.map(|at| beside(self.mesh, chain, at));
                    let vertices = near.unwrap_or_else(|| chain.mesh_vertices.clone());
                    faults.push(SeamFault::near(&sides, &vertices, why));
                }
            }
        }
        none(faults)?;
        Ok(worst)
    }

    /// The curve of a chain, which is turned round if that is necessary, and its distance from its surfaces.
    fn edge(
        &self,
        network: &mut ChainNetwork,
        number: usize,
        plans: &[FacePlan],
    ) -> Result<(BrepCurve, f64), EdgeFault> {
        let Chain { left, right, .. } = network.chains[number];
        let limit = self.limit_at(network.chains[number].error);
        let made = |chain: &Chain| match &chain.arch {
            Some(arch) => arch
                .curve([chain.points[0], chain.points[chain.points.len() - 1]])
                .map(|curve| (curve, 0.0)),
            None => self.pair(chain).curve_within(chain, limit),
        };
        let (mut curve, mut off) = made(&network.chains[number])?;
        if self.is_clockwise(&curve, [left, right], plans) {
            network.reverse(number);
            (curve, off) = made(&network.chains[number])?;
        }
        let mut off_planes = 0.0;
        if let Some(faces) = self.pair_of_faces(&network.chains[number]) {
            off_planes = faces.off_planes(&curve);
            if [left, right].iter().any(|&i| self.is_wall(i) || self.is_bent(i)) {
                off = faces.worst(&curve);
            }
        } else {
            off = 0.0;
        }
        let Some(ends) = network.chains[number].ends else {
            return Err(String::from("a chain without ends").into());
        };
        let [from, to] = curve.ends().map(Point::from);
        if ends[0] != ends[1] && (to - from).norm() < KERNEL {
            return Err(String::from("an edge without a length").into());
        }
        for (place, end) in [from, to].iter().zip(ends) {
            off = off.max((place - network.vertices[end]).norm());
        }
        // A distance that is not a number fails, too.
        if off_planes < EXACT && off < limit {
            Ok((curve, off))
        } else {
            let why = format!("an edge is {:.1e} mm off its faces", off.max(off_planes));
            let faces = self.pair_of_faces(&network.chains[number]);
            Err(EdgeFault { why, at: faces.map(|faces| faces.worst_place(&curve)) })
        }
    }

    /// The faults of faces, and the largest gap between edges and faces. The check measures it at more places than those who made the edges.
    fn face_faults(
        &self,
        network: &ChainNetwork,
        brep: &mut Brep,
        mut gap: f64,
    ) -> (f64, Vec<(FaceId, ModelFault)>) {
        loop {
            let faults = brep.face_faults();
            let allowed = |(_, fault): &(FaceId, ModelFault)| {
                let ModelFault::OffSurface(_, off) = *fault else { return None };
                let error = chain_of(network, brep, fault).map_or(0.0, |chain| chain.error);
                (off <= self.limit_at(error)).then_some(off)
            };
            let Some(off) = faults.iter().filter_map(allowed).reduce(f64::max) else {
                return (gap, faults);
            };
            gap = gap.max(off);
            brep.uncertainty_mm = KERNEL.max(SLACK * gap);
        }
    }

    /// Whether an arc runs clockwise in the plane of one of its faces, for which STEP has no pcurve.
    fn is_clockwise(&self, curve: &BrepCurve, sides: [usize; 2], plans: &[FacePlan]) -> bool {
        let BrepCurve::Ellipse(arc) = curve else { return false };
        let [x, y] = arc.axes().map(Vector::from);
        sides.iter().any(|&i| {
            !self.is_wall(i)
                && self.patches[i].surface.kind() == PrimitiveKind::Plane
                && x.cross(&y).dot(&Vector::from(plans[i].chart.frame.z())) < 0.0
        })
    }
}
