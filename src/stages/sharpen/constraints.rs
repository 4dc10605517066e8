//! Conditions on surfaces: parallel and perpendicular directions, common axes and planes, equal radii, given sizes, and pairs that touch. All are
//! met at once with the least motion, in which every surface counts by its covariance.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, DVector};

use super::Work;
use super::surfaces::FittedSurface;
use crate::geometry::sets::Sets;
use crate::geometry::{Point, Vector};
use crate::primitives::tangency::misses;
use crate::primitives::{MOST_PARAMETERS, MotionRow, Primitive};
use crate::statistics::MeanSquare;

/// A condition is kept if chance explains what it costs at so many standard deviations of a normal error.
const KEPT: f64 = 4.0;

/// Conditions on places are also kept if they move the surfaces by less than this share of the noise: real scanners have as large errors that are
/// no noise. Radii that a designer made different may differ by less.
const RELEVANT: f64 = 0.5;

/// So many conditions of a group may contradict the others.
const MOST_DROPPED: usize = 30;

/// The steps of Newton's method.
const STEPS: usize = 12;

/// Newton's method has converged when the size of the motions changes by less than this share: a square of what is left of the
/// conditions.
const CONVERGED: f64 = 1e-13;

/// What is left of a condition when it is met, as a share of the edges.
const MET: f64 = 1e-11;

/// The damping of dependent conditions as a share of their variance.
const DAMPING: f64 = 1e-11;

/// The shares of a standard deviation that derivatives are taken over.
const DIFFERENCE: f64 = 1e-2;

/// The most conditions that are met together. Solving more takes seconds.
const MOST: usize = 1500;

/// A condition on two surfaces, or on one, which is then both of them. Of two that touch, the second one is the ball that rolls along the first one.
#[derive(Debug, Clone)]
pub(super) struct Condition {
    pub first: usize,
    pub second: usize,
    pub kind: ConditionKind,
}

#[derive(Debug, Clone)]
pub(super) enum ConditionKind {
    /// They touch next to some points.
    Touching(Vec<Point>),
    /// Their directions are parallel, given two directions across and the length that makes angles lengths.
    Parallel([Vector; 2], f64),
    /// Their directions are perpendicular.
    Perpendicular(f64),
    /// Their axes, which are parallel, are one line.
    Coaxial([Vector; 2]),
    /// Two planes, which are parallel, are one, or so far apart along the normal of the first one.
    Apart(f64),
    /// The radii of cylinders, spheres, and tubes of tori are equal.
    EqualRadii,
    /// A size of a surface has a value.
    Sized(Size, f64),
}

/// A size of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// The radius of a cylinder, a sphere, or the tube of a torus.
    Radius,
    /// The radius of the circle of a torus.
    MajorRadius,
    /// The angle between the axis of a cone and its generators, in radians.
    HalfAngle,
}

impl Size {
    /// The value that a surface has.
    pub(super) fn of(self, surface: &Primitive) -> Option<f64> {
        match (self, *surface) {
            (Size::Radius, _) => surface.radius(),
            (Size::MajorRadius, Primitive::Torus { major, .. }) => Some(major),
            (Size::HalfAngle, Primitive::Cone { angle, .. }) => Some(angle),
            _ => None,
        }
    }
}

/// How far a plane is from another one, which is parallel to it, along the normal of the first one.
pub(super) fn apart(first: &Primitive, second: &Primitive) -> f64 {
    direction(first).dot(&(second.origin() - first.origin()))
}

