//! Vertices of a noisy mesh moved onto the surfaces of its regions, so that the mesh becomes a clean tessellation.
//!
//! The input is a closed mesh, surfaces, and for each triangle the surface that it lies on. The output is a mesh whose
//! vertices lie on their surfaces to the last digits: those inside of a region on its surface, those between two regions on
//! the curve in which the surfaces cross or touch, and those where more regions meet on all of them. The border of the
//! triangles is only the start of these curves.
//!
//! - `small` finds the surfaces of pieces that are too small to be found without what is beside them.
//! - `labels` smooths the borders by likelihood, and gives small pieces to their neighbours.
//! - `relations` finds the conditions of a designer that the data allow: surfaces that touch, parallel directions, equal radii, and others.
//! - `sizes` finds round numbers within the uncertainty of sizes.
//! - `constraints` moves the surfaces, weighted by their covariances, so that all conditions are met exactly.
//! - `places` moves the vertices. Where surfaces have no common point nearby, the triangles there lose their region.

mod borders;
mod constraints;
mod labels;
mod places;
mod relations;
mod risers;
mod sizes;
mod small;
mod surfaces;

use places::Placed;

use crate::geometry::{NONE, Point};
use crate::mesh::{EdgeMap, Mesh, VertexRings};
use crate::primitives::{Primitive, Uncertainty};
pub use constraints::Size;
pub use sizes::{RoundSize, SizeKind};

/// The surface of a region.
#[derive(Debug, Clone, Copy)]
pub struct ScanSurface {
    /// The surface, in the unit of the mesh.
    pub surface: Primitive,
    /// +1 if the outside of the mesh is where the distance to the surface is positive, -1 otherwise.
    pub side: f64,
}

/// What is known of the scan.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// The standard deviation of the vertices along the normal.
    pub noise: f64,
    /// The variance of a mean of many neighbouring vertices, as a multiple of what it would be if their errors were independent.
    pub correlation: f64,
    /// Systematic errors of the scanner, which neighbouring vertices share.
    pub bias: f64,
    /// The length of the mesh's unit in that of the file, in which numbers are round.
    pub unit: f64,
    /// Whether sizes are made round where the scan allows it.
    pub regularize: bool,
}

/// Triangles that join surfaces which do not meet.
#[derive(Debug, Clone)]
pub struct Riser {
    /// The place, in the unit of the mesh.
    pub place: Point,
    /// The number of its triangles.
    pub triangles: usize,
    /// The reason.
    pub why: &'static str,
}

/// A mesh with its vertices on their surfaces.
#[derive(Debug, Clone)]
pub struct Sharpened {
    /// The mesh.
    pub mesh: Mesh,
    /// For each of its triangles the number of the surface.
    pub of_triangle: Vec<u32>,
    /// For each of its triangles that has no surface the number of its facet. The triangles of a facet follow each other.
    pub facet_of: Vec<u32>,
    /// The surfaces. Constraints are met.
    pub surfaces: Vec<ScanSurface>,
    /// For each surface how exactly its vertices tell it.
    pub uncertainties: Vec<Option<Uncertainty>>,
    /// Sizes that are round within their uncertainty.
    pub round_sizes: Vec<RoundSize>,
    /// The number of pairs of surfaces that touch.
    pub touching: usize,
    /// Where surfaces do not meet.
    pub risers: Vec<Riser>,
}

/// The mesh with what all steps need.
struct Work<'a> {
    mesh: &'a Mesh,
    edges: EdgeMap,
    rings: VertexRings,
    /// The mean length of the edges.
    edge: f64,
    noise: f64,
    correlation: f64,
    bias: f64,
    surfaces: Vec<ScanSurface>,
    /// For each triangle its surface.
    of: Vec<u32>,
}

/// Moves the vertices of a closed mesh onto the surfaces of its triangles.
pub fn sharpen(
    mesh: &Mesh,
    surfaces: &[ScanSurface],
    of_triangle: &[u32],
    options: &Options,
) -> Sharpened {
    let (edges, rings) = (EdgeMap::new(mesh), VertexRings::new(mesh));
    let count = 3 * mesh.triangles.len();
    let long = |side: usize| {
        let (a, b) = mesh.side(side);
        (mesh.point(a) - mesh.point(b)).norm()
    };
    let edge = (0..count).map(long).sum::<f64>() / count.max(1) as f64;
    let Options { noise, correlation, bias, unit, regularize } = *options;
    let (surfaces, of) = (surfaces.to_vec(), of_triangle.to_vec());
    let mut work = Work { mesh, edges, rings, edge, noise, correlation, bias, surfaces, of };
    work.tidy();
    let fits = work.fitted();
    let mut conditions = work.conditions(&fits);
    let mut touching = work.meet(&conditions, &fits);
    let mut round_sizes = work.round_sizes(&fits, unit);
    if regularize {
        conditions.extend(round_sizes.iter().map(RoundSize::condition));
        touching = work.meet(&conditions, &fits);
        work.mark_taken(&mut round_sizes);
    }
    let Placed { mesh, of, facet, risers } = work.place(&touching);
    let (of_triangle, facet_of, touching) = (of, facet, touching.len());
    let uncertainties = fits.iter().map(|fit| fit.uncertainty).collect();
    let surfaces = work.surfaces;
    Sharpened {
        mesh,
        of_triangle,
        facet_of,
        surfaces,
        uncertainties,
        round_sizes,
        touching,
        risers,
    }
}

impl Work<'_> {
    /// The regions around a vertex, ascending, without those triangles that have none.
    fn around(&self, v: u32) -> Vec<u32> {
        let triangles = self.rings.triangles(crate::geometry::VertexId(v)).iter();
        let mut all: Vec<u32> =
            triangles.map(|&t| self.of[t as usize]).filter(|&r| r != NONE).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    fn surface(&self, region: u32) -> &Primitive {
        &self.surfaces[region as usize].surface
    }
}
