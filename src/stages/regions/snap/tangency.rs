//! All tangencies at once: Newton's method on the conditions of contact, with the least motion.

use nalgebra::{DMatrix, DVector};

use super::{Snap, SnapKind, Snapping};
use crate::geometry::sets::Sets;
use crate::geometry::{NONE, Point};
use crate::primitives::Primitive;
use crate::primitives::tangency::{UNKNOWNS, ball_is_second, changed, is_movable, misses};
use crate::stages::regions::tessellation::MOST_ERRORS;
use crate::stages::regions::{Regions, Tessellation};

/// Normals of touching surfaces differ by rounding of the vertices, and by this much (rad) where that is smaller.
const LEAST_TURN: f64 = 1e-4;

/// The most surfaces that are moved together. Larger groups stay as they are: their equations would take seconds.
const MOST_TOGETHER: usize = 300;

/// The steps of Newton's method. It converges quadratically; coupled pairs need the most.
const STEPS: usize = 12;

/// The damping that picks the least motion among equal ones, as a share of the largest diagonal entry.
const DAMPING: f64 = 1e-13;

/// The step of difference quotients, as a share of the errors: all conditions are smooth far beyond.
const DIFFERENCE: f64 = 1.0;

/// Two regions that touch, the ball second, and points of their border.
struct Touch {
    other: usize,
    ball: usize,
    points: Vec<Point>,
}

pub(super) fn snap(
    mesh: &Tessellation,
    regions: &Regions,
    all: &mut [Snapping],
    snaps: &mut Vec<Snap>,
) {
    let touches = touches(mesh, regions, all);
    let mut sets = Sets::new(all.len());
    for touch in &touches {
        if is_movable(&all[touch.other].surface) && is_movable(&all[touch.ball].surface) {
            sets.join(touch.other, touch.ball);
        }
    }
    let mut groups: Vec<Vec<&Touch>> = Vec::new();
    let mut of = vec![NONE; all.len()];
    for touch in &touches {
        let root = sets.find(touch.ball);
        if of[root] == NONE {
            of[root] = groups.len() as u32;
            groups.push(Vec::new());
        }
        groups[of[root] as usize].push(touch);
    }
    for group in groups {
        solve(&group, all, snaps);
    }
}

/// The pairs of regions whose surfaces touch within the rounding.
fn touches(mesh: &Tessellation, regions: &Regions, all: &[Snapping]) -> Vec<Touch> {
    let mut index = vec![NONE; regions.regions.len()];
    all.iter().enumerate().for_each(|(i, s)| index[s.region as usize] = i as u32);
    let mut borders: Vec<(u32, u32, u32)> = Vec::new();
    for t in 0..regions.of_triangle.len() as u32 {
        let a = index[regions.of_triangle[t as usize] as usize];
        for (other, side) in mesh.across(t) {
            let b = index[regions.of_triangle[other as usize] as usize];
            if a != NONE && b != NONE && a < b {
                borders.extend(mesh.ends(side).map(|v| (a, b, v)));
            }
        }
    }
    borders.sort_unstable();
    borders.dedup();
    let pairs = borders.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1));
    pairs.filter_map(|same| touch(mesh, regions, all, same)).collect()
}

fn touch(
    mesh: &Tessellation,
    regions: &Regions,
    all: &[Snapping],
    border: &[(u32, u32, u32)],
) -> Option<Touch> {
    let (a, b) = (border[0].0 as usize, border[0].1 as usize);
    let [x, y] = [a, b].map(|i| &all[i].surface);
    let (other, ball) = if ball_is_second(x, y)? { (a, b) } else { (b, a) };
    let side = |i: usize| regions.regions[all[i].region as usize].side;
    let radius = all[ball].surface.radius()?;
    let error = border.iter().map(|&(.., v)| mesh.error(v)).fold(0.0, f64::max);
    let error = error * all[a].looseness.max(all[b].looseness);
    // An error of the parameters of a few roundings turns the normals at the junction by √(2 error / radius).
    let gate = (2.0 * (8.0 * MOST_ERRORS * error / radius).sqrt()).max(LEAST_TURN);
    let is_smooth = border.iter().all(|&(.., v)| {
        let p = mesh.point(v);
        let (n, m) = (side(a) * x.normal(p), side(b) * y.normal(p));
        n.cross(&m).norm().atan2(n.dot(&m)) < gate
    });
    let picked = [0, border.len() / 2, border.len() - 1].map(|k| mesh.point(border[k].2));
    is_smooth.then(|| Touch { other, ball, points: picked.to_vec() })
}