impl Condition {
    /// What is missing, as lengths.
    fn residuals(&self, of: impl Fn(usize) -> Primitive) -> Vec<f64> {
        let (first, second) = (of(self.first), of(self.second));
        match &self.kind {
            ConditionKind::Touching(points) => {
                let mut all = Vec::new();
                points.iter().for_each(|&p| misses(&first, &second, p, &mut all));
                all
            }
            ConditionKind::Parallel(across, length) => {
                let turn = direction(&first).cross(&direction(&second));
                across.iter().map(|x| length * x.dot(&turn)).collect()
            }
            ConditionKind::Perpendicular(length) => {
                vec![length * direction(&first).dot(&direction(&second))]
            }
            ConditionKind::Coaxial(across) => {
                let (apart, along) = (second.origin() - first.origin(), direction(&first));
                let apart = apart - apart.dot(&along) * along;
                across.iter().map(|x| x.dot(&apart)).collect()
            }
            ConditionKind::Apart(far) => vec![apart(&first, &second) - far],
            ConditionKind::EqualRadii => {
                let radii = first.radius().zip(second.radius());
                radii.map(|(a, b)| b - a).into_iter().collect()
            }
            ConditionKind::Sized(size, value) => {
                size.of(&first).map(|own| own - value).into_iter().collect()
            }
        }
    }
}

/// The normal of a plane, or the direction of an axis. A sphere has none.
pub(super) fn direction(surface: &Primitive) -> Vector {
    match *surface {
        Primitive::Plane { normal, .. } => normal,
        _ => surface.axis().unwrap_or_default(),
    }
}

