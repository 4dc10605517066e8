//! Prisms of five to eight sides: cylinders only if the part's own law of tessellation says so.

use std::f64::consts::{PI, TAU};

use super::competition::Claims;
use super::exact::ExactFacets;
use super::growth::{Evidence, GrownRegion, RegionMarks};
use super::search::samples;
use crate::geometry::{NONE, Point, plane_axes};
use crate::primitives::{FitOptions, OrientedPoint, Primitive, PrimitiveKind, fit, starts};

/// The sides of prisms that may be cylinders. Four are a box; nine turn less than the most that a curved face turns.
const SIDES: std::ops::RangeInclusive<usize> = 5..=8;

/// The edges of a prism of five sides turn by so much, and those of others by less.
pub(super) const WIDEST_TURN: f64 = TAU / 5.0;

/// Turns of a regular prism are equal to this angle (rad); float32 parts of usual sizes are far better.
const EQUAL_TURNS: f64 = 1e-3;

/// A regular prism that may stand for a cylinder.
#[derive(Debug, Clone, PartialEq)]
pub struct Prism {
    /// The number of its sides.
    pub sides: usize,
    /// The radius of the circle through its edges.
    pub radius: f64,
    /// A point of its axis.
    pub origin: Point,
    /// Whether it became a cylinder, because the other round faces of the part obey a law that predicts its sides.
    pub is_round: bool,
}

/// What a law of tessellation keeps below its bound, for a radius and a number of segments.
type Law = fn(f64, f64) -> f64;

/// Equal angles, equal sagittas, equal lengths.
const LAWS: [Law; 3] =
    [|_, n| TAU / n, |radius, n| radius * (1.0 - (PI / n).cos()), |radius, n| TAU * radius / n];

/// The laws that all round faces obey, each with the interval of its bound: `n` is the smallest number of segments that
/// keeps it.
fn laws(evidence: &ExactFacets, regions: &[GrownRegion]) -> Vec<(Law, [f64; 2])> {
    let steps: Vec<(f64, f64)> = regions
        .iter()
        .filter_map(|r| match r.surface() {
            Primitive::Cylinder { origin, axis, radius } => {
                Some((radius, segments(evidence, r, origin, axis)?))
            }
            _ => None,
        })
        .collect();
    if steps.is_empty() {
        return Vec::new();
    }
    let bounds = LAWS.map(|law| {
        let low = steps.iter().map(|&(r, n)| law(r, n)).fold(0.0, f64::max);
        let high = steps.iter().map(|&(r, n)| law(r, n - 1.0)).fold(f64::INFINITY, f64::min);
        (law, [low, high])
    });
    bounds.into_iter().filter(|(_, [low, high])| low <= high).collect()
}

/// The segments of a full turn of a cylinder of equal steps.
fn segments(
    evidence: &ExactFacets,
    region: &GrownRegion,
    origin: Point,
    axis: crate::geometry::Vector,
) -> Option<f64> {
    let (x, y) = plane_axes(axis);
    let mut angles: Vec<f64> = region
        .vertices
        .iter()
        .map(|&v| {
            let q = evidence.mesh.point(v) - origin;
            q.dot(&y).atan2(q.dot(&x))
        })
        .collect();
    angles.sort_unstable_by(f64::total_cmp);
    let mut gaps: Vec<f64> =
        angles.windows(2).map(|p| p[1] - p[0]).filter(|&g| g > EQUAL_TURNS).collect();
    gaps.sort_unstable_by(f64::total_cmp);
    let step = *gaps.get(gaps.len() / 2)?;
    let equal = gaps.iter().filter(|&&g| (g - step).abs() < EQUAL_TURNS).count();
    let n = TAU / step;
    // Most steps of a face that is cut by nothing are equal, and go round in a whole number.
    let is_regular = 2 * equal > gaps.len() && (n - n.round()).abs() < n * n * EQUAL_TURNS / TAU;
    (is_regular && n.round() > *SIDES.end() as f64).then(|| n.round())
}

