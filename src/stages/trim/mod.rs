//! Trim loops along the rims of holes and islands and along the outer boundary.
//!
//! The input is the fitted surface and the rims as polygons. The output is one [`TrimLoop`] for
//! each rim: closed curves in (u, v) and the edges in space that they trace on the surface.
//!
//! Tekumalla and Cohen (2005) only say that the surface over a hole is trimmed away. Here the
//! vertices of a rim are projected onto the surface, and a closed cubic B-spline is fitted by
//! least squares to the polygon of their parameter points. The spline has a corner where the rim
//! has one. It has as few knots as keep it near the rim, and more where it would cross itself,
//! another loop or the edge of the patch.

mod corners;
mod follow;
mod least_squares;
mod loop_fit;
mod needles;
pub mod network;
mod polygon;
mod scatter;

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::error::{Error, Result, of};
use crate::geometry::{MOST_ROUNDS, NEGLIGIBLE, Point, Uv, Vector, bounds};
use crate::mesh::Bound;
use crate::rules;
use crate::spline::decimal;
use crate::spline::{
    CertifiedLoop, Curve, EdgeTree, LocatedFault, Nest, Surface, crossings, curve_on_surface,
    misplaced, off_surface, pieces_on_surface, runs,
};
use crate::statistics::{SIGNIFICANT, median};
use loop_fit::LoopFit;

/// Options of [`trim`]: how near trim curves keep to rims.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// The tolerance of the face, in mm. Where [`keeps_vertices`](Self::keeps_vertices) is set
    /// or [`rim`](Self::rim) is 0, it also bounds the distance of the loop from the vertices.
    /// A small value makes loops with many control points. A large value lets loops cut off
    /// details of the rim.
    pub tolerance: f64,
    /// How far a loop may be from its rim at most, in mm. A scan does not show more exactly where it
    /// ends. Within this distance the loop has as few control points as possible. A large value
    /// makes smooth loops that pass over details. At 0 the loop follows every tooth of its rim
    /// that is larger than half of the tolerance.
    pub rim: f64,
    /// How far a loop may be at least from a rim whose vertices lie on a fair curve, in mm. Each rim gets
    /// the scatter of its vertices about a fair curve, between this length and [`rim`](Self::rim).
    pub least_rim: f64,
    /// Whether every vertex of a rim must be within the tolerance of the face, even if
    /// [`rim`](Self::rim) would allow a larger distance.
    pub keeps_vertices: bool,
}

/// A loop that follows every tooth stays within this share of the tolerance from its rim. Other loops that
/// need not keep their vertices have at least this share of the rim tolerance as room. A smaller share
/// makes short spans where the surface is off the rim, which no loop can correct.
const ROOM_SHARE: f64 = 0.5;

/// A fair loop that keeps its vertices within the tolerance uses this share of the remaining
/// room. The rest is a reserve, because the loop may cut off vertices beside the rim by a little
/// more than vertices on it.
const KEPT_SHARE: f64 = 0.7;

/// The least room around the foot point of a vertex, as a share of the tolerance. It applies
/// where the surface is so far from the vertex that the tolerance would leave less room.
const LEAST_SHARE: f64 = 0.1;

/// The uncertainty of a rim, as a share of its edge length. A scanner measures its last point up
/// to one edge length before the end of the part, which is half an edge length on average.
const RIM_UNCERTAINTY: f64 = 0.5;

