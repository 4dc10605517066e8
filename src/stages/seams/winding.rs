//! How a face goes around its surface: its frame, and where its seam lies.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::chart::{Chart, around};
use super::curves::Pair;
use super::fallback::SeamFault;
use super::network::{ChainNetwork, ChainUse};
use super::{EXACT, Work};
use crate::geometry::{Point, Vector};
use crate::primitives::{Primitive, PrimitiveKind};

/// How a face goes around.
#[derive(Debug, Clone)]
pub(super) enum Wrap {
    /// It does not.
    Not,
    /// It is the whole sphere or the whole torus.
    Whole,
    /// Along u. The numbers of the loops that do so: two, or one around a pole.
    U(Vec<usize>),
    /// Along v of a torus: the two loops, and v of the seam.
    V(Vec<usize>, f64),
}

/// The frame of a face, and how it goes around.
#[derive(Debug, Clone)]
pub(super) struct FacePlan {
    pub chart: Chart,
    pub wrap: Wrap,
}

/// A loop keeps this angle from a seam that is no part of it.
const CLEAR: f64 = 0.02;

/// A sphere's pole is outside of a face if the cosine to all points is below this: 10°.
const POLE: f64 = 0.985;

/// A vertex lies on a seam if its angle is so close.
const ON_SEAM: f64 = 1e-9;

/// Neighbouring points of a chain never turn so far about an axis.
const JUMP: f64 = 1.5;

