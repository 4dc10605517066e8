//! Surfaces that meet in a point or touch, moved within the errors of the mesh until they do so exactly.
//!
//! More than three surfaces around a vertex, or two that touch, have no common point unless their parameters agree.
//! Each such place is a condition on the parameters. All conditions are met together by Newton's method, with the
//! motions of the surfaces that move them least at the vertices of the mesh.

use nalgebra::{DMatrix, DVector, SMatrix};

use super::network::ChainNetwork;
use super::{EXACT, Work};
use crate::geometry::sets::Sets;
use crate::geometry::{Point, Vector, VertexId};
use crate::primitives::contact::touch;
use crate::primitives::{MOST_PARAMETERS, MotionRow, Motions, Primitive};

/// The steps of Newton's method, which converges quadratically from within the errors.
const STEPS: usize = 6;

/// What is left of a condition in mm when it is met: a hundredth of what edges may leave their faces.
const MET: f64 = 0.01 * EXACT;

/// The most conditions that are met together. Solving more takes seconds.
const MOST: usize = 600;

/// The sine of the angle below which surfaces do not hold a point across each other.
const HELD: f64 = 1e-5;

/// The damping of dependent conditions as a share of the largest: rounding of the sums.
const DAMPING: f64 = 1e-13;

/// Surfaces along the axes of the coordinates were put there on purpose, and stay if others can move.
const ALIGNED: f64 = 1e6;

type Metric = SMatrix<f64, MOST_PARAMETERS, MOST_PARAMETERS>;

/// Surfaces that have a point in common.
struct Meeting {
    at: Point,
    error: f64,
    members: Vec<usize>,
}

/// A sum of distances that has to be zero.
struct Condition {
    value: f64,
    /// For each surface the derivatives by its motions.
    slopes: Vec<(usize, MotionRow)>,
}

