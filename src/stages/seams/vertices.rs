//! Places of vertices: least squares on all surfaces around them, by steps of least length.

use nalgebra::{DMatrix, DVector, Vector3};

use super::fallback::SeamFault;
use super::network::ChainNetwork;
use super::shell::none;
use super::{EXACT, FacePatch, Work};
use crate::geometry::{Point, Vector};
use crate::primitives::contact::{contact, touch};
use crate::primitives::{Primitive, PrimitiveKind};

const STEPS: usize = 15;

/// The step of the numerical derivative in mm, about the cube root of the rounding of coordinates.
const STEP: f64 = 1e-6;

/// Planes hold a vertex so many times as firmly as other surfaces: readers take edges that are not on their planes for
/// faults, whatever uncertainty a file states. So a residual that is just within the limit is exact on planes.
const FIRM: f64 = 1e3;

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
            if !self.is_bent(own) {
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
        let mut around = self.holding();
        self.hold_at_rims(network, &mut around);
        let mut shortest = vec![f64::INFINITY; self.mesh.points.len()];
        for side in 0..3 * self.mesh.triangles.len() {
            let (a, b) = self.mesh.side(side);
            let long = (self.mesh.point(a) - self.mesh.point(b)).norm();
            shortest[a.index()] = shortest[a.index()].min(long);
        }
        let mut faults = Vec::new();
        for (n, &v) in network.junctions.iter().enumerate() {
            let all = &around[v as usize];
            let mut patches: Vec<&FacePatch> = all.iter().map(|&i| &self.patches[i]).collect();
            // Pieces of one surface hold a vertex once.
            patches.dedup_by_key(|patch| patch.surface);
            let start = network.vertices[n];
            let error = self.errors[v as usize];
            let limit = self.limit_at(error);
            let (at, left) = placed(&patches, start, error, limit);
            let moved = (at - start).norm();
            if left < limit && moved < MOVES * shortest[v as usize] {
                network.vertices[n] = at;
            } else {
                let why = format!("a vertex is {left:.1e} mm off its surfaces, moved {moved:.1e}");
                faults.push(SeamFault::near(all, &[v], why));
            }
        }
        none(faults)
    }
}

fn is_plane(of: &Primitive) -> bool {
    of.kind() == PrimitiveKind::Plane
}

/// The point, and its largest distance from a surface.
pub(super) fn placed(patches: &[&FacePatch], start: Point, error: f64, limit: f64) -> (Point, f64) {
    let surfaces: Vec<&Primitive> = patches.iter().map(|patch| &patch.surface).collect();
    let mut pairs = Vec::new();
    for (i, a) in patches.iter().enumerate() {
        let others = patches[i + 1..].iter().filter(|b| !a.is_facet && !b.is_facet);
        let others = others.map(|b| &b.surface);
        let touching = others.filter(|b| touch(&a.surface, b, &[start], error));
        pairs.extend(touching.map(|b| (&a.surface, b)));
    }
    let residual = |p: Point| {
        let weight = |s: &Primitive| if is_plane(s) { FIRM } else { 1.0 };
        let mut rows: Vec<f64> = surfaces.iter().map(|s| weight(s) * s.distance(p).0).collect();
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
    let off = |s: &&Primitive| s.distance(at).0.abs();
    // What planes are off counts as much as it may be on others.
    let planes = surfaces.iter().copied().filter(|s| is_plane(s));
    let off_planes = planes.map(|s| off(&s)).fold(0.0, f64::max) * (limit / EXACT);
    (at, surfaces.iter().map(off).fold(off_planes, f64::max))
}
