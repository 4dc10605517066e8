//! Trimming: every hole's rim, every island's, and the outer boundary where it is
//! cut along, as a closed curve in (u, v) and as edges in space that
//! lie on the surface.
//!
//! The paper only says that the surface over a hole is trimmed away. Here the
//! rim's vertices are projected onto the fitted surface and a closed cubic
//! B-spline is fitted to the polygon of their parameter points: with corners
//! where the rim has corners, with as few knots as keep it near the rim, and
//! with more where it would cross itself, another loop or the edge of the patch.

mod closed;
mod corners;
mod course;
mod fair;
mod needles;

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::error::{Error, Result, of};
use crate::geometry::{Point, Uv, bounds};
use crate::mesh::Bound;
use crate::rules;
use crate::spline::decimal;
use crate::spline::{
    CertifiedLoop, Curve, EdgeTree, LocatedFault, Nest, Surface, crossings, curve_on_surface,
    misplaced, off_surface, pieces_on_surface, runs,
};
use course::Course;

/// How near trim curves keep to rims.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// The tolerance of the face, in mm.
    pub tolerance: f64,
    /// How far, in mm, a loop may be from its rim: a scan does not tell better where it
    /// ends. Within this the loop has as few control points as it can. At 0 the loop follows
    /// every tooth of its rim that is larger than half of the tolerance.
    pub rim: f64,
    /// Whether every vertex of a rim must be within the tolerance of the face, although the
    /// loop may be farther than that from the rim.
    pub keeps_vertices: bool,
}

/// A loop that follows every tooth keeps to its rim within this share of the tolerance.
const SHARE: f64 = 0.5;

/// One that keeps its vertices within the tolerance uses this share of what that leaves:
/// it may cut off vertices beside the rim by a little more than those on it.
const KEPT_SHARE: f64 = 0.7;

/// Where the surface misses a vertex so far that the tolerance leaves less, a loop has room
/// of this share of the tolerance around the vertex's foot.
const LEAST_SHARE: f64 = 0.1;

/// The same where the rim tolerance rules. Less would make short spans where the surface
/// misses the rim, which no loop can mend.
const LEAST_OF_RIM: f64 = 0.5;

/// Where a scan ends is uncertain by this share of its edges there: a scanner sees the last
/// point up to a whole edge before the end, half of one in the mean.
const UNCERTAIN: f64 = 0.5;

impl Options {
    /// What suits some rims where nobody says how near loops shall be: half the median edge of
    /// the rims, or the tolerance if that is more. A tolerance that the user names binds
    /// the vertices at the rims, too.
    pub fn of_rims(rims: &[Rim], tolerance: f64, named: bool) -> Self {
        let rim = (UNCERTAIN * median_edge(rims)).max(tolerance);
        Options { tolerance, rim, keeps_vertices: named }
    }

    /// How far, in mm, a vertex may be off the surface if a trim curve is to have room
    /// around its foot within the tolerance.
    pub fn most_off(tolerance: f64) -> f64 {
        tolerance * (1.0 - LEAST_SHARE * LEAST_SHARE).sqrt()
    }

    /// Whether loops have as few control points as they can.
    fn is_fair(&self) -> bool {
        self.rim > 0.0
    }

    /// How far a trim curve may be, within the surface, from the foot of a vertex
    /// that is `off` the surface.
    fn room(&self, off: f64) -> f64 {
        let left = |of: f64| (of.powi(2) - off.powi(2)).max(0.0).sqrt();
        let within = left(self.tolerance).max(LEAST_SHARE * self.tolerance);
        match (self.is_fair(), self.keeps_vertices) {
            (false, _) => within.min(SHARE * self.tolerance),
            (true, true) => (KEPT_SHARE * within).min(self.rim),
            (true, false) => left(self.rim).max(LEAST_OF_RIM * self.rim),
        }
    }
}

/// A rim to cut along: vertices in order, the measured surface to their left, with
/// the parameter points that the parameterization gave them.
#[derive(Debug, Clone)]
pub struct Rim {
    /// Which rim.
    pub of: Bound,
    /// The position, among all rims, of the next one around this one: of an
    /// island its hole's, of a hole that of the island that it is in, or else the
    /// outer one, if there is a rim of that. It comes before this one.
    pub within: Option<usize>,
    /// Its vertices.
    pub points: Vec<Point>,
    /// Their parameter points.
    pub uv: Vec<Uv>,
}

