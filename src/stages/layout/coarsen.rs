//! Half-edge collapses until no legal one is left.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::Matrix4;

use super::base::{Base, Flat};
use crate::geometry::{EQUILATERAL, OrderedFloat, Uv, Vector};
use crate::mesh::remesh::LEAST_VALENCE;

/// The weight of the squared length of an edge, beside the mean squared distance from the planes of
/// the scan. It keeps triangles of flat regions from becoming long.
const LENGTH: f64 = 0.003;

/// The most triangles around a vertex of the base. Vertices with more become irregular vertices with
/// many faces, where faces are narrow.
const MOST_VALENCE: usize = 8;

/// The least quality of a triangle in the plane and in space: 1 for equal sides, 0 for no area. Worse
/// triangles map the scan with much distortion. A triangle may also be as bad as one before.
const FLAT_QUALITY: f64 = 0.08;
const QUALITY: f64 = 0.25;

/// The cosine of the largest angle between a face and the mean normal of the scan in it (75°).
const FACING: f64 = 0.26;

/// The normals of single triangles are rough. The spread of a face whose sides are shorter than
/// `SHORT` edges of the scan may be larger: its cosine is `EASED` (80°). A face whose sides are
/// shorter than `TINY` edges may face anywhere. Without this, rough normals keep small clusters.
const SHORT: f64 = 5.0;
const TINY: f64 = 2.0;
const EASED: f64 = 0.17;

/// Collapses edges as long as the normals of the scan in each triangle are within an angle whose
/// cosine is `spread` of their mean.
pub(super) fn coarsen(base: &mut Base, quadrics: &[ErrorQuadric], spread: f64) {
    let mut queue = BinaryHeap::new();
    let mut versions = vec![0u32; base.around.len()];
    for v in 0..base.around.len() as u32 {
        push(base, quadrics, &mut queue, v, 0);
    }
    while let Some(Reverse((_, v, version))) = queue.pop() {
        if versions[v as usize] != version || base.valence(v) == 0 {
            continue;
        }
        let Some(ring) = base.ring(v) else { continue };
        let mut targets: Vec<(f64, usize)> =
            (0..ring.len()).map(|k| (cost(base, quadrics, v, ring[k].0), k)).collect();
        targets.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let change = targets.iter().find_map(|&(_, k)| collapse(base, spread, v, &ring, k));
        let Some(change) = change else { continue };
        base.replace(change.old, change.new, &change.corners, change.members);
        for &(w, _) in &ring {
            versions[w as usize] += 1;
            push(base, quadrics, &mut queue, w, versions[w as usize]);
        }
    }
}

/// The cost of removing a vertex, the vertex, and its version. The heap returns the least first.
type CollapseCandidate = Reverse<(OrderedFloat, u32, u32)>;

fn push(
    base: &Base,
    quadrics: &[ErrorQuadric],
    queue: &mut BinaryHeap<CollapseCandidate>,
    v: u32,
    version: u32,
) {
    let around = base.around[v as usize].iter();
    let others = around.flat_map(|&t| base.triangles[t as usize]).filter(|&w| w != v);
    let least = others.map(|w| cost(base, quadrics, v, w)).fold(f64::INFINITY, f64::min);
    if least.is_finite() {
        queue.push(Reverse((OrderedFloat(least), v, version)));
    }
}

/// The squared distances from planes, weighted by areas (Garland, Heckbert, "Surface simplification
/// using quadric error metrics", 1997).
#[derive(Debug, Clone, Copy)]
pub(super) struct ErrorQuadric {
    matrix: Matrix4<f64>,
    area: f64,
}

/// The quadrics of the triangles around every vertex.
pub(super) fn quadrics(base: &Base) -> Vec<ErrorQuadric> {
    let of = |around: &Vec<u32>| {
        let mut sum = ErrorQuadric { matrix: Matrix4::zeros(), area: 0.0 };
        for &t in around {
            let corners = base.triangles[t as usize];
            let normal = base.area_vector(corners);
            let area = normal.norm();
            let Some(n) = normal.try_normalize(0.0) else { continue };
            let plane = n.push(-n.dot(&base.point(corners[0]).coords));
            sum.matrix += area * plane * plane.transpose();
            sum.area += area;
        }
        sum
    };
    base.around.iter().map(of).collect()
}

fn cost(base: &Base, quadrics: &[ErrorQuadric], v: u32, target: u32) -> f64 {
    let q = &quadrics[v as usize];
    let at = base.point(target).coords.push(1.0);
    let distance = at.dot(&(q.matrix * at)) / q.area.max(f64::MIN_POSITIVE);
    distance + LENGTH * (base.point(target) - base.point(v)).norm_squared()
}

/// A change of the triangulation that may be made.
struct Change {
    old: Vec<Flat>,
    new: Vec<Flat>,
    corners: Vec<[u32; 3]>,
    members: Vec<Vec<(u32, [f64; 3])>>,
}

