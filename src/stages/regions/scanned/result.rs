//! Regions of triangles from labels of vertices.

use super::division::{Division, NORMAL_DEVIATION};
use super::model::MOST_SAMPLES;
use super::scan::{NoisyScan, some};
use super::seeds::FEWEST;
use crate::geometry::{NONE, VertexId};
use crate::mesh::EdgeMap;
use crate::primitives::{FitOptions, PrimitiveKind, fit};
use crate::stages::regions::{FaceRegion, FlatPairs, RegionOrigin, Regions};

pub(super) fn gathered(scan: &NoisyScan, edges: &EdgeMap, division: &Division) -> Regions {
    let mut of_triangle = labels_of_triangles(scan, division);
    let pieces = connected(edges, &mut of_triangle);
    let mut regions = Vec::new();
    for (label, triangles) in pieces {
        regions.extend(region(scan, division, label as usize, triangles));
    }
    regions.sort_by_key(|r| r.origin != RegionOrigin::Curved);
    let mut of_triangle = vec![NONE; scan.mesh.triangles.len()];
    let area = |t: usize| scan.mesh.area_vector(scan.mesh.triangles[t]).norm();
    let all: f64 = (0..of_triangle.len()).map(area).sum();
    let mut explained = 0.0;
    for (number, region) in regions.iter().enumerate() {
        for &t in &region.triangles {
            of_triangle[t as usize] = number as u32;
            explained += area(t as usize);
        }
    }
    let explained = if all > 0.0 { explained / all } else { 0.0 };
    Regions {
        regions,
        of_triangle,
        snaps: Vec::new(),
        prisms: Vec::new(),
        explained,
        pairs: FlatPairs { exact: 0, near: 0 },
        significant: explained,
    }
}

/// The region of each triangle: that of its corners, or of those the one whose surface is nearest.
fn labels_of_triangles(scan: &NoisyScan, division: &Division) -> Vec<u32> {
    let of = |(t, corners): (usize, &[VertexId; 3])| {
        let labels = corners.map(|v| division.labels[v.index()]);
        if labels[0] == labels[1] && labels[1] == labels[2] {
            return labels[0];
        }
        let cost = |label: u32| {
            let model = &division.parts[label as usize].model;
            let squares = corners.map(|v| model.cost_at(scan, v.0));
            let middle = nalgebra::center(
                &nalgebra::center(&scan.point(corners[0].0), &scan.point(corners[1].0)),
                &scan.point(corners[2].0),
            );
            let normal = model.side * model.surface.distance(middle).1;
            let angle = normal.dot(&scan.facings[t]).clamp(-1.0, 1.0).acos() / NORMAL_DEVIATION;
            squares.iter().sum::<f64>() + angle * angle
        };
        let known = labels.into_iter().filter(|&label| label != NONE);
        // A triangle with two free corners is free.
        if known.clone().count() < 2 {
            return NONE;
        }
        let rated = known.map(|label| (cost(label), label));
        rated.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map_or(NONE, |best| best.1)
    };
    scan.mesh.triangles.iter().enumerate().map(of).collect()
}

/// The connected pieces of the regions. Those with fewer triangles than a seed has vertices are given to what surrounds them.
fn connected(edges: &EdgeMap, of: &mut [u32]) -> Vec<(u32, Vec<u32>)> {
    let across = |t: u32| {
        let first = 3 * t as usize;
        (first..first + 3).filter_map(|side| Some(edges.across(side)? as u32 / 3))
    };
    let pieces = |of: &[u32]| {
        let mut is_seen = vec![false; of.len()];
        let mut all = Vec::new();
        for first in 0..of.len() as u32 {
            if is_seen[first as usize] {
                continue;
            }
            is_seen[first as usize] = true;
            let (mut found, mut done) = (vec![first], 0);
            while let Some(&t) = found.get(done) {
                done += 1;
                for other in across(t) {
                    if of[other as usize] == of[first as usize] && !is_seen[other as usize] {
                        is_seen[other as usize] = true;
                        found.push(other);
                    }
                }
            }
            found.sort_unstable();
            all.push((of[first as usize], found));
        }
        all
    };
    for (label, piece) in pieces(of) {
        if piece.len() >= FEWEST {
            continue;
        }
        let mut beside: Vec<u32> = piece
            .iter()
            .flat_map(|&t| across(t))
            .map(|t| of[t as usize])
            .filter(|&l| l != label)
            .collect();
        beside.sort_unstable();
        let most = beside.chunk_by(|a, b| a == b).max_by_key(|same| same.len());
        if let Some(home) = most.map(|same| same[0]) {
            piece.iter().for_each(|&t| of[t as usize] = home);
        }
    }
    pieces(of).into_iter().filter(|(label, _)| *label != NONE).collect()
}

fn region(
    scan: &NoisyScan,
    division: &Division,
    label: usize,
    triangles: Vec<u32>,
) -> Option<FaceRegion> {
    let model = division.parts[label].model;
    let corners = triangles.iter().flat_map(|&t| scan.mesh.triangles[t as usize].map(|v| v.0));
    let mut vertices: Vec<u32> =
        corners.filter(|&v| division.labels[v as usize] as usize == label).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let fitted: Vec<u32> = division.core(scan, label);
    let samples: Vec<_> = some(&fitted, MOST_SAMPLES).map(|v| scan.sample(v)).collect();
    let found = fit(model.surface, &samples, &FitOptions { steps: 1, ..FitOptions::default() })?;
    let origin = match model.kind() {
        PrimitiveKind::Plane => RegionOrigin::Flat,
        _ => RegionOrigin::Curved,
    };
    Some(FaceRegion {
        surface: found.surface,
        side: model.side,
        origin,
        triangles,
        vertices,
        slack: 1.0,
        is_told: false,
        motions: found.motions,
        covariance: found.covariance * scan.common,
    })
}
