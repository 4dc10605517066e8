//! The control points of a patch at a corner in an irregular vertex.
//!
//! The outer rows are given by the tracks, and the rows beyond by the regular quads. Four control
//! points are left. They are fitted to the limit surface by least squares, and the patch is bound to
//! normals along both spokes: those of the limit surface at first, and then those on which the patches
//! on both sides of a spoke agree.

use nalgebra::{DMatrix, DVector};

use super::PatchSource;
use super::tracks::{Spoke, from_corner, limit_at};
use crate::geometry::{Point, Quarter, Uv, Vector, plane_axes};
use crate::spline::subdivision::QuadPlace;
use crate::spline::{Basis, Surface, foot_point};

/// The four control points, counted from the corner.
const FREE: [(usize, usize); 4] = [(1, 1), (2, 1), (1, 2), (2, 2)];

/// The number of their coordinates.
const UNKNOWNS: usize = 3 * FREE.len();

/// The number of samples of the limit surface along each side of the quad, and of each spoke.
const SAMPLES: usize = 8;

/// The number of steps along a spoke between the places at which normals are compared. With 8, patches of bodies with
/// thin walls met at up to 77° between two places.
const SLOPES: usize = 16;

/// The number of places in each span at which the normal of a patch is compared with that of the limit surface.
const INSIDE: usize = 3;

/// The weight of the slope against the normals along the spokes, beside that of distances. It
/// is large because a step between tangent planes is seen before a distance is.
const SLOPE: f64 = 100.0;

/// The weights of the distance of the four control points, along the surface, from a blend of the rows around
/// them. It holds the parameters and leaves the shape free. Of these weights each corner takes the first one with small angles to the limit normals, or else the one with the
/// smallest. With less weight the parameters of a patch may turn back beside a spoke, and with more the
/// tangent planes of neighbours differ.
const BLENDS: [f64; 5] = [1.0, 0.1, 10.0, 100.0, 1e4];

/// The cosine of an angle to the limit normals that is small enough to end the choice (2°).
const SMOOTH: f64 = 0.9994;

/// The rounds of parameter correction.
pub(super) const ROUNDS: usize = 3;

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
        let [i, j] = Quarter(self.k).turned(self.count - 1, [a, b]);
        i * self.count + j
    }

    /// The parameter point of the patch at (x, y) from the corner.
    fn uv(&self, at: Uv) -> Uv {
        Quarter(self.k).turned(self.end, at.into()).into()
    }

    /// The inverse of [`Corner::uv`].
    fn local(&self, uv: Uv) -> Uv {
        Quarter(self.k).turned_back(self.end, uv.into()).into()
    }
}

/// The fit of the control points at a corner.
pub(super) struct CornerFit {
    corner: Corner,
    /// A blend of the rows around for each control point, and a normal of the limit surface near it.
    blends: Vec<(Vector, Vector)>,
    /// The normals that the patch is to have along both spokes.
    pub normals: [Vec<Vector>; 2],
    /// Points of the limit surface, and their places on the patch.
    samples: Vec<(Uv, Point)>,
    /// The square root of the weight of the blends.
    weight: f64,
}

/// The parameter of a place along a spoke.
fn share(i: usize) -> f64 {
    i as f64 / SLOPES as f64
}

impl CornerFit {
    /// The control points in a patch.
    pub(crate) fn points(&self, patch: &Surface) -> Vec<Vector> {
        FREE.iter().map(|&(a, b)| patch.net[self.corner.at(a, b)]).collect()
    }

    /// Puts the control points into a patch.
    pub(crate) fn set(&self, patch: &mut Surface, points: Vec<Vector>) {
        for (&(a, b), point) in FREE.iter().zip(points) {
            patch.net[self.corner.at(a, b)] = point;
        }
    }

    /// The unit normal of a patch at a place counted from the corner.
    fn normal(&self, patch: &Surface, at: Uv) -> Vector {
        let jet = patch.jet(self.corner.uv(at));
        jet.su.cross(&jet.sv).try_normalize(0.0).unwrap_or_default()
    }

    /// The unit normals of a patch along both spokes.
    pub(crate) fn along_spokes(&self, patch: &Surface) -> [Vec<Vector>; 2] {
        let places = [|t| Uv::new(t, 0.0), |t| Uv::new(0.0, t)];
        places.map(|at| (0..=SLOPES).map(|i| self.normal(patch, at(share(i)))).collect())
    }

    /// The cosine of the largest angle between the normals of the patch and those that it is to have along the
    /// spokes. It is less by one if the patch turns away from the limit normals on the quad, which
    /// `limit` gives for places counted from the corner.
    fn facing(&self, patch: &Surface, limit: impl Fn(Uv) -> Vector) -> f64 {
        let own = self.along_spokes(patch).concat();
        let smallest = own.iter().zip(self.normals.concat()).map(|(n, m)| n.dot(&m));
        let middles: Vec<f64> = patch.u.middles(INSIDE).into_iter().filter(|&t| t < 1.0).collect();
        let mut inside = middles.iter().flat_map(|&x| middles.iter().map(move |&y| Uv::new(x, y)));
        let turned = inside.any(|at| self.normal(patch, at).dot(&limit(at)) <= 0.0);
        smallest.fold(1.0, f64::min) - f64::from(u8::from(turned))
    }
}

