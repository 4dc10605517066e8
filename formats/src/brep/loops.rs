//! Checks of the loops of faces.

use super::check::{Checked, distance};
use super::{Brep, BrepElement, BrepSurface, EdgeUse, Face, FaceId, ModelFault, PCurve, VertexId};

/// The number of parts of each span at whose ends an edge and its pcurve are compared. The error of
/// a cubic fit has its maxima between the ends of a span, and eight parts are enough to find each
/// maximum.
const PARTS: usize = 8;

/// A loop in the parameter plane is closed if its gaps are smaller than this share of the surface's
/// range, or of the face where the range is infinite. Parameters that were rounded to decimal
/// digits have errors of this size.
const CLOSED: f64 = 1e-9;

impl Face {
    /// The sizes of the face's surroundings in u and v: those of its surface, or those of its
    /// pcurves where the surface is unbounded or periodic.
    pub(super) fn plane_sizes(&self, surface: &BrepSurface) -> [f64; 2] {
        let [low, high] = self.plane_bounds();
        let ranges = surface.ranges();
        [0, 1].map(|k| {
            let (from, to) = ranges[k];
            let range = to - from;
            if range.is_finite() { range } else { (high[k] - low[k]).max(f64::MIN_POSITIVE) }
        })
    }
}

/// The end of a pcurve and the start of the next one, if they are not the same point.
pub(super) fn jump(ring: &[EdgeUse], n: usize, sizes: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    let ends = |of_loop: &EdgeUse, at: bool| of_loop.pcurve.ends()[usize::from(at)];
    let [of_loop, next] = [&ring[n], &ring[(n + 1) % ring.len()]];
    let [end, start] = [ends(of_loop, of_loop.forward), ends(next, !next.forward)];
    let gap = |k: usize| (start[k] - end[k]).abs() / sizes[k];
    (gap(0).max(gap(1)) > CLOSED).then_some([end, start])
}

impl Brep {
    /// The corners of faces that are the pole of a sphere or the apex of a cone: the faces with their
    /// vertices there. OpenCASCADE finds such faces in a STEP file valid only after healing, because
    /// STEP has no edge there. It is better to choose the axis of a sphere so that its poles are
    /// outside of the face, or at the end of a seam edge.
    pub fn corner_poles(&self) -> Vec<(FaceId, VertexId)> {
        let mut found = Vec::new();
        for (number, face) in self.faces.iter().enumerate() {
            for ring in &face.loops {
                for (n, jumps) in self.jumps(face, ring).into_iter().enumerate() {
                    let [towards, from] = [&ring[n], &ring[(n + 1) % ring.len()]];
                    if jumps && towards.edge != from.edge {
                        let ends = self.edges[towards.edge.0].ends;
                        found.push((FaceId(number), ends[usize::from(towards.forward)]));
                    }
                }
            }
        }
        found
    }

    /// For each use of a loop, whether the loop jumps at a pole from its pcurve to the next one. Gaps
    /// that are as small as the uncertainty are jumps nowhere else.
    pub(crate) fn jumps(&self, face: &Face, ring: &[EdgeUse]) -> Vec<bool> {
        let surface = &self.surfaces[face.surface.0];
        let sizes = face.plane_sizes(surface);
        let is_jump = |[from, _]: [[f64; 2]; 2]| {
            let Some(period) = surface.periods()[0] else { return surface.spline().is_some() };
            let across = surface.point(from[0] + 0.5 * period, from[1]);
            distance(surface.point(from[0], from[1]), across) <= self.uncertainty_mm
        };
        (0..ring.len()).map(|n| jump(ring, n, sizes).is_some_and(is_jump)).collect()
    }

    /// The jumps of each loop of a face at poles: the parameter points from which and to which it
    /// jumps.
    pub(crate) fn poles(&self, face: &Face) -> Vec<Vec<[[f64; 2]; 2]>> {
        let sizes = face.plane_sizes(&self.surfaces[face.surface.0]);
        let of_loop =
            |ring: &Vec<EdgeUse>| (0..ring.len()).filter_map(|n| jump(ring, n, sizes)).collect();
        face.loops.iter().map(of_loop).collect()
    }

    /// Checks that the loops of a face are closed and lie on its surface.
    pub(super) fn check_face(&self, number: usize, face: &Face) -> Checked {
        if face.loops.is_empty() {
            return Err(ModelFault::Nothing(BrepElement::Face(number)));
        }
        for ring in 0..face.loops.len() {
            self.check_loop(number, face, ring)?;
        }
        let [low, high] = face.plane_bounds();
        let periods = self.surfaces[face.surface.0].periods();
        let laps = |k: usize| periods[k].is_some_and(|p| high[k] - low[k] > p * (1.0 + CLOSED));
        match laps(0) || laps(1) {
            true => Err(ModelFault::Laps(BrepElement::Face(number))),
            false => Ok(()),
        }
    }

