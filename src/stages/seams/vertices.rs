//! Places of vertices: least squares on all surfaces around them, by steps of least length.

use nalgebra::{DMatrix, DVector, Vector3};

use super::contact::{contact, touch};
use super::network::ChainNetwork;
use super::{SeamFault, Work};
use crate::geometry::{Point, Vector};
use crate::primitives::{Primitive, PrimitiveKind};

const STEPS: usize = 15;

/// The step of the numerical derivative in mm, about the cube root of the rounding of coordinates.
const STEP: f64 = 1e-6;

/// Directions in which the surfaces hold a vertex less than this do not move it.
const HELD: f64 = 1e-5;

/// A vertex is on a surface within so many errors of the mesh's vertices, or this many mm, whichever is more.
const ERRORS: f64 = 20.0;
const ON: f64 = 1e-6;

/// A vertex stays so close to its place in the mesh, in mm or in errors.
const MOVED: f64 = 1e-4;
const MOVED_ERRORS: f64 = 100.0;

impl Work<'_> {
    /// Moves the vertices onto the surfaces. Facets do not hold vertices; their planes follow.
    pub(super) fn place_vertices(&self, network: &mut ChainNetwork) -> Result<(), SeamFault> {
        let mut around: Vec<Vec<usize>> = vec![Vec::new(); self.mesh.points.len()];
        for (t, corners) in self.mesh.triangles.iter().enumerate() {
            corners.iter().for_each(|v| around[v.index()].push(self.of_triangle[t]));
        }
        for (n, &v) in network.junctions.iter().enumerate() {
            let mut all = around[v as usize].clone();
            all.sort_unstable();
            all.dedup();
            let holding: Vec<usize> =
                all.iter().copied().filter(|&i| !self.patches[i].is_facet).collect();
            let surfaces: Vec<Primitive> =
                holding.iter().map(|&i| self.patches[i].surface).collect();
            let (start, error) = (network.vertices[n], self.errors[v as usize]);
            let (at, left) = placed(&surfaces, start, error);
            let moved = (at - start).norm();
            if left > ON.max(ERRORS * error) || moved > MOVED.max(MOVED_ERRORS * error) {
                let curved = |i: &usize| self.patches[*i].surface.kind() != PrimitiveKind::Plane;
                let mut bad: Vec<usize> = holding.iter().copied().filter(curved).collect();
                if bad.is_empty() {
                    bad = holding;
                }
                let why = format!("a vertex is {left:.1e} mm off its surfaces, moved {moved:.1e}");
                return Err(SeamFault::new(&bad, why));
            }
            network.vertices[n] = at;
        }
        Ok(())
    }
}

/// The point, and the largest residual there.
fn placed(surfaces: &[Primitive], start: Point, error: f64) -> (Point, f64) {
    let mut pairs = Vec::new();
    for (i, a) in surfaces.iter().enumerate() {
        let others = surfaces[i + 1..].iter();
        pairs.extend(others.filter(|b| touch(a, b, &[start], error)).map(|b| (a, b)));
    }
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
