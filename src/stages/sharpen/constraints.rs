//! Conditions between surfaces: parallel and perpendicular directions, common axes, and pairs that touch. All are met at once with the least motion, in which every surface counts by
//! its covariance.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, DVector};

use super::Work;
use super::surfaces::FittedSurface;
use crate::geometry::sets::Sets;
use crate::geometry::{NONE, Point, Vector, plane_axes};
use crate::primitives::contact::contact;
use crate::primitives::tangency::{ball_is_second, misses};
use crate::primitives::{MOST_PARAMETERS, MotionRow, Primitive};
use crate::statistics::{MeanSquare, median};

/// Surfaces may touch if their normals differ by less than this angle (rad) along their border: 20°.
const MOST_TURN: f64 = 0.35;

/// A condition is kept if chance explains what it costs at so many standard deviations of a normal error.
const KEPT: f64 = 4.0;

/// It is also kept if it moves the surfaces by less than this share of the noise: real scanners have as large errors that are no noise.
const RELEVANT: f64 = 0.5;

/// Directions may be parallel or perpendicular if they are so to this sine, and axes may be one line if they are so many edges apart.
const MOST_LEAN: f64 = 0.05;
const MOST_APART: f64 = 3.0;

/// Angles count as what they move so many edges away.
const LEVER: f64 = 30.0;

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

/// A condition between two surfaces. Of two that touch, the second one is the ball that rolls along the first one.
#[derive(Debug, Clone)]
struct Condition {
    first: usize,
    second: usize,
    kind: ConditionKind,
}

#[derive(Debug, Clone)]
enum ConditionKind {
    /// They touch next to some points.
    Touching(Vec<Point>),
    /// Their directions are parallel, given two directions across and the length that makes angles lengths.
    Parallel([Vector; 2], f64),
    /// Their directions are perpendicular.
    Perpendicular(f64),
    /// Their axes, which are parallel, are one line.
    Coaxial([Vector; 2]),
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
        }
    }
}

/// The normal of a plane, or the direction of an axis. A sphere has none.
fn direction(surface: &Primitive) -> Vector {
    match *surface {
        Primitive::Plane { normal, .. } => normal,
        _ => surface.axis().unwrap_or_default(),
    }
}

