//! Where the parameter domain of a face is cut: a surface that goes around becomes a rectangle of one period.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::chart::{Chart, around};
use super::fallback::SeamFault;
use super::network::ChainNetwork;
use super::{EXACT, Work};
use crate::geometry::{Point, Vector};
use crate::primitives::{Primitive, PrimitiveKind};

/// The frame of a face, and where its domain begins: at u = 0, and on a torus at `v`.
#[derive(Debug, Clone)]
pub(super) struct FacePlan {
    pub chart: Chart,
    pub v: f64,
}

/// A loop keeps this angle from a cut that it does not cross, and passes a cut so steeply.
const CLEAR: f64 = 0.02;

/// A sphere's pole is outside of a face if the cosine to all points is below this: 10°.
const POLE: f64 = 0.985;

/// A cut so close beside a vertex leaves a short edge, of whose curve little is known.
const SHORT: f64 = 0.1;

/// A vertex lies on a cut if its angle is so close.
const ON_CUT: f64 = 1e-9;

/// Neighbouring points of a chain never turn so far about an axis.
const JUMP: f64 = 1.5;

/// A loop that touches a cut or runs along it is avoided at the cost of so many crossings.
const AVOIDED: usize = 4;

/// The vertices of a face that are tried as places of its cut.
const MOST_TRIED: usize = 16;

/// The points of a loop that the cost of a cut is counted on.
const MOST_COUNTED: usize = 500;

/// An angle at which a domain is cut.
#[derive(Debug, Clone, Copy)]
struct CutPlace {
    middle: f64,
    /// The width of the range around it that the face does not reach. It is 0 if the face is cut there.
    width: f64,
}

impl CutPlace {
    /// The same angle as the beginning of the domain. Readers move parameters that are far from the first period: the face
    /// is in it if it can be, and else around its beginning.
    fn begin(&self) -> f64 {
        if self.width == 0.0 {
            return around(self.middle);
        }
        let low = (self.middle + 0.5 * self.width).rem_euclid(TAU);
        let is_within = low + TAU - self.width <= TAU;
        low - 0.5 * self.width - if is_within { 0.0 } else { TAU }
    }
}

