//! The control points of a patch at a corner in an irregular vertex.
//!
//! The outer rows are given by the tracks, and the rows beyond by the regular quads. Four control
//! points are left. They are fitted to the limit surface by least squares, and the patch is bound to
//! the limit normals along both spokes, so that the patches on both sides of a spoke have the same
//! tangent planes.

use nalgebra::{DMatrix, DVector};

use super::PatchSource;
use super::tracks::{Spoke, from_corner, limit_at};
use crate::geometry::{Point, Uv, Vector};
use crate::spline::subdivision::QuadPlace;
use crate::spline::{Basis, Surface, foot_point};

/// The four control points, counted from the corner.
const FREE: [(usize, usize); 4] = [(1, 1), (2, 1), (1, 2), (2, 2)];

/// The number of samples of the limit surface along each side of the quad, and of each spoke.
const SAMPLES: usize = 8;

/// The number of places in each span at which the normal of a patch is compared with that of the limit surface.
const INSIDE: usize = 3;

/// The weight of the slope against the limit normals along the spokes, beside that of distances. It
/// is large because a step between tangent planes is seen before a distance is.
const SLOPE: f64 = 100.0;

/// The weights of the distance of the four control points from a blend of the rows around them, of which
/// each corner takes the first one with small angles to the limit normals, or else the one with the
/// smallest. With less weight the parameters of a patch may turn back beside a spoke, and with more the
/// tangent planes of neighbours differ.
const BLENDS: [f64; 5] = [1.0, 0.1, 10.0, 100.0, 1e4];

/// The cosine of an angle to the limit normals that is small enough to end the choice (2°).
const SMOOTH: f64 = 0.9994;

/// The rounds of parameter correction.
const ROUNDS: usize = 3;

/// A linear least-squares problem in the coordinates of the four control points.
struct Equations {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
}

/// A corner of a patch, with parameters that run from the corner along both sides.
struct Corner {
    k: usize,
    count: usize,
    end: f64,
}

impl Corner {
    /// The position in the net of the control point (a, b), counted from the corner.
    fn at(&self, a: usize, b: usize) -> usize {
        let last = self.count - 1;
        let (i, j) = match self.k {
            0 => (a, b),
            1 => (last - b, a),
            2 => (last - a, last - b),
            _ => (b, last - a),
        };
        i * self.count + j
    }

    /// The parameter point of the patch at (x, y) from the corner.
    fn uv(&self, at: Uv) -> Uv {
        match self.k {
            0 => at,
            1 => Uv::new(self.end - at.y, at.x),
            2 => Uv::new(self.end - at.x, self.end - at.y),
            _ => Uv::new(at.y, self.end - at.x),
        }
    }

    /// The cosine of the largest angle between the normals of the patch and the limit normals along the
    /// spokes. It is less by one if the patch turns away from the limit normals on the quad, which
    /// `limit` gives for places counted from the corner.
    fn facing(&self, patch: &Surface, spokes: &[Spoke; 2], limit: impl Fn(Uv) -> Vector) -> f64 {
        let normal = |at: Uv| {
            let jet = patch.jet(self.uv(at));
            jet.su.cross(&jet.sv).try_normalize(0.0).unwrap_or_default()
        };
        let share = |i: usize| i as f64 / SAMPLES as f64;
        let on_spokes = (0..2 * (SAMPLES + 1)).map(|i| {
            let (k, t) = (i % 2, share(i / 2));
            let at = [Uv::new(t, 0.0), Uv::new(0.0, t)][k];
            normal(at).dot(&spokes[k].at(t * spokes[k].length()).1)
        });
        let middles: Vec<f64> = patch.u.middles(INSIDE).into_iter().filter(|&t| t < 1.0).collect();
        let mut inside = middles.iter().flat_map(|&x| middles.iter().map(move |&y| Uv::new(x, y)));
        let turned = inside.any(|at| normal(at).dot(&limit(at)) <= 0.0);
        on_spokes.fold(1.0, f64::min) - f64::from(u8::from(turned))
    }

    /// The inverse of [`Corner::uv`].
    fn local(&self, uv: Uv) -> Uv {
        match self.k {
            0 => uv,
            1 => Uv::new(uv.y, self.end - uv.x),
            2 => Uv::new(self.end - uv.x, self.end - uv.y),
            _ => Uv::new(self.end - uv.y, uv.x),
        }
    }
}

