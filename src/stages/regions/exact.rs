//! The evidence of a clean mesh: facets whose corners lie on the surface within the rounding of the file.

use std::f64::consts::FRAC_PI_2;
use std::rc::Rc;

use super::facets::{Border, Facet, FacetMesh};
use super::growth::{Evidence, GrownRegion};
use super::tessellation::{MOST_ERRORS, SLIVER, Tessellation};
use crate::geometry::Vector;
use crate::primitives::{FitSample, OrientedPoint, Primitive, PrimitiveKind};

/// No facet of a curved face turns more than this from the next: nobody exports coarser than 9 segments a turn (40°).
/// It keeps cubes from becoming spheres (54.7°), and hexagons and octagons flat.
pub const MOST_TURN: f64 = 0.707;

/// From the middle of a facet to its corner is half a step across a ruled surface, and half a diagonal, ¾ step, of
/// a mesh in two directions.
const HALF_STEP: f64 = 0.5;
const HALF_DIAGONAL: f64 = 0.75;

/// Computed angles differ by so much for facets that are cut askew.
const ANGLE_SLACK: f64 = 1.05;

/// Steps of one face differ by less than 1.5, so sagittas by less than its square.
const SAGITTA_RATIO: f64 = 2.25;

/// The facets of a clean mesh as evidence.
#[derive(Clone)]
pub(super) struct ExactFacets<'a> {
    pub(super) mesh: &'a Tessellation<'a>,
    pub(super) facets: Rc<FacetMesh>,
    /// The factor by which all errors are larger than those of the file.
    pub(super) slack: f64,
    /// FacetMesh that no region may grow over.
    pub(super) closed: Rc<Vec<bool>>,
}

/// The largest distance of a facet of the growth from its surface.
pub(super) struct Sagitta(f64);

impl Evidence for ExactFacets<'_> {
    type Memory = Sagitta;

    fn begin(&self, surface: &Primitive, seed: &[u32]) -> Sagitta {
        Sagitta(seed.iter().map(|&f| self.sagitta(surface, self.facets.get(f))).fold(0.0, f64::max))
    }

    fn neighbours(&self, unit: u32, visit: &mut dyn FnMut(u32)) {
        let is_open = |b: &&Border| !b.is_sharp && !self.closed[b.facet as usize];
        let open = self.facets.get(unit).borders.iter().filter(is_open);
        open.for_each(|b| visit(b.facet));
    }

    fn vertices(&self, unit: u32) -> &[u32] {
        &self.facets.get(unit).corners
    }

    fn sample(&self, vertex: u32) -> FitSample {
        FitSample { at: self.mesh.point(vertex), error: self.error(vertex) }
    }

    fn bound(&self) -> f64 {
        MOST_ERRORS
    }

    fn slack(&self) -> f64 {
        self.slack
    }

    fn joins(
        &self,
        unit: u32,
        growth: &GrownRegion,
        largest: &mut Sagitta,
        is_settled: bool,
    ) -> bool {
        let facet = self.facets.get(unit);
        let surface = growth.surface();
        let on = |&v: &u32| {
            let s = self.sample(v);
            let d = surface.distance(s.at).0.abs();
            d <= MOST_ERRORS * s.error
                || !is_settled && {
                    let leverage = growth.fit.deviation_at(s.at) / s.error;
                    d <= MOST_ERRORS * s.error * (1.0 + leverage * leverage).sqrt()
                }
        };
        if !facet.corners.iter().all(on) || !self.faces(&surface, growth.side, facet) {
            return false;
        }
        let is_ruled = matches!(surface.kind(), PrimitiveKind::Cylinder | PrimitiveKind::Cone);
        let sagitta = self.sagitta(&surface, facet);
        if !is_settled && (facet.is_flat || is_ruled) && !self.is_as_flat(sagitta, largest.0, facet)
        {
            return false;
        }
        largest.0 = largest.0.max(sagitta);
        true
    }
}