impl Options {
    /// Default options for the given rims. The rim tolerance is at most half of the median edge length
    /// of the rims, or `tolerance` if that is larger, and at least the noise for which `tolerance` stands.
    /// If the user has `named` the tolerance, it binds the vertices of the rims instead.
    pub fn of_rims<'a>(
        rims: impl Iterator<Item = &'a [Point]>,
        tolerance: f64,
        named: bool,
    ) -> Self {
        let rim = (RIM_UNCERTAINTY * median_edge(rims)).max(tolerance);
        let least_rim = if named { rim } else { tolerance / SIGNIFICANT };
        Options { tolerance, rim, least_rim, keeps_vertices: named }
    }

    /// The options for one rim, of which the vertices and the normals of the surface there are given.
    fn of_rim(&self, points: &[Point], normals: &[Vector]) -> Self {
        let known = || scatter::scatter(points, normals);
        match self.least_rim < self.rim {
            true => Options {
                rim: known().map_or(self.rim, |known| known.clamp(self.least_rim, self.rim)),
                ..*self
            },
            false => *self,
        }
    }

    /// The options for each rim on a surface.
    fn of_each(&self, surface: &Surface, rims: &[Rim]) -> Vec<Options> {
        let normal = |&at: &Uv| {
            let jet = surface.jet(at);
            jet.su.cross(&jet.sv).try_normalize(0.0).unwrap_or_default()
        };
        let own = |rim: &Rim| match self.least_rim < self.rim {
            true => self.of_rim(&rim.points, &rim.uv.iter().map(normal).collect::<Vec<_>>()),
            false => *self,
        };
        rims.par_iter().map(own).collect()
    }

    /// The largest distance that a loop may have from one of the rims, in mm. Without rims it is
    /// [`rim`](Self::rim).
    pub(crate) fn largest_rim(&self, surface: &Surface, rims: &[Rim]) -> f64 {
        let each = self.of_each(surface, rims).into_iter().map(|own| own.rim);
        each.reduce(f64::max).unwrap_or(self.rim)
    }

    /// The largest distance of a vertex from the surface, in mm, that leaves a trim curve room
    /// around the vertex's foot point within the tolerance.
    pub(crate) fn most_off(tolerance: f64) -> f64 {
        tolerance * (1.0 - LEAST_SHARE * LEAST_SHARE).sqrt()
    }

    /// Whether loops have as few control points as possible.
    fn is_fair(&self) -> bool {
        self.rim > 0.0
    }

    /// How far a trim curve may be from the foot point of a vertex, measured on the surface in
    /// mm. The vertex is at the distance `off` from the surface.
    fn room(&self, off: f64) -> f64 {
        let left = |of: f64| (of.powi(2) - off.powi(2)).max(0.0).sqrt();
        let within = left(self.tolerance).max(LEAST_SHARE * self.tolerance);
        match (self.is_fair(), self.keeps_vertices) {
            (false, _) => within.min(ROOM_SHARE * self.tolerance),
            (true, true) => (KEPT_SHARE * within).min(self.rim),
            (true, false) => left(self.rim).max(ROOM_SHARE * self.rim),
        }
    }
}

/// A rim to trim along: vertices in order with the measured surface to their left, and the
/// parameter points that the parameterization gave them.
#[derive(Debug, Clone)]
pub struct Rim {
    /// Which boundary of the mesh this is.
    pub of: Bound,
    /// The index of the next rim around this one, which must come before this one. For an
    /// island it is the rim of its hole. For a hole it is the rim of the island around it, or
    /// the outer rim if there is one.
    pub within: Option<usize>,
    /// The vertices, in mm.
    pub points: Vec<Point>,
    /// The parameter points of the vertices, one for each vertex.
    pub uv: Vec<Uv>,
}

impl Rim {
    /// The rim with only the vertices at the given positions.
    fn only(&self, kept: &[usize]) -> Rim {
        let points = kept.iter().map(|&i| self.points[i]).collect();
        Rim { points, uv: kept.iter().map(|&i| self.uv[i]).collect(), ..*self }
    }

    /// The rim with all lengths multiplied by a factor.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Rim {
        self.points.iter_mut().for_each(|p| p.coords *= factor);
        self
    }

    /// Checks that this rim can be at this position in the list of rims.
    fn check(&self, position: usize) -> Result<()> {
        if self.points.is_empty() || self.points.len() != self.uv.len() {
            return Err(Error::Input("a rim does not have one parameter point for each vertex"));
        }
        match self.within {
            Some(around) if around >= position => {
                Err(Error::Input("a rim is within a rim that does not come before it"))
            }
            _ => Ok(()),
        }
    }
}

/// The closed loop of a rim: pcurves in (u, v), each with the edge that it traces on the surface
/// at the same parameter. The loop of a hole runs clockwise in (u, v). The loops of an island and
/// of the outer boundary run counter-clockwise.
#[derive(Debug, Clone)]
pub struct TrimLoop {
    /// Which boundary of the mesh this is the loop of.
    pub of: Bound,
    /// The index of the next loop around this one.
    pub within: Option<usize>,
    /// The arcs in the parameter plane.
    pub pcurves: Vec<Curve<2>>,
    /// The edges in space, in mm, one for each pcurve.
    pub edges: Vec<Curve<3>>,
}

/// The quality of one loop. Lengths are in mm.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct LoopReport {
    /// Which boundary of the mesh the loop belongs to.
    pub of: Bound,
    /// The number of control points of all pcurves.
    pub control_points: usize,
    /// The largest distance between an edge and S(pcurve(t)).
    pub max_off_surface: f64,
    /// The largest distance of a rim vertex from the edges.
    pub max_from_rim: f64,
}