impl PatchSource<'_> {
    /// Fits the control points at corner `k` of a block's patch, if there is an irregular vertex.
    pub(super) fn fit_corner(&self, block: usize, k: usize, patch: &mut Surface) {
        let quad = self.quad_at(block, k, 0);
        if self.surface.is_regular(quad) {
            return;
        }
        let corner = Corner { k, count: self.knots.functions(), end: self.mesh.side as f64 };
        let blends = self.blends(&corner, patch);
        let (other, side) = self.surface.across(quad, (k + 3) % 4);
        let spokes = [Spoke::new(self, quad, k), Spoke::new(self, other, side)];
        let start = self.samples(quad, k, &spokes);
        let mut best: Option<(f64, Vec<Vector>)> = None;
        for weight in BLENDS.map(f64::sqrt) {
            let mut samples = start.clone();
            for (&(a, b), &blend) in FREE.iter().zip(&blends) {
                patch.net[corner.at(a, b)] = blend;
            }
            for _ in 0..ROUNDS {
                for (at, p) in &mut samples {
                    let (uv, _) = foot_point(patch, *p, corner.uv(*at));
                    let local = corner.local(uv);
                    *at = Uv::new(local.x.clamp(0.0, 1.0), local.y.clamp(0.0, 1.0));
                }
                self.solve(&corner, patch, &spokes, &samples, (&blends, weight));
            }
            let facing = corner.facing(patch, &spokes, |at| self.limit_normal(quad, k, at));
            if best.as_ref().is_none_or(|best| facing > best.0) {
                best = Some((facing, FREE.map(|(a, b)| patch.net[corner.at(a, b)]).to_vec()));
            }
            if facing > SMOOTH {
                break;
            }
        }
        let points = best.map(|best| best.1).unwrap_or_default();
        for (&(a, b), point) in FREE.iter().zip(points) {
            patch.net[corner.at(a, b)] = point;
        }
    }

    /// A normal of the limit surface at a place counted from corner `k` of a quad.
    fn limit_normal(&self, quad: usize, k: usize, at: Uv) -> Vector {
        let place = QuadPlace { quad, at: from_corner(k, at) };
        let [_, du, dv] = self.surface.jet(self.control, place, &mut Vec::new());
        du.cross(&dv)
    }

    /// Points of the limit surface on the irregular quad, with their estimated places on the patch.
    fn samples(&self, quad: usize, k: usize, spokes: &[Spoke; 2]) -> Vec<(Uv, Point)> {
        let mut scratch = Vec::new();
        let steps = (1..=SAMPLES).map(|i| (i as f64 / SAMPLES as f64).powi(2));
        let steps: Vec<f64> = steps.collect();
        let mut samples = Vec::with_capacity(SAMPLES * SAMPLES);
        for &y in &steps {
            for &x in &steps {
                let place = QuadPlace { quad, at: from_corner(k, Uv::new(x, y)) };
                let at = Uv::new(spokes[0].share(x), spokes[1].share(y));
                samples.push((at, limit_at(self, place, &mut scratch)));
            }
        }
        samples
    }

    /// A bilinear blend of the rows around the four control points (Coons).
    fn blends(&self, corner: &Corner, patch: &Surface) -> Vec<Vector> {
        let parameter = |a: usize| self.knots.greville(a) / self.knots.greville(3);
        let at = |a: usize, b: usize| patch.net[corner.at(a, b)];
        let blend = |&(a, b): &(usize, usize)| {
            let (x, y) = (parameter(a), parameter(b));
            let sides = at(0, b).lerp(&at(3, b), x) + at(a, 0).lerp(&at(a, 3), y);
            sides - at(0, 0).lerp(&at(3, 0), x).lerp(&at(0, 3).lerp(&at(3, 3), x), y)
        };
        FREE.iter().map(blend).collect()
    }

    fn solve(
        &self,
        corner: &Corner,
        patch: &mut Surface,
        spokes: &[Spoke; 2],
        samples: &[(Uv, Point)],
        (blends, weight): (&[Vector], f64),
    ) {
        let mut equations = Equations { matrix: DMatrix::zeros(12, 12), right: DVector::zeros(12) };
        for (at, p) in samples {
            let (bx, by) = (self.knots.basis(at.x), self.knots.basis(at.y));
            let weights = combined(&bx, 0, &by, 0);
            equations.add(corner, patch, &weights, p.coords, None);
        }
        for (&(a, b), blend) in FREE.iter().zip(blends) {
            equations.add(corner, patch, &[(a, b, weight)], weight * blend, None);
        }
        for i in 0..=SAMPLES {
            let t = i as f64 / SAMPLES as f64;
            let (along, start) = (self.knots.basis(t), self.knots.basis(0.0));
            let normals = [0, 1].map(|k| spokes[k].at(t * spokes[k].length()).1);
            let slopes = [combined(&along, 0, &start, 1), combined(&start, 1, &along, 0)];
            for (weights, normal) in slopes.iter().zip(normals) {
                equations.add(corner, patch, weights, Vector::zeros(), Some(normal));
            }
        }
        let Some(factor) = equations.matrix.cholesky() else { return };
        let solution = factor.solve(&equations.right);
        for (n, &(a, b)) in FREE.iter().enumerate() {
            patch.net[corner.at(a, b)] = solution.fixed_rows::<3>(3 * n).into();
        }
    }
}

/// The weights of the control points that a derivative depends on: the numbers of the point from
/// the corner, and its weight.
fn combined(x: &Basis, dx: usize, y: &Basis, dy: usize) -> Vec<(usize, usize, f64)> {
    let pairs = (0..16).map(|k| (k % 4, k / 4));
    pairs
        .map(|(i, j)| (x.first + i, y.first + j, x.derivative[dx][i] * y.derivative[dy][j]))
        .collect()
}

impl Equations {
    /// Adds that the combination of control points is the target, or, with a normal, that it is at a
    /// right angle to the normal.
    fn add(
        &mut self,
        corner: &Corner,
        patch: &Surface,
        weights: &[(usize, usize, f64)],
        target: Vector,
        normal: Option<Vector>,
    ) {
        let mut rest = target;
        let mut own = [0.0; 4];
        for &(a, b, weight) in weights {
            match FREE.iter().position(|&free| free == (a, b)) {
                Some(n) => own[n] = weight,
                None => rest -= weight * patch.net[corner.at(a, b)],
            }
        }
        let axes = match normal {
            Some(normal) => vec![SLOPE.sqrt() * normal],
            None => vec![Vector::x(), Vector::y(), Vector::z()],
        };
        for axis in axes {
            let row = DVector::from_fn(12, |i, _| own[i / 3] * axis[i % 3]);
            self.matrix.ger(1.0, &row, &row, 1.0);
            self.right.axpy(rest.dot(&axis), &row, 1.0);
        }
    }
}
