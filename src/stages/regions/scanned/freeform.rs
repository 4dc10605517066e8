//! Which regions are faces, and which are pieces of a free-form surface that a simple one happens to fit.
//!
//! A face ends at an edge: a little beyond its border the scan leaves its surface abruptly, or another face begins.
//! From a piece of a free-form surface the scan departs slowly, as a cubic does.

use std::collections::BTreeMap;

use super::division::Division;
use super::growth::Room;
use super::model::MOST_OFF;
use super::scan::{CREASE, MOST_TURN, NoisyScan};
use super::seeds::depths;
use crate::geometry::{NONE, SAME_SIDE, Vector};
use crate::primitives::PrimitiveKind;

/// The share of abrupt places that makes a region a face, and the share of places that are abrupt or faces.
const ABRUPT: f64 = 0.9;
const BORDERED: f64 = 0.75;

/// A region must be so many rings deep to be a face by itself. A blend is at most so deep, and what is left over is
/// no face if it is less.
const LEAST_DEPTH: u32 = 3;

/// The places that are looked at lie half as many rings outside as the region is deep, within these bounds.
const RINGS_OUTSIDE: [u32; 2] = [2, 12];

/// A free-form surface is somewhere deeper than this, in rings; a chain of blends is not.
const BLEND_DEPTH: u32 = 9;

/// A scan of whose vertices fewer than this share lie on faces is a free-form one.
const FEW_FACES: f64 = 0.1;

/// What lies beyond a region's border.
struct Outside {
    depth: u32,
    /// For each place whether it is abrupt, and its region.
    places: Vec<(bool, u32)>,
}

/// Which regions are faces by themselves or with the faces beside them.
struct FoundFaces {
    alive: Vec<usize>,
    outside: Vec<Outside>,
    is_face: Vec<bool>,
}

impl FoundFaces {
    fn of(scan: &NoisyScan, room: &mut Room, division: &Division) -> Self {
        let alive: Vec<usize> = division.alive().collect();
        let outside: Vec<Outside> =
            alive.iter().map(|&a| outside(scan, room, division, a)).collect();
        let mut is_slight = vec![false; division.parts.len()];
        for &a in &alive {
            let part = &division.parts[a];
            let is_plane = part.model.kind() == PrimitiveKind::Plane;
            // Two slightly bent surfaces that continue each other are one free-form surface.
            is_slight[a] = !is_plane && spread(scan, &part.vertices) < MOST_TURN;
        }
        let share = |a: usize, beyond: &Outside, is_face: &[bool]| {
            let ends = |&&(is_abrupt, label): &&(bool, u32)| {
                let is_face = || label != NONE && is_face[label as usize];
                is_abrupt || is_face() && !(is_slight[a] && is_slight[label as usize])
            };
            let count = beyond.places.iter().filter(ends).count();
            if beyond.places.is_empty() { 1.0 } else { count as f64 / beyond.places.len() as f64 }
        };
        let none = vec![false; division.parts.len()];
        let mut is_face = none.clone();
        for (&a, beyond) in alive.iter().zip(&outside) {
            is_face[a] = beyond.depth >= LEAST_DEPTH && share(a, beyond, &none) >= ABRUPT;
        }
        loop {
            let before = is_face.clone();
            for (&a, beyond) in alive.iter().zip(&outside) {
                is_face[a] |= share(a, beyond, &is_face) >= BORDERED;
            }
            if is_face == before {
                break;
            }
        }
        FoundFaces { alive, outside, is_face }
    }
}

/// Whether nearly the whole scan is free-form. Then chance makes some of its pieces look like faces, and all regions
/// but flat faces are given up.
pub(super) fn is_free_form(scan: &NoisyScan, room: &mut Room, division: &mut Division) -> bool {
    let faces = FoundFaces::of(scan, room, division);
    let count = |&&a: &&usize| faces.is_face[a];
    let found = faces.alive.iter().filter(count).map(|&a| division.parts[a].vertices.len());
    let share = found.sum::<usize>() as f64 / scan.len() as f64;
    if share >= FEW_FACES {
        return false;
    }
    for &a in &faces.alive {
        let part = &division.parts[a];
        if !faces.is_face[a] || part.model.kind() != PrimitiveKind::Plane {
            part.vertices.iter().for_each(|&v| division.labels[v as usize] = NONE);
        }
    }
    division.list();
    true
}

/// Gives up the regions that are not faces.
pub(super) fn give_up(scan: &NoisyScan, room: &mut Room, division: &mut Division) {
    let FoundFaces { alive, outside, is_face } = FoundFaces::of(scan, room, division);
    let is_left = |v: u32| {
        let label = division.labels[v as usize];
        label == NONE || !is_face[label as usize]
    };
    let is_deep = deep_clusters(scan, is_left);
    for (&a, beyond) in alive.iter().zip(&outside).filter(|(a, _)| !is_face[**a]) {
        let part = &division.parts[a];
        let deep = part.vertices.iter().filter(|&&v| is_deep[v as usize]).count();
        let is_bent = part.model.kind() != PrimitiveKind::Plane;
        if is_bent && beyond.depth > LEAST_DEPTH || 2 * deep > part.vertices.len() {
            part.vertices.iter().for_each(|&v| division.labels[v as usize] = NONE);
        }
    }
    division.list();
}

