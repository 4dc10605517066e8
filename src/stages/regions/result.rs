//! The regions as callers see them.

use super::competition::Claims;
use super::exact::{ExactFacets, MOST_TURN};
use super::growth::{Evidence, GrownRegion};
use super::precision::FlatPairs;
use super::prisms::Prism;
use super::snap::Snap;
use super::tessellation::Tessellation;
use crate::geometry::NONE;
use crate::geometry::sets::Sets;
use crate::primitives::{
    Covariance, FitOptions, FitSample, Motions, Primitive, PrimitiveKind, fit,
};

/// What a region is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RegionOrigin {
    /// A curved face.
    Curved,
    /// A flat face.
    Flat,
    /// A facet of a curved face whose surface was not found. It is a plane that says nothing about the design.
    Facet,
}

/// Triangles of one surface. They are connected across edges.
#[derive(Debug, Clone)]
pub struct FaceRegion {
    /// The surface, in the unit of the mesh. Snaps are applied.
    pub surface: Primitive,
    /// +1 if the outside of the mesh is where the distance to the surface is positive, -1 otherwise (a bore).
    pub side: f64,
    /// What the region is.
    pub origin: RegionOrigin,
    /// The triangles, ascending.
    pub triangles: Vec<u32>,
    /// The vertices that must lie on the surface, ascending: corners of the outlines of its facets; of a flat face all
    /// vertices.
    pub vertices: Vec<u32>,
    /// The vertices may be off the surface by so many times their bounds, as edges of the model are off its surfaces.
    pub slack: f64,
    /// Whether only some of them may be off, as the others tell the surface.
    pub(crate) is_told: bool,
    /// The motions of the surface before it was snapped, which `covariance` speaks of.
    pub motions: Motions,
    /// The covariance of these motions for independent errors of the vertices of the size of their bounds.
    pub covariance: Covariance,
}

/// The regions of a mesh.
#[derive(Debug, Clone)]
pub struct Regions {
    /// All regions: curved ones first, then flat ones and left-over facets.
    pub regions: Vec<FaceRegion>,
    /// For each triangle the number of its region.
    pub of_triangle: Vec<u32>,
    /// What was moved within the rounding.
    pub snaps: Vec<Snap>,
    /// Prisms of few sides, flat or not.
    pub prisms: Vec<Prism>,
    /// The share of the area that belongs to curved and flat faces, not to left-over facets.
    pub explained: f64,
    /// How many pairs of neighbouring triangles are flat within the rounding, and how many nearly so.
    pub pairs: FlatPairs,
    /// The share of the area that belongs to faces which chance does not explain: see [`Regions::is_significant`].
    pub significant: f64,
}

/// The exact faces are the part if they are most of it: what is left then are a few faces of other kinds.
pub(crate) const MOST_OF_IT: f64 = 0.5;

impl Regions {
    /// The share of the area that is on curved faces.
    pub(crate) fn curved_share(&self, mesh: &Tessellation) -> f64 {
        let curved = self.regions.iter().filter(|of| of.surface.kind() != PrimitiveKind::Plane);
        let area: f64 = curved.flat_map(|of| &of.triangles).map(|&t| mesh.areas[t as usize]).sum();
        area / mesh.areas.iter().sum::<f64>().max(f64::MIN_POSITIVE)
    }

    /// Whether the mesh is a clean tessellation most of whose area belongs to exact faces: a CAD export. False for scans,
    /// for remeshed and smoothed models, and for free-form models.
    ///
    /// Curved faces count, because each passed a test of significance. Flat ones count if they hold more vertices than
    /// a facet of a smooth surface has and the mesh has more pairs that are flat within the rounding than pairs that are
    /// nearly so. Faces also count that have nothing but creases and curved faces around them, as those of a cube and of a
    /// hexagon key. No face counts if the pairs are those of noise.
    pub fn is_significant(&self) -> bool {
        self.significant > MOST_OF_IT
    }
}

