//! A scan with what all steps need: neighbours, noise, and normals for decisions.

use rayon::prelude::*;

use super::ScanNoise;
use crate::geometry::{Point, Vector, VertexId};
use crate::mesh::{Mesh, VertexRings};
use crate::primitives::{FitSample, Primitive};

/// Normals that differ by more than this many radians at one vertex are those of a crease. Noise of a tenth of an edge
/// turns triangles by 8°, and the filter leaves a tenth of that.
pub(super) const CREASE: f64 = 0.44;

/// A vertex does not belong to a surface whose normal is farther from its own, in radians: the filtered normal of a
/// vertex beside an edge is off by about as much.
pub(super) const MOST_TURN: f64 = 0.35;

/// The rounds of the filter of normals. More change no normal by more than the noise that is left.
const FILTER_ROUNDS: usize = 12;

/// The filter takes normals that differ by less than this for equal, and by less than three times what the noise does
/// to them.
const LEAST_RANGE: f64 = 0.25;

/// A scan that is divided into regions.
pub(super) struct NoisyScan<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) noise: &'a ScanNoise,
    starts: Vec<u32>,
    near: Vec<u32>,
    /// The filtered normals of the vertices. Only decisions use them.
    pub(super) normals: Vec<Vector>,
    /// The filtered normals of the triangles.
    pub(super) facings: Vec<Vector>,
    /// Whether the filtered normals around a vertex differ.
    pub(super) is_crease: Vec<bool>,
    /// The mean length of the edges.
    pub(super) edge: f64,
    pub(super) diagonal: f64,
    /// By how much more the mean of many vertices varies than that of as many independent ones.
    pub(super) common: f64,
    most_turn: f64,
}

impl<'a> NoisyScan<'a> {
    pub(super) fn new(mesh: &'a Mesh, rings: &VertexRings, noise: &'a ScanNoise) -> Self {
        let (mut starts, mut near) = (vec![0], Vec::new());
        let mut around = Vec::new();
        for v in 0..mesh.points.len() {
            around.clear();
            around.extend(rings.neighbours(mesh, VertexId::from(v)).map(|w| w.0));
            around.sort_unstable();
            around.dedup();
            near.extend_from_slice(&around);
            starts.push(near.len() as u32);
        }
        let edge = mesh.mean_edge();
        let facings = filtered(mesh, rings, noise.deviation / edge);
        let mut normals = vec![Vector::zeros(); mesh.points.len()];
        for (t, facing) in mesh.triangles.iter().zip(&facings) {
            let area = mesh.area_vector(*t).norm();
            t.iter().for_each(|v| normals[v.index()] += area * facing);
        }
        normals.iter_mut().for_each(|n| *n = n.try_normalize(0.0).unwrap_or_else(Vector::zeros));
        let is_crease = |v: usize| {
            let around = rings.triangles(VertexId::from(v));
            around.iter().enumerate().any(|(k, &t)| {
                let other = |&u: &u32| facings[t as usize].dot(&facings[u as usize]);
                around[..k].iter().any(|u| other(u) < CREASE.cos())
            })
        };
        let is_crease = (0..mesh.points.len()).into_par_iter().map(is_crease).collect();
        let [one, two] = noise.correlation;
        NoisyScan {
            starts,
            near,
            normals,
            facings,
            is_crease,
            edge,
            diagonal: mesh.diagonal(),
            common: 1.0 + 6.0 * one + 12.0 * two,
            most_turn: MOST_TURN.cos(),
            mesh,
            noise,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.mesh.points.len()
    }

    pub(super) fn near(&self, v: u32) -> &[u32] {
        let v = v as usize;
        &self.near[self.starts[v] as usize..self.starts[v + 1] as usize]
    }

    pub(super) fn point(&self, v: u32) -> Point {
        self.mesh.points[v as usize]
    }

    pub(super) fn normal(&self, v: u32) -> Vector {
        self.normals[v as usize]
    }

    pub(super) fn sample(&self, v: u32) -> FitSample {
        FitSample { at: self.point(v), error: self.noise.at(v) }
    }

    /// At most so many of the vertices, evenly.
    pub(super) fn samples(&self, vertices: &[u32], most: usize) -> Vec<FitSample> {
        some(vertices, most).map(|v| self.sample(v)).collect()
    }

    /// The distance of a vertex from a surface in standard deviations, and the cosine of the angle between the normals.
    pub(super) fn residual(&self, surface: &Primitive, side: f64, v: u32) -> (f64, f64) {
        let (d, g) = surface.distance(self.point(v));
        (d / self.noise.at(v), side * g.dot(&self.normal(v)))
    }

    /// The distance of a vertex from a surface in standard deviations; infinite if their normals differ.
    pub(super) fn off(&self, surface: &Primitive, side: f64, v: u32) -> f64 {
        let (d, cosine) = self.residual(surface, side, v);
        if cosine > self.most_turn { d } else { f64::INFINITY }
    }

    /// +1 if the normals of most of these vertices are those of the surface, otherwise -1.
    pub(super) fn side(&self, surface: &Primitive, vertices: &[u32]) -> f64 {
        let normal = |v: u32| surface.distance(self.point(v)).1.dot(&self.normal(v));
        let sum: f64 = some(vertices, MOST_SIDES).map(normal).sum();
        if sum < 0.0 { -1.0 } else { 1.0 }
    }

    /// The standard deviation of the mean of the errors of `count` vertices that are neighbours.
    pub(super) fn deviation_of_mean(&self, count: usize) -> f64 {
        // Of the pairs of a vertex and its six neighbours twelve are one edge apart, and nine two.
        let [one, two] = self.noise.correlation;
        let shared = (12.0 * one + 9.0 * two) / 21.0;
        let count = count as f64;
        ((1.0 + (count - 1.0) * shared) / count).sqrt()
    }
}

/// The vertices that suffice to tell a side.
const MOST_SIDES: usize = 300;

/// At most so many of the items, evenly.
pub(super) fn some(items: &[u32], most: usize) -> impl Iterator<Item = u32> + '_ {
    let count = items.len().min(most);
    (0..count).map(move |k| items[k * items.len() / count])
}

