//! Loops along rims on a network of surfaces.
//!
//! The network and the rims go in. The [`NetworkCut`] comes out: the loops, divided where they cross
//! the tracks of the network, and the faces on their left. The vertices of a rim are brought to the
//! nearest places of the network (`places`). Where two neighbours are on different surfaces, the rim
//! crosses the tracks between them (`path`). On each surface a cubic B-spline follows the rim with as
//! few knots as its room allows (`arcs`). At last the loops tell which faces are kept (`regions`).

mod arcs;
mod path;
mod places;
mod regions;

use rayon::prelude::*;

use super::{MAX_PIECES, Options, Rim, refusal};
use crate::error::Result;
use crate::geometry::{Bound, Point, Vector};
use crate::spline::{
    CertifiedLoop, Curve, CutArc, KnotVector, Network, NetworkCut, TrackNode, crossings,
    pieces_on_surface, runs,
};
use arcs::OpenPolygon;
use path::{NetworkPaths, Run};

/// A rim on a network: vertices in order with the measured surface to their left, and its normals.
#[derive(Debug, Clone)]
pub struct NetworkRim {
    /// Which boundary of the mesh this is.
    pub of: Bound,
    /// The vertices, in mm.
    pub points: Vec<Point>,
    /// The normals of the measured surface at the vertices.
    pub normals: Vec<Vector>,
}

/// The number of rounds in which the arcs of faulty faces are brought nearer to their rims.
const MAX_ROUNDS: usize = 6;

/// Computes the loops along the given rims, and the faces that they leave.
///
/// # Errors
/// [`Error::Trim`](crate::Error::Trim) if a loop crosses itself or another loop, or leaves no face.
pub fn cut(network: &Network, rims: &[NetworkRim], options: &Options) -> Result<NetworkCut> {
    if rims.is_empty() {
        return Ok(NetworkCut::none(network));
    }
    let fault = |rim: &NetworkRim, fault: &str| {
        let rim = Rim { of: rim.of, within: None, points: rim.points.clone(), uv: Vec::new() };
        refusal(&rim, fault, rim.points.first().copied().unwrap_or_default())
    };
    let paths = NetworkPaths::new(network);
    let traced = |rim: &NetworkRim| {
        paths.runs(rim, options.rim).ok_or_else(|| fault(rim, "is not on the faces"))
    };
    let mut runs: Vec<Vec<Run>> = rims.par_iter().map(traced).collect::<Result<_>>()?;
    paths.spread(&mut runs);
    let mut fits =
        LoopFits::new(network, &runs, options).ok_or_else(|| fault(&rims[0], "is a point"))?;
    for _ in 0..MAX_ROUNDS {
        let mut cut = fits.cut(network).ok_or_else(|| fault(&rims[0], "has no smooth curve"))?;
        regions::add_faces(network, &mut cut)
            .ok_or_else(|| fault(&rims[0], "does not bound the faces"))?;
        let faulty = faulty(network, &cut);
        if faulty.is_empty() {
            return Ok(cut);
        }
        fits.tighten(&faulty);
    }
    Err(fault(&rims[0], "crosses itself"))
}

/// The arcs of all loops while they are fitted.
struct LoopFits {
    nodes: Vec<TrackNode>,
    /// For each arc its surface, its nodes, and the polygon that it follows.
    arcs: Vec<(usize, Option<[usize; 2]>, OpenPolygon)>,
}

impl LoopFits {
    fn new(network: &Network, rims: &[Vec<Run>], options: &Options) -> Option<Self> {
        let end = network.end();
        let mut fits = LoopFits { nodes: Vec::new(), arcs: Vec::new() };
        for runs in rims {
            let first = fits.nodes.len();
            let leaving = runs.iter().filter_map(|run| run.leaves);
            fits.nodes.extend(leaving.map(|c| TrackNode { track: c.track, at: c.at }));
            for (i, run) in runs.iter().enumerate() {
                let surface = &network.surfaces[run.face];
                let room = |off: f64| options.room(off);
                let before = runs[(i + runs.len() - 1) % runs.len()].leaves;
                let (ends, nodes, points) = match (before, run.leaves) {
                    (Some(enters), Some(leaves)) => {
                        let ends = [
                            enters.sides[1].place(end, enters.at, 0.0),
                            leaves.sides[0].place(end, leaves.at, 0.0),
                        ];
                        let nodes = [(i + runs.len() - 1) % runs.len(), i].map(|k| first + k);
                        (ends, Some(nodes), &run.points[..])
                    }
                    _ => ([run.points.first()?.0; 2], None, &run.points[1..]),
                };
                let polygon = OpenPolygon::new(surface, ends, points, room)?;
                fits.arcs.push((run.face, nodes, polygon));
            }
        }
        Some(fits)
    }

    /// The cut without its faces.
    fn cut(&self, network: &Network) -> Option<NetworkCut> {
        let arc = |(surface, ends, polygon): &(usize, Option<[usize; 2]>, OpenPolygon)| {
            let curve = polygon.curve()?;
            let least = if ends.is_some() { 1 } else { 2 };
            let ends_of_parts =
                runs(&pieces_on_surface(&network.surfaces[*surface], &curve), MAX_PIECES, least);
            let parts = ends_of_parts.windows(2).map(|w| curve.part(w[0], w[1])).collect();
            Some(CutArc { surface: *surface, pcurves: parts, ends: *ends })
        };
        let arcs = self.arcs.par_iter().map(arc).collect::<Option<_>>()?;
        Some(NetworkCut { nodes: self.nodes.clone(), arcs, faces: Vec::new() })
    }

    /// Brings the arcs on some surfaces nearer to their rims.
    fn tighten(&mut self, surfaces: &[usize]) {
        let faulty = self.arcs.iter_mut().filter(|arc| surfaces.contains(&arc.0));
        faulty.for_each(|arc| arc.2.tighten());
    }
}

/// The surfaces with a face whose loops cross themselves or each other.
fn faulty(network: &Network, cut: &NetworkCut) -> Vec<usize> {
    let is_faulty = |face: &&crate::spline::KeptFace| {
        let loops = cut.boundary(network, face);
        let outlines = loops.iter().map(|curves| {
            let curves: Vec<Curve<2>> =
                curves.iter().map(|c| checkable(c, network.end())).collect();
            CertifiedLoop::new(&curves)
        });
        let outlines: Vec<_> = outlines.collect();
        let whole: Vec<&CertifiedLoop> = outlines.iter().flatten().collect();
        whole.len() < outlines.len() || !crossings(&whole).is_empty()
    };
    let cut_faces = cut.faces.par_iter().filter(|face| !face.is_whole());
    cut_faces.filter(is_faulty).map(|face| face.surface).collect()
}

/// The curve as a cubic in the middle of the unit square, where [`CertifiedLoop`] wants it.
fn checkable(curve: &Curve<2>, end: f64) -> Curve<2> {
    let middle = |p: &nalgebra::Vector2<f64>| (0.5 * p / end).add_scalar(0.25);
    if curve.knots.degree() == 3 {
        return Curve::new(curve.knots.clone(), curve.control.iter().map(middle).collect());
    }
    let (low, high) = curve.knots.range();
    let thirds = (0..4).map(|k| low + (high - low) * f64::from(k) / 3.0);
    let control = thirds.map(|t| middle(&curve.point(t))).collect();
    Curve::new(KnotVector::clamped(3, &[low, high], 1), control)
}
