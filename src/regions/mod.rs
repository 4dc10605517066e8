//! The faces of a CAD model, found again in the mesh that was exported of it.
//!
//! Every vertex of such a mesh lies on the true surfaces around it within the rounding of the file, and every triangle
//! belongs to one true face. So a surface is hit or missed by orders of magnitude, and all decisions compare with the
//! rounding.
//!
//! - [`Rounding`] tells how exactly the file states its coordinates, [`Tessellation`] measures the mesh,
//!   [`FlatPairs`] tells whether it is such an export at all.
//! - [`find`] makes facets of coplanar triangles, grows surfaces over them from seeds, lets the surfaces compete,
//!   and moves them within the rounding to where a designer would have put them.
//!
//! The method is RANSAC-like region growing (Schnabel, Wahl, Klein 2007; Attene, Patanè 2010), with the number of false
//! alarms of Desolneux, Moisan and Morel (2000) as the test of significance.

mod competition;
mod corners;
mod exact;
mod facets;
mod growth;
mod patches;
mod precision;
mod prisms;
mod rounding;
mod search;
mod significance;
mod snap;
mod tessellation;
#[cfg(test)]
mod tests;

pub use precision::FlatPairs;
pub use prisms::Prism;
pub use rounding::Rounding;
pub use snap::{Snap, SnapKind};
pub use tessellation::Tessellation;

use competition::Claims;
use exact::{ExactFacets, MOST_TURN};
use facets::Facets;
use growth::{Evidence, Growth, Marks};
use search::Search;

use crate::geometry::NONE;
use crate::sets::Sets;
use crate::primitives::{Covariance, FitOptions, Motions, Primitive, Sample, fit};

/// What a caller decides.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// The length of the mesh's unit in the unit of the file, in which round numbers are round.
    pub unit: f64,
    /// Whether prisms of five to eight sides stay flat even if the part's other faces speak for cylinders.
    pub keep_polygons: bool,
}

impl Default for Options {
    fn default() -> Self {
        Options { unit: 1.0, keep_polygons: false }
    }
}

/// What a region is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// A curved face.
    Curved,
    /// A flat face.
    Flat,
    /// A facet of a curved face whose surface was not found. It is a plane that says nothing about the design.
    Facet,
}

/// Triangles of one surface. They are connected across edges.
#[derive(Debug, Clone)]
pub struct Region {
    /// The surface, in the unit of the mesh. Snaps are applied.
    pub surface: Primitive,
    /// +1 if the outside of the mesh is where the distance to the surface is positive, -1 otherwise (a bore).
    pub side: f64,
    /// What the region is.
    pub origin: Origin,
    /// The triangles, ascending.
    pub triangles: Vec<u32>,
    /// The vertices that must lie on the surface, ascending: corners of the outlines of its facets; of a flat face all
    /// vertices.
    pub vertices: Vec<u32>,
    /// The motions of the surface before it was snapped, which `covariance` speaks of.
    pub motions: Motions,
    /// The covariance of these motions for independent errors of the vertices of the size of their bounds.
    pub covariance: Covariance,
}

/// The regions of a mesh.
#[derive(Debug, Clone)]
pub struct Regions {
    /// All regions: curved ones first, then flat ones and left-over facets.
    pub regions: Vec<Region>,
    /// For each triangle the number of its region.
    pub of_triangle: Vec<u32>,
    /// What was moved within the rounding.
    pub snaps: Vec<Snap>,
    /// Prisms of few sides, flat or not.
    pub prisms: Vec<Prism>,
    /// The share of the area that belongs to curved and flat faces, not to left-over facets.
    pub explained: f64,
}

/// Finds the regions of a clean mesh.
pub fn find(mesh: &Tessellation, options: &Options) -> Regions {
    let facets = Facets::of(mesh);
    let count = facets.all.len();
    let mut evidence = ExactFacets { mesh, facets, slack: 1.0, closed: vec![false; count] };
    let generous = if FlatPairs::of(mesh).is_clean() == Some(true) { most_slack(mesh) } else { 1.0 };
    let mut claims = Claims { regions: Vec::new(), of: vec![NONE; count], generous };
    loop {
        for _ in 0..MOST_SEARCHES {
            evidence.closed = claims.of.iter().map(|&r| r != NONE).collect();
            let known = claims.regions.iter().map(Growth::surface).collect();
            let mut search = Search::new(&evidence, known);
            let found = search.run();
            let before = claims.regions.len();
            competition::settle(&evidence, &mut search, found, &mut claims);
            if claims.regions.len() == before {
                break;
            }
            claims.merge(&evidence);
            claims.absorb(&evidence, false);
        }
        if evidence.slack >= generous {
            break;
        }
        evidence.slack = (SLACK_STEP * evidence.slack).min(generous);
    }
    evidence.closed.fill(false);
    evidence.slack = generous;
    claims.absorb(&evidence, true);
    evidence.slack = 1.0;
    claims.merge(&evidence);
    evidence.slack = generous;
    claims.unify(&evidence);
    claims.absorb(&evidence, true);
    evidence.slack = 1.0;
    claims.cut(&mut evidence);
    let count = evidence.facets.all.len();
    let mut marks = Marks::new(count, mesh.errors.len());
    let prisms = prisms::find(&evidence, &mut claims, options.keep_polygons, &mut marks);
    let mut result = gathered(&evidence, &claims);
    result.prisms = prisms;
    result.snaps = snap::snap(mesh, &mut result, options.unit);
    result
}