impl Work<'_> {
    /// Chooses the frame and the seam of a face. Its chains get vertices on the seam.
    pub(super) fn plan(&self, network: &mut ChainNetwork, i: usize) -> Result<FacePlan, SeamFault> {
        let surface = self.patches[i].surface;
        let axis = match surface.kind() {
            PrimitiveKind::Sphere => self.sphere_axis(network, i),
            _ => Vector::z(),
        };
        let fault = |why: &str| SeamFault::new(&[i], why);
        let mut chart = Chart::new(&surface, axis).map_err(|why| fault(&why))?;
        if surface.kind() == PrimitiveKind::Plane {
            return Ok(FacePlan { chart, wrap: Wrap::Not });
        }
        if network.loops[i].is_empty() {
            let is_whole = matches!(surface.kind(), PrimitiveKind::Sphere | PrimitiveKind::Torus);
            return match is_whole {
                true => Ok(FacePlan { chart, wrap: Wrap::Whole }),
                false => Err(fault("a face without a border")),
            };
        }
        let mut windings = self.windings(network, i, &chart);
        let winds = |windings: &[[i32; 2]], k: usize| -> Vec<usize> {
            (0..windings.len()).filter(|&n| windings[n][k] != 0).collect()
        };
        if windings.iter().any(|w| w[0].abs() + w[1].abs() > 1) {
            return Err(fault("a loop that goes around twice"));
        }
        let [in_u, in_v] = [0, 1].map(|k| winds(&windings, k));
        if let ([one], PrimitiveKind::Sphere) = (in_u.as_slice(), surface.kind())
            && f64::from(windings[*one][0]) * self.patches[i].side > 0.0
        {
            // The loop must lie above the pole that is inside.
            chart = Chart::new(&surface, -axis).map_err(|why| fault(&why))?;
            windings = self.windings(network, i, &chart);
        }
        let points = self.patch_points(i);
        match (in_u.len(), in_v.len()) {
            (0, 0) => {
                let mut all = points;
                all.extend(network.loops[i].iter().flat_map(|ring| network.ring_points(ring)));
                let u = widest_gap(&chart, &all);
                Ok(FacePlan { chart: chart.turned(&surface, u), wrap: Wrap::Not })
            }
            (0, 2) => {
                let v = self.seam_place(network, i, &chart, &in_v, 1);
                chart = chart.turned(&surface, widest_gap(&chart, &points));
                self.seam_vertices(network, i, &chart, &in_v, (1, v))?;
                Ok(FacePlan { chart, wrap: Wrap::V(in_v, v) })
            }
            (1 | 2, 0) => {
                if in_u.len() == 1
                    && (f64::from(windings[in_u[0]][0]) * self.patches[i].side > 0.0
                        || !matches!(surface, Primitive::Cone { .. } | Primitive::Sphere { .. }))
                {
                    return Err(fault("one loop goes around"));
                }
                let u = self.seam_place(network, i, &chart, &in_u, 0);
                chart = chart.turned(&surface, u);
                self.seam_vertices(network, i, &chart, &in_u, (0, 0.0))?;
                Ok(FacePlan { chart, wrap: Wrap::U(in_u) })
            }
            _ => Err(fault("loops that go around in a way that faces do not have")),
        }
    }

    fn patch_points(&self, i: usize) -> Vec<Point> {
        let triangles = self.patches[i].triangles.iter();
        triangles.flat_map(|&t| self.mesh.corners(self.mesh.triangles[t as usize])).collect()
    }

    /// How often each loop goes around along u and v.
    fn windings(&self, network: &ChainNetwork, i: usize, chart: &Chart) -> Vec<[i32; 2]> {
        let periods = chart.surface.periods();
        let rings = network.loops[i].iter();
        let winding = |ring: &Vec<ChainUse>| {
            let uv = chart.unwrapped(&network.ring_points(ring), None);
            let (first, last) = (uv[0], uv[uv.len() - 1]);
            [0, 1].map(|k| periods[k].map_or(0, |p| ((last[k] - first[k]) / p).round() as i32))
        };
        rings.map(winding).collect()
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
        let mut all: Vec<Point> = rings.concat();
        for &t in &self.patches[i].triangles {
            let corners = self.mesh.corners(self.mesh.triangles[t as usize]);
            all.push(Point::from(corners.iter().map(|p| p.coords).sum::<Vector>() / 3.0));
        }
        let worst = |axis: &Vector| {
            let towards = all.iter().filter_map(|p| (p - centre).try_normalize(0.0));
            towards.map(|d| d.dot(axis).abs()).fold(0.0, f64::max)
        };
        let mut best = (f64::INFINITY, Vector::z());
        for axis in candidates {
            let found = worst(&axis);
            if found < best.0 - 1e-6 {
                best = (found, axis);
            }
        }
        if best.0 < POLE { best.1 } else { through.first().copied().unwrap_or(best.1) }
    }

    /// The angle of the seam: at a vertex of the loops, else a quarter turn of the usual frame, clear of other loops.
    fn seam_place(
        &self,
        network: &ChainNetwork,
        i: usize,
        chart: &Chart,
        winding: &[usize],
        k: usize,
    ) -> f64 {
        let rings = network.loops[i].iter().enumerate();
        let mut others: Vec<[f64; 2]> = Vec::new();
        let mut own: Vec<Vec<f64>> = Vec::new();
        let mut vertices = Vec::new();
        for (number, ring) in rings {
            let uv = chart.unwrapped(&network.ring_points(ring), None);
            if winding.contains(&number) {
                let ends = ring.iter().filter_map(|of| network.chains[of.0].ends);
                let places = ends.flatten().map(|v| chart.parameters(network.vertices[v]).0[k]);
                vertices.extend(places);
                own.push(uv.iter().map(|uv| uv[k]).collect());
            } else {
                let values = uv.iter().map(|uv| uv[k]);
                let low = values.clone().fold(f64::INFINITY, f64::min);
                others.push([low, values.fold(f64::NEG_INFINITY, f64::max)]);
            }
        }
        let is_clear = |u: &f64| {
            others.iter().all(|[low, high]| {
                let (low, high) = (low - CLEAR, high + CLEAR);
                let above = u + TAU * ((low - u) / TAU).ceil();
                above > high
            }) && own.iter().all(|loop_around| crosses_once(loop_around, *u))
        };
        vertices.sort_unstable_by(f64::total_cmp);
        let score = |u: &f64| vertices.iter().filter(|v| around(*v - u).abs() < ON_SEAM).count();
        let mut best: Option<(usize, f64)> = None;
        let between = vertices.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let quarters = [0.0, FRAC_PI_2, PI, -FRAC_PI_2];
        for u in vertices.iter().copied().chain(quarters).chain(between) {
            if is_clear(&u) && best.is_none_or(|(found, _)| score(&u) > found) {
                best = Some((score(&u), u));
            }
        }
        let in_gap = || {
            let mut values: Vec<f64> = Vec::new();
            for [low, high] in &others {
                let steps = ((high - low) / CLEAR).ceil().max(1.0) as usize;
                values.extend((0..=steps).map(|n| low + (high - low) * n as f64 / steps as f64));
            }
            gap_middle(values)
        };
        best.map_or_else(in_gap, |(_, u)| u)
    }

    fn seam_vertices(
        &self,
        network: &mut ChainNetwork,
        i: usize,
        chart: &Chart,
        winding: &[usize],
        (k, seam): (usize, f64),
    ) -> Result<(), SeamFault> {
        let off = |p: Point| around(chart.parameters(p).0[k] - seam);
        for &number in winding {
            let ring = network.loops[i][number].clone();
            let ends = ring.iter().filter_map(|of| network.chains[of.0].ends);
            let mut places = ends.flatten().map(|v| network.vertices[v]);
            if places.any(|p| chart.off_seam(p, k, seam) < 0.5 * EXACT) {
                continue;
            }
            let Some((chain, after, p)) = self.on_seam(network, &ring, &off) else {
                return Err(SeamFault::new(&[i], "a loop that does not meet its seam"));
            };
            network.cut(chain, after, p);
        }
        Ok(())
    }

    /// The chain that crosses the seam, the point before it, and the place.
    fn on_seam(
        &self,
        network: &ChainNetwork,
        ring: &[ChainUse],
        off: &impl Fn(Point) -> f64,
    ) -> Option<(usize, usize, Point)> {
        for &(chain, _) in ring {
            let of = &network.chains[chain];
            let pair = self.pair(of.left, of.right, of.touches);
            for (after, ends) in of.points.windows(2).enumerate() {
                let [a, b] = [off(ends[0]), off(ends[1])];
                if a * b > 0.0 || (a - b).abs() > JUMP {
                    continue;
                }
                let at = |w: f64| pair.project(ends[0] + w * (ends[1] - ends[0]));
                let [mut low, mut high] = [0.0, 1.0];
                // Bisection to the last digit.
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if a * off(at(middle)) > 0.0 { low = middle } else { high = middle }
                }
                return Some((chain, after, at(high)));
            }
        }
        None
    }

    pub(super) fn pair(&self, left: usize, right: usize, touches: bool) -> Pair<'_> {
        Pair { a: &self.patches[left].surface, b: &self.patches[right].surface, touches }
    }
}

