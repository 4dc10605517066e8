//! Loops along rims on a network of surfaces.
//!
//! The network and the rims go in. The [`NetworkCut`] comes out: the loops, divided where they cross
//! the tracks of the network, and the faces on their left. The vertices of a rim are brought to the
//! nearest places of the network (`places`). Where two neighbours are on different surfaces, the rim
//! crosses the tracks between them (`path`). On each surface a cubic B-spline follows the rim with as
//! few knots as its room allows (`follow`). At last the loops tell which faces are kept (`regions`).

mod path;
mod places;
mod regions;

use rayon::prelude::*;

use super::follow::Follower;
use super::{MAX_PIECES, Options};
use crate::error::Error;
use crate::geometry::{Bound, Point, Uv, Vector};
use crate::spline::{
    CertifiedLoop, Curve, CutArc, KnotVector, Network, NetworkCut, TrackNode, crossings,
    pieces_on_surface, runs,
};
use path::{NetworkPaths, RimRun};

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

impl NetworkRim {
    /// The length around the rim, in mm.
    pub(crate) fn length(&self) -> f64 {
        let next = self.points.iter().cycle().skip(1);
        self.points.iter().zip(next).map(|(a, b)| (b - a).norm()).sum()
    }
}

/// The least distance of a curve from the sides of the domain, as a share of a side. At a node the
/// curve leaves the side at once.
const MARGIN: f64 = 1e-4;

/// How often a room or a part of a rim is halved at most. It is then a few thousandths
/// as long.
const MOST_HALVINGS: usize = 12;

/// The reason why there is no loop along a rim.
#[derive(Debug, Clone)]
pub struct CutFault {
    /// Which boundary of the mesh the rim is.
    pub of: Bound,
    /// What is wrong with the loop.
    pub fault: &'static str,
    /// Where.
    pub at: Point,
    /// A surface there.
    pub surface: usize,
}

impl From<CutFault> for Error {
    fn from(fault: CutFault) -> Self {
        Error::Trim { of: fault.of, fault: fault.fault.to_owned(), at: fault.at }
    }
}

/// Computes the loops along the given rims, and the faces that they leave.
///
/// # Errors
/// [`CutFault`] if a rim is not near the surfaces, or a loop crosses itself or another loop, or leaves no
/// face.
pub fn cut(
    network: &Network,
    rims: &[NetworkRim],
    options: &Options,
) -> Result<NetworkCut, CutFault> {
    if rims.is_empty() {
        return Ok(NetworkCut::none(network));
    }
    let paths = NetworkPaths::new(network);
    let own: Vec<Options> =
        rims.par_iter().map(|rim| options.of_rim(&rim.points, &rim.normals)).collect();
    let traced = |(rim, own): (&NetworkRim, &Options)| {
        paths.runs(rim, own.rim).map_err(|at| CutFault {
            of: rim.of,
            fault: "is not on the faces",
            at,
            surface: paths.nearest_surface(at),
        })
    };
    let mut runs: Vec<Vec<RimRun>> =
        rims.par_iter().zip(&own).map(traced).collect::<Result<_, _>>()?;
    paths.spread(&mut runs, &own.iter().map(|own| own.rim).collect::<Vec<_>>());
    let on_surface = |surface: usize, fault: &'static str| {
        let is_on = |run: &&RimRun| run.face == surface && !run.points.is_empty();
        let rim = runs.iter().position(|of_rim| of_rim.iter().any(|run| is_on(&run)));
        let rim = rim.unwrap_or(0);
        let at = runs[rim].iter().find(is_on).map_or(rims[rim].points[0], |run| run.points[0].1);
        CutFault { of: rims[rim].of, fault, at, surface }
    };
    let mut fits = LoopFits::new(network, &runs, &own)
        .map_err(|surface| on_surface(surface, "has no length on a face"))?;
    let mut faulty = Vec::new();
    // Each round halves the room of the arcs of faulty faces.
    for _ in 0..MOST_HALVINGS {
        fits.tighten(&faulty);
        let mut cut = fits.cut(network);
        regions::add_faces(network, &mut cut)
            .map_err(|surface| on_surface(surface, "does not bound the faces"))?;
        faulty = faulty_surfaces(network, &cut);
        if faulty.is_empty() {
            return Ok(cut);
        }
    }
    Err(on_surface(faulty[0], "crosses itself"))
}

/// The arcs of all loops while they are fitted.
struct LoopFits<'a> {
    nodes: Vec<TrackNode>,
    /// For each arc its surface, its nodes, and its curve.
    arcs: Vec<(usize, Option<[usize; 2]>, Follower<'a>)>,
}

impl<'a> LoopFits<'a> {
    /// Each rim has its own options. Returns the surface on which a loop has no length if there is one.
    fn new(network: &'a Network, rims: &[Vec<RimRun>], options: &[Options]) -> Result<Self, usize> {
        let end = network.end();
        let range = [MARGIN * end, (1.0 - MARGIN) * end];
        let mut fits = LoopFits { nodes: Vec::new(), arcs: Vec::new() };
        for (runs, options) in rims.iter().zip(options) {
            let first = fits.nodes.len();
            let leaving = runs.iter().filter_map(|run| run.leaves);
            fits.nodes.extend(leaving.map(|c| TrackNode { track: c.track, at: c.at }));
            for (i, run) in runs.iter().enumerate() {
                let surface = &network.surfaces[run.face];
                let foot = |&(at, p): &(Uv, Point)| (at, (surface.point(at) - p).norm());
                let feet: Vec<_> = run.points.iter().map(foot).collect();
                let before = runs[(i + runs.len() - 1) % runs.len()].leaves;
                let (nodes, follower) = match (before, run.leaves) {
                    (Some(enters), Some(leaves)) => {
                        let ends = [
                            enters.sides[1].place(end, enters.at, 0.0),
                            leaves.sides[0].place(end, leaves.at, 0.0),
                        ];
                        let nodes = [(i + runs.len() - 1) % runs.len(), i].map(|k| first + k);
                        let between = Follower::between(surface, ends, &feet, options, range);
                        (Some(nodes), between)
                    }
                    _ => {
                        let around = Follower::around(surface, &feet, options, &[], range);
                        (None, around.map(|around| around.0))
                    }
                };
                fits.arcs.push((run.face, nodes, follower.ok_or(run.face)?));
            }
        }
        Ok(fits)
    }

    /// The cut without its faces.
    fn cut(&self, network: &Network) -> NetworkCut {
        let arc = |(surface, ends, follower): &(usize, Option<[usize; 2]>, Follower<'a>)| {
            let divided = |arc: Curve<2>| {
                let pieces = pieces_on_surface(&network.surfaces[*surface], &arc);
                let ends = runs(&pieces, MAX_PIECES, 1);
                ends.windows(2).map(|w| arc.part(w[0], w[1])).collect::<Vec<_>>()
            };
            let parts = follower.arcs().into_iter().flat_map(divided).collect();
            CutArc { surface: *surface, pcurves: parts, ends: *ends }
        };
        let arcs = self.arcs.par_iter().map(arc).collect();
        NetworkCut { nodes: self.nodes.clone(), arcs, faces: Vec::new() }
    }

    /// Brings the arcs on some surfaces nearer to their rims.
    fn tighten(&mut self, surfaces: &[usize]) {
        let faulty = self.arcs.iter_mut().filter(|arc| surfaces.contains(&arc.0));
        faulty.for_each(|arc| arc.2.tighten());
    }
}

/// The surfaces with a face whose loops cross themselves or each other.
fn faulty_surfaces(network: &Network, cut: &NetworkCut) -> Vec<usize> {
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