/// The normals of the triangles after a bilateral filter (Zheng, Fu, Au, Tai, "Bilateral normal filtering for mesh
/// denoising", 2011). `noise` is the standard deviation of the vertices as a share of an edge.
fn filtered(mesh: &Mesh, rings: &VertexRings, noise: f64) -> Vec<Vector> {
    let count = mesh.triangles.len();
    let vectors: Vec<Vector> = mesh.triangles.iter().map(|&t| mesh.area_vector(t)).collect();
    let areas: Vec<f64> = vectors.iter().map(|v| v.norm()).collect();
    let unit = |v: &Vector| v.try_normalize(0.0).unwrap_or_else(Vector::zeros);
    let mut now: Vec<Vector> = vectors.iter().map(unit).collect();
    let middles: Vec<Vector> = mesh
        .triangles
        .iter()
        .map(|&t| mesh.corners(t).iter().map(|p| p.coords).sum::<Vector>() / 3.0)
        .collect();
    let around = |t: usize| {
        let mut others: Vec<u32> = mesh.triangles[t]
            .iter()
            .flat_map(|&v| rings.triangles(v))
            .copied()
            .filter(|&u| u as usize != t)
            .collect();
        others.sort_unstable();
        others.dedup();
        let apart = |u: u32| (middles[t] - middles[u as usize]).norm_squared();
        others.into_iter().map(|u| (u, apart(u))).collect::<Vec<_>>()
    };
    let mut around: Vec<Vec<(u32, f64)>> = (0..count).into_par_iter().map(around).collect();
    let pairs: usize = around.iter().map(Vec::len).sum();
    let apart = around.iter().flatten().map(|(_, square)| square.sqrt()).sum::<f64>();
    let wide = apart / pairs.max(1) as f64;
    for (t, others) in around.iter_mut().enumerate() {
        others.iter_mut().for_each(|(u, square)| {
            *square = areas[*u as usize] * (-*square / (2.0 * wide * wide)).exp();
        });
        others.push((t as u32, areas[t]));
    }
    let range = LEAST_RANGE.max(3.0 * noise);
    for _ in 0..FILTER_ROUNDS {
        let next = |t: usize| {
            let own = now[t];
            let weighted = |&(u, weight): &(u32, f64)| {
                let other = now[u as usize];
                let unlike = (own - other).norm_squared() / (2.0 * range * range);
                weight * (-unlike).exp() * other
            };
            unit(&around[t].iter().map(weighted).sum())
        };
        now = (0..count).into_par_iter().map(next).collect();
    }
    now
}