/// Whether a loop that goes around passes an angle once, and does not run along it.
fn crosses_once(angles: &[f64], u: f64) -> bool {
    let all = angles.iter().skip(1).map(|angle| around(angle - u));
    let off: Vec<f64> = all.filter(|off| off.abs() > ON_SEAM).collect();
    let Some(&last) = off.last() else { return false };
    let before = std::iter::once(last).chain(off.iter().copied());
    let passes = before.zip(&off).filter(|(a, b)| a * **b < 0.0 && (a - **b).abs() < PI).count();
    passes == 1 && angles.len() - 1 - off.len() < 2
}

fn loop_normal(ring: &[Point]) -> Option<Vector> {
    let first = *ring.first()?;
    let areas = ring.windows(2).map(|w| (w[0] - first).cross(&(w[1] - first)));
    areas.sum::<Vector>().try_normalize(f64::MIN_POSITIVE)
}

/// The middle of the widest range of u without points.
fn widest_gap(chart: &Chart, points: &[Point]) -> f64 {
    gap_middle(points.iter().map(|&p| chart.parameters(p).0[0]).collect())
}

fn gap_middle(mut values: Vec<f64>) -> f64 {
    values.iter_mut().for_each(|v| *v = v.rem_euclid(TAU));
    values.sort_unstable_by(f64::total_cmp);
    let Some((&first, &last)) = values.first().zip(values.last()) else { return 0.0 };
    let mut best = (first + TAU - last, 0.5 * (first + TAU + last));
    for pair in values.windows(2) {
        if pair[1] - pair[0] > best.0 {
            best = (pair[1] - pair[0], 0.5 * (pair[0] + pair[1]));
        }
    }
    best.1
}