/// Moves vertex `v` onto entry `k` of its ring, if this is legal.
fn collapse(base: &Base, spread: f64, v: u32, ring: &[(u32, u32)], k: usize) -> Option<Change> {
    let m = ring.len();
    let u = ring[k].0;
    let at = |i: usize| ring[(k + i) % m].0;
    // The link condition: the two vertices have no common neighbours but those beside their edge.
    let shares = |i: usize| {
        base.around[u as usize].iter().any(|&t| base.triangles[t as usize].contains(&at(i)))
    };
    if m < 3 || (2..m - 1).any(shares) {
        return None;
    }
    let valence = base.valence(u) + m - 4;
    let loses = |i: usize| base.valence(at(i)) > LEAST_VALENCE;
    if valence > MOST_VALENCE.max(base.valence(u)) || valence < 3 || !loses(1) || !loses(m - 1) {
        return None;
    }
    let flat = flattened(base, v, ring)?;
    let place = |i: usize| flat[(k + i) % m];
    let flat_of = |w: u32| ring.iter().position(|r| r.0 == w).map_or(Uv::origin(), |i| flat[i]);
    let old: Vec<Flat> =
        ring.iter().map(|&(_, t)| (t, base.triangles[t as usize].map(flat_of))).collect();
    let new: Vec<Flat> = (1..m - 1).map(|i| (0, [place(0), place(i), place(i + 1)])).collect();
    let corners: Vec<[u32; 3]> = (1..m - 1).map(|i| [u, at(i), at(i + 1)]).collect();
    is_shaped(base, &old, &new, &corners).then_some(())?;
    let members = base.moved_members(&old, &new, Some(v));
    let faces = corners.iter().zip(&members);
    faces.into_iter().all(|(t, members)| faces_scan(base, spread, *t, members)).then_some(())?;
    Some(Change { old, new, corners, members })
}

/// The largest power. At the tip of a needle a larger one would leave no difference between short lengths.
const MOST_POWER: f64 = 4.0;

/// The ring of a vertex in the plane: its angles are scaled to a full circle, and its lengths raised
/// to the same power (Welch, Witkin 1994).
fn flattened(base: &Base, v: u32, ring: &[(u32, u32)]) -> Option<Vec<Uv>> {
    let m = ring.len();
    let arms: Vec<Vector> = ring.iter().map(|r| base.point(r.0) - base.point(v)).collect();
    let angles: Vec<f64> = (0..m).map(|i| arms[i].angle(&arms[(i + 1) % m])).collect();
    let sum: f64 = angles.iter().sum();
    let longest = arms.iter().map(|a| a.norm()).fold(0.0, f64::max);
    (sum > 0.0 && longest > 0.0).then_some(())?;
    let turned = std::f64::consts::TAU / sum;
    let power = turned.min(MOST_POWER);
    let mut turn: f64 = 0.0;
    let mut flat = Vec::with_capacity(m);
    for i in 0..m {
        let radius = (arms[i].norm() / longest).powf(power);
        flat.push(Uv::new(radius * turn.cos(), radius * turn.sin()));
        turn += turned * angles[i];
    }
    Some(flat)
}

/// Whether all new triangles have a good shape, or one no worse than the worst before.
pub(super) fn is_shaped(base: &Base, old: &[Flat], new: &[Flat], corners: &[[u32; 3]]) -> bool {
    let worst = |flats: &[Flat]| flats.iter().map(|f| quality(f.1)).fold(1.0, f64::min);
    let least = worst(new);
    if least <= 0.0 || least < FLAT_QUALITY.min(worst(old)) {
        return false;
    }
    let before = old.iter().map(|f| space_quality(base, base.triangles[f.0 as usize]));
    let before = before.fold(1.0, f64::min);
    corners.iter().all(|&t| space_quality(base, t) >= QUALITY.min(before))
}

/// The quality of a triangle in the plane, 1 if its sides are equal. It is negative if the triangle is turned over.
fn quality([a, b, c]: [Uv; 3]) -> f64 {
    let squares = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
    4.0 * EQUILATERAL * crate::geometry::orient2d(a, b, c) / squares.max(f64::MIN_POSITIVE)
}

pub(super) fn space_quality(base: &Base, t: [u32; 3]) -> f64 {
    let [a, b, c] = t.map(|v| base.point(v));
    let squares = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
    4.0 * EQUILATERAL * base.area_vector(t).norm() / squares.max(f64::MIN_POSITIVE)
}

/// Whether a triangle faces as the scan in it does, and the normals of the scan in it are within the
/// spread.
pub(super) fn faces_scan(
    base: &Base,
    spread: f64,
    t: [u32; 3],
    members: &[(u32, [f64; 3])],
) -> bool {
    let size = base.scan_edges(t);
    if size < TINY {
        return true;
    }
    let own = t.iter().map(|&v| base.normals[v as usize]);
    let all = || members.iter().map(|m| base.normals[m.0 as usize]);
    let mean: Vector = own.chain(all()).sum();
    let Some(mean) = mean.try_normalize(0.0) else { return false };
    let normal = base.area_vector(t).try_normalize(0.0).unwrap_or_default();
    if normal.dot(&mean) < FACING {
        return false;
    }
    let spread = if size < SHORT { spread.min(EASED) } else { spread };
    all().all(|n| n.dot(&mean) >= spread)
}