impl Work<'_> {
    /// Meets conditions as far as they do not contradict each other, from the fits on. Returns the pairs that touch.
    pub(super) fn meet(
        &mut self,
        conditions: &[Condition],
        fits: &[FittedSurface],
    ) -> BTreeSet<[u32; 2]> {
        let mut done = BTreeSet::new();
        let mut left = groups(conditions.to_vec(), fits.len());
        while let Some(group) = left.pop() {
            let Some((group, motions)) = self.largest_part(group.clone(), fits) else {
                // Tangent neighbours are worth more than directions: without them there are no edges.
                let is_mixed = group.iter().any(|of| !of.is_touching());
                let touching = group.into_iter().filter(Condition::is_touching).collect();
                left.extend(if is_mixed { groups(touching, fits.len()) } else { Vec::new() });
                continue;
            };
            for (r, motion) in motions {
                if let Some(to) = fits[r].motions.moved(&motion) {
                    self.surfaces[r].surface = to;
                }
            }
            done.extend(group.iter().filter(|of| of.is_touching()).map(Condition::pair));
        }
        done
    }

    /// The conditions of a group that can be met together, and the motions for that. `None` if too many contradict the others.
    fn largest_part(
        &self,
        mut group: Vec<Condition>,
        fits: &[FittedSurface],
    ) -> Option<(Vec<Condition>, BTreeMap<usize, MotionRow>)> {
        for _ in 0..MOST_DROPPED {
            if group.is_empty() || group.len() > MOST {
                return None;
            }
            let worst = match self.solved(&group, fits) {
                Ok(motions) => return Some((group, motions)),
                Err(worst) => worst,
            };
            // The condition of the surface that would move farthest that costs most is the least likely one.
            let is_at =
                |of: &Condition| worst.is_none_or(|worst| of.first == worst || of.second == worst);
            let costs: Vec<f64> = group.iter().map(|of| self.price(of, fits)).collect();
            let dropped = (0..group.len())
                .filter(|&k| is_at(&group[k]))
                .max_by(|&i, &j| costs[i].total_cmp(&costs[j]))?;
            group.remove(dropped);
        }
        None
    }

    fn price(&self, of: &Condition, fits: &[FittedSurface]) -> f64 {
        let found = self.step(std::slice::from_ref(of), fits, &BTreeMap::new());
        found.map_or(f64::INFINITY, |found| found.1)
    }

    /// Whether the data allow a condition.
    pub(super) fn allows(&self, condition: &Condition, fits: &[FittedSurface]) -> bool {
        let one = std::slice::from_ref(condition);
        let Some((motions, cost, rank)) = self.step(one, fits, &BTreeMap::new()) else {
            return false;
        };
        let limit = rank as f64 * MeanSquare(rank as f64).at(KEPT);
        let may_be_slight = !matches!(condition.kind, ConditionKind::EqualRadii);
        let is_slight = || motions.iter().all(|(&r, m)| self.is_small(&fits[r], m));
        cost <= limit || may_be_slight && is_slight()
    }

    /// Whether a motion moves a surface by a small share of the noise at its vertices.
    fn is_small(&self, fit: &FittedSurface, motion: &MotionRow) -> bool {
        let relevant = RELEVANT.max(self.bias / self.noise);
        squared(fit, motion) <= relevant * relevant * fit.weight
    }

    /// Meets all conditions of a group. Otherwise the surface that would move farthest is returned.
    fn solved(
        &self,
        group: &[Condition],
        fits: &[FittedSurface],
    ) -> Result<BTreeMap<usize, MotionRow>, Option<usize>> {
        let mut motions = BTreeMap::new();
        let mut last = f64::INFINITY;
        for _ in 0..STEPS {
            let (next, cost, _) = self.step(group, fits, &motions).ok_or(None)?;
            motions = next;
            if (cost - last).abs() <= CONVERGED * cost {
                break;
            }
            last = cost;
        }
        let of = |r: usize| {
            let motion = motions.get(&r).copied().unwrap_or_default();
            fits[r].motions.moved(&motion).unwrap_or(self.surfaces[r].surface)
        };
        let off = group.iter().flat_map(|one| one.residuals(of)).map(f64::abs).fold(0.0, f64::max);
        let ratio = |r: usize| squared(&fits[r], &motions[&r]) / fits[r].weight;
        let worst = motions.keys().copied().max_by(|&i, &j| ratio(i).total_cmp(&ratio(j)));
        let is_near = worst.is_none_or(|r| {
            ratio(r) <= 1.0 || squared(&fits[r], &motions[&r]) <= KEPT * KEPT * 7.0
        });
        if off <= MET * self.edge * 1e3 && is_near { Ok(motions) } else { Err(worst) }
    }

    /// One step: the motions of least size that meet the conditions to first order, their squared size, and the number
    /// of independent conditions.
    fn step(
        &self,
        group: &[Condition],
        fits: &[FittedSurface],
        now: &BTreeMap<usize, MotionRow>,
    ) -> Option<(BTreeMap<usize, MotionRow>, f64, usize)> {
        let motion = |r: usize| now.get(&r).copied().unwrap_or_default();
        let mut members: Vec<usize> = group.iter().flat_map(|of| [of.first, of.second]).collect();
        members.sort_unstable();
        members.dedup();
        let mut surfaces: BTreeMap<usize, Primitive> = BTreeMap::new();
        for &r in &members {
            surfaces.insert(r, fits[r].motions.moved(&motion(r))?);
        }
        let mut values: Vec<f64> = Vec::new();
        // For each condition the rows of its two surfaces.
        let mut rows: Vec<[(usize, MotionRow); 2]> = Vec::new();
        for one in group {
            let own = one.residuals(|r| surfaces[&r]);
            let first = rows.len();
            let zero = MotionRow::zeros();
            rows.extend(own.iter().map(|_| [(one.first, zero), (one.second, zero)]));
            values.extend(&own);
            // A condition on one surface has one row.
            let sides = if one.first == one.second { 1 } else { 2 };
            for (side, r) in [one.first, one.second].into_iter().take(sides).enumerate() {
                for k in 0..MOST_PARAMETERS {
                    let h = DIFFERENCE * fits[r].covariance[(k, k)].max(0.0).sqrt();
                    if h <= 0.0 {
                        continue;
                    }
                    let at = |by: f64| {
                        let mut moved = motion(r);
                        moved[k] += by;
                        let to = fits[r].motions.moved(&moved)?;
                        let own = one.residuals(|s| if s == r { to } else { surfaces[&s] });
                        Some(own)
                    };
                    let (up, down) = (at(h)?, at(-h)?);
                    if up.len() != own.len() || down.len() != own.len() {
                        return None;
                    }
                    for (n, (u, d)) in up.iter().zip(&down).enumerate() {
                        rows[first + n][side].1[k] = (u - d) / (2.0 * h);
                    }
                }
            }
        }
        let n = values.len();
        // What the conditions ask of the motions from the fits on.
        let mut right = DVector::zeros(n);
        let mut by_surface: BTreeMap<usize, Vec<(usize, MotionRow)>> = BTreeMap::new();
        for (i, pair) in rows.iter().enumerate() {
            right[i] = -values[i];
            for (r, row) in pair {
                right[i] += row.dot(&motion(*r));
                by_surface.entry(*r).or_default().push((i, *row));
            }
        }
        let mut matrix = DMatrix::<f64>::zeros(n, n);
        for (r, rows) in &by_surface {
            let moved: Vec<MotionRow> =
                rows.iter().map(|(_, row)| fits[*r].covariance * row).collect();
            for (x, (i, _)) in rows.iter().enumerate() {
                for (j, b) in rows {
                    matrix[(*i, *j)] += moved[x].dot(b);
                }
            }
        }
        let scale: Vec<f64> = (0..n)
            .map(|i| if matrix[(i, i)] > 0.0 { matrix[(i, i)].sqrt().recip() } else { 0.0 })
            .collect();
        let scaled = DMatrix::from_fn(n, n, |i, j| {
            scale[i] * matrix[(i, j)] * scale[j] + if i == j { DAMPING } else { 0.0 }
        });
        let wanted = DVector::from_fn(n, |i, _| scale[i] * right[i]);
        let factor = scaled.clone().cholesky()?;
        let mut forces = factor.solve(&wanted);
        // One refinement takes most of the damping back.
        let left = &wanted - (&scaled * &forces - &forces * DAMPING);
        forces += factor.solve(&left);
        let rank = (0..n).filter(|&i| factor.l_dirty()[(i, i)].powi(2) > 1e-6).count().max(1);
        let cost = wanted.dot(&forces);
        let mut motions = BTreeMap::new();
        for (r, rows) in by_surface {
            let pull: MotionRow = rows.iter().map(|(i, row)| row * (scale[*i] * forces[*i])).sum();
            motions.insert(r, fits[r].covariance * pull);
        }
        Some((motions, cost, rank))
    }
}

