//! Conversion of the loops of a face to closed polygons of its parameter plane.
//!
//! The input is the edges of the loops. The output is closed rings. On a surface that is periodic, each edge is moved
//! by whole periods to the end of the one before it. A loop may go around the surface, because its file has no seams.
//! Then it is closed by a line to another such loop, or to a pole.

use std::sync::Arc;

use formats::cad::{CadEdge, CadFace};
use nalgebra::Vector2;

use super::closure::Pole;
use super::surface::Domain;
use super::trace::{Trace, TracePoint, Tracer};
use crate::geometry::{NEGLIGIBLE, Uv, uv_bounds};
use crate::spline::ParametricSurface;

/// A corner of a ring.
#[derive(Debug, Clone, Copy)]
pub(super) struct RingCorner {
    pub(super) at: Uv,
    pub(super) point: crate::geometry::Point,
    /// Whether it is in the middle of a piece of an edge.
    pub(super) is_middle: bool,
    /// Whether the side that begins here is no edge, but a line across the face.
    pub(super) is_across: bool,
}

/// A closed polygon. The first corner is not repeated at the end.
pub(super) type Ring = Vec<RingCorner>;

/// The rings that bound a face.
pub(super) struct FaceOutline {
    pub(super) rings: Vec<Ring>,
    /// Whether the face is the whole surface without what the rings surround.
    pub(super) natural: bool,
}

/// A loop in the parameter plane. Its last corner is the image of the first one.
pub(super) struct TracedLoop {
    pub(super) corners: Ring,
    /// The number of times that it goes around in u and in v.
    pub(super) turns: [i32; 2],
    /// Whether it has a seam, whose two uses are a period apart.
    pub(super) has_seam: bool,
}

/// Seams are searched in loops of at most so many edges. Those of real faces have few.
const MOST_WITH_SEAMS: usize = 256;

