//! One attempt: chains, vertices, curves, faces, and the checked solid.

use formats::Brep;
use formats::brep::{BrepCurve, BrepElement, FaceId, ModelFault, Shell, Solid, VertexId};

use super::chart::array;
use super::curves::Pair;
use super::faces::FaceBuilder;
use super::network::ChainNetwork;
use super::winding::FacePlan;
use super::{SeamFault, Work, contact};
use crate::geometry::{Point, Vector};
use crate::primitives::{Primitive, PrimitiveKind};

/// The flat faces of facets hold all their corners within so many mm: what files may state, less a fifth.
const FLAT: f64 = 8e-8;

/// The least uncertainty in mm: the precision of modelling kernels.
const KERNEL: f64 = 1e-7;

/// Edges may leave their faces by so much in mm, plus so many errors of vertices.
const LEAVES: f64 = 1e-6;
const LEAVES_ERRORS: f64 = 20.0;

/// Gaps are measured at some places only, and the uncertainty is larger by this.
const BETWEEN: f64 = 1.5;

/// Builds the solid of all patches.
pub(super) fn shell(work: &mut Work, name: &str) -> Result<(Brep, f64), SeamFault> {
    let mut network = work.network()?;
    work.place_vertices(&mut network)?;
    work.fit_facets(&network)?;
    work.refine(&mut network)?;
    let plans = work.plans(&mut network)?;
    work.refine(&mut network)?;
    let mut brep = Brep { name: name.into(), ..Brep::default() };
    let gap = work.edges(&mut network, &mut brep, &plans)?;
    let mut builder = FaceBuilder { work, network: &network, brep: &mut brep, gap };
    for (i, plan) in plans.iter().enumerate() {
        builder.face(i, plan)?;
    }
    let gap = builder.gap;
    let faces = (0..brep.faces.len()).map(FaceId).collect();
    let outer = brep.add_shell(Shell { faces, closed: true });
    brep.solids.push(Solid { outer, voids: Vec::new() });
    brep.uncertainty_mm = KERNEL.max(BETWEEN * gap);
    brep.check().map_err(|fault| SeamFault::new(&patch_of(&brep, &fault), fault.to_string()))?;
    work.guard(&brep)?;
    Ok((brep, gap))
}