impl ExactFacets<'_> {
    /// The same facets with other errors.
    pub(super) fn with_slack(&self, slack: f64) -> Self {
        ExactFacets { slack, ..self.clone() }
    }

    /// The error of a vertex.
    pub(super) fn error(&self, vertex: u32) -> f64 {
        self.slack * self.mesh.error(vertex)
    }

    /// How far a facet's normal may be off.
    pub(super) fn normal_error(&self, facet: &Facet) -> f64 {
        self.slack * facet.normal_error()
    }

    /// Whether a facet is as near to its surface as others of the same face.
    pub(super) fn is_as_flat(&self, sagitta: f64, largest: f64, facet: &Facet) -> bool {
        sagitta <= SAGITTA_RATIO * largest + MOST_ERRORS * self.slack * facet.error
    }

    /// The largest distance of a facet from a surface: at the middles of edges and of triangles.
    pub(super) fn sagitta(&self, surface: &Primitive, facet: &Facet) -> f64 {
        let mut largest = 0.0f64;
        for &t in &facet.triangles {
            let [a, b, c] = self.mesh.corners(t).map(|v| self.mesh.point(v));
            let centre = a + (b - a + (c - a)) / 3.0;
            for p in [a + (b - a) / 2.0, b + (c - b) / 2.0, a + (c - a) / 2.0, centre] {
                largest = largest.max(surface.distance(p).0.abs());
            }
        }
        largest
    }

    /// Whether a facet's normal is that of a chord of the surface: inside the fan of the normals at its corners.
    pub(super) fn faces(&self, surface: &Primitive, side: f64, facet: &Facet) -> bool {
        let share = match surface.kind() {
            PrimitiveKind::Cylinder | PrimitiveKind::Cone => HALF_STEP,
            _ => HALF_DIAGONAL,
        };
        self.turns_at_most(share * MOST_TURN, surface, side, facet)
    }

    /// The same with the largest angle between the facet and the normal at a corner.
    pub(super) fn turns_at_most(
        &self,
        most: f64,
        surface: &Primitive,
        side: f64,
        facet: &Facet,
    ) -> bool {
        if facet.width < SLIVER * self.slack * facet.error {
            return true;
        }
        let normals = self.corner_normals(surface, side, facet);
        let turn = |n: &Vector| n.cross(&facet.normal).norm().atan2(n.dot(&facet.normal));
        let turned = normals.iter().map(turn).fold(0.0, f64::max);
        let mut least = 1.0f64;
        for (i, n) in normals.iter().enumerate() {
            normals[..i].iter().for_each(|m| least = least.min(n.dot(m)));
        }
        let spread = least.clamp(-1.0, 1.0).acos();
        let slack = self.normal_error(facet);
        if turned <= most.min(spread) * ANGLE_SLACK + slack {
            return true;
        }
        // Where a chord along a ring is further inside than the next ring is away, the triangle between them leans.
        let lean = (self.sagitta(surface, facet) / (2.0 * facet.width)).min(1.0).asin();
        facet.triangles.len() == 1
            && spread <= 2.0 * most * ANGLE_SLACK + slack
            && turned <= ((spread + lean) * ANGLE_SLACK + slack).min(FRAC_PI_2)
    }

    /// The surface's normals at a facet's corners, on the side of the mesh. An apex has none.
    fn corner_normals(&self, surface: &Primitive, side: f64, facet: &Facet) -> Vec<Vector> {
        let apex = surface.apex();
        // A facet of many corners is flat; some of them show its fan.
        let stride = facet.corners.len().div_ceil(16);
        let corners = facet.corners.iter().step_by(stride.max(1));
        let away = |v: &&u32| {
            apex.is_none_or(|apex| (self.mesh.point(**v) - apex).norm() > 10.0 * self.error(**v))
        };
        corners.filter(away).map(|&v| side * surface.normal(self.mesh.point(v))).collect()
    }

    /// A facet as a start of a fit sees it.
    pub(super) fn facing(&self, facet: u32) -> OrientedPoint {
        let facet = self.facets.get(facet);
        OrientedPoint { centre: facet.centre, normal: facet.normal, area: facet.area }
    }

    /// On which side of a surface some facets lie: the sign of its normal that they have.
    pub(super) fn side(&self, surface: &Primitive, facets: &[u32]) -> f64 {
        let along = |&f: &u32| {
            let facet = self.facets.get(f);
            facet.area * surface.normal(facet.centre).dot(&facet.normal)
        };
        if facets.iter().map(along).sum::<f64>() < 0.0 { -1.0 } else { 1.0 }
    }
}