impl Tracer<'_> {
    /// The rings of a face. Where the file has seams, they tell where the face is, and nothing depends on the
    /// direction of loops, which some files have wrong. Otherwise the face is to the left of its loops.
    ///
    /// # Errors
    /// An edge has no curve or is not on the surface, a loop does not close, or the loops do not bound a part of
    /// the surface.
    pub(super) fn outline(&mut self, face: &CadFace) -> Result<FaceOutline, String> {
        let all: Vec<Vec<&CadEdge>> =
            face.loops.iter().map(|edges| edges.iter().collect()).collect();
        let fault = match self.bounded(&all, face, face.forward) {
            Ok(outline) => return Ok(outline),
            Err(fault) if !self.surface.is_periodic() => return Err(fault),
            Err(fault) => fault,
        };
        let found = match face.forward {
            Some(forward) => self.bounded(&all, face, Some(!forward)),
            None => self.either_way(&all, face),
        };
        found
            .or_else(|_| self.bounded(&without_seams(&face.loops), face, face.forward))
            .map_err(|_| fault)
    }

    /// The rings of a face whose loops may run either way. Only one of the ways may bound a part of the surface, or
    /// both must bound the same part.
    fn either_way(
        &mut self,
        loops: &[Vec<&CadEdge>],
        face: &CadFace,
    ) -> Result<FaceOutline, String> {
        let [one, other] = [true, false].map(|forward| self.bounded(loops, face, Some(forward)));
        let size = |outline: &FaceOutline| -> f64 {
            outline.rings.iter().map(signed_area).sum::<f64>().abs()
        };
        match (one, other) {
            (Ok(one), Ok(other)) if (size(&one) - size(&other)).abs() > NEGLIGIBLE * size(&one) => {
                Err("nothing tells on which side of its loops it is".into())
            }
            (Ok(found), _) | (Err(_), Ok(found)) => Ok(found),
            (Err(fault), Err(_)) => Err(fault),
        }
    }

    fn bounded(
        &mut self,
        loops: &[Vec<&CadEdge>],
        face: &CadFace,
        forward: Option<bool>,
    ) -> Result<FaceOutline, String> {
        let mut traced = Vec::with_capacity(loops.len());
        for edges in loops {
            traced.extend(self.traced(edges, forward)?);
        }
        let (around, mut rings): (Vec<_>, Vec<_>) =
            traced.into_iter().partition(|traced| traced.turns != [0; 2]);
        let goes_around = !around.is_empty();
        let has_seams = around.iter().chain(&rings).any(|traced| traced.has_seam);
        if goes_around {
            rings.push(self.closed(around, forward)?);
        }
        let mut rings: Vec<Ring> = rings.into_iter().map(|traced| traced.corners).collect();
        rings.iter_mut().for_each(close);
        rings.retain(|ring| ring.len() > 2);
        if rings.iter().flatten().any(|c| !c.at.iter().chain(c.point.iter()).all(|x| x.is_finite()))
        {
            return Err("a loop has a point with infinite coordinates".into());
        }
        self.bring_together(&mut rings);
        // The only loop of a face around a closed surface bounds what is outside of it, if it runs the other way.
        let area: f64 = rings.iter().map(signed_area).sum();
        let is_closed = !goes_around && !has_seams && self.surface.is_closed();
        // Curves in the parameter plane tell it: the face is inside of them.
        let has_pcurves = loops.iter().flatten().all(|edge| !edge.pcurves.is_empty());
        let is_told = face.forward.is_some() || face.natural || has_pcurves || rings.is_empty();
        if is_closed && !is_told {
            return Err("nothing tells on which side of its loops it is".into());
        }
        let complement = is_closed && face.forward.is_some_and(|forward| (area < 0.0) == forward);
        let natural = face.natural || rings.is_empty() || complement;
        if natural && self.surface.has_two_parts() {
            return Err("nothing tells which part between the poles of its surface it is".into());
        }
        Ok(FaceOutline { natural, rings })
    }

    /// A loop in the parameter plane. `None` if it has no edges with a length.
    fn traced(
        &mut self,
        edges: &[&CadEdge],
        forward: Option<bool>,
    ) -> Result<Option<TracedLoop>, String> {
        let (mut all, mut taken): (Ring, Vec<_>) = (Vec::new(), Vec::new());
        let (mut by_pcurve, mut middles) = ([false; 2], Vec::new());
        // Do not begin with a seam edge, because nothing tells which of its two pcurves is meant.
        let first = edges.iter().position(|edge| edge.pcurves.len() < 2).unwrap_or(0);
        for edge in edges[first..].iter().chain(&edges[..first]) {
            let last = all.last().map(|c| c.at);
            let Some(trace) = self.edge(edge, last, &mut taken)? else { continue };
            let Trace { mut corners, is_by_pcurve } = trace;
            if all.is_empty() {
                by_pcurve[0] = is_by_pcurve;
            } else {
                let shift = self.shift(&all, corners[0], by_pcurve[1] && is_by_pcurve, forward)?;
                corners.iter_mut().for_each(|corner| corner.0 += shift);
            }
            by_pcurve[1] = is_by_pcurve;
            middles.push(corners[corners.len() / 2]);
            let same = all.last().is_some_and(|last| last.at == corners[0].0);
            let corner = |(i, &(at, point)): (usize, &TracePoint)| RingCorner {
                at,
                point,
                is_middle: i % 2 == 1,
                is_across: false,
            };
            all.extend(corners.iter().enumerate().skip(usize::from(same)).map(corner));
        }
        let Some(&start) = all.first() else { return Ok(None) };
        let shift = self.shift(&all, (start.at, start.point), by_pcurve == [true; 2], forward)?;
        let turns = [0, 1].map(|axis| match self.surface.closure.periods[axis] {
            Some(period) => (shift[axis] / period).round() as i32,
            None => 0,
        });
        all.push(RingCorner { at: start.at + shift, is_middle: false, ..start });
        let has_seam = self.has_seam(&middles);
        Ok(Some(TracedLoop { corners: all, turns, has_seam }))
    }

    /// Whether two edges with these middles are the same edge, a period apart.
    fn has_seam(&self, middles: &[TracePoint]) -> bool {
        if middles.len() > MOST_WITH_SEAMS {
            return false;
        }
        let is_apart = |a: &TracePoint, b: &TracePoint| {
            (0..2).any(|axis| {
                let period = self.surface.closure.periods[axis];
                period.is_some_and(|period| (a.0[axis] - b.0[axis]).abs() > 0.5 * period)
            })
        };
        let is_seam = |(i, a): (usize, &TracePoint)| {
            let same = |b: &&TracePoint| (a.1 - b.1).norm() <= self.gap;
            middles[i + 1..].iter().filter(same).any(|b| is_apart(a, b))
        };
        middles.iter().enumerate().any(is_seam)
    }

    /// The vector by which the next edge of a loop is moved, so that it continues the loop so far. It consists of
    /// whole periods.
    fn shift(
        &self,
        ring: &Ring,
        start: TracePoint,
        by_pcurve: bool,
        forward: Option<bool>,
    ) -> Result<Vector2<f64>, String> {
        let Some(end) = ring.last() else { return Ok(Vector2::zeros()) };
        if let (Some(pole), true) = (self.pole(end.point), (end.point - start.1).norm() <= self.gap)
        {
            return self.shift_at_pole(*pole, ring, start, by_pcurve, forward);
        }
        let image = self.surface.image(start.0, end.at);
        let is_joined = self.joint_gap((end.at, end.point), (start.0, start.1)) <= self.gap;
        let shift = if is_joined { Vector2::zeros() } else { image - start.0 };
        let off = self.joint_gap((end.at, end.point), (start.0 + shift, start.1));
        if off <= self.gap {
            return Ok(shift);
        }
        let [x, y, z]: [f64; 3] = end.point.coords.into();
        Err(format!("a loop does not close on its surface, near ({x:.3}, {y:.3}, {z:.3}) mm"))
    }

    /// The same where two edges meet at a pole. There the loop turns about the pole, and the face is to its left.
    fn shift_at_pole(
        &self,
        pole: Pole,
        ring: &Ring,
        start: TracePoint,
        by_pcurve: bool,
        forward: Option<bool>,
    ) -> Result<Vector2<f64>, String> {
        let (end, axis) = (ring[ring.len() - 1], 1 - pole.axis);
        let gap = start.0[axis] - end.at[axis];
        let mut shift = Vector2::zeros();
        let Some(period) = self.surface.closure.periods[axis] else { return Ok(shift) };
        let least = NEGLIGIBLE * period;
        let turns = gap.abs() > least && gap.abs() <= period + least;
        if by_pcurve && turns {
            return Ok(shift);
        }
        let forward = forward.ok_or("nothing tells on which side of a pole the face is")?;
        let before = ring[ring.len().saturating_sub(2)].at[pole.axis];
        // Along a side of the parameter plane, a loop around a region runs towards higher u where v is low, towards
        // lower u where v is high, and the other way around for the sides of u.
        let is_low = before > pole.value;
        let rises = (is_low == (pole.axis == 1)) == forward;
        let wanted = if rises {
            gap - period * ((gap - least) / period).floor()
        } else {
            gap - period * ((gap + least) / period).ceil()
        };
        shift[axis] = wanted - gap;
        Ok(shift)
    }

    /// The largest distance of a corner from the next one, and from the line between their parameter
    /// points. This line is long where the file omits the edge of a pole.
    fn joint_gap(&self, end: TracePoint, start: TracePoint) -> f64 {
        let between =
            [0.25, 0.5, 3.0 / 4.0].map(|s| self.surface.point(end.0 + s * (start.0 - end.0)));
        let farthest = between.iter().chain([&start.1]).map(|p| (p - end.1).norm());
        farthest.fold(0.0, f64::max)
    }

    /// Moves rings by whole periods to the first one.
    fn bring_together(&self, rings: &mut [Ring]) {
        let middle = |ring: &Ring| {
            let [low, high] = uv_bounds(&ring.iter().map(|c| c.at).collect::<Vec<_>>());
            nalgebra::center(&low, &high)
        };
        let Some((first, others)) = rings.split_first_mut() else { return };
        let to = middle(first);
        for ring in others {
            let from = middle(ring);
            let shift = self.surface.image(from, to) - from;
            ring.iter_mut().for_each(|corner| corner.at += shift);
        }
    }
}

