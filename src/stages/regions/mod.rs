//! The faces of a CAD model, found again in the mesh that was exported of it.
//!
//! Every vertex of such a mesh lies on the true surfaces around it within the rounding of the file, and every triangle
//! belongs to one true face. So a surface is hit or missed by orders of magnitude, and all decisions compare with the
//! rounding.
//!
//! - [`FileRounding`] tells how exactly the file states its coordinates, [`Tessellation`] measures the mesh,
//!   [`FlatPairs`] tells whether it is such an export at all.
//! - [`find`] makes facets of coplanar triangles, grows surfaces over them from seeds, lets the surfaces compete,
//!   and moves them within the rounding to where a designer would have put them.
//!
//! The method is RANSAC-like region growing (Schnabel, Wahl, Klein 2007; Attene, Patanè 2010), with the number of false
//! alarms of Desolneux, Moisan and Morel (2000) as the test of significance.

mod borders;
mod coincidences;
mod competition;
mod computed;
mod corners;
mod exact;
mod facets;
mod growth;
mod leftovers;
mod loose;
mod patches;
mod precision;
mod prisms;
mod result;
mod scanned;
mod search;
mod seeds;
mod significance;
mod snap;
mod tessellation;
#[cfg(test)]
mod tests;
mod tori;

pub use crate::mesh::FileRounding;
pub(crate) use crate::mesh::VertexErrors;
pub use computed::computed;
pub use exact::MOST_TURN;
pub use precision::FlatPairs;
pub use prisms::Prism;
pub(crate) use result::MOST_OF_IT;
pub use result::{FaceRegion, RegionOrigin, Regions};
pub use scanned::{ScanNoise, find_scanned};
pub use snap::{Snap, SnapKind};
pub(crate) use tessellation::MOST_ERRORS;
pub use tessellation::Tessellation;

use competition::Claims;
use exact::ExactFacets;
use facets::FacetMesh;
use growth::{GrownRegion, RegionMarks};
use search::SeedSearch;

use crate::geometry::NONE;

/// What a caller decides.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// The length of the mesh's unit in the unit of the file, in which round numbers are round.
    pub unit: f64,
    /// Whether prisms of five to eight sides stay flat even if the part's other faces speak for cylinders.
    pub keep_polygons: bool,
    /// No region reaches across an edge that turns by more than this angle, in radians. Without, evidence decides.
    pub sharp: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Options { unit: 1.0, keep_polygons: false, sharp: None }
    }
}

/// Finds the regions of a clean mesh.
pub fn find(mesh: &Tessellation, options: &Options) -> Regions {
    let sharp = options.sharp.unwrap_or(f64::INFINITY);
    let facets = FacetMesh::of(mesh, sharp);
    let count = facets.all.len();
    let mut evidence =
        ExactFacets { mesh, facets: facets.into(), slack: 1.0, closed: vec![false; count].into() };
    let pairs = FlatPairs::of(mesh);
    let is_noise = pairs.is_clean() == Some(false);
    let generous = if is_noise { 1.0 } else { most_slack(mesh) };
    let mut claims = Claims { regions: Vec::new(), of: vec![NONE; count], generous };
    // Noise has no surface to be found, only faces that happen to be flat.
    if !is_noise {
        search(&mut evidence, &mut claims, generous);
    }
    evidence.closed = vec![false; count].into();
    evidence.slack = generous;
    claims.absorb(&evidence, true);
    evidence.slack = 1.0;
    claims.merge(&evidence);
    evidence.slack = generous;
    let mut marks = RegionMarks::new(count, mesh.errors.len());
    claims.unify(&evidence, &mut marks);
    claims.absorb(&evidence, true);
    evidence.slack = 1.0;
    if claims.cut(&mut evidence) {
        claims.merge(&evidence);
    }
    let count = evidence.facets.all.len();
    let mut marks = RegionMarks::new(count, mesh.errors.len());
    let keep_polygons = options.keep_polygons || sharp < prisms::WIDEST_TURN;
    let prisms = prisms::find(&evidence, &mut claims, keep_polygons, &mut marks);
    let mut result = result::gathered(&evidence, &claims, pairs);
    result.prisms = prisms;
    result.snaps = snap::snap(mesh, &mut result, options.unit);
    result
}

/// Searches for regions with errors of growing size, up to so many times those of the mesh.
fn search(evidence: &mut ExactFacets, claims: &mut Claims, generous: f64) {
    loop {
        let mut hopeless = Vec::new();
        for _ in 0..MOST_SEARCHES {
            evidence.closed = claims.of.iter().map(|&r| r != NONE).collect::<Vec<_>>().into();
            let known = claims.regions.iter().map(GrownRegion::surface).collect();
            let mut search = SeedSearch::new(evidence, known, hopeless, generous);
            let found = search.run();
            let before = claims.regions.len();
            competition::compete(evidence, &mut search, found, claims);
            hopeless = search.into_hopeless();
            if claims.regions.len() == before {
                break;
            }
            claims.merge(evidence);
            claims.absorb(evidence, false);
        }
        if evidence.slack >= generous {
            break;
        }
        evidence.slack = (SLACK_STEP * evidence.slack).min(generous);
    }
}

/// Where faces meet, modelling kernels store curves that are a little off both, by errors of up to this share of the diagonal. Of the parts
/// that were measured, a nut is the farthest off, with 2.1e-5.
const LOOSE_EDGES: f64 = 2.5e-5;

/// The searches with the same errors. What a wrong region took from a right one before it lost is found by the next.
const MOST_SEARCHES: usize = 3;

/// The errors of each search among what is left are so many times larger than those of the search before. A region is found
/// with the smallest errors that explain it, to this factor.
const SLACK_STEP: f64 = 8.0;

/// The largest factor of the errors: vertices may be off as far as loose edges are.
fn most_slack(mesh: &Tessellation) -> f64 {
    let mut errors = mesh.errors.to_vec();
    errors.sort_unstable_by(f64::total_cmp);
    let middle = errors.get(errors.len() / 2).copied().unwrap_or(0.0);
    (LOOSE_EDGES * mesh.mesh.diagonal() / middle).max(1.0)
}