/// Where faces meet, modelling kernels store curves that are a little off both: up to this share of the diagonal in the parts
/// that were measured.
const LOOSE_EDGES: f64 = 2e-5;

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

/// Makes regions of the claims, and flat ones of the facets that are left.
fn gathered(evidence: &ExactFacets, claims: &Claims) -> Regions {
    let mut regions: Vec<Region> =
        claims.regions.iter().map(|growth| curved(evidence, growth)).collect();
    let leftovers = leftovers(evidence, claims);
    for f in (0..claims.of.len() as u32).filter(|&f| claims.of[f as usize] == NONE) {
        regions.push(flat(evidence, &leftovers, f));
    }
    let mut of_triangle = vec![NONE; evidence.mesh.areas.len()];
    let (mut all, mut explained) = (0.0, 0.0);
    for (number, region) in regions.iter().enumerate() {
        for &t in &region.triangles {
            of_triangle[t as usize] = number as u32;
            all += evidence.mesh.areas[t as usize];
            if region.origin != Origin::Facet {
                explained += evidence.mesh.areas[t as usize];
            }
        }
    }
    let explained = if all > 0.0 { explained / all } else { 0.0 };
    Regions { regions, of_triangle, snaps: Vec::new(), prisms: Vec::new(), explained }
}

/// So many facets that continue each other smoothly are a curved face that was not found. A profile of fewer flat faces is
/// usual.
const FEWEST_LEFTOVERS: usize = 5;

/// For each facet whether it belongs to a curved face that was not found.
fn leftovers(evidence: &ExactFacets, claims: &Claims) -> Vec<bool> {
    let facets = &evidence.facets.all;
    let is_free = |f: usize| claims.of[f] == NONE && !facets[f].is_flat;
    let smooth = |f: usize| facets[f].borders.iter().filter(|b| b.dihedral <= MOST_TURN);
    let mut sets = Sets::new(facets.len());
    let mut sizes = vec![0; facets.len()];
    for f in (0..facets.len()).filter(|&f| is_free(f)) {
        smooth(f).map(|b| b.facet as usize).filter(|&g| is_free(g)).for_each(|g| {
            sets.join(f, g);
        });
    }
    (0..facets.len()).filter(|&f| is_free(f)).for_each(|f| sizes[sets.find(f)] += 1);
    let mut is_left = |f: usize| {
        // A single triangle that continues a curved face is one that the face has lost.
        let is_lost = facets[f].triangles.len() == 1
            && smooth(f).any(|b| claims.of[b.facet as usize] != NONE);
        is_free(f) && (is_lost || sizes[sets.find(f)] >= FEWEST_LEFTOVERS)
    };
    (0..facets.len()).map(&mut is_left).collect()
}

fn curved(evidence: &ExactFacets, growth: &Growth) -> Region {
    let units = growth.units.iter();
    let mut triangles: Vec<u32> =
        units.flat_map(|&f| evidence.facets.get(f).triangles.iter().copied()).collect();
    triangles.sort_unstable();
    let mut vertices = growth.vertices.clone();
    vertices.sort_unstable();
    Region {
        surface: growth.surface(),
        side: growth.side,
        origin: Origin::Curved,
        triangles,
        vertices,
        motions: growth.fit.motions,
        covariance: growth.fit.covariance,
    }
}

fn flat(evidence: &ExactFacets, leftovers: &[bool], f: u32) -> Region {
    let facet = evidence.facets.get(f);
    let mut triangles = facet.triangles.clone();
    triangles.sort_unstable();
    let mut vertices: Vec<u32> = triangles.iter().flat_map(|&t| evidence.mesh.corners(t)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let start = Primitive::Plane { origin: facet.centre, normal: facet.normal };
    let samples: Vec<Sample> = vertices.iter().map(|&v| evidence.sample(v)).collect();
    let fitted = fit(start, &samples, &FitOptions::default());
    let surface = fitted.map_or(start, |fit| fit.surface);
    let motions = fitted.map_or(Motions::new(start, facet.centre, false), |fit| fit.motions);
    let covariance = fitted.map_or(Covariance::zeros(), |fit| fit.covariance);
    let is_facet = leftovers[f as usize];
    let origin = if is_facet { Origin::Facet } else { Origin::Flat };
    Region { surface, side: 1.0, origin, triangles, vertices, motions, covariance }
}