impl Work<'_> {
    /// Chooses the frame of a face and the cuts of its domain. Its chains get vertices where they cross the cuts.
    pub(super) fn plan(&self, network: &mut ChainNetwork, i: usize) -> Result<FacePlan, SeamFault> {
        let surface = self.patches[i].surface;
        let fault = |why: &str| SeamFault::new(&[i], why);
        let axis = match surface.kind() {
            PrimitiveKind::Sphere => self.sphere_axis(network, i),
            _ => Vector::z(),
        };
        let mut chart = Chart::new(&surface, axis).map_err(|why| fault(&why))?;
        if surface.kind() == PrimitiveKind::Plane || self.is_wall(i) {
            return Ok(FacePlan { chart, v: 0.0 });
        }
        let is_whole = matches!(surface.kind(), PrimitiveKind::Sphere | PrimitiveKind::Torus);
        if network.loops[i].is_empty() && !is_whole {
            return Err(fault("a face without a border"));
        }
        if surface.kind() == PrimitiveKind::Sphere && self.is_above(network, i, &chart) {
            // Readers want the loop above the pole that is inside.
            chart = Chart::new(&surface, -axis).map_err(|why| fault(&why))?;
        }
        let u = self.place_of_cut(network, i, &chart, 0).middle;
        chart = chart.turned(&surface, u);
        self.cut(network, i, &chart, (0, 0.0));
        let mut v = 0.0;
        if surface.kind() == PrimitiveKind::Torus {
            v = self.place_of_cut(network, i, &chart, 1).begin();
            self.cut(network, i, &chart, (1, v));
        }
        Ok(FacePlan { chart, v })
    }

    /// Whether the face is the part of a sphere above its only loop that goes around.
    fn is_above(&self, network: &ChainNetwork, i: usize, chart: &Chart) -> bool {
        let winding = |ring: &Vec<_>| {
            let uv = chart.unwrapped(&network.ring_points(ring), None);
            uv.last().zip(uv.first()).map_or(0.0, |(last, first)| last[0] - first[0])
        };
        let turns = network.loops[i].iter().map(winding).filter(|turn| turn.abs() > PI);
        let turns: Vec<f64> = turns.collect();
        turns.len() == 1 && turns[0] * self.patches[i].side > 0.0
    }

    /// The angle of a cut: outside of the face if it does not go around, else where the loops cross it least, at one of
    /// their vertices if there is one.
    fn place_of_cut(&self, network: &ChainNetwork, i: usize, chart: &Chart, k: usize) -> CutPlace {
        let rings = network.loops[i].iter().map(|ring| network.ring_points(ring));
        let rings: Vec<Vec<f64>> = rings
            .map(|ring| chart.unwrapped(&ring, None).iter().map(|uv| uv[k]).collect())
            .collect();
        let mut covered = self.arcs(i, chart, k);
        for ring in &rings {
            covered.extend(ring.windows(2).map(|w| [w[0].min(w[1]), w[0].max(w[1])]));
        }
        if let Some(gap) = widest_gap(covered) {
            return gap;
        }
        let ends = network.loops[i].iter().flatten().filter_map(|of| network.chains[of.0].ends);
        let places = ends.flatten().map(|v| chart.parameters(network.vertices[v]).0[k]);
        let mut vertices: Vec<f64> = places.collect();
        vertices.sort_unstable_by(f64::total_cmp);
        let stride = vertices.len().div_ceil(MOST_TRIED).max(1);
        let some = |ring: Vec<f64>| {
            let stride = ring.len().div_ceil(MOST_COUNTED).max(1);
            ring.into_iter().step_by(stride).collect()
        };
        let rings: Vec<Vec<f64>> = rings.into_iter().map(some).collect();
        let tried = || vertices.iter().copied().step_by(stride);
        let between = tried().zip(tried().skip(1)).map(|(a, b)| 0.5 * (a + b));
        let quarters = [0.0, FRAC_PI_2, PI, -FRAC_PI_2];
        let cost = |&angle: &f64| -> [usize; 3] {
            let crossed = |at: f64| rings.iter().map(|ring| crossings(ring, at)).sum::<usize>();
            let [low, here, high] = [-CLEAR, 0.0, CLEAR].map(|by| crossed(angle + by));
            let within =
                |most: f64| vertices.iter().filter(|v| around(*v - angle).abs() < most).count();
            let at_vertices = within(ON_CUT);
            let along = rings.iter().filter(|ring| runs_along(ring, angle)).count();
            let unclear = low.abs_diff(here) + high.abs_diff(here) + along;
            let beside_vertices = within(SHORT) - at_vertices;
            [here + AVOIDED * unclear, beside_vertices, vertices.len() - at_vertices]
        };
        let all = tried().chain(quarters).chain(between);
        CutPlace { middle: all.min_by_key(cost).unwrap_or(0.0), width: 0.0 }
    }

    /// The ranges of an angle that the triangles of a patch cover.
    fn arcs(&self, i: usize, chart: &Chart, k: usize) -> Vec<[f64; 2]> {
        let of = |&t: &u32| {
            let corners = self.mesh.corners(self.mesh.triangles[t as usize]);
            let found = corners.map(|p| chart.parameters(p));
            let is_around = |(_, is_pole): &([f64; 2], bool)| k == 1 || !is_pole;
            let mut angles = found.into_iter().filter(is_around).map(|(uv, _)| uv[k]);
            let Some(first) = angles.next() else { return [0.0; 2] };
            let (mut low, mut high, mut last) = (first, first, first);
            for angle in angles {
                last += around(angle - last);
                low = low.min(last);
                high = high.max(last);
            }
            // A triangle around a pole covers all.
            if (last + around(first - last) - first).abs() > PI { [0.0, TAU] } else { [low, high] }
        };
        self.patches[i].triangles.iter().map(of).collect()
    }

    /// Makes vertices where the loops of a face cross the line on which one parameter has a value.
    fn cut(&self, network: &mut ChainNetwork, i: usize, chart: &Chart, (k, at): (usize, f64)) {
        let mut left: Vec<usize> = network.loops[i].iter().flatten().map(|of| of.0).collect();
        while let Some(chain) = left.pop() {
            let Some((after, p)) = self.crossing_of(network, chain, chart, (k, at)) else {
                continue;
            };
            let count = network.chains.len();
            network.cut(chain, after, p);
            left.push(chain);
            left.extend(count..network.chains.len());
        }
    }

    /// The first point inside of a chain where it crosses a line, and the number of the point before it.
    fn crossing_of(
        &self,
        network: &ChainNetwork,
        chain: usize,
        chart: &Chart,
        (k, at): (usize, f64),
    ) -> Option<(usize, Point)> {
        let of = &network.chains[chain];
        let pair = self.pair(of);
        let off = |p: Point| match chart.parameters(p) {
            (_, true) if k == 0 => 0.0,
            _ if chart.off_seam(p, k, at) < EXACT => 0.0,
            (uv, _) => around(uv[k] - at),
        };
        let offs: Vec<f64> = of.points.iter().map(|&p| off(p)).collect();
        let last = offs.len() - 1;
        if of.ends.is_none() && offs[0] == 0.0 && last > 1 && passes(offs[last - 1], offs[1]) {
            return Some((0, of.points[0]));
        }
        let mut before: Option<usize> = None;
        for n in (0..=last).filter(|&n| offs[n] != 0.0) {
            let from = before.replace(n);
            let Some(from) = from.filter(|&from| passes(offs[from], offs[n])) else { continue };
            if n > from + 1 {
                return Some((from, of.points[from + 1]));
            }
            let [a, b] = [of.points[from], of.points[n]];
            let place = |w: f64| pair.project(a + w * (b - a));
            let [mut low, mut high] = [0.0, 1.0];
            // Bisection to the last digit.
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let is_before =
                    offs[from] * around(chart.parameters(place(middle)).0[k] - at) > 0.0;
                if is_before { low = middle } else { high = middle }
            }
            let p = place(high);
            // A place beside the cut would be found again and again.
            return (off(p) == 0.0).then_some((from, p));
        }
        None
    }

    /// An axis of a sphere that keeps the poles out of the face if there is one, else one through a loop.
    fn sphere_axis(&self, network: &ChainNetwork, i: usize) -> Vector {
        let Primitive::Sphere { centre, .. } = self.patches[i].surface else { return Vector::z() };
        let rings: Vec<Vec<Point>> =
            network.loops[i].iter().map(|ring| network.ring_points(ring)).collect();
        let through: Vec<Vector> = rings.iter().filter_map(|ring| loop_normal(ring)).collect();
        let mut candidates = vec![Vector::z(), Vector::x(), Vector::y()];
        candidates.extend(&through);
        for (x, y, z) in [(1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1)] {
            candidates.push(Vector::new(f64::from(x), f64::from(y), f64::from(z)).normalize());
        }
        for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            candidates.push(Vector::new(x, y, 1.0).normalize());
        }
        let towards = |p: &Point| (p - centre).try_normalize(0.0);
        let border: Vec<Vector> = rings.iter().flatten().filter_map(towards).collect();
        let of = |&t: &u32| self.mesh.corners(self.mesh.triangles[t as usize]).map(|p| p - centre);
        let triangles: Vec<[Vector; 3]> = self.patches[i].triangles.iter().map(of).collect();
        // The cosine to what is nearest of the face.
        let nearest = |pole: Vector| match triangles.iter().any(|corners| is_within(pole, corners))
        {
            true => 1.0,
            false => border.iter().map(|d| d.dot(&pole)).fold(-1.0, f64::max),
        };
        let best_of = |axes: &[Vector], worst: &dyn Fn(Vector) -> f64| {
            let mut best = (f64::INFINITY, None);
            for &axis in axes {
                let found = worst(axis);
                if found < best.0 - 1e-6 {
                    best = (found, Some(axis));
                }
            }
            best
        };
        if let (found, Some(axis)) = best_of(&candidates, &|axis| nearest(axis).max(nearest(-axis)))
            && found < POLE
        {
            return axis;
        }
        best_of(&through, &|axis| nearest(axis).min(nearest(-axis))).1.unwrap_or(candidates[0])
    }
}