/// The patches that a fault speaks of. The number of a face is that of its patch.
fn patch_of(brep: &Brep, fault: &ModelFault) -> Vec<usize> {
    let element = match fault {
        ModelFault::Nothing(e) | ModelFault::Range(e) | ModelFault::Leaves(e) => *e,
        ModelFault::Measures(e, _) | ModelFault::OffSurface(e, _) => *e,
        ModelFault::Open(e) | ModelFault::OpenInPlane(e) | ModelFault::Laps(e) => *e,
        ModelFault::WrongWay(e) | ModelFault::Vertex(e, _) => *e,
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

impl Work<'_> {
    /// Lays the planes of facets through their vertices.
    fn fit_facets(&mut self, network: &ChainNetwork) -> Result<(), SeamFault> {
        let mut places = self.mesh.points.clone();
        for (n, &v) in network.junctions.iter().enumerate() {
            places[v as usize] = network.vertices[n];
        }
        let mut bent = Vec::new();
        for (number, patch) in self.patches.iter_mut().enumerate().filter(|(_, p)| p.is_facet) {
            let mut normal = Vector::zeros();
            let mut corners = Vec::new();
            for &t in &patch.triangles {
                let [a, b, c] = self.mesh.triangles[t as usize].map(|v| places[v.index()]);
                normal += (b - a).cross(&(c - a));
                corners.extend([a, b, c]);
            }
            let Some(normal) = normal.try_normalize(f64::MIN_POSITIVE) else { continue };
            let sum: Vector = corners.iter().map(|p| p.coords).sum();
            let origin = match patch.triangles.len() {
                1 => corners[0],
                _ => Point::from(sum / corners.len() as f64),
            };
            patch.surface = Primitive::Plane { origin, normal };
            patch.side = 1.0;
            let off = |p: &Point| (p - origin).dot(&normal).abs() > FLAT;
            if patch.triangles.len() > 1 && corners.iter().any(off) {
                bent.push(number);
            }
        }
        if bent.is_empty() {
            Ok(())
        } else {
            Err(SeamFault::new(&bent, "a facet that is not flat"))
        }
    }

    /// Puts the points of chains onto both surfaces.
    fn refine(&self, network: &mut ChainNetwork) -> Result<(), SeamFault> {
        let vertices = &network.vertices;
        for chain in &mut network.chains {
            let [a, b] = [chain.left, chain.right];
            let [sa, sb] = [a, b].map(|i| &self.patches[i].surface);
            if let Some(ends) = chain.ends {
                let last = chain.points.len() - 1;
                chain.points[0] = vertices[ends[0]];
                chain.points[last] = vertices[ends[1]];
            }
            chain.touches |= contact::touch(sa, sb, &chain.points, chain.error);
            let pair = Pair { a: sa, b: sb, touches: chain.touches };
            pair.refine(chain).map_err(|why| SeamFault::new(&[a, b], why))?;
        }
        Ok(())
    }

    /// Chooses frames and seams, the largest faces first, and gives all closed chains a vertex.
    fn plans(&self, network: &mut ChainNetwork) -> Result<Vec<FacePlan>, SeamFault> {
        let area = |i: usize| -> f64 {
            let triangles = self.patches[i].triangles.iter();
            let of = |&t: &u32| self.mesh.area_vector(self.mesh.triangles[t as usize]).norm();
            triangles.map(of).sum()
        };
        let areas: Vec<f64> = (0..self.patches.len()).map(area).collect();
        let mut order: Vec<usize> = (0..areas.len()).collect();
        order.sort_by(|&i, &j| areas[j].total_cmp(&areas[i]).then(i.cmp(&j)));
        let mut plans: Vec<Option<FacePlan>> = vec![None; areas.len()];
        for i in order {
            plans[i] = Some(self.plan(network, i)?);
        }
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
    ) -> Result<f64, SeamFault> {
        brep.vertices = network.vertices.iter().map(|&p| array(p)).collect();
        let mut worst: f64 = 0.0;
        for number in 0..network.chains.len() {
            let mut chain = network.chains[number].clone();
            let sides = [chain.left, chain.right];
            let fault = |why: String| SeamFault::new(&sides, why);
            let pair = self.pair(chain.left, chain.right, chain.touches);
            let (mut curve, mut off) = pair.curve(&chain).map_err(fault)?;
            if self.is_clockwise(&curve, sides, plans) {
                network.reverse(number);
                chain = network.chains[number].clone();
                (curve, off) = pair.curve(&chain).map_err(fault)?;
            }
            let Some(ends) = chain.ends else { return Err(fault("a chain without ends".into())) };
            let places = curve.ends().map(Point::from);
            for (place, end) in places.iter().zip(ends) {
                off = off.max((place - network.vertices[end]).norm());
            }
            if !off.is_finite() || off > LEAVES + LEAVES_ERRORS * chain.error {
                return Err(fault(format!("an edge is {off:.1e} mm off its faces")));
            }
            worst = worst.max(off);
            brep.add_edge(curve, ends.map(VertexId));
        }
        Ok(worst)
    }

    /// Whether an arc runs clockwise in the plane of one of its faces, for which STEP has no pcurve.
    fn is_clockwise(&self, curve: &BrepCurve, sides: [usize; 2], plans: &[FacePlan]) -> bool {
        let BrepCurve::Ellipse(arc) = curve else { return false };
        let [x, y] = arc.axes().map(Vector::from);
        sides.iter().any(|&i| {
            self.patches[i].surface.kind() == PrimitiveKind::Plane
                && x.cross(&y).dot(&Vector::from(plans[i].chart.frame.z())) < 0.0
        })
    }
}
