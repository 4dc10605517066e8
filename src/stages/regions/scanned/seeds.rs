//! The search for regions: seeds off the creases first, then seeds anywhere among what is left.

use super::division::Division;
use super::growth::{Room, bounds_of_means, grow};
use super::scan::{CREASE, NoisyScan};
use crate::geometry::{NONE, Vector, plane_axes};
use nalgebra::{SMatrix, SVector};

/// The radii of seeds, in rings. Those anywhere have the last three.
const SEEDS: [usize; 5] = [7, 5, 4, 3, 2];

/// The fewest vertices of a seed, of a thin blend, and of a region whose kind is chosen again.
pub(super) const FEWEST: usize = 12;

/// A narrow seed is not tried if a quadric leaves so many times the noise.
const MOST_MISFIT: f64 = 4.0;

/// Searches from discs that hold neither a crease nor a vertex of another region, the widest first.
pub(super) fn off_creases(scan: &NoisyScan, room: &mut Room, division: &mut Division) {
    let means = bounds_of_means(scan);
    for rings in SEEDS {
        let mut is_tried = vec![false; scan.len()];
        loop {
            let depths =
                depths(scan, |v| scan.is_crease[v as usize] || division.labels[v as usize] != NONE);
            let mut candidates: Vec<u32> = (0..scan.len() as u32)
                .filter(|&v| !is_tried[v as usize] && depths[v as usize] > rings as u32)
                .collect();
            candidates.sort_by_key(|&v| std::cmp::Reverse(depths[v as usize]));
            let mut is_any = false;
            for v in candidates {
                if division.labels[v as usize] != NONE || is_tried[v as usize] {
                    continue;
                }
                let seed = room.ball(scan, v, rings, |_| true);
                if seed.iter().any(|&w| division.labels[w as usize] != NONE) {
                    continue;
                }
                match grow(scan, room, &means, &seed, &division.labels) {
                    Some((model, vertices)) => {
                        division.add(model, vertices);
                        is_any = true;
                    }
                    None => room
                        .ball(scan, v, (rings / 2).max(1), |_| true)
                        .into_iter()
                        .for_each(|w| is_tried[w as usize] = true),
                }
            }
            if !is_any {
                break;
            }
        }
    }
}

/// The number of edges from each vertex to the next one of a set.
pub(super) fn depths(scan: &NoisyScan, is_in: impl Fn(u32) -> bool) -> Vec<u32> {
    let mut depths = vec![NONE; scan.len()];
    let mut queue: Vec<u32> = (0..scan.len() as u32).filter(|&v| is_in(v)).collect();
    queue.iter().for_each(|&v| depths[v as usize] = 0);
    let mut done = 0;
    while let Some(&v) = queue.get(done) {
        done += 1;
        for &w in scan.near(v) {
            if depths[w as usize] == NONE {
                depths[w as usize] = depths[v as usize] + 1;
                queue.push(w);
            }
        }
    }
    depths
}

/// Searches from what is left of balls around any vertex, where the normals agree. Thin faces have no vertex off the
/// creases.
pub(super) fn anywhere(scan: &NoisyScan, room: &mut Room, division: &mut Division) {
    let means = bounds_of_means(scan);
    for &rings in &SEEDS[2..] {
        let mut candidates: Vec<(f64, u32)> = Vec::new();
        for v in 0..scan.len() as u32 {
            if division.labels[v as usize] == NONE {
                let seed = narrow_seed(scan, room, division, v, rings);
                if seed.len() >= FEWEST {
                    let misfit = misfit_of_quadric(scan, v, &seed, rings);
                    if misfit < MOST_MISFIT {
                        candidates.push((misfit, v));
                    }
                }
            }
        }
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut is_tried = vec![false; scan.len()];
        for (_, v) in candidates {
            if division.labels[v as usize] != NONE || is_tried[v as usize] {
                continue;
            }
            let seed = narrow_seed(scan, room, division, v, rings);
            if seed.len() < FEWEST {
                continue;
            }
            match grow(scan, room, &means, &seed, &division.labels) {
                Some((model, vertices)) => division.add(model, vertices),
                None => {
                    is_tried[v as usize] = true;
                    scan.near(v).iter().for_each(|&w| is_tried[w as usize] = true);
                }
            }
        }
    }
}

fn narrow_seed(
    scan: &NoisyScan,
    room: &mut Room,
    division: &Division,
    v: u32,
    rings: usize,
) -> Vec<u32> {
    let normal = scan.normal(v);
    let most = CREASE.cos();
    room.ball(scan, v, rings, |w| {
        division.labels[w as usize] == NONE && scan.normal(w).dot(&normal) > most
    })
}

/// The mean square that the best quadric over the tangent plane leaves, in variances of the noise.
fn misfit_of_quadric(scan: &NoisyScan, v: u32, vertices: &[u32], rings: usize) -> f64 {
    let sum: Vector = vertices.iter().map(|&w| scan.normal(w)).sum();
    let Some(normal) = sum.try_normalize(0.0) else { return f64::INFINITY };
    let (x, y) = plane_axes(normal);
    let size = rings as f64 * scan.edge;
    let mut matrix = SMatrix::<f64, 6, 6>::identity() * crate::geometry::ROUNDING;
    let mut right = SVector::<f64, 6>::zeros();
    let mut squares = 0.0;
    for &w in vertices {
        let q = scan.point(w) - scan.point(v);
        let (a, b) = (q.dot(&x) / size, q.dot(&y) / size);
        let height = q.dot(&normal) / scan.noise.at(w);
        let row = SVector::<f64, 6>::from_column_slice(&[1.0, a, b, a * a, a * b, b * b]);
        matrix += row * row.transpose();
        right += height * row;
        squares += height * height;
    }
    let Some(factor) = matrix.cholesky() else { return f64::INFINITY };
    let explained = factor.solve(&right).dot(&right);
    (squares - explained).max(0.0) / vertices.len().saturating_sub(6).max(1) as f64
}