/// Removes the last corner of a ring, which repeats the first one.
fn close(ring: &mut Ring) {
    if let (Some(first), Some(last)) = (ring.first(), ring.last())
        && first.at == last.at
    {
        ring.pop();
    }
}

/// The area of a ring in the parameter plane. It is positive if the ring runs counter-clockwise.
pub(super) fn signed_area(ring: &Ring) -> f64 {
    let sides = ring.iter().zip(ring.iter().cycle().skip(1));
    0.5 * sides.map(|(a, b)| a.at.x * b.at.y - a.at.y * b.at.x).sum::<f64>()
}

/// The loops of a face without the edges that it uses once in each direction. A loop may fall apart, and two may
/// become one.
fn without_seams(loops: &[Vec<CadEdge>]) -> Vec<Vec<&CadEdge>> {
    let edges: Vec<&CadEdge> = loops.iter().flatten().collect();
    let (mut next, mut before) = (vec![0; edges.len()], vec![0; edges.len()]);
    let mut first = 0;
    for edges in loops {
        for i in 0..edges.len() {
            let (here, there) = (first + i, first + (i + 1) % edges.len());
            (next[here], before[there]) = (there, here);
        }
        first += edges.len();
    }
    // The uses of each curve, by its address. The order does not depend on the addresses.
    let mut uses = std::collections::HashMap::<_, Vec<usize>>::new();
    let mut is_left = vec![true; edges.len()];
    for (i, edge) in edges.iter().enumerate() {
        let Some(curve) = &edge.curve else { continue };
        let of_curve = uses.entry(Arc::as_ptr(curve)).or_default();
        let opposite = of_curve
            .iter()
            .position(|&j| edges[j].forward != edge.forward && edges[j].ends == edge.ends);
        let Some(opposite) = opposite else {
            of_curve.push(i);
            continue;
        };
        let j = of_curve.swap_remove(opposite);
        let (a, b, c, d) = (before[j], next[i], before[i], next[j]);
        (next[a], before[b]) = (b, a);
        (next[c], before[d]) = (d, c);
        is_left[i] = false;
        is_left[j] = false;
    }
    let mut left = Vec::new();
    for start in 0..edges.len() {
        let mut at = start;
        let mut of_loop = Vec::new();
        while is_left[at] {
            is_left[at] = false;
            of_loop.push(edges[at]);
            at = next[at];
        }
        if !of_loop.is_empty() {
            left.push(of_loop);
        }
    }
    left
}

/// The bounding box of some rings.
pub(super) fn ring_bounds(rings: &[Ring]) -> [Uv; 2] {
    uv_bounds(&rings.iter().flatten().map(|c| c.at).collect::<Vec<_>>())
}

/// The part of a surface that a face is on.
pub(super) fn bounded<'a>(domain: &Domain<'a>, outline: &FaceOutline) -> Domain<'a> {
    if outline.natural { domain.once() } else { domain.within(ring_bounds(&outline.rings)) }
}