/// The largest distance between a 3D edge and the trace of its pcurve, in mm. Importers test
/// whether the two agree, and Boolean operations fail where they do not.
pub const EDGE_ACCURACY: f64 = 1e-7;

/// A bound on the number of rounding errors by which a surface and an edge on it differ at the
/// same parameter.
const ROUNDINGS: f64 = 128.0;

/// The largest distance between edges and the traces of their pcurves on a surface, in mm.
///
/// It is [`EDGE_ACCURACY`] as a rule. For a tiny surface it is a share of the surface's size. For
/// a surface that is so large, so far from the origin (kilometres) or so steep in its parameters
/// that double precision does not suffice, it is a multiple of the rounding error.
pub fn edge_accuracy(surface: &Surface) -> f64 {
    let [low, high] = bounds(surface.net.iter().map(|&p| Point::from(p)));
    let wanted = EDGE_ACCURACY.min(NEGLIGIBLE * (high - low).norm());
    let farthest = low.coords.amax().max(high.coords.amax());
    let rounded = f64::EPSILON * farthest.max(surface.speed());
    wanted.max(ROUNDINGS * rounded).max(f64::MIN_POSITIVE)
}

/// Computes the trim loops of the given rims, in the order of the rims.
///
/// # Errors
/// [`Error::Trim`] if a loop crosses itself, another loop or the edge of the patch.
/// [`Error::Option`] if a tolerance is not a valid length. [`Error::Input`] if a rim does not have
/// one parameter point for each vertex, or is within a rim that does not come before it.
pub fn trim(
    surface: &Surface,
    rims: &[Rim],
    options: &Options,
) -> Result<(Vec<TrimLoop>, Vec<LoopReport>)> {
    Ok(trace(surface, rims, arcs(surface, rims, options)?))
}

/// Computes the arcs of each rim's loop in the parameter plane.
///
/// # Errors
/// The same as those of [`trim`].
pub fn arcs(surface: &Surface, rims: &[Rim], options: &Options) -> Result<Vec<Vec<Curve<2>>>> {
    rules::length(options.tolerance).map_err(of("tolerance"))?;
    rules::extent(options.rim).map_err(of("rim_tolerance"))?;
    rules::extent(options.least_rim).map_err(of("rim_tolerance"))?;
    rims.iter().enumerate().try_for_each(|(i, rim)| rim.check(i))?;
    let mut arcs = uncrossed(surface, rims, &options.of_each(surface, rims))?;
    arcs.iter_mut().flatten().for_each(decimal::parameters);
    Ok(arcs)
}

/// Computes the edges in space of loops whose arcs are given. The surface and the rims may be
/// scaled copies of those that the arcs were computed for.
pub fn trace(
    surface: &Surface,
    rims: &[Rim],
    arcs: Vec<Vec<Curve<2>>>,
) -> (Vec<TrimLoop>, Vec<LoopReport>) {
    let accuracy = edge_accuracy(surface);
    let traced = |(rim, pcurves)| traced(surface, rim, pcurves, accuracy);
    let both = rims.par_iter().zip(arcs).map(traced);
    both.collect::<Vec<_>>().into_iter().unzip()
}

/// The median edge length of the given rims, in mm. It is 0 if there are no rims.
pub(crate) fn median_edge<'a>(rims: impl Iterator<Item = &'a [Point]>) -> f64 {
    let edges = |rim: &'a [Point]| {
        let next = rim.iter().cycle().skip(1);
        rim.iter().zip(next).map(|(a, b)| (b - a).norm())
    };
    let mut lengths: Vec<f64> = rims.flat_map(edges).collect();
    median(&mut lengths).unwrap_or(0.0)
}

