//! Conditions that may hold between surfaces: those of a designer, as far as the data allow them.

use std::collections::{BTreeMap, BTreeSet};

use super::Work;
use super::borders::Border;
use super::constraints::{Condition, ConditionKind, apart, direction};
use super::surfaces::FittedSurface;
use crate::geometry::{NONE, plane_axes};
use crate::primitives::Primitive;
use crate::primitives::contact::contact;
use crate::primitives::tangency::ball_is_second;
use crate::statistics::median;

/// Surfaces may touch if their normals differ by less than this angle (rad) along their border: 20°.
const MOST_TURN: f64 = 0.35;

/// Directions may be parallel or perpendicular if they are so to this sine, and axes and planes may be one if they are so many edges apart.
const MOST_LEAN: f64 = 0.05;
const MOST_APART: f64 = 3.0;

/// Angles count as what they move so many edges away.
const LEVER: f64 = 30.0;

/// A radius with a standard deviation of a larger share is equal to many others by chance.
const KNOWN: f64 = 0.1;

impl Work<'_> {
    /// The conditions that the data allow.
    pub(super) fn conditions(&self, fits: &[FittedSurface]) -> Vec<Condition> {
        let borders = self.borders();
        let beside = borders.iter().map(|border| border.pair).collect();
        let mut all = self.relations(fits, &beside);
        all.extend(self.equal_radii(fits, &beside));
        let touching = self.candidates(borders).into_iter();
        all.extend(touching.filter(|one| self.allows(one, fits)));
        all
    }

    /// Parallel and perpendicular directions, axes on one line, and planes that are one. Each surface is compared with those before it, the
    /// best known ones first. Neighbours, which are given, cannot be one.
    fn relations(&self, fits: &[FittedSurface], beside: &BTreeSet<[u32; 2]>) -> Vec<Condition> {
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
        let pair = |a: usize, b: usize| [a.min(b) as u32, a.max(b) as u32];
        let mut leaders: Vec<usize> = Vec::new();
        let mut lines: Vec<(usize, usize)> = Vec::new();
        // Planes with the same leader that are one.
        let mut flats: Vec<(usize, Vec<usize>)> = Vec::new();
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
                match self.surface(r as u32).axis() {
                    Some(_) => lines.push((r, r)),
                    None => flats.push((r, vec![r])),
                }
                continue;
            };
            found.push(one);
            if self.surface(r as u32).axis().is_none() {
                let mut own = flats.iter_mut().filter(|flat| flat.0 == leader);
                let flat = own.find_map(|(_, flat)| {
                    let one = between(flat[0], ConditionKind::Apart(0.0));
                    let [first, second] = [flat[0], r].map(|r| *self.surface(r as u32));
                    let is_near = apart(&first, &second).abs() < MOST_APART * self.edge;
                    // Neighbours on one plane would have no edge.
                    let is_apart = flat.iter().all(|&other| !beside.contains(&pair(other, r)));
                    (is_near && is_apart && self.allows(&one, fits)).then_some((flat, one))
                });
                match flat {
                    Some((flat, one)) => {
                        flat.push(r);
                        found.push(one);
                    }
                    None => flats.push((leader, vec![r])),
                }
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
    fn candidates(&self, borders: Vec<Border>) -> Vec<Condition> {
        let mut along: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
        for border in borders {
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

    /// Equal radii. Each is compared with those before it, the best known ones first.
    fn equal_radii(&self, fits: &[FittedSurface], beside: &BTreeSet<[u32; 2]>) -> Vec<Condition> {
        let error = |r: usize| fits[r].uncertainty.and_then(|of| of.radius);
        let is_known = |&(error, r): &(f64, usize)| {
            let radius = self.surface(r as u32).radius();
            fits[r].weight > 1.0 && radius.is_some_and(|radius| error <= KNOWN * radius)
        };
        let errors = (0..fits.len()).filter_map(|r| Some((error(r)?, r)));
        let mut order: Vec<(f64, usize)> = errors.filter(is_known).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut groups: Vec<Vec<usize>> = Vec::new();
        let mut found = Vec::new();
        for (_, r) in order {
            // Neighbours of one kind with one radius and one axis would have no edge.
            let may_be_one = |other: usize| {
                let [a, b] = [other, r].map(|r| self.surface(r as u32));
                a.kind() == b.kind() && beside.contains(&[other.min(r) as u32, other.max(r) as u32])
            };
            let group = groups.iter_mut().find_map(|group| {
                let one = Condition { first: group[0], second: r, kind: ConditionKind::EqualRadii };
                let is_apart = !group.iter().any(|&other| may_be_one(other));
                (is_apart && self.allows(&one, fits)).then_some((group, one))
            });
            match group {
                Some((group, one)) => {
                    group.push(r);
                    found.push(one);
                }
                None => groups.push(vec![r]),
            }
        }
        found
    }
}