impl PatchSource<'_> {
    /// Fits the control points at corner `k` of a block's patch, if there is an irregular vertex.
    pub(super) fn fit_corner(
        &self,
        block: usize,
        k: usize,
        patch: &mut Surface,
    ) -> Option<CornerFit> {
        let quad = self.quad_at(block, k, 0);
        if self.surface.is_regular(quad) {
            return None;
        }
        let corner = Corner { k, count: self.knots.functions(), end: self.mesh.side as f64 };
        let limit = |at: Uv| self.limit_normal(quad, k, at);
        let blends = self.blends(&corner, patch, limit);
        let (other, side) = self.surface.across(quad, (k + 3) % 4);
        let spokes = [Spoke::new(self, quad, k), Spoke::new(self, other, side)];
        let start = self.samples(quad, k, &spokes);
        let normals = spokes
            .each_ref()
            .map(|spoke| (0..=SLOPES).map(|i| spoke.at(share(i) * spoke.length()).1).collect());
        let mut fit = CornerFit { corner, blends, normals, samples: Vec::new(), weight: 0.0 };
        let mut best: Option<(f64, f64, Vec<Vector>)> = None;
        for weight in BLENDS.map(f64::sqrt) {
            fit.samples.clone_from(&start);
            fit.weight = weight;
            fit.set(patch, fit.blends.iter().map(|blend| blend.0).collect());
            for _ in 0..ROUNDS {
                self.fit_again(&mut fit, patch);
            }
            let facing = fit.facing(patch, limit);
            if best.as_ref().is_none_or(|best| facing > best.0) {
                best = Some((facing, weight, fit.points(patch)));
            }
            if facing > SMOOTH {
                break;
            }
        }
        let (_, weight, points) = best?;
        fit.weight = weight;
        fit.set(patch, points);
        Some(fit)
    }

    /// Corrects the places of the samples, and fits the control points again.
    pub(super) fn fit_again(&self, fit: &mut CornerFit, patch: &mut Surface) {
        for (at, p) in &mut fit.samples {
            let (uv, _) = foot_point(patch, *p, fit.corner.uv(*at));
            let local = fit.corner.local(uv);
            *at = Uv::new(local.x.clamp(0.0, 1.0), local.y.clamp(0.0, 1.0));
        }
        self.solve(fit, patch);
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
    fn blends(
        &self,
        corner: &Corner,
        patch: &Surface,
        limit: impl Fn(Uv) -> Vector,
    ) -> Vec<(Vector, Vector)> {
        let parameter = |a: usize| self.knots.greville(a) / self.knots.greville(3);
        let at = |a: usize, b: usize| patch.net[corner.at(a, b)];
        let blend = |&(a, b): &(usize, usize)| {
            let (x, y) = (parameter(a), parameter(b));
            let sides = at(0, b).lerp(&at(3, b), x) + at(a, 0).lerp(&at(a, 3), y);
            let blend = sides - at(0, 0).lerp(&at(3, 0), x).lerp(&at(0, 3).lerp(&at(3, 3), x), y);
            let place = Uv::new(self.knots.greville(a), self.knots.greville(b));
            (blend, limit(place).try_normalize(0.0).unwrap_or(Vector::z()))
        };
        FREE.iter().map(blend).collect()
    }

    fn solve(&self, fit: &CornerFit, patch: &mut Surface) {
        let CornerFit { corner, blends, normals, samples, weight } = fit;
        let mut equations = Equations {
            matrix: DMatrix::zeros(UNKNOWNS, UNKNOWNS),
            right: DVector::zeros(UNKNOWNS),
        };
        let axes = [Vector::x(), Vector::y(), Vector::z()];
        for (at, p) in samples {
            let (bx, by) = (self.knots.basis(at.x), self.knots.basis(at.y));
            let weights = combined(&bx, 0, &by, 0);
            equations.add(corner, patch, &weights, p.coords, &axes);
        }
        for (&(a, b), &(blend, normal)) in FREE.iter().zip(blends) {
            let (x, y) = plane_axes(normal);
            equations.add(corner, patch, &[(a, b, *weight)], *weight * blend, &[x, y]);
        }
        for i in 0..=SLOPES {
            let (along, start) = (self.knots.basis(share(i)), self.knots.basis(0.0));
            let slopes = [combined(&along, 0, &start, 1), combined(&start, 1, &along, 0)];
            for (weights, normals) in slopes.iter().zip(normals) {
                let axis = SLOPE.sqrt() * normals[i];
                equations.add(corner, patch, weights, Vector::zeros(), &[axis]);
            }
        }
        let Some(factor) = equations.matrix.cholesky() else { return };
        let solution = factor.solve(&equations.right);
        fit.set(patch, (0..FREE.len()).map(|n| solution.fixed_rows::<3>(3 * n).into()).collect());
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
    /// Adds that the combination of control points is the target along each of the axes, whose squared lengths
    /// are weights.
    fn add(
        &mut self,
        corner: &Corner,
        patch: &Surface,
        weights: &[(usize, usize, f64)],
        target: Vector,
        axes: &[Vector],
    ) {
        let mut rest = target;
        let mut own = [0.0; FREE.len()];
        for &(a, b, weight) in weights {
            match FREE.iter().position(|&free| free == (a, b)) {
                Some(n) => own[n] = weight,
                None => rest -= weight * patch.net[corner.at(a, b)],
            }
        }
        for axis in axes {
            let row = DVector::from_fn(UNKNOWNS, |i, _| own[i / 3] * axis[i % 3]);
            self.matrix.ger(1.0, &row, &row, 1.0);
            self.right.axpy(rest.dot(axis), &row, 1.0);
        }
    }
}
