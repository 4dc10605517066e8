//! Trimming: every hole's rim, and every island's, as a closed curve in (u, v)
//! and as an edge in space that lies on the surface.
//!
//! The paper only says that the surface over a hole is trimmed away. Here the
//! rim's vertices are projected onto the fitted surface and a closed cubic
//! B-spline is fitted to their parameter points, with as few control points as
//! keep it near the rim, and with more where it would cross itself, another
//! loop or the edge of the patch.

mod closed;
mod crossing;

use crate::error::{Error, Result};
use crate::geometry::{Point, Uv, segment_distance};
use crate::spline::{Curve, Surface, curve_on_surface, foot_point};
use closed::ClosedCubic;
use crossing::Outline;

/// How near trim curves keep to rims.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Distance, in mm, between a rim's vertices and the trim curve that needs
    /// no more control points.
    pub tolerance: f64,
}

/// The rim of a hole, or of an island in one: vertices in order, the measured
/// surface to their left, with the parameter points that the parameterization
/// gave them.
#[derive(Debug, Clone)]
pub struct Rim {
    /// The hole's number.
    pub hole: usize,
    /// The number of the island in the hole; `None`: the rim is the hole's.
    pub island: Option<usize>,
    /// The position, among all rims, of the next one around this one: of an
    /// island its hole's, of a hole that of the island that it is in, if any.
    /// It comes before this one.
    pub within: Option<usize>,
    /// Its vertices.
    pub points: Vec<Point>,
    /// Their parameter points.
    pub uv: Vec<Uv>,
}

/// A hole cut out, or an island in it: the arcs of its loop, around a hole
/// clockwise in (u, v), around an island counter-clockwise, each with the edge
/// that it traces on the surface at the same parameter.
#[derive(Debug, Clone)]
pub struct TrimLoop {
    /// The hole's number.
    pub hole: usize,
    /// The island's number; `None`: the loop is the hole's.
    pub island: Option<usize>,
    /// The position, among all loops, of the next one around this one.
    pub within: Option<usize>,
    /// The arcs in the parameter plane.
    pub pcurves: Vec<Curve<2>>,
    /// The edges in space.
    pub edges: Vec<Curve<3>>,
}

/// How a loop turned out. Lengths are mm.
#[derive(Debug, Clone)]
pub struct LoopReport {
    /// The hole's number.
    pub hole: usize,
    /// The island's number, if the loop is one's.
    pub island: Option<usize>,
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

/// The trim loops of the given rims.
pub fn trim(
    surface: &Surface,
    rims: &[Rim],
    options: &Options,
) -> Result<(Vec<TrimLoop>, Vec<LoopReport>)> {
    let mut outlines: Vec<Outline> = Vec::with_capacity(rims.len());
    let mut loops = Vec::with_capacity(rims.len());
    let mut reports = Vec::with_capacity(rims.len());
    for rim in rims {
        let around = around(rims, rim);
        let (curve, outline) = rim_curve(surface, rim, (&outlines, &around), options)?;
        outlines.push(outline);
        let pcurves = curve.arcs();
        let edges: Vec<Curve<3>> =
            pcurves.iter().map(|c| curve_on_surface(surface, c, EDGE_ACCURACY)).collect();
        reports.push(LoopReport {
            hole: rim.hole,
            island: rim.island,
            control_points: pcurves.iter().map(|c| c.control.len()).sum(),
            max_off_surface: off_surface(surface, &pcurves, &edges),
            max_from_rim: distance_to_edges(&rim.points, &edges),
        });
        let Rim { hole, island, within, .. } = *rim;
        loops.push(TrimLoop { hole, island, within, pcurves, edges });
    }
    Ok((loops, reports))
}

/// The positions of all rims that run around one.
fn around(rims: &[Rim], rim: &Rim) -> Vec<usize> {
    std::iter::successors(rim.within, |&i| rims[i].within).collect()
}

/// The closed curve with the fewest control points that is near the rim and
/// crosses nothing; where none is near enough, the one with the most that
/// crosses nothing.
///
/// Rim vertices are taken at their feet on the surface. Feet of a ragged rim
/// can run across each other, while the parameter points of an embedding
/// cannot; so these are tried next.
fn rim_curve(
    surface: &Surface,
    rim: &Rim,
    (others, around): (&[Outline], &[usize]),
    options: &Options,
) -> Result<(ClosedCubic, Outline)> {
    let feet: Vec<Uv> =
        rim.points.iter().zip(&rim.uv).map(|(&p, &uv)| foot_point(surface, p, uv).0).collect();
    let mut fault = String::from("has too few vertices");
    for uv in [&feet, &rim.uv] {
        let mut best = None;
        for n in control_counts(rim.points.len()) {
            let Some(curve) = ClosedCubic::fit(surface, &rim.points, uv, n) else { continue };
            let outline = Outline::new(&curve);
            match outline.fault(others, around) {
                Some(f) => fault = f,
                None => {
                    let far = curve.distance(surface, &rim.points);
                    best = Some((curve, outline));
                    if far <= options.tolerance {
                        break;
                    }
                }
            }
        }
        if let Some(best) = best {
            return Ok(best);
        }
    }
    let which = if rim.island.is_some() { "around an island " } else { "" };
    Err(Error::Trim { hole: rim.hole, fault: format!("{which}{fault}"), at: rim.points[0] })
}

/// Even numbers of control points to try, up to six for every vertex of the
/// rim: that many follow teeth of single vertices.
fn control_counts(vertices: usize) -> impl Iterator<Item = usize> {
    let most = (6 * vertices).max(8);
    std::iter::successors(Some(6usize), |n| Some((n * 3 / 2).next_multiple_of(2)))
        .take_while(move |&n| n <= most)
}

fn off_surface(surface: &Surface, pcurves: &[Curve<2>], edges: &[Curve<3>]) -> f64 {
    let mut worst: f64 = 0.0;
    for (c, e) in pcurves.iter().zip(edges) {
        for span in e.knots.breaks().windows(2) {
            for i in 0..8 {
                let t = span[0] + (span[1] - span[0]) * (f64::from(i) + 0.5) / 8.0;
                let exact = surface.point(Uv::from(c.point(t)));
                worst = worst.max((e.point(t) - exact.coords).norm());
            }
        }
    }
    worst
}

/// The farthest of `points` from the edges, in mm, measured to chords of an
/// eighth of a knot span.
pub fn distance_to_edges(points: &[Point], edges: &[Curve<3>]) -> f64 {
    let lines: Vec<Vec<Point>> = edges.iter().map(polyline).collect();
    let nearest = |p: &Point| {
        let segments = lines.iter().flat_map(|line| line.windows(2));
        segments.map(|s| segment_distance(*p, s[0], s[1])).fold(f64::INFINITY, f64::min)
    };
    points.iter().map(nearest).fold(0.0, f64::max)
}

fn polyline(edge: &Curve<3>) -> Vec<Point> {
    let breaks = edge.knots.breaks();
    let mut line: Vec<Point> = Vec::with_capacity(8 * breaks.len());
    for span in breaks.windows(2) {
        let at = |i: i32| span[0] + (span[1] - span[0]) * f64::from(i) / 8.0;
        line.extend((0..8).map(|i| Point::from(edge.point(at(i)))));
    }
    line.extend(breaks.last().map(|&t| Point::from(edge.point(t))));
    line
}
