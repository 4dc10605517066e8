//! Places of vertices: least squares on all surfaces around them, by steps of least length.

use nalgebra::{DMatrix, DVector, Vector3};

use super::contact::{contact, touch};
use super::fallback::SeamFault;
use super::network::ChainNetwork;
use super::shell::none;
use super::{FacePatch, Work};
use crate::geometry::{Point, Vector};
use super::FaceSurface;

const STEPS: usize = 15;

/// The step of the numerical derivative in mm, about the cube root of the rounding of coordinates.
const STEP: f64 = 1e-6;

/// Directions in which the surfaces hold a vertex less than this do not move it.
const HELD: f64 = 1e-5;

/// A vertex moves by less than this share of its shortest edge. What moves more changes which edges meet.
const MOVES: f64 = 0.25;

impl Work<'_> {
    /// For each vertex of the mesh the patches that hold it. Facets of one triangle follow instead.
    pub(super) fn holding(&self) -> Vec<Vec<usize>> {
        let mut around: Vec<Vec<usize>> = vec![Vec::new(); self.mesh.points.len()];
        for (t, corners) in self.mesh.triangles.iter().enumerate() {
            let own = self.of_triangle[t];
            if !self.patches[own].is_facet || self.patches[own].triangles.len() > 1 {
                corners.iter().for_each(|v| around[v.index()].push(own));
            }
        }
        for own in &mut around {
            own.sort_unstable();
            own.dedup();
        }
        around
    }

    /// Moves the vertices onto the surfaces. Facets of one triangle do not hold vertices; their planes follow.
    pub(super) fn place_vertices(&self, network: &mut ChainNetwork) -> Result<(), Vec<SeamFault>> {
        let around = self.holding();
        let mut shortest = vec![f64::INFINITY; self.mesh.points.len()];
        for side in 0..3 * self.mesh.triangles.len() {
            let (a, b) = self.mesh.side(side);
            let long = (self.mesh.point(a) - self.mesh.point(b)).norm();
            shortest[a.index()] = shortest[a.index()].min(long);
        }
        let mut faults = Vec::new();
        for (n, &v) in network.junctions.iter().enumerate() {
            let all = &around[v as usize];
            let patches: Vec<&FacePatch> = all.iter().map(|&i| &self.patches[i]).collect();
            let start = network.vertices[n];
            let error = self.errors[v as usize];
            let (mut at, mut left) = placed(&patches, start, error);
            if left >= self.limit {
                // Other surfaces say more exactly where it is than B-splines do.
                let exact: Vec<&FacePatch> =
                    patches.into_iter().filter(|patch| patch.surface.exact().is_some()).collect();
                (at, left) = placed(&exact, start, error);
            }
            let moved = (at - start).norm();
            if left < self.limit && moved < MOVES * shortest[v as usize] {
                network.vertices[n] = at;
            } else {
                let why = format!("a vertex is {left:.1e} mm off its surfaces, moved {moved:.1e}");
                faults.push(SeamFault::near(all, &[v], why));
            }
        }
        none(faults)
    }
}

/// The point, and the largest residual there. B-splines that touch other surfaces do not hold it.
fn placed(patches: &[&FacePatch], start: Point, error: f64) -> (Point, f64) {
    let mut pairs = Vec::new();
    let mut is_loose = vec![false; patches.len()];
    for (i, a) in patches.iter().enumerate() {
        for (k, b) in patches.iter().enumerate().skip(i + 1).filter(|(_, b)| !b.is_facet) {
            if a.is_facet || !touch(&a.surface, &b.surface, &[start], error) {
                continue;
            }
            match (a.surface.exact(), b.surface.exact()) {
                (Some(a), Some(b)) => pairs.push((a, b)),
                (a, b) => {
                    is_loose[i] |= a.is_none();
                    is_loose[k] |= b.is_none();
                }
            }
        }
    }
    let holding = patches.iter().zip(is_loose).filter(|(_, is_loose)| !is_loose);
    let surfaces: Vec<&FaceSurface> = holding.map(|(patch, _)| &patch.surface).collect();
    let residual = |p: Point| {
        let mut rows: Vec<f64> = surfaces.iter().map(|s| s.distance(p).0).collect();
        for (a, b) in &pairs {
            let off = p - contact(a, b, p);
            rows.extend([off.x, off.y, off.z]);
        }
        DVector::from_vec(rows)
    };
    let mut at = start;
    if surfaces.is_empty() {
        return (at, 0.0);
    }
    for _ in 0..STEPS {
        let rows = residual(at);
        if rows.amax() == 0.0 {
            break;
        }
        let columns = [Vector::x(), Vector::y(), Vector::z()].map(|e: Vector3<f64>| {
            (residual(at + STEP * e) - residual(at - STEP * e)) / (2.0 * STEP)
        });
        let svd = DMatrix::from_columns(&columns).svd(true, true);
        let Ok(step) = svd.solve(&-rows, HELD * svd.singular_values.max()) else { break };
        at += Vector::new(step[0], step[1], step[2]);
        if step.norm() < 1e-15 * at.coords.norm() {
            break;
        }
    }
    let left = residual(at).amax();
    (at, left)
}