/// Fits all loops and tightens them until none of them crosses itself, another loop or the edge
/// of the patch.
fn uncrossed(surface: &Surface, rims: &[Rim], options: &[Options]) -> Result<Vec<Vec<Curve<2>>>> {
    let nests: Vec<Nest> = rims.iter().map(|rim| nest(rims, rim)).collect();
    let initial = |(rim, options)| {
        let loop_fit = LoopFit::new(surface, rim, options);
        loop_fit.ok_or_else(|| refusal(rim, "is a point", rim.points[0]))
    };
    let mut fits: Vec<LoopFit> =
        rims.par_iter().zip(options).map(initial).collect::<Result<_>>()?;
    let mut round = 0;
    loop {
        let arcs: Vec<Vec<Curve<2>>> = fits.par_iter().map(LoopFit::arcs).collect();
        let faults = faults(&arcs, &nests);
        let Some(&(first, (fault, at))) = faults.first() else { return Ok(arcs) };
        let mut places: BTreeMap<usize, Vec<Option<f64>>> = BTreeMap::new();
        faults.iter().for_each(|(i, (_, at))| places.entry(*i).or_default().push(*at));
        // Where two loops cross, it is enough that one of them is tightened.
        let give_way = |(i, at): (usize, Vec<_>)| fits[i].tighten(&at, &options[i]).is_some();
        let better = places.into_iter().map(give_way).filter(|&given| given).count() > 0;
        round += 1;
        if round == MOST_ROUNDS || !better {
            let place = at.map_or(rims[first].points[0], |t| fits[first].vertex(t));
            return Err(refusal(&rims[first], &fault.to_string(), place));
        }
    }
}

/// The faults of the loops. If single loops have faults, only those are returned. Otherwise these
/// are the crossings of loops, and if there are none, the loops that lie on the wrong side of
/// another one.
fn faults(arcs: &[Vec<Curve<2>>], nests: &[Nest]) -> Vec<(usize, LocatedFault)> {
    let outlines: Vec<_> = arcs.par_iter().map(|arcs| CertifiedLoop::new(arcs)).collect();
    let single =
        |(i, o): (usize, &std::result::Result<_, LocatedFault>)| Some((i, *o.as_ref().err()?));
    let mut found: Vec<_> = outlines.iter().enumerate().filter_map(single).collect();
    let outlines: Vec<&CertifiedLoop> = outlines.iter().flatten().collect();
    if found.is_empty() {
        found = crossings(&outlines);
    }
    if found.is_empty() {
        found = misplaced(&outlines, nests);
    }
    found
}

fn refusal(rim: &Rim, fault: &str, at: Point) -> Error {
    Error::Trim { of: rim.of, fault: fault.to_owned(), at }
}

/// The orientation and nesting that the loop of a rim must have: clockwise around a hole,
/// counter-clockwise around measured material.
fn nest(rims: &[Rim], rim: &Rim) -> Nest {
    let around: Vec<usize> = std::iter::successors(rim.within, |&i| rims[i].within).collect();
    Nest { clockwise: matches!(rim.of, Bound::Hole(_)), around }
}

fn traced(
    surface: &Surface,
    rim: &Rim,
    pcurves: Vec<Curve<2>>,
    accuracy: f64,
) -> (TrimLoop, LoopReport) {
    let (pcurves, edges): (Vec<_>, Vec<_>) =
        pcurves.into_iter().flat_map(|c| divided(surface, &c, accuracy)).unzip();
    let off = |(pcurve, edge)| off_surface(surface, pcurve, edge);
    let Rim { of, within, .. } = *rim;
    let report = LoopReport {
        of,
        control_points: pcurves.iter().map(|c| c.control.len()).sum(),
        max_off_surface: pcurves.iter().zip(&edges).map(off).fold(0.0, f64::max),
        max_from_rim: distance_to_edges(&rim.points, &edges),
    };
    (TrimLoop { of, within, pcurves, edges }, report)
}

/// The largest number of polynomial pieces of an edge. CAD systems integrate along an edge with a
/// limited number of points. In OpenCASCADE the areas of extruded loop edges were up to 0.12 % off
/// with twenty pieces, and up to 2.7 % off without division.
const MAX_PIECES: usize = 16;

/// Divides a pcurve into parts and computes the edge in space that each part traces.
fn divided(surface: &Surface, pcurve: &Curve<2>, accuracy: f64) -> Vec<(Curve<2>, Curve<3>)> {
    let ends = runs(&pieces_on_surface(surface, pcurve), MAX_PIECES, 1);
    let part = |w: &[f64]| {
        let part = pcurve.part(w[0], w[1]);
        let mut edge = curve_on_surface(surface, &part, accuracy);
        decimal::lengths(&mut edge, accuracy);
        (part, edge)
    };
    ends.windows(2).map(part).collect()
}

/// The largest distance of any of `points` from the edges, in mm.
pub fn distance_to_edges(points: &[Point], edges: &[Curve<3>]) -> f64 {
    let tree = EdgeTree::new(edges);
    points.par_iter().map(|&p| tree.distance(p)).reduce(|| 0.0, f64::max)
}

#[cfg(test)]
mod tests;