    fn check_loop(&self, number: usize, face: &Face, ring: usize) -> Checked {
        let uses = &face.loops[ring];
        let Some(mut before) = uses.last() else {
            return Err(ModelFault::Nothing(BrepElement::Loop(number, ring)));
        };
        let surface = &self.surfaces[face.surface.0];
        let sizes = face.plane_sizes(surface);
        let vertex = |of_loop: &EdgeUse, at: bool| self.edges[of_loop.edge.0].ends[usize::from(at)];
        let mut area = 0.0;
        for (n, of_loop) in uses.iter().enumerate() {
            let part = BrepElement::Use(number, ring, n);
            self.check_use(of_loop, surface, part)?;
            if vertex(of_loop, !of_loop.forward) != vertex(before, before.forward) {
                return Err(ModelFault::Open(part));
            }
            if let Some(gap) = jump(uses, (n + uses.len() - 1) % uses.len(), sizes) {
                if !self.is_pole(surface, gap) {
                    return Err(ModelFault::OpenInPlane(part));
                }
                area += triangle(gap);
            }
            before = of_loop;
            area += enclosed(&of_loop.pcurve) * if of_loop.forward { 1.0 } else { -1.0 };
        }
        if (area > 0.0) == ((ring == 0) == face.forward) {
            return Ok(());
        }
        Err(ModelFault::WrongWay(BrepElement::Loop(number, ring)))
    }

    /// Whether the line between two parameter points is one point in space: a pole or an apex.
    fn is_pole(&self, surface: &BrepSurface, [from, to]: [[f64; 2]; 2]) -> bool {
        let place = |i: usize| {
            let share = i as f64 / PARTS as f64;
            let [u, v] = [0, 1].map(|k| from[k] + share * (to[k] - from[k]));
            surface.point(u, v)
        };
        (1..=PARTS).all(|i| distance(place(i), place(0)) <= self.uncertainty_mm)
    }

    /// Checks that an edge agrees with its pcurve.
    fn check_use(&self, of_loop: &EdgeUse, surface: &BrepSurface, part: BrepElement) -> Checked {
        let curve = &self.edges[of_loop.edge.0].curve;
        let pcurve = &of_loop.pcurve;
        if pcurve.spline().is_some_and(|spline| !spline.knots().are_clamped()) {
            return Err(ModelFault::Unclamped(part));
        }
        if pcurve.range() != curve.range() {
            return Err(ModelFault::Range(part));
        }
        let ranges = allowed(surface);
        // A torus that crosses itself ends on its axis.
        let beyond_axis = |v: f64| match surface {
            BrepSurface::Torus { major, minor, .. } => major + minor * v.cos() < -CLOSED * minor,
            _ => false,
        };
        let outside = |at: &[f64; 2]| {
            (0..2).any(|k| at[k] < ranges[k].0 || at[k] > ranges[k].1) || beyond_axis(at[1])
        };
        // Poles may be outside of the range although the curve is inside.
        let leaves = pcurve.spline().is_none_or(|spline| spline.poles().iter().any(outside));
        let mut breaks = [curve.breaks(), pcurve.breaks()].concat();
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        let mut worst: f64 = 0.0;
        for span in breaks.windows(2) {
            for k in 0..=PARTS {
                let t = span[0] + (span[1] - span[0]) * k as f64 / PARTS as f64;
                let at = pcurve.point(t);
                if leaves && outside(&at) {
                    return Err(ModelFault::Leaves(part));
                }
                worst = worst.max(distance(surface.point(at[0], at[1]), curve.point(t)));
            }
        }
        if worst > self.uncertainty_mm { Err(ModelFault::OffSurface(part, worst)) } else { Ok(()) }
    }
}

/// The ranges that pcurves may have. Those of B-spline surfaces are exact, because their knots are
/// those of the file. Other ranges end at poles and at ends of profiles, which pcurves reach except
/// for rounding.
fn allowed(surface: &BrepSurface) -> [(f64, f64); 2] {
    let ranges = surface.ranges();
    match surface {
        BrepSurface::Spline(_) => ranges,
        _ => ranges.map(|(low, high)| {
            let size = |x: f64| if x.is_finite() { x.abs() } else { 0.0 };
            let slack = CLOSED * size(low).max(size(high)).max(1.0);
            (low - slack, high + slack)
        }),
    }
}

/// The approximate contribution of a pcurve to the area that its loop encloses, from points of the
/// curve.
fn enclosed(pcurve: &PCurve) -> f64 {
    let breaks = pcurve.breaks();
    let spans = breaks.windows(2);
    let places =
        spans.flat_map(|s| (0..PARTS).map(|k| s[0] + (s[1] - s[0]) * k as f64 / PARTS as f64));
    let mut points: Vec<[f64; 2]> = places.map(|t| pcurve.point(t)).collect();
    points.push(pcurve.ends()[1]);
    points.windows(2).map(|p| triangle([p[0], p[1]])).sum()
}

/// The area of the triangle with the corners 0, p and q.
fn triangle([p, q]: [[f64; 2]; 2]) -> f64 {
    0.5 * (p[0] * q[1] - q[0] * p[1])
}
