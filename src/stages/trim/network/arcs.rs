//! The fit of the part of a loop on one surface.

use nalgebra::{DMatrix, Vector2};

use super::MOST_HALVINGS;
use crate::geometry::{NEGLIGIBLE, Point, Uv};
use crate::spline::{Curve, KnotVector, Surface};

/// The number of samples of the polygon between two of its corners.
const SAMPLES: usize = 4;

/// The least distance of a curve from the sides of the domain, as a share of a side. At a node the
/// curve leaves the side at once.
const MARGIN: f64 = 1e-4;

/// A polygon in the parameter plane of a surface with fixed ends, and the curve that follows it.
#[derive(Debug, Clone)]
pub(crate) struct OpenPolygon {
    /// The corners.
    uv: Vec<Uv>,
    /// The length of the polygon on the surface up to each corner, as a share of the whole.
    at: Vec<f64>,
    /// For each corner what a step in u and in v is in space.
    metric: Vec<[f64; 3]>,
    /// How far the curve may be from each corner, in mm.
    room: Vec<f64>,
    /// The highest parameter of the surface.
    end: f64,
    /// The least distance of a curve from the sides of the domain, except at its ends.
    margin: f64,
}

impl OpenPolygon {
    /// The polygon from a node over some foot points to another node. `None` if it has no length.
    /// `room` says how far the curve may be from the foot point of a vertex at some distance from the
    /// surface.
    pub fn new(
        surface: &Surface,
        ends: [Uv; 2],
        points: &[(Uv, Point)],
        room: impl Fn(f64) -> f64,
    ) -> Option<Self> {
        let inner = points.iter().map(|&(at, p)| (at, room((surface.point(at) - p).norm())));
        let [first, last] = ends.map(|end| (end, room(0.0)));
        let all: Vec<(Uv, f64)> =
            std::iter::once(first).chain(inner).chain(std::iter::once(last)).collect();
        let jets: Vec<_> = all.iter().map(|corner| surface.jet(corner.0)).collect();
        let mut at = vec![0.0];
        for pair in jets.windows(2) {
            at.push(at[at.len() - 1] + (pair[1].s - pair[0].s).norm());
        }
        let whole = at[at.len() - 1];
        let end = surface.u.range().1;
        // Corners at one place get different parameters.
        let least = NEGLIGIBLE * whole / at.len() as f64;
        for i in 1..at.len() {
            at[i] = at[i].max(at[i - 1] + least);
        }
        let whole = at[at.len() - 1];
        at.iter_mut().for_each(|s| *s /= whole);
        let metric = jets
            .iter()
            .map(|jet| [jet.su.norm_squared(), jet.su.dot(&jet.sv), jet.sv.norm_squared()]);
        (whole > 0.0 && whole.is_finite()).then(|| OpenPolygon {
            at,
            metric: metric.collect(),
            end,
            margin: MARGIN * end,
            uv: all.iter().map(|corner| corner.0).collect(),
            room: all.iter().map(|corner| corner.1).collect(),
        })
    }

    /// Makes the room half as wide.
    pub(crate) fn tighten(&mut self) {
        self.room.iter_mut().for_each(|room| *room *= 0.5);
    }

    /// The curve with few knots that stays in the room around the corners. Its ends are those of the
    /// polygon.
    pub(crate) fn curve(&self) -> Option<Curve<2>> {
        // A whole loop has at least two edges.
        let is_closed = self.uv.first() == self.uv.last();
        let mut breaks = if is_closed { vec![0.0, 0.5, 1.0] } else { vec![0.0, 1.0] };
        let mut curve = self.fit(&breaks)?;
        for _ in 0..MOST_HALVINGS {
            let is_far = |i: usize| self.distance(&curve, i) > self.room[i];
            let inside = |span: &[f64]| {
                (0..self.at.len())
                    .filter(move |&i| span[0] <= self.at[i] && self.at[i] <= span[1])
                    .collect::<Vec<_>>()
            };
            let far = |span: &[f64]| {
                let held = inside(span);
                let between = held.windows(2).any(|pair| self.strays(&curve, pair[0]));
                held.len() > 1 && (between || held.into_iter().any(is_far))
            };
            let halves: Vec<f64> =
                breaks.windows(2).filter(|s| far(s)).map(|s| 0.5 * (s[0] + s[1])).collect();
            if halves.is_empty() {
                break;
            }
            breaks.extend(halves);
            breaks.sort_by(f64::total_cmp);
            curve = self.fit(&breaks)?;
        }
        Some(curve)
    }