impl Rim {
    /// The rim with the vertices at some positions only.
    fn only(&self, kept: &[usize]) -> Rim {
        let points = kept.iter().map(|&i| self.points[i]).collect();
        Rim { points, uv: kept.iter().map(|&i| self.uv[i]).collect(), ..*self }
    }

    /// The same with all lengths times a factor.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Rim {
        self.points.iter_mut().for_each(|p| p.coords *= factor);
        self
    }

    /// Whether it can be the rim at this position.
    fn check(&self, position: usize) -> Result<()> {
        if self.points.is_empty() || self.points.len() != self.uv.len() {
            return Err(Error::Input("a rim has not one parameter point a vertex"));
        }
        match self.within {
            Some(around) if around >= position => {
                Err(Error::Input("a rim is within one that does not come before it"))
            }
            _ => Ok(()),
        }
    }
}

/// The arcs of a rim's loop, around a hole clockwise in (u, v), around an island and
/// the whole patch counter-clockwise, each with the edge that it traces on the
/// surface at the same parameter.
#[derive(Debug, Clone)]
pub struct TrimLoop {
    /// Which rim's.
    pub of: Bound,
    /// The position, among all loops, of the next one around this one.
    pub within: Option<usize>,
    /// The arcs in the parameter plane.
    pub pcurves: Vec<Curve<2>>,
    /// The edges in space.
    pub edges: Vec<Curve<3>>,
}

/// How a loop turned out. Lengths are mm.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct LoopReport {
    /// Which rim's loop.
    pub of: Bound,
    /// Control points of the pcurves.
    pub control_points: usize,
    /// The farthest that an edge is from S(pcurve(t)).
    pub max_off_surface: f64,
    /// The farthest that a rim vertex is from the edges.
    pub max_from_rim: f64,
}

/// How near a 3D edge is to its pcurve's trace, in mm. Importers test whether
/// the two agree, and Boolean operations fail where they do not.
pub const EDGE_ACCURACY: f64 = 1e-7;

/// Edges of what is smaller than 0.1 mm are as near for its size as of that.
const EDGE_SHARE: f64 = 1e-6;

/// Evaluating a surface and an edge on it at one place makes them differ by some
/// roundings; by fewer than this.
const ROUNDINGS: f64 = 128.0;

/// How near edges are to their pcurves' traces on a surface, in mm: [`EDGE_ACCURACY`],
/// a share of the surface's size where it is tiny, and what doubles can tell where it
/// is so large, so far from the origin (kilometres) or so steep in its parameters that
/// they cannot tell that.
pub fn edge_accuracy(surface: &Surface) -> f64 {
    let [low, high] = bounds(surface.net.iter().map(|&p| Point::from(p)));
    let wanted = EDGE_ACCURACY.min(EDGE_SHARE * (high - low).norm());
    let farthest = low.coords.amax().max(high.coords.amax());
    let rounded = f64::EPSILON * farthest.max(surface.speed());
    wanted.max(ROUNDINGS * rounded).max(f64::MIN_POSITIVE)
}

/// Rounds in which loops that cross are tightened.
const ROUNDS: usize = 100;

/// The trim loops of the given rims.
///
/// # Errors
/// [`Error::Trim`]: a loop that crosses itself, another one or the edge of the patch.
/// [`Error::Option`]: a tolerance that is no length. [`Error::Input`]: a rim without
/// a parameter point a vertex, or within one that does not come before it.
pub fn trim(
    surface: &Surface,
    rims: &[Rim],
    options: &Options,
) -> Result<(Vec<TrimLoop>, Vec<LoopReport>)> {
    Ok(trace(surface, rims, arcs(surface, rims, options)?))
}

