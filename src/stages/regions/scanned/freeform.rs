//! Which regions are faces, and which are pieces of a free-form surface that a simple one happens to fit.
//!
//! A face ends at an edge: a little beyond its border the scan leaves its surface abruptly, or another face begins.
//! From a piece of a free-form surface the scan departs slowly, as a cubic does.

use std::collections::BTreeMap;

use super::division::Division;
use super::growth::Room;
use super::model::MOST_OFF;
use super::scan::Scan;
use super::seeds::depths;
use crate::geometry::{NONE, SAME_SIDE};

/// The share of abrupt places that makes a region a face, and the share of places that are abrupt or faces.
const ABRUPT: f64 = 0.8;
const BORDERED: f64 = 0.7;

/// A region must be so many rings deep to be a face by itself.
const LEAST_DEPTH: u32 = 3;

/// The places that are looked at lie half as many rings outside as the region is deep, within these bounds.
const RINGS_OUTSIDE: [u32; 2] = [2, 12];

/// What lies beyond a region's border.
struct Outside {
    depth: u32,
    /// For each place whether it is abrupt, and its region.
    places: Vec<(bool, u32)>,
}

/// Gives up the regions that are not faces.
pub(super) fn give_up(scan: &Scan, room: &mut Room, division: &mut Division) {
    let alive: Vec<usize> = division.alive().collect();
    let outside: Vec<Outside> = alive.iter().map(|&a| outside(scan, room, division, a)).collect();
    let mut is_face = vec![false; division.parts.len()];
    let share = |beyond: &Outside, is_face: &[bool]| {
        let ends = |&&(is_abrupt, label): &&(bool, u32)| {
            is_abrupt || label != NONE && is_face[label as usize]
        };
        let count = beyond.places.iter().filter(ends).count();
        if beyond.places.is_empty() { 1.0 } else { count as f64 / beyond.places.len() as f64 }
    };
    for (&a, beyond) in alive.iter().zip(&outside) {
        let only_abrupt = vec![false; division.parts.len()];
        is_face[a] = beyond.depth >= LEAST_DEPTH && share(beyond, &only_abrupt) >= ABRUPT;
    }
    loop {
        let before = is_face.clone();
        for (&a, beyond) in alive.iter().zip(&outside) {
            is_face[a] |= share(beyond, &is_face) >= BORDERED;
        }
        if is_face == before {
            break;
        }
    }
    for a in alive.into_iter().filter(|&a| !is_face[a]) {
        division.parts[a].vertices.iter().for_each(|&v| division.labels[v as usize] = NONE);
    }
    division.list();
}

fn outside(scan: &Scan, room: &mut Room, division: &Division, a: usize) -> Outside {
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
    scan: &Scan,
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

/// Left-over vertices that are nowhere farther than this from a region belong to it.
const THIN: u32 = 2;

/// Gives what is left to the nearest surfaces where it is too thin to be a face. What is deeper stays free-form.
pub(super) fn fill_thin(scan: &Scan, division: &mut Division) {
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
        .filter(|&v| piece[v as usize] != NONE && deepest[piece[v as usize] as usize] <= THIN)
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