/// Whether chance does not explain a region.
fn is_significant(
    evidence: &ExactFacets,
    claims: &Claims,
    pairs: &FlatPairs,
    region: &FaceRegion,
) -> bool {
    let is_bordered = || {
        let facet = evidence.facets.of[region.triangles[0] as usize];
        let borders = &evidence.facets.get(facet).borders;
        let ends =
            |facet: u32, dihedral: f64| dihedral > MOST_TURN || claims.of[facet as usize] != NONE;
        !borders.is_empty() && borders.iter().all(|b| ends(b.facet, b.dihedral))
    };
    match (region.origin, pairs.is_clean()) {
        (RegionOrigin::Facet, _) | (_, Some(false)) => false,
        (RegionOrigin::Curved, _) => true,
        (RegionOrigin::Flat, Some(true)) => region.vertices.len() > FACET_CORNERS || is_bordered(),
        (RegionOrigin::Flat, None) => is_bordered(),
    }
}

/// The facets of a smooth surface have three corners, or four where a program makes flat quadrangles.
const FACET_CORNERS: usize = 4;

/// Makes regions of the claims, and flat ones of the facets that are left.
pub(super) fn gathered(evidence: &ExactFacets, claims: &Claims, pairs: FlatPairs) -> Regions {
    let mut regions: Vec<FaceRegion> =
        claims.regions.iter().map(|growth| curved(evidence, growth)).collect();
    let leftovers = leftovers(evidence, claims);
    for f in (0..claims.of.len() as u32).filter(|&f| claims.of[f as usize] == NONE) {
        regions.push(flat(evidence, &leftovers, f));
    }
    let mut of_triangle = vec![NONE; evidence.mesh.areas.len()];
    let (mut all, mut explained, mut significant) = (0.0, 0.0, 0.0);
    for (number, region) in regions.iter().enumerate() {
        region.triangles.iter().for_each(|&t| of_triangle[t as usize] = number as u32);
        let area: f64 = region.triangles.iter().map(|&t| evidence.mesh.areas[t as usize]).sum();
        all += area;
        explained += if region.origin == RegionOrigin::Facet { 0.0 } else { area };
        significant += if is_significant(evidence, claims, &pairs, region) { area } else { 0.0 };
    }
    let [explained, significant] =
        [explained, significant].map(|part| if all > 0.0 { part / all } else { 0.0 });
    let (snaps, prisms) = (Vec::new(), Vec::new());
    Regions { regions, of_triangle, snaps, prisms, explained, pairs, significant }
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

fn curved(evidence: &ExactFacets, growth: &GrownRegion) -> FaceRegion {
    let units = growth.units.iter();
    let mut triangles: Vec<u32> =
        units.flat_map(|&f| evidence.facets.get(f).triangles.iter().copied()).collect();
    triangles.sort_unstable();
    let mut vertices = growth.vertices.clone();
    vertices.sort_unstable();
    FaceRegion {
        surface: growth.surface(),
        side: growth.side,
        origin: RegionOrigin::Curved,
        triangles,
        vertices,
        slack: growth.slack,
        is_told: growth.is_told,
        motions: growth.fit.motions,
        covariance: growth.fit.covariance,
    }
}

fn flat(evidence: &ExactFacets, leftovers: &[bool], f: u32) -> FaceRegion {
    let facet = evidence.facets.get(f);
    let mut triangles = facet.triangles.clone();
    triangles.sort_unstable();
    let mut vertices: Vec<u32> = triangles.iter().flat_map(|&t| evidence.mesh.corners(t)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let start = Primitive::Plane { origin: facet.centre, normal: facet.normal };
    let samples: Vec<FitSample> = vertices.iter().map(|&v| evidence.sample(v)).collect();
    let fitted = fit(start, &samples, &FitOptions::default());
    let surface = fitted.map_or(start, |fit| fit.surface);
    let motions = fitted.map_or(Motions::new(start, facet.centre, false), |fit| fit.motions);
    let covariance = fitted.map_or(Covariance::zeros(), |fit| fit.covariance);
    let is_facet = leftovers[f as usize];
    let origin = if is_facet { RegionOrigin::Facet } else { RegionOrigin::Flat };
    FaceRegion {
        surface,
        side: 1.0,
        origin,
        triangles,
        vertices,
        slack: 1.0,
        is_told: false,
        motions,
        covariance,
    }
}
