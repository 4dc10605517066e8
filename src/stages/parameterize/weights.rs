//! The weight of each part of the surface in the energy. A spline needs more knots where the
//! surface is sharply curved for its size, and the map should leave space for them.

use rayon::prelude::*;

use crate::geometry::{Point, Vector};
use crate::mesh::one_rings::HalfEdgeCollapse;
use crate::mesh::progressive_mesh::{self, ProgressiveMesh};

/// The weights of vertices, as means over the part of the surface that each vertex represents.
#[derive(Debug, Clone, Default)]
pub(crate) struct Weights {
    /// The weight of each vertex.
    pub of: Vec<f64>,
    /// The amount of surface that each vertex represents, in any unit.
    mass: Vec<f64>,
}

/// A place has the weight 2 if its radius of curvature is this share of the square root of the
/// area.
const SHARP_RADIUS: f64 = 1.0 / 28.0;

/// A place gets more weight only if its curvature exceeds this multiple of the mean curvature. A
/// rough surface has no places that stand out.
const MIN_CURVATURE_RATIO: f64 = 4.0;

/// The largest weight.
const MAX_WEIGHT: f64 = 20.0;

/// The weight of the scaffold, which should give way.
const SCAFFOLD: f64 = 0.01;

/// The number of rounds in which the weights are averaged over neighbours.
const ROUNDS: usize = 3;

impl Weights {
    /// Equal weights.
    pub(crate) fn even(count: usize) -> Self {
        Weights { of: vec![1.0; count], mass: vec![1.0; count] }
    }

    /// Gives the vertices from `first` on, which belong to the scaffold, the weight of the
    /// scaffold.
    pub(crate) fn lighten(&mut self, first: usize) {
        self.of[first..].fill(SCAFFOLD);
    }

    /// Whether a vertex belongs to the scaffold. Weights by curvature are at least one.
    pub(crate) fn is_light(&self, v: u32) -> bool {
        self.of[v as usize] < 1.0
    }

    /// The weights by the curvature of the present mesh of a hierarchy. `area` is that of the
    /// surface, in mm².
    pub(crate) fn by_curvature(points: &[Point], hierarchy: &ProgressiveMesh, area: f64) -> Self {
        let mut weights = Weights::even(points.len());
        let (rings, remaining) = (&hierarchy.rings, &hierarchy.remaining);
        let mut normals = vec![Vector::zeros(); points.len()];
        let found: Vec<Vector> =
            remaining.par_iter().map(|&v| progressive_mesh::normal(points, rings, v)).collect();
        remaining.iter().zip(found).for_each(|(&v, normal)| normals[v as usize] = normal);
        let bend = |&v: &u32| {
            let turn = |&w: &u32| {
                let away = (points[w as usize] - points[v as usize]).norm_squared();
                let turn = (normals[w as usize] - normals[v as usize]).norm_squared();
                turn / away.max(f64::MIN_POSITIVE)
            };
            let ring = rings.ring(v);
            (ring.iter().map(turn).sum::<f64>() / ring.len().max(1) as f64).sqrt()
        };
        let bends: Vec<f64> = remaining.par_iter().map(bend).collect();
        let mean = bends.iter().sum::<f64>() / bends.len().max(1) as f64;
        let tight = (1.0 / (SHARP_RADIUS * area.sqrt())).max(MIN_CURVATURE_RATIO * mean);
        let of = bends.iter().map(|bend| 1.0 + (bend / tight).powi(3).min(MAX_WEIGHT - 1.0));
        remaining.iter().zip(of).for_each(|(&v, weight)| weights.of[v as usize] = weight);
        for _ in 0..ROUNDS {
            let mean = |&v: &u32| {
                let ring = rings.ring(v);
                let sum: f64 = ring.iter().map(|&w| weights.of[w as usize]).sum();
                0.5 * (weights.of[v as usize] + sum / ring.len().max(1) as f64)
            };
            let of: Vec<f64> = remaining.par_iter().map(mean).collect();
            remaining.iter().zip(of).for_each(|(&v, weight)| weights.of[v as usize] = weight);
        }
        weights
    }

    /// The weights of the vertices `remaining`, renumbered in their order.
    pub(crate) fn renumbered(&self, remaining: &[u32]) -> Self {
        let of = remaining.iter().map(|&v| self.of[v as usize]).collect();
        Weights { of, mass: remaining.iter().map(|&v| self.mass[v as usize]).collect() }
    }

    /// Adds the surface that a collapsed vertex represents to the apex of its fan.
    pub(crate) fn lump(&mut self, collapse: &HalfEdgeCollapse) {
        self.shift(collapse, 1.0);
    }

    /// Undoes [`Weights::lump`] when the vertex is split off again.
    pub(crate) fn unlump(&mut self, collapse: &HalfEdgeCollapse) {
        self.shift(collapse, -1.0);
    }

    fn shift(&mut self, collapse: &HalfEdgeCollapse, sign: f64) {
        if self.is_light(collapse.vertex) || self.is_light(collapse.fan().0) {
            return;
        }
        let (apex, v) = (collapse.fan().0 as usize, collapse.vertex as usize);
        let mass = self.mass[apex] + sign * self.mass[v];
        let whole = self.of[apex] * self.mass[apex] + sign * self.of[v] * self.mass[v];
        (self.of[apex], self.mass[apex]) = ((whole / mass).clamp(1.0, MAX_WEIGHT), mass);
    }

    /// Gives vertices that were not present when the curvature was measured the mean weight of
    /// their rings. No vertex is in the ring of another one.
    pub(crate) fn follow(&mut self, pass: &[HalfEdgeCollapse]) {
        let weigh = |collapse: &HalfEdgeCollapse| {
            if self.is_light(collapse.vertex) {
                return self.of[collapse.vertex as usize];
            }
            let sum: f64 = collapse.ring.iter().map(|&w| self.of[w as usize].max(1.0)).sum();
            sum / collapse.ring.len().max(1) as f64
        };
        let found: Vec<f64> = pass.par_iter().with_min_len(64).map(weigh).collect();
        pass.iter().zip(found).for_each(|(r, weight)| self.of[r.vertex as usize] = weight);
    }
}