impl Work<'_> {
    /// Meets the conditions that the data allow. Returns the pairs that touch.
    pub(super) fn constrain(&mut self, fits: &[FittedSurface]) -> BTreeSet<[u32; 2]> {
        let mut kept = self.relations(fits);
        let touching = self.candidates();
        kept.extend(touching.into_iter().filter(|one| self.allows(one, fits)));
        let mut done = BTreeSet::new();
        let mut left = groups(kept, fits.len());
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

    /// Parallel and perpendicular directions, and axes on one line. Each surface is compared with those before it, the best known
    /// ones first.
    fn relations(&self, fits: &[FittedSurface]) -> Vec<Condition> {
        let error = |r: usize| {
            let of = &fits[r].covariance;
            of[(0, 0)].max(of[(1, 1)])
        };
        let is_known = |&r: &usize| {
            fits[r].weight > 1.0 && direction(self.surface(r as u32)).norm() > 0.0 && error(r) > 0.0
        };
        let mut order: Vec<usize> = (0..fits.len()).filter(is_known).collect();
        order.sort_by(|&i, &j| error(i).total_cmp(&error(j)).then(i.cmp(&j)));
        let length = LEVER * self.edge;
        let mut leaders: Vec<usize> = Vec::new();
        let mut lines: Vec<(usize, usize)> = Vec::new();
        let mut found = Vec::new();
        for r in order {
            let own = direction(self.surface(r as u32));
            let between = |other: usize, kind| Condition { first: other, second: r, kind };
            let parallel = leaders.iter().copied().find_map(|other| {
                let d = direction(self.surface(other as u32));
                let across = plane_axes(d);
                let one = between(other, ConditionKind::Parallel([across.0, across.1], length));
                let is_near = d.cross(&own).norm() < MOST_LEAN;
                (is_near && self.allows(&one, fits)).then_some((other, one))
            });
            let Some((leader, one)) = parallel else {
                let perpendicular = leaders.iter().copied().filter_map(|other| {
                    let d = direction(self.surface(other as u32));
                    let one = between(other, ConditionKind::Perpendicular(length));
                    (d.dot(&own).abs() < MOST_LEAN && self.allows(&one, fits)).then_some(one)
                });
                found.extend(perpendicular.take(2));
                leaders.push(r);
                if self.surface(r as u32).axis().is_some() {
                    lines.push((r, r));
                }
                continue;
            };
            found.push(one);
            if self.surface(r as u32).axis().is_none() {
                continue;
            }
            let across = plane_axes(direction(self.surface(leader as u32)));
            let line = lines.iter().filter(|line| line.0 == leader).find_map(|&(_, other)| {
                let one = between(other, ConditionKind::Coaxial([across.0, across.1]));
                let apart = self.surface(r as u32).origin() - self.surface(other as u32).origin();
                let off = apart.cross(&own).norm();
                (off < MOST_APART * self.edge && self.allows(&one, fits)).then_some(one)
            });
            if line.is_none() {
                lines.push((leader, r));
            }
            found.extend(line);
        }
        // The centre of a sphere has two conditions to be on an axis.
        for r in (0..fits.len()).filter(|&r| fits[r].weight > 1.0) {
            let Primitive::Sphere { centre, .. } = *self.surface(r as u32) else { continue };
            found.extend(lines.iter().find_map(|&(_, other)| {
                let axis = self.surface(other as u32);
                let d = direction(axis);
                let (x, y) = plane_axes(d);
                let kind = ConditionKind::Coaxial([x, y]);
                let one = Condition { first: other, second: r, kind };
                let off = (centre - axis.origin()).cross(&d).norm();
                (off < MOST_APART * self.edge && self.allows(&one, fits)).then_some(one)
            }));
        }
        found
    }

    /// The pairs whose normals agree along their border.
    fn candidates(&self) -> Vec<Condition> {
        let mut along: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
        for border in self.borders() {
            if border.pair[1] != NONE {
                along.entry(border.pair).or_default().extend(border.vertices);
            }
        }
        let mut found = Vec::new();
        for (pair, vertices) in along {
            let [a, b] = pair.map(|r| self.surfaces[r as usize]);
            let Some(is_second) = ball_is_second(&a.surface, &b.surface) else { continue };
            let [x, y] = pair.map(|r| r as usize);
            let (first, second) = if is_second { (x, y) } else { (y, x) };
            let turn = |&v: &u32| {
                let p = self.mesh.points[v as usize];
                let (n, m) = (a.side * a.surface.normal(p), b.side * b.surface.normal(p));
                n.cross(&m).norm().atan2(n.dot(&m))
            };
            let mut turns: Vec<f64> = vertices.iter().map(turn).collect();
            if vertices.len() < 3 || median(&mut turns).is_none_or(|turn| turn > MOST_TURN) {
                continue;
            }
            let picked = [0, vertices.len() / 3, 2 * vertices.len() / 3, vertices.len() - 1];
            let point = |k: usize| {
                let p = self.mesh.points[vertices[k] as usize];
                contact(&a.surface, &b.surface, p)
            };
            let points = picked.map(point).to_vec();
            found.push(Condition { first, second, kind: ConditionKind::Touching(points) });
        }
        found
    }

    fn price(&self, of: &Condition, fits: &[FittedSurface]) -> f64 {
        let found = self.step(std::slice::from_ref(of), fits, &BTreeMap::new());
        found.map_or(f64::INFINITY, |found| found.1)
    }

    /// Whether the data allow a condition.
    fn allows(&self, condition: &Condition, fits: &[FittedSurface]) -> bool {
        let one = std::slice::from_ref(condition);
        let Some((motions, cost, rank)) = self.step(one, fits, &BTreeMap::new()) else {
            return false;
        };
        let limit = rank as f64 * MeanSquare(rank as f64).at(KEPT);
        cost <= limit || motions.iter().all(|(&r, m)| self.is_small(&fits[r], m))
    }

    /// Whether a motion moves a surface by a small share of the noise at its vertices.
    fn is_small(&self, fit: &FittedSurface, motion: &MotionRow) -> bool {
        squared(fit, motion) <= RELEVANT * RELEVANT * fit.weight
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
            for (side, r) in [one.first, one.second].into_iter().enumerate() {
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