fn residuals(touch: &Touch, surfaces: &[Primitive]) -> Vec<f64> {
    let mut all = Vec::new();
    for &p in &touch.points {
        misses(&surfaces[touch.other], &surfaces[touch.ball], p, &mut all);
    }
    all
}

/// Moves the surfaces of a group so that all touch, if all their vertices allow it.
fn solve(group: &[&Touch], all: &mut [Snapping], snaps: &mut Vec<Snap>) {
    let mut members: Vec<usize> = group.iter().flat_map(|t| [t.other, t.ball]).collect();
    members.sort_unstable();
    members.dedup();
    members.retain(|&i| is_movable(&all[i].surface));
    if members.len() > MOST_TOGETHER {
        return;
    }
    let mut surfaces: Vec<Primitive> = all.iter().map(|s| s.surface).collect();
    let size = |surfaces: &[Primitive]| -> f64 {
        group.iter().flat_map(|t| residuals(t, surfaces)).map(|r| r * r).sum()
    };
    let mut before = size(&surfaces);
    for _ in 0..STEPS {
        let Some(step) = newton(group, &members, &surfaces, all) else { break };
        let mut next = surfaces.clone();
        for (k, &i) in members.iter().enumerate() {
            next[i] = changed(&surfaces[i], &step.as_slice()[UNKNOWNS * k..UNKNOWNS * (k + 1)]);
        }
        let after = size(&next);
        if after >= before {
            break;
        }
        (surfaces, before) = (next, after);
    }
    if members.iter().all(|&i| all[i].allows(&surfaces[i])) {
        for i in members {
            all[i].take(surfaces[i], SnapKind::Tangent, snaps);
        }
    }
}

/// The step of least motion, in which each surface counts by the errors of its vertices.
fn newton(
    group: &[&Touch],
    members: &[usize],
    surfaces: &[Primitive],
    all: &[Snapping],
) -> Option<DVector<f64>> {
    let n = UNKNOWNS * members.len();
    let mut matrix = DMatrix::<f64>::zeros(n, n);
    let mut right = DVector::<f64>::zeros(n);
    for touch in group {
        let now = residuals(touch, surfaces);
        let mut columns: Vec<(usize, f64, Vec<f64>)> = Vec::new();
        for i in [touch.other, touch.ball] {
            let Ok(k) = members.binary_search(&i) else { continue };
            let h = DIFFERENCE * all[i].error;
            for unknown in 0..UNKNOWNS {
                let at = |step: f64| {
                    let mut by = [0.0; UNKNOWNS];
                    by[unknown] = step;
                    let other = if i == touch.other {
                        changed(&surfaces[i], &by)
                    } else {
                        surfaces[touch.other]
                    };
                    let ball = if i == touch.ball {
                        changed(&surfaces[i], &by)
                    } else {
                        surfaces[touch.ball]
                    };
                    let mut all = Vec::new();
                    touch.points.iter().for_each(|&p| misses(&other, &ball, p, &mut all));
                    all
                };
                let (up, down) = (at(h), at(-h));
                if up.len() != now.len() || down.len() != now.len() {
                    return None;
                }
                // In units of the surface's errors.
                let slopes = up.iter().zip(&down).map(|(u, d)| (u - d) / 2.0).collect();
                columns.push((UNKNOWNS * k + unknown, h, slopes));
            }
        }
        for (i, _, x) in &columns {
            right[*i] -= x.iter().zip(&now).map(|(a, b)| a * b).sum::<f64>();
            for (j, _, y) in &columns {
                matrix[(*i, *j)] += x.iter().zip(y).map(|(a, b)| a * b).sum::<f64>();
            }
        }
    }
    let largest = matrix.diagonal().max();
    (0..n).for_each(|i| matrix[(i, i)] += DAMPING * largest);
    let mut step = matrix.cholesky()?.solve(&right);
    for (k, &i) in members.iter().enumerate() {
        let h = DIFFERENCE * all[i].error;
        step.rows_mut(UNKNOWNS * k, UNKNOWNS).iter_mut().for_each(|x| *x *= h);
    }
    step.iter().all(|x| x.is_finite()).then_some(step)
}