/// Whether an angle passes zero between two values, and does not jump by a turn.
fn passes(a: f64, b: f64) -> bool {
    a * b < 0.0 && (a - b).abs() < JUMP
}

/// Whether a line runs along an angle.
fn runs_along(angles: &[f64], at: f64) -> bool {
    let is_on = |angle: f64| around(angle - at).abs() < ON_CUT;
    angles.windows(2).any(|w| is_on(w[0]) && is_on(w[1]))
}

/// How often a closed line crosses an angle.
fn crossings(angles: &[f64], at: f64) -> usize {
    let offs = angles.iter().map(|angle| around(angle - at)).filter(|off| off.abs() > ON_CUT);
    let offs: Vec<f64> = offs.collect();
    let Some(&last) = offs.last() else { return 0 };
    let before = std::iter::once(last).chain(offs.iter().copied());
    before.zip(&offs).filter(|(a, b)| passes(*a, **b)).count()
}

/// Whether a direction points into the triangle of three others.
fn is_within(direction: Vector, corners: &[Vector; 3]) -> bool {
    let [a, b, c] = corners;
    let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|normal| normal.dot(&direction));
    let ahead = (a + b + c).dot(&direction) > 0.0;
    ahead && (sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0))
}

fn loop_normal(ring: &[Point]) -> Option<Vector> {
    let first = *ring.first()?;
    let areas = ring.windows(2).map(|w| (w[0] - first).cross(&(w[1] - first)));
    areas.sum::<Vector>().try_normalize(f64::MIN_POSITIVE)
}

/// The widest range of an angle that no arc covers, if it is wide enough.
fn widest_gap(arcs: Vec<[f64; 2]>) -> Option<CutPlace> {
    let start = |arc: [f64; 2]| {
        let low = arc[0].rem_euclid(TAU);
        [low, low + arc[1] - arc[0]]
    };
    let mut arcs: Vec<[f64; 2]> = arcs.into_iter().map(start).collect();
    arcs.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let first = arcs.first()?[0];
    // What is beyond a turn covers the beginning.
    let mut end = arcs.iter().map(|arc| arc[1] - TAU).fold(f64::NEG_INFINITY, f64::max).max(first);
    let mut best = (2.0 * CLEAR, None);
    for [low, high] in arcs.into_iter().chain([[first + TAU; 2]]) {
        if low - end > best.0 {
            best = (low - end, Some(CutPlace { middle: 0.5 * (low + end), width: low - end }));
        }
        end = end.max(high);
    }
    best.1
}