    /// The distance in mm of the curve from a corner at the corner's parameter.
    fn distance(&self, curve: &Curve<2>, i: usize) -> f64 {
        self.length(curve.point(self.at[i]) - self.uv[i].coords, i)
    }

    /// Whether the curve leaves its room in the middle between a corner and the next one.
    fn strays(&self, curve: &Curve<2>, i: usize) -> bool {
        let t = 0.5 * (self.at[i] + self.at[i + 1]);
        let off = curve.point(t) - self.point(t).coords;
        self.length(off, i) > self.room[i].max(self.room[i + 1])
    }

    /// The length in mm of a step in the parameter plane at a corner.
    fn length(&self, off: Vector2<f64>, i: usize) -> f64 {
        let [a, b, c] = self.metric[i];
        (a * off.x * off.x + 2.0 * b * off.x * off.y + c * off.y * off.y).max(0.0).sqrt()
    }

    /// The point of the polygon at a parameter.
    fn point(&self, t: f64) -> Uv {
        let i = self.at.partition_point(|&s| s <= t).clamp(1, self.at.len() - 1);
        let share = (t - self.at[i - 1]) / (self.at[i] - self.at[i - 1]);
        self.uv[i - 1] + share * (self.uv[i] - self.uv[i - 1])
    }

    /// The cubic with these knots nearest to samples of the polygon, with the ends of the polygon.
    /// `None` if the equations are singular.
    fn fit(&self, breaks: &[f64]) -> Option<Curve<2>> {
        let knots = KnotVector::clamped(3, breaks, 1);
        let n = knots.functions();
        let (first, last) = (self.uv[0], self.uv[self.uv.len() - 1]);
        let mut gram = DMatrix::<f64>::zeros(n - 2, n - 2);
        let mut right = DMatrix::<f64>::zeros(n - 2, 2);
        for span in breaks.windows(2) {
            let held = self.at.iter().filter(|&&t| span[0] < t && t < span[1]).count();
            let count = SAMPLES * (held + 1);
            let step = (span[1] - span[0]) / count as f64;
            for k in 0..count {
                let t = span[0] + (k as f64 + 0.5) * step;
                let basis = knots.basis(t);
                let weights = &basis.derivative[0][..=3];
                let mut target = self.point(t).coords;
                for (k, &weight) in weights.iter().enumerate() {
                    let i = basis.first + k;
                    if i == 0 {
                        target -= weight * first.coords;
                    } else if i == n - 1 {
                        target -= weight * last.coords;
                    }
                }
                for (k, &own) in weights.iter().enumerate() {
                    let i = basis.first + k;
                    if i == 0 || i == n - 1 {
                        continue;
                    }
                    right[(i - 1, 0)] += step * own * target.x;
                    right[(i - 1, 1)] += step * own * target.y;
                    for (l, &other) in weights.iter().enumerate() {
                        let j = basis.first + l;
                        if j > 0 && j < n - 1 {
                            gram[(i - 1, j - 1)] += step * own * other;
                        }
                    }
                }
            }
        }
        let inner = gram.cholesky()?.solve(&right);
        let mut control = vec![first.coords];
        // A curve is where its control points are, so it stays in the domain.
        let within = |x: f64| x.clamp(self.margin, self.end - self.margin);
        control
            .extend((0..n - 2).map(|i| Vector2::new(within(inner[(i, 0)]), within(inner[(i, 1)]))));
        control.push(last.coords);
        Some(Curve::new(knots, control))
    }
}