/// Whether each vertex belongs to a smooth cluster of vertices that are left which is somewhere so deep that it has
/// room for a free-form surface. The others are chains of blends between faces.
fn deep_clusters(scan: &NoisyScan, is_left: impl Fn(u32) -> bool) -> Vec<bool> {
    let turn = CREASE.cos();
    let is_joined = |v: u32, w: u32| is_left(w) && scan.normal(v).dot(&scan.normal(w)) > turn;
    let is_inner = |v: u32| is_left(v) && scan.near(v).iter().all(|&w| is_joined(v, w));
    let depths = depths(scan, |v| !is_inner(v));
    let mut is_deep = vec![false; scan.len()];
    let mut is_seen = vec![false; scan.len()];
    for first in 0..scan.len() as u32 {
        if is_seen[first as usize] || !is_left(first) {
            continue;
        }
        is_seen[first as usize] = true;
        let (mut found, mut done) = (vec![first], 0);
        while let Some(&v) = found.get(done) {
            done += 1;
            for &w in scan.near(v) {
                if !is_seen[w as usize] && is_joined(v, w) {
                    is_seen[w as usize] = true;
                    found.push(w);
                }
            }
        }
        if found.iter().any(|&v| depths[v as usize] > BLEND_DEPTH) {
            found.into_iter().for_each(|v| is_deep[v as usize] = true);
        }
    }
    is_deep
}

/// The angle over which the normals of vertices spread, if they do so along an arc.
fn spread(scan: &NoisyScan, vertices: &[u32]) -> f64 {
    let sum: Vector = vertices.iter().map(|&v| scan.normal(v)).sum();
    (24.0 * (1.0 - sum.norm() / vertices.len() as f64)).max(0.0).sqrt()
}

fn outside(scan: &NoisyScan, room: &mut Room, division: &Division, a: usize) -> Outside {
    let part = &division.parts[a];
    let is_own = |v: u32| division.labels[v as usize] as usize == a;
    room.clear();
    let is_border = |v: &u32| scan.near(*v).iter().any(|&w| !is_own(w));
    let border: Vec<u32> = part.vertices.iter().copied().filter(is_border).collect();
    let inward = rings(scan, room, &border, u32::MAX, is_own);
    let depth = inward.len() as u32;
    let count = depth.div_ceil(2).clamp(RINGS_OUTSIDE[0], RINGS_OUTSIDE[1]);
    let most = MOST_OFF * (1.0 + f64::from(count) / f64::from(depth.max(1))).powi(3);
    let outward = rings(scan, room, &border, count, |v| !is_own(v));
    let place = |&v: &u32| {
        let (d, cosine) = scan.residual(&part.model.surface, part.model.side, v);
        (d.abs() > most || cosine < SAME_SIDE, division.labels[v as usize])
    };
    let last = if outward.len() as u32 > count { outward.last() } else { None };
    Outside { depth, places: last.map_or(Vec::new(), |ring| ring.iter().map(place).collect()) }
}

/// The rings of allowed vertices around some vertices, these first.
fn rings(
    scan: &NoisyScan,
    room: &mut Room,
    first: &[u32],
    most: u32,
    is_allowed: impl Fn(u32) -> bool,
) -> Vec<Vec<u32>> {
    room.clear();
    first.iter().for_each(|&v| {
        room.mark(v);
    });
    let mut found = vec![first.to_vec()];
    while (found.len() as u32) <= most {
        let mut next = Vec::new();
        for &v in found.last().into_iter().flatten() {
            for &w in scan.near(v) {
                if is_allowed(w) && room.mark(w) {
                    next.push(w);
                }
            }
        }
        if next.is_empty() {
            break;
        }
        found.push(next);
    }
    found
}

/// Gives what is left to the nearest surfaces where it is too thin to be a face. What is deeper stays free-form.
pub(super) fn fill_thin(scan: &NoisyScan, division: &mut Division) {
    let depths = depths(scan, |v| division.labels[v as usize] != NONE);
    let mut piece = vec![NONE; scan.len()];
    let mut deepest = Vec::new();
    for first in 0..scan.len() as u32 {
        if division.labels[first as usize] != NONE || piece[first as usize] != NONE {
            continue;
        }
        let number = deepest.len() as u32;
        piece[first as usize] = number;
        let (mut found, mut done, mut most) = (vec![first], 0, 0);
        while let Some(&v) = found.get(done) {
            done += 1;
            most = most.max(depths[v as usize]);
            for &w in scan.near(v) {
                if division.labels[w as usize] == NONE && piece[w as usize] == NONE {
                    piece[w as usize] = number;
                    found.push(w);
                }
            }
        }
        deepest.push(most);
    }
    let mut left: Vec<u32> = (0..scan.len() as u32)
        .filter(|&v| piece[v as usize] != NONE && deepest[piece[v as usize] as usize] < LEAST_DEPTH)
        .collect();
    while !left.is_empty() {
        let mut given = BTreeMap::new();
        for &v in &left {
            let labels = scan.near(v).iter().map(|&w| division.labels[w as usize]);
            let rated = labels.filter(|&label| label != NONE).map(|label| {
                let model = &division.parts[label as usize].model;
                let (d, cosine) = scan.residual(&model.surface, model.side, v);
                let away = if cosine < 0.0 { scan.edge / scan.noise.at(v) } else { 0.0 };
                (d.abs() + away, label)
            });
            if let Some((_, label)) = rated.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))) {
                given.insert(v, label);
            }
        }
        if given.is_empty() {
            break;
        }
        given.iter().for_each(|(&v, &label)| division.labels[v as usize] = label);
        left.retain(|v| !given.contains_key(v));
    }
    division.list();
}
