//! Trimming: every hole's rim, every island's, and the outer boundary where it is
//! cut along, as a closed curve in (u, v) and as one to four edges in space that
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
mod needles;

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::error::{Error, Result, of};
use crate::geometry::{Point, Uv, bounds, segment_distance};
use crate::mesh::Bound;
use crate::rules;
use crate::spline::{
    Curve, Nest, Outline, Place, Surface, crossings, curve_on_surface, misplaced, off_surface,
};
use course::Course;

/// How near trim curves keep to rims.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// The tolerance of the face, in mm.
    pub tolerance: f64,
    /// How far, in mm, a loop may be from its rim, within the surface. Where that is less
    /// than the tolerance leaves (at 0, say), the loop keeps to the tolerance.
    pub rim: f64,
}

/// Trim curves keep to the rims within this share of the tolerance, and to within
/// the lesser one of a vertex that the surface misses so far that no room is left.
const SHARE: f64 = 0.5;
const LEAST_SHARE: f64 = 0.1;

impl Options {
    /// How far, in mm, a vertex may be off the surface if a trim curve is to have room
    /// around its foot within the tolerance.
    pub fn most_off(&self) -> f64 {
        self.tolerance * (1.0 - LEAST_SHARE * LEAST_SHARE).sqrt()
    }

    /// How far a trim curve may be, within the surface, from the foot of a vertex
    /// that is `off` the surface.
    fn room(&self, off: f64) -> f64 {
        let left = (self.tolerance.powi(2) - off.powi(2)).max(0.0).sqrt();
        let left = left.clamp(LEAST_SHARE * self.tolerance, SHARE * self.tolerance);
        let floor: f64 = std::env::var("FLOOR").ok().and_then(|v| v.parse().ok()).unwrap_or(0.5);
        let fair = (self.rim.powi(2) - off.powi(2)).max((floor * self.rim).powi(2)).sqrt();
        left.max(fair)
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
    rules::length(options.tolerance).map_err(of("tolerance"))?;
    rims.iter().enumerate().try_for_each(|(i, rim)| rim.check(i))?;
    let arcs = uncrossed(surface, rims, options)?;
    let accuracy = edge_accuracy(surface);
    let traced = |(rim, pcurves)| traced(surface, rim, pcurves, accuracy);
    let both = rims.par_iter().zip(arcs).map(traced);
    Ok(both.collect::<Vec<_>>().into_iter().unzip())
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
fn wrong(arcs: &[Vec<Curve<2>>], nests: &[Nest]) -> Vec<(usize, Place)> {
    let outlines: Vec<_> = arcs.par_iter().map(|arcs| Outline::new(arcs)).collect();
    let single = |(i, o): (usize, &std::result::Result<_, Place>)| Some((i, *o.as_ref().err()?));
    let mut found: Vec<_> = outlines.iter().enumerate().filter_map(single).collect();
    let outlines: Vec<&Outline> = outlines.iter().flatten().collect();
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
    let (edges, max_off_surface) = edges(surface, &pcurves, accuracy);
    let Rim { of, within, .. } = *rim;
    let report = LoopReport {
        of,
        control_points: pcurves.iter().map(|c| c.control.len()).sum(),
        max_off_surface,
        max_from_rim: distance_to_edges(&rim.points, &edges),
    };
    (TrimLoop { of, within, pcurves, edges }, report)
}

/// Loops of a surface on the `surface` that is the same with all lengths times a factor. Their
/// edges are traced there anew, since how near they must be does not grow with it.
pub(crate) fn scaled(
    surface: &Surface,
    both: (Vec<TrimLoop>, Vec<LoopReport>),
    factor: f64,
) -> (Vec<TrimLoop>, Vec<LoopReport>) {
    if factor == 1.0 {
        return both;
    }
    let accuracy = edge_accuracy(surface);
    let scaled = |(ring, report): (TrimLoop, LoopReport)| {
        let (edges, max_off_surface) = edges(surface, &ring.pcurves, accuracy);
        let max_from_rim = factor * report.max_from_rim;
        (TrimLoop { edges, ..ring }, LoopReport { max_off_surface, max_from_rim, ..report })
    };
    let (loops, reports) = both;
    let both = loops.into_par_iter().zip(reports).map(scaled);
    both.collect::<Vec<_>>().into_iter().unzip()
}

/// The edges that arcs trace on a surface, and the farthest that one is from its trace.
fn edges(surface: &Surface, pcurves: &[Curve<2>], accuracy: f64) -> (Vec<Curve<3>>, f64) {
    let edges: Vec<Curve<3>> =
        pcurves.iter().map(|c| curve_on_surface(surface, c, accuracy)).collect();
    let off = |(pcurve, edge)| off_surface(surface, pcurve, edge);
    let farthest = pcurves.iter().zip(&edges).map(off).fold(0.0, f64::max);
    (edges, farthest)
}

/// The farthest of `points` from the edges, in mm, measured to chords of an
/// eighth of a knot span.
pub fn distance_to_edges(points: &[Point], edges: &[Curve<3>]) -> f64 {
    let spans: Vec<Chords> = edges.iter().flat_map(chords).collect();
    let nearest = |p: &Point| {
        spans.iter().fold(f64::INFINITY, |best, span| {
            if (p - span.line[0]).norm() - span.length > best {
                return best;
            }
            let sides = span.line.windows(2).map(|s| segment_distance(*p, s[0], s[1]));
            sides.fold(best, f64::min)
        })
    };
    points.par_iter().map(nearest).reduce(|| 0.0, f64::max)
}

/// The chords of one knot span, and how long they are together.
struct Chords {
    line: [Point; 9],
    length: f64,
}

fn chords(edge: &Curve<3>) -> Vec<Chords> {
    let of_span = |span: &[f64]| {
        let at = |i: usize| span[0] + (span[1] - span[0]) * i as f64 / 8.0;
        let line = std::array::from_fn(|i| Point::from(edge.point(at(i))));
        Chords { line, length: line.windows(2).map(|s| (s[1] - s[0]).norm()).sum() }
    };
    edge.knots.breaks().windows(2).map(of_span).collect()
}

#[cfg(test)]
mod tests;