impl Work<'_> {
    /// Moves the surfaces. Those of a group stay if their vertices would leave them.
    pub(super) fn agree(&mut self, network: &ChainNetwork) {
        let mut meetings = self.meetings(network);
        let before: Vec<Primitive> = self.patches.iter().map(|patch| patch.surface).collect();
        let mut is_stuck = vec![false; before.len()];
        for _ in 0..STEPS {
            let motions = self.motions();
            let mut conditions = Vec::new();
            for meeting in &mut meetings {
                conditions.extend(self.conditions(meeting, &motions));
            }
            let mut is_done = true;
            for group in groups(conditions, before.len()) {
                let is_met = group.iter().all(|of| of.value.abs() < MET);
                let is_held = group.iter().flat_map(|of| &of.slopes).any(|&(i, _)| is_stuck[i]);
                if !is_met && !is_held && group.len() <= MOST {
                    is_done &= !self.step(&group, &motions, &before, &mut is_stuck);
                }
            }
            if is_done {
                break;
            }
        }
    }

    /// The places where surfaces meet: vertices, and three points of borders along which they touch.
    fn meetings(&self, network: &ChainNetwork) -> Vec<Meeting> {
        let around = self.holding();
        let of_vertex = |&v: &u32| Meeting {
            at: self.mesh.points[v as usize],
            error: self.errors[v as usize],
            members: around[v as usize].clone(),
        };
        let mut all: Vec<Meeting> = network.junctions.iter().map(of_vertex).collect();
        for chain in &network.chains {
            let sides = [chain.left, chain.right];
            let [a, b] = sides.map(|i| &self.patches[i]);
            let is_smooth = || touch(&a.surface, &b.surface, &chain.points, chain.error);
            if !a.is_facet && !b.is_facet && is_smooth() {
                let n = chain.points.len() - 1;
                let points = [0, n / 3, 2 * n / 3, n].map(|k| chain.points[k]);
                all.extend(points.map(|at| Meeting {
                    at,
                    error: chain.error,
                    members: sides.to_vec(),
                }));
            }
        }
        all.retain(|meeting| meeting.members.len() > 1);
        all
    }

    fn motions(&self) -> Vec<Motions> {
        let of = |patch: &super::FacePatch| {
            let corners = patch.triangles.iter().map(|&t| self.mesh.triangles[t as usize][0]);
            let n = patch.triangles.len().max(1) as f64;
            let sum: Vector = corners.map(|v| self.mesh.point(v).coords).sum();
            Motions::new(patch.surface, Point::from(sum / n), false)
        };
        self.patches.iter().map(of).collect()
    }

    /// The conditions of a meeting. Its point moves to where the surfaces are closest.
    fn conditions(&self, meeting: &mut Meeting, motions: &[Motions]) -> Vec<Condition> {
        let members = &meeting.members;
        let rows: Vec<(f64, MotionRow)> =
            members.iter().map(|&i| motions[i].row(meeting.at)).collect();
        let mut normals: Vec<Vector> =
            members.iter().map(|&i| self.patches[i].surface.normal(meeting.at)).collect();
        for k in 0..members.len() {
            for j in 0..k {
                let [a, b] = [j, k].map(|n| &self.patches[members[n]]);
                if !a.is_facet
                    && !b.is_facet
                    && touch(&a.surface, &b.surface, &[meeting.at], meeting.error)
                {
                    normals[k] = normals[j] * normals[j].dot(&normals[k]).signum();
                    break;
                }
            }
        }
        let gram =
            DMatrix::from_fn(members.len(), members.len(), |i, k| normals[i].dot(&normals[k]));
        let eigen = gram.symmetric_eigen();
        let mut conditions = Vec::new();
        let mut step = Vector::zeros();
        for (n, &value) in eigen.eigenvalues.iter().enumerate() {
            let weights = eigen.eigenvectors.column(n);
            let off: f64 = weights.iter().zip(&rows).map(|(w, row)| w * row.0).sum();
            if value > HELD * HELD {
                let sum: Vector = weights.iter().zip(&normals).map(|(w, g)| *w * g).sum();
                step -= sum * (off / value);
                continue;
            }
            let slopes = members.iter().zip(&rows).zip(weights.iter());
            let slopes = slopes.map(|((&i, row), w)| (i, *w * row.1)).collect();
            conditions.push(Condition { value: off, slopes });
        }
        meeting.at += step;
        conditions
    }

    /// Moves the surfaces of a group. Returns whether they moved.
    fn step(
        &mut self,
        group: &[Condition],
        motions: &[Motions],
        before: &[Primitive],
        is_stuck: &mut [bool],
    ) -> bool {
        let mut members: Vec<usize> =
            group.iter().flat_map(|of| of.slopes.iter().map(|slope| slope.0)).collect();
        members.sort_unstable();
        members.dedup();
        let free: Vec<Option<Metric>> =
            members.iter().map(|&i| self.mobility(i, &motions[i])).collect();
        let of_member = |k: usize, condition: &Condition| {
            let own = condition.slopes.iter().filter(|slope| slope.0 == members[k]);
            own.map(|slope| slope.1).sum::<MotionRow>()
        };
        let mut matrix = DMatrix::<f64>::zeros(group.len(), group.len());
        for (k, free) in free.iter().enumerate() {
            let Some(free) = free else { continue };
            let rows: Vec<(usize, MotionRow)> = (0..group.len())
                .map(|n| (n, of_member(k, &group[n])))
                .filter(|row| row.1.amax() > 0.0)
                .collect();
            for (i, a) in &rows {
                let moved = free * a;
                rows.iter().for_each(|(j, b)| matrix[(*i, *j)] += moved.dot(b));
            }
        }
        let damping = DAMPING * matrix.diagonal().max();
        (0..group.len()).for_each(|i| matrix[(i, i)] += damping);
        let right = DVector::from_fn(group.len(), |i, _| -group[i].value);
        let found = matrix.cholesky().map(|of| of.solve(&right));
        let moved = found.and_then(|forces| {
            let of = |(k, free): (usize, &Option<Metric>)| {
                let Some(free) = free else { return Some(self.patches[members[k]].surface) };
                let pull: MotionRow =
                    (0..group.len()).map(|n| of_member(k, &group[n]) * forces[n]).sum();
                motions[members[k]].moved(&(free * pull))
            };
            free.iter().enumerate().map(of).collect::<Option<Vec<Primitive>>>()
        });
        let allowed = moved
            .filter(|moved| members.iter().zip(moved).all(|(&i, surface)| self.holds(i, surface)));
        match allowed {
            Some(moved) => {
                members.iter().zip(moved).for_each(|(&i, to)| self.patches[i].surface = to);
                true
            }
            None => {
                for &i in &members {
                    self.patches[i].surface = before[i];
                    is_stuck[i] = true;
                }
                false
            }
        }
    }

    /// The inverse of what motions of a surface do to the vertices of its patch.
    fn mobility(&self, i: usize, motions: &Motions) -> Option<Metric> {
        let patch = &self.patches[i];
        let count = patch.surface.kind().parameters();
        let mut metric = Metric::zeros();
        for v in patch.triangles.iter().flat_map(|&t| self.mesh.triangles[t as usize]) {
            let (_, row) = motions.row(self.mesh.point(v));
            metric += row * row.transpose();
        }
        let axis = match patch.surface {
            Primitive::Plane { normal, .. } => Some(normal),
            _ => patch.surface.axis(),
        };
        if axis.is_some_and(|axis| axis.amax() == 1.0) {
            metric *= ALIGNED;
        }
        let damping = DAMPING.sqrt() * metric.diagonal().max().max(f64::MIN_POSITIVE);
        (0..MOST_PARAMETERS).for_each(|k| metric[(k, k)] += damping);
        let mut inverse = metric.try_inverse()?;
        for k in count..MOST_PARAMETERS {
            inverse.row_mut(k).fill(0.0);
            inverse.column_mut(k).fill(0.0);
        }
        Some(inverse)
    }

    fn holds(&self, i: usize, surface: &Primitive) -> bool {
        let corners = self.patches[i].triangles.iter();
        let mut corners = corners.flat_map(|&t| self.mesh.triangles[t as usize]);
        corners.all(|v: VertexId| self.is_on(surface, v))
    }
}

/// The conditions that share surfaces.
fn groups(conditions: Vec<Condition>, count: usize) -> Vec<Vec<Condition>> {
    let mut sets = Sets::new(count);
    for condition in &conditions {
        condition.slopes.windows(2).for_each(|pair| sets.join(pair[0].0, pair[1].0));
    }
    let mut groups: std::collections::BTreeMap<usize, Vec<Condition>> = Default::default();
    for condition in conditions {
        groups.entry(sets.find(condition.slopes[0].0)).or_default().push(condition);
    }
    groups.into_values().collect()
}