/// Finds the prisms among left-over facets. Those that a law predicts become regions.
pub(super) fn find(
    evidence: &ExactFacets,
    claims: &mut Claims,
    keep_polygons: bool,
    marks: &mut RegionMarks,
) -> Vec<Prism> {
    let laws = laws(evidence, &claims.regions);
    let mut seen = vec![false; claims.of.len()];
    let mut prisms = Vec::new();
    for first in 0..claims.of.len() as u32 {
        let Some(ring) = ring(evidence, claims, first, &seen) else { continue };
        ring.iter().for_each(|&f| seen[f as usize] = true);
        let Some(growth) = cylinder(evidence, &ring, marks) else { continue };
        let Primitive::Cylinder { origin, radius, .. } = growth.surface() else { continue };
        let n = ring.len() as f64;
        let predicted = |&(law, [low, high]): &(Law, [f64; 2])| {
            law(radius, n) <= high && law(radius, n - 1.0) >= low
        };
        let is_round = !keep_polygons && laws.iter().any(predicted);
        prisms.push(Prism { sides: ring.len(), radius, origin, is_round });
        if is_round {
            let number = claims.regions.len() as u32;
            ring.iter().for_each(|&f| claims.of[f as usize] = number);
            claims.regions.push(growth);
        }
    }
    prisms
}

/// A closed ring of free facets with equal turns that begins with `first`.
fn ring(evidence: &ExactFacets, claims: &Claims, first: u32, seen: &[bool]) -> Option<Vec<u32>> {
    let is_free = |f: u32| claims.of[f as usize] == NONE && !seen[f as usize];
    if !is_free(first) {
        return None;
    }
    let start = evidence.facets.get(first);
    start.borders.iter().filter(|b| is_free(b.facet)).find_map(|border| {
        let sides = (TAU / border.dihedral).round() as usize;
        if !SIDES.contains(&sides) || (border.dihedral - TAU / sides as f64).abs() > EQUAL_TURNS {
            return None;
        }
        let axis = start.normal.cross(&evidence.facets.get(border.facet).normal).normalize();
        let mut ring = vec![first, border.facet];
        while let Some(next) = next(evidence, &ring, border.dihedral, |f| {
            is_free(f) && evidence.facets.get(f).normal.dot(&axis).abs() < EQUAL_TURNS
        }) {
            ring.push(next);
            if ring.len() > sides {
                return None;
            }
        }
        let last = evidence.facets.get(*ring.last()?);
        (ring.len() == sides && last.border(first).is_some()).then_some(ring)
    })
}

fn next(
    evidence: &ExactFacets,
    ring: &[u32],
    turn: f64,
    may_join: impl Fn(u32) -> bool,
) -> Option<u32> {
    let last = evidence.facets.get(*ring.last()?);
    let fits = last.borders.iter().filter(|b| (b.dihedral - turn).abs() < EQUAL_TURNS);
    fits.map(|b| b.facet).find(|f| !ring.contains(f) && may_join(*f))
}

/// The cylinder through all corners of a ring.
fn cylinder(evidence: &ExactFacets, ring: &[u32], marks: &mut RegionMarks) -> Option<GrownRegion> {
    let samples = samples(evidence, ring);
    let faces: Vec<OrientedPoint> = ring
        .iter()
        .map(|&f| {
            let facet = evidence.facets.get(f);
            OrientedPoint { centre: facet.centre, normal: facet.normal, area: facet.area }
        })
        .collect();
    let points: Vec<Point> = samples.iter().map(|s| s.at).collect();
    let start = starts(PrimitiveKind::Cylinder, &points, &faces, &[]).into_iter().next()?;
    let found = fit(start, &samples, &FitOptions::default())?;
    let side = evidence.side(&found.surface, ring);
    let growth = GrownRegion::new(evidence, found, side, ring, marks);
    (found.worst <= evidence.bound()).then_some(growth)
}