/// The squared size of a motion in standard deviations.
fn squared(fit: &FittedSurface, motion: &MotionRow) -> f64 {
    let scale = |k: usize| {
        let v = fit.covariance[(k, k)];
        if v > 0.0 { v.sqrt().recip() } else { 0.0 }
    };
    let mut scaled = fit.covariance;
    for i in 0..MOST_PARAMETERS {
        for j in 0..MOST_PARAMETERS {
            scaled[(i, j)] *= scale(i) * scale(j);
        }
        if scale(i) == 0.0 {
            scaled[(i, i)] = 1.0;
        } else {
            scaled[(i, i)] += DAMPING;
        }
    }
    let x = MotionRow::from_fn(|k, _| motion[k] * scale(k));
    scaled.cholesky().map_or(0.0, |of| x.dot(&of.solve(&x)))
}

impl Condition {
    fn is_touching(&self) -> bool {
        matches!(self.kind, ConditionKind::Touching(_))
    }

    fn pair(&self) -> [u32; 2] {
        let [a, b] = [self.first as u32, self.second as u32];
        [a.min(b), a.max(b)]
    }
}

/// Conditions that share surfaces.
fn groups(all: Vec<Condition>, surfaces: usize) -> Vec<Vec<Condition>> {
    let mut sets = Sets::new(surfaces);
    all.iter().for_each(|of| sets.join(of.first, of.second));
    let mut groups: BTreeMap<usize, Vec<Condition>> = BTreeMap::new();
    for one in all {
        groups.entry(sets.find(one.first)).or_default().push(one);
    }
    groups.into_values().collect()
}