/// The arcs of each rim's loop in the parameter plane.
///
/// # Errors
/// Those of [`trim`].
pub fn arcs(surface: &Surface, rims: &[Rim], options: &Options) -> Result<Vec<Vec<Curve<2>>>> {
    rules::length(options.tolerance).map_err(of("tolerance"))?;
    rules::extent(options.rim).map_err(of("rim_tolerance"))?;
    rims.iter().enumerate().try_for_each(|(i, rim)| rim.check(i))?;
    let mut arcs = uncrossed(surface, rims, options)?;
    arcs.iter_mut().flatten().for_each(decimal::parameters);
    Ok(arcs)
}

/// The loops whose arcs are given, with their edges in space. The surface and the rims may
/// be those that the arcs were found on with all lengths times a factor.
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

/// The median length of the edges of some rims, in mm; 0 if there are none.
pub fn median_edge(rims: &[Rim]) -> f64 {
    let edges = |rim: &Rim| {
        let next = rim.points.iter().cycle().skip(1);
        rim.points.iter().zip(next).map(|(a, b)| (b - a).norm()).collect::<Vec<_>>()
    };
    let mut lengths: Vec<f64> = rims.iter().flat_map(edges).collect();
    if lengths.is_empty() {
        return 0.0;
    }
    let middle = lengths.len() / 2;
    *lengths.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The arcs of all loops, none of which crosses another one, itself or the edge
/// of the patch.
fn uncrossed(surface: &Surface, rims: &[Rim], options: &Options) -> Result<Vec<Vec<Curve<2>>>> {
    let nests: Vec<Nest> = rims.iter().map(|rim| nest(rims, rim)).collect();
    let begun = |rim| {
        let course = Course::new(surface, rim, options);
        course.ok_or_else(|| refusal(rim, "is a point", rim.points[0]))
    };
    let mut courses: Vec<Course> = rims.par_iter().map(begun).collect::<Result<_>>()?;
    let mut round = 0;
    loop {
        let arcs: Vec<Vec<Curve<2>>> = courses.par_iter().map(Course::arcs).collect();
        let wrong = wrong(&arcs, &nests);
        let Some(&(first, (fault, at))) = wrong.first() else { return Ok(arcs) };
        let mut places: BTreeMap<usize, Vec<Option<f64>>> = BTreeMap::new();
        wrong.iter().for_each(|(i, (_, at))| places.entry(*i).or_default().push(*at));
        // Where two loops cross it is enough that one of them gives way.
        let give_way = |(i, at): (usize, Vec<_>)| courses[i].tighten(&at, options).is_some();
        let better = places.into_iter().map(give_way).filter(|&given| given).count() > 0;
        round += 1;
        if round == ROUNDS || !better {
            let place = at.map_or(rims[first].points[0], |t| courses[first].vertex(t));
            return Err(refusal(&rims[first], &fault.to_string(), place));
        }
    }
}

/// The faults of the loops: those of single ones, else those of loops that
/// cross, else those of loops that are not in their places.
fn wrong(arcs: &[Vec<Curve<2>>], nests: &[Nest]) -> Vec<(usize, LocatedFault)> {
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

/// How the loop of a rim must lie: clockwise around a hole, counter-clockwise
/// around what was measured.
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

/// Polynomial pieces of an edge at the most. CAD systems integrate along an edge with a bounded
/// number of places: the sides of extruded edges of loops were up to 0.12 % off in OpenCASCADE
/// with twenty pieces, and up to 2.7 % undivided.
const MOST_PIECES: usize = 16;

/// A pcurve in parts, each with the edge in space that it traces.
fn divided(surface: &Surface, pcurve: &Curve<2>, accuracy: f64) -> Vec<(Curve<2>, Curve<3>)> {
    let ends = runs(&pieces_on_surface(surface, pcurve), MOST_PIECES, 1);
    let part = |w: &[f64]| {
        let part = pcurve.part(w[0], w[1]);
        let mut edge = curve_on_surface(surface, &part, accuracy);
        decimal::lengths(&mut edge, accuracy);
        (part, edge)
    };
    ends.windows(2).map(part).collect()
}

/// The farthest of `points` from the edges, in mm.
pub fn distance_to_edges(points: &[Point], edges: &[Curve<3>]) -> f64 {
    let tree = EdgeTree::new(edges);
    points.par_iter().map(|&p| tree.distance(p)).reduce(|| 0.0, f64::max)
}

#[cfg(test)]
mod tests;
