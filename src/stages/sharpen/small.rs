//! Surfaces of small pieces that no region holds: the wall of a hole in a sheet, the floor of a narrow bore.
//!
//! They have too few vertices to be found among all others. Beside known surfaces fewer are enough, as these tell directions: a floor
//! is across the axis of its bore or a cone about it, and a hole goes along the normal of its sheet.

use std::cmp::Ordering;

use super::labels::middle;
use super::{ScanSurface, Work};
use crate::geometry::{NONE, Point, Vector, VertexId};
use crate::primitives::{
    FitOptions, FitSample, OrientedPoint, Primitive, PrimitiveKind, fit, starts, with_axis,
};
use crate::statistics::{MeanSquare, SIGNIFICANT};

/// A piece has so many vertices more than its surface has parameters.
const SPARE: usize = 2;

/// Vertices on the rim of a piece may lie on the surfaces beside it. So this share of them may be farther off than noise explains.
const MOST_OFF: f64 = 0.25;

/// A surface near a piece.
struct Start {
    surface: Primitive,
    /// How many of its first motions are not made: two turns where its direction is known, and two shifts where its axis is.
    held: usize,
}

impl Start {
    fn parameters(&self) -> usize {
        self.surface.kind().parameters() - self.held
    }

    fn options(&self) -> FitOptions {
        let frozen = std::array::from_fn(|k| k < self.held);
        FitOptions { frozen, fixed_centre: self.held == AXIS, ..FitOptions::default() }
    }
}

/// What a known direction and a known axis hold.
const DIRECTION: usize = 2;
const AXIS: usize = 4;

/// A surface that explains a piece.
struct Explained {
    found: ScanSurface,
    /// How many vertices it leaves unexplained.
    left: usize,
    parameters: usize,
    /// The mean square of the distances of the others, in units of the noise.
    squares: f64,
}

impl Explained {
    /// The one that leaves fewest vertices comes first, then the simplest one.
    fn order(&self, other: &Self) -> Ordering {
        let [a, b] = [self, other].map(|of| (of.left, of.parameters));
        a.cmp(&b).then(self.squares.total_cmp(&other.squares))
    }
}

/// What is known of a piece.
struct SmallPiece {
    /// The vertices that belong to no region.
    points: Vec<Point>,
    facets: Vec<OrientedPoint>,
}

impl Work<'_> {
    /// Gives pieces that no region holds a surface of their own, where one explains their vertices.
    pub(super) fn find_small_faces(&mut self) {
        for piece in self.pieces() {
            if self.of[piece[0] as usize] != NONE {
                continue;
            }
            let own = self.small(&piece);
            let tried = self.starts(&piece, &own).into_iter();
            let fits = tried.filter_map(|start| self.explaining(start, &own));
            if let Some(Explained { found, .. }) = fits.min_by(Explained::order) {
                let is_same =
                    |of: &ScanSurface| of.surface == found.surface && of.side == found.side;
                let known = self.surfaces.iter().position(is_same);
                let number = known.unwrap_or(self.surfaces.len()) as u32;
                if known.is_none() {
                    self.surfaces.push(found);
                }
                piece.iter().for_each(|&t| self.of[t as usize] = number);
            }
        }
    }

    fn small(&self, piece: &[u32]) -> SmallPiece {
        let corners = piece.iter().flat_map(|&t| self.mesh.triangles[t as usize]);
        let is_inside =
            |v: &VertexId| self.rings.triangles(*v).iter().all(|&t| self.of[t as usize] == NONE);
        let mut inner: Vec<VertexId> = corners.filter(is_inside).collect();
        inner.sort_unstable();
        inner.dedup();
        let facet = |&t: &u32| {
            let corners = self.mesh.triangles[t as usize];
            let area = self.mesh.area_vector(corners);
            let centre = middle(self.mesh.corners(corners));
            let normal = area.try_normalize(f64::MIN_POSITIVE)?;
            Some(OrientedPoint { centre, normal, area: area.norm() })
        };
        SmallPiece {
            points: inner.iter().map(|&v| self.mesh.point(v)).collect(),
            facets: piece.iter().filter_map(facet).collect(),
        }
    }

    /// Surfaces near a piece.
    fn starts(&self, piece: &[u32], own: &SmallPiece) -> Vec<Start> {
        let SmallPiece { points, facets } = own;
        // A surface that is known already needs no parameters.
        let known =
            |of: &ScanSurface| Start { surface: of.surface, held: of.surface.kind().parameters() };
        let mut found: Vec<Start> = self.surfaces.iter().map(known).collect();
        let planes = starts(PrimitiveKind::Plane, points, facets, &[]);
        let mut normals: Vec<Vector> = Vec::new();
        for region in self.regions_beside(piece) {
            let surface = self.surface(region);
            let Some(axis) = surface.axis() else {
                normals.push(surface.normal(surface.origin()));
                continue;
            };
            let across =
                planes.iter().map(|of| Primitive::Plane { origin: of.origin(), normal: axis });
            found.extend(across.map(|surface| Start { surface, held: DIRECTION }));
            for kind in [PrimitiveKind::Cylinder, PrimitiveKind::Cone] {
                let about = with_axis(kind, points, surface.origin(), axis);
                found.extend(about.map(|surface| Start { surface, held: AXIS }));
            }
        }
        found.extend(planes.into_iter().map(|surface| Start { surface, held: 0 }));
        let along = starts(PrimitiveKind::Cylinder, points, facets, &normals).into_iter().skip(1);
        found.extend(along.map(|surface| Start { surface, held: DIRECTION }));
        found
    }

    /// The surface fitted to a piece, if noise explains how far nearly all of its vertices are off.
    fn explaining(&self, start: Start, own: &SmallPiece) -> Option<Explained> {
        let sample = |&at: &Point| FitSample { at, error: self.noise };
        let mut samples: Vec<FitSample> = own.points.iter().map(sample).collect();
        let fewest = ((1.0 - MOST_OFF) * samples.len() as f64).ceil() as usize;
        let (parameters, options) = (start.parameters(), start.options());
        let mut surface = start.surface;
        while samples.len() >= fewest.max(parameters + SPARE) {
            let free = (samples.len() - parameters) as f64;
            let found = fit(surface, &samples, &options)?;
            if parameters > 0 {
                surface = found.surface;
            }
            if found.squares <= free * MeanSquare(free).at(SIGNIFICANT) {
                let facing =
                    |of: &OrientedPoint| of.area * of.normal.dot(&surface.normal(of.centre));
                let is_inverted = own.facets.iter().map(facing).sum::<f64>() < 0.0;
                let side = if is_inverted { -1.0 } else { 1.0 };
                return Some(Explained {
                    found: ScanSurface { surface, side },
                    left: own.points.len() - samples.len(),
                    parameters,
                    squares: found.squares / free,
                });
            }
            let off = |of: &FitSample| surface.distance(of.at).0.abs();
            let worst = (0..samples.len())
                .max_by(|&a, &b| off(&samples[a]).total_cmp(&off(&samples[b])))?;
            samples.swap_remove(worst);
        }
        None
    }
}
