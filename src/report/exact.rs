//! The figures of exact faces: the parameters of their surfaces, bores and shafts, what was snapped, and what stayed
//! in facets.

use std::f64::consts::{PI, TAU};

use super::exact_sizes::{self, PlaneDistanceFigures, SizeFigures};
use super::relations::{self, RelationFigures};
use crate::convert::ExactFit;
use crate::geometry::{Point, Vector, plane_axes};
use crate::primitives::Primitive;
use crate::stages::regions::{Snap, SnapKind};
use crate::stages::seams::{ClosedGap, Fallback, GapFill};
use crate::stages::sharpen::Riser;
use crate::words::grouped;

/// What exact faces are, and what is not exact.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct ExactFigures {
    /// The percentage of the area whose surface was found.
    pub explained_pct: f64,
    /// The bound of the errors of the vertices: the rounding of the file. Two values of the part are the same if they
    /// differ by twice as much at the most, and two directions if lines of the length of the part do.
    pub rounding_mm: f64,
    /// The factor by which it is larger than the rounding of the file, as programs leave it that compute in 32 bits. 1 for
    /// most files.
    pub rounding_factor: f64,
    /// Bores and shafts: cylinders, one for each axis and radius, the widest first.
    pub cylinders: Vec<CylinderFigures>,
    /// Cylinders of equal radius, on one axis, and with parallel and perpendicular axes.
    pub relations: Vec<RelationFigures>,
    /// What was moved within the rounding of the file.
    pub snaps: Vec<SnapFigures>,
    /// Sizes of a scan that are round within two standard deviations.
    pub round_sizes: Vec<SizeFigures>,
    /// The distances of parallel planes, each to the next one of its direction.
    pub distances: Vec<PlaneDistanceFigures>,
    /// Faces that were found, but became facets.
    pub facets: Vec<FacetFigures>,
    /// The number of free-form faces, which are B-splines where no surface was found.
    pub free_forms: usize,
    /// Where the surfaces of a scan do not meet, so that other faces join them.
    pub risers: Vec<RiserFigures>,
    /// Gaps of the mesh that were closed.
    pub gaps: Vec<GapFigures>,
}

/// The parameters of a surface. Those that its kind does not have are `None`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct SurfaceFigures {
    /// "plane", "cylinder", "cone", "sphere" or "torus".
    pub kind: &'static str,
    /// A point of a plane or of an axis, or the centre of a sphere or a torus.
    pub at: [f64; 3],
    /// The normal of a plane, or the direction of an axis.
    pub axis: Option<[f64; 3]>,
    /// The radius; of a cone at `at`, and of a torus that of its circle.
    pub radius_mm: Option<f64>,
    /// The radius of the tube of a torus.
    pub tube_radius_mm: Option<f64>,
    /// The angle between the axis of a cone and its generators, in degrees.
    pub half_angle_deg: Option<f64>,
}

/// A cylinder of a part.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct CylinderFigures {
    /// If it goes all around: "bore" where the material is outside of it, and otherwise "shaft". If it does not: "fillet"
    /// and "round".
    pub kind: &'static str,
    /// Its radius.
    pub radius_mm: f64,
    /// The standard deviation of the radius, if it is that of a scan.
    pub radius_deviation_mm: Option<f64>,
    /// The middle of its axis.
    pub at: [f64; 3],
    /// The direction of its axis.
    pub axis: [f64; 3],
    /// Its extent along the axis.
    pub length_mm: f64,
    /// The angle that its faces cover, in degrees.
    pub sweep_deg: f64,
    /// The faces that are on it, as positions in the list of faces.
    pub faces: Vec<usize>,
}

/// What was moved within the rounding of the file.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct SnapFigures {
    /// The face, as a position in the list of faces.
    pub face: u32,
    /// What it was moved to: "axis of the world", "parallel", "perpendicular", "coaxial", "round place",
    /// "round value" or "tangent".
    pub to: &'static str,
    /// The surface before.
    pub before: SurfaceFigures,
    /// The surface after.
    pub after: SurfaceFigures,
}

/// A face that became facets.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct FacetFigures {
    /// The kind of its surface.
    pub surface: &'static str,
    /// The number of its triangles.
    pub triangles: usize,
    /// A point of it.
    pub at: [f64; 3],
    /// Why.
    pub why: String,
}

/// Triangles that join surfaces of a scan which do not meet.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct RiserFigures {
    /// The number of the triangles.
    pub triangles: usize,
    /// A point of them.
    pub at: [f64; 3],
    /// Why.
    pub why: &'static str,
}

/// A gap of the mesh that was closed.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct GapFigures {
    /// The number of the vertices of its rim.
    pub rim_vertices: usize,
    /// The length of its rim.
    pub rim_length_mm: f64,
    /// The number of vertices that were added.
    pub added_vertices: usize,
    /// The number of triangles that were added.
    pub added_triangles: usize,
    /// The middle of its rim.
    pub at: [f64; 3],
    /// What closes it: "extension" of the faces beside it, "plane" for planes through its rim, "bore" for a cylinder to
    /// another rim, or "facets", all or some.
    pub closed_by: &'static str,
}

impl ExactFigures {
    /// The figures of exact faces.
    pub fn of(fit: &ExactFit) -> Self {
        let cylinders = cylinders(fit);
        // The conditions between surfaces of a scan are met as exactly as CAD programs tell.
        let same = if fit.noise.is_some() { SAME } else { fit.rounding };
        ExactFigures {
            explained_pct: 100.0 * fit.explained,
            rounding_mm: fit.rounding,
            rounding_factor: fit.rounding_factor,
            relations: relations::relations(&cylinders, same, fit.mesh.diagonal()),
            cylinders,
            snaps: fit.snaps.iter().map(|snap| SnapFigures::of(snap, fit.mm)).collect(),
            round_sizes: fit.round_sizes.iter().map(SizeFigures::of).collect(),
            distances: exact_sizes::distances(fit),
            facets: fit.fallbacks.iter().map(FacetFigures::of).collect(),
            free_forms: fit.free_forms,
            risers: fit.risers.iter().map(RiserFigures::of).collect(),
            gaps: fit.gaps.iter().map(GapFigures::of).collect(),
        }
    }

    /// The cylinders in lines for people, those of one kind, radius and direction together: "2 bores of radius
    /// 2.750 mm along z, at …".
    pub fn cylinder_lines(&self) -> Vec<String> {
        relations::lists(&self.relations, &self.cylinders)
    }

    /// The relations in short phrases, one for each kind that there is: "equal radii 2 × 2.750 mm".
    pub fn relation_phrases(&self) -> Vec<String> {
        relations::phrases(&self.relations, &self.cylinders)
    }

    /// What was snapped in short phrases: "8 to an axis of the world".
    pub fn snap_phrases(&self) -> Vec<String> {
        let said = |(to, words): (&str, &str)| {
            let count = self.snaps.iter().filter(|snap| snap.to == to).count();
            (count > 0).then(|| format!("{} {words}", grouped(count)))
        };
        SNAPPED.into_iter().filter_map(said).collect()
    }
}

/// What surfaces are snapped to, and in words.
const SNAPPED: [(&str, &str); 7] = [
    ("axis of the world", "to an axis of the world"),
    ("parallel", "to be parallel"),
    ("perpendicular", "to be perpendicular"),
    ("coaxial", "to be coaxial"),
    ("round place", "to a round place"),
    ("round value", "to a round value"),
    ("tangent", "to be tangent"),
];

impl CylinderFigures {
    /// What it is in words: "bore", "shaft", "fillet" or "round edge".
    pub fn name(&self) -> &'static str {
        if self.kind == "round" { "round edge" } else { self.kind }
    }
}

impl SurfaceFigures {
    pub(super) fn of(surface: &Primitive) -> Self {
        let figures = SurfaceFigures {
            kind: surface.kind().name(),
            at: surface.origin().into(),
            axis: surface.axis().map(<[f64; 3]>::from),
            radius_mm: surface.radius(),
            tube_radius_mm: None,
            half_angle_deg: None,
        };
        match *surface {
            Primitive::Plane { normal, .. } => {
                SurfaceFigures { axis: Some(normal.into()), ..figures }
            }
            Primitive::Cone { radius, angle, .. } => SurfaceFigures {
                radius_mm: Some(radius),
                half_angle_deg: Some(angle.to_degrees()),
                ..figures
            },
            Primitive::Torus { major, minor, .. } => {
                SurfaceFigures { radius_mm: Some(major), tube_radius_mm: Some(minor), ..figures }
            }
            Primitive::Cylinder { .. } | Primitive::Sphere { .. } => figures,
        }
    }
}

impl SnapFigures {
    fn of(snap: &Snap, mm: f64) -> Self {
        let [before, after] =
            [snap.before, snap.after].map(|surface| SurfaceFigures::of(&surface.scaled(mm)));
        let to = match snap.kind {
            SnapKind::World => "axis of the world",
            SnapKind::Parallel => "parallel",
            SnapKind::Perpendicular => "perpendicular",
            SnapKind::Coaxial => "coaxial",
            SnapKind::Place => "round place",
            SnapKind::Value => "round value",
            SnapKind::Tangent => "tangent",
        };
        SnapFigures { face: snap.region, to, before, after }
    }
}

impl RiserFigures {
    fn of(riser: &Riser) -> Self {
        RiserFigures { triangles: riser.triangles, at: riser.place.into(), why: riser.why }
    }
}

impl FacetFigures {
    fn of(fallback: &Fallback) -> Self {
        let Fallback { kind, triangles, place, why } = fallback;
        FacetFigures {
            surface: kind.name(),
            triangles: *triangles,
            at: (*place).into(),
            why: why.clone(),
        }
    }
}

impl GapFigures {
    fn of(gap: &ClosedGap) -> Self {
        GapFigures {
            rim_vertices: gap.rim_vertices,
            rim_length_mm: gap.rim_length,
            added_vertices: gap.added_vertices,
            added_triangles: gap.added_triangles,
            at: gap.place.into(),
            closed_by: match gap.fill {
                GapFill::Extension => "extension",
                GapFill::Plane => "plane",
                GapFill::Bore => "bore",
                GapFill::Facets => "facets",
            },
        }
    }
}

/// The bores and shafts.
fn cylinders(fit: &ExactFit) -> Vec<CylinderFigures> {
    let mut found: Vec<(Primitive, CylinderFigures)> = Vec::new();
    let extents = extents(fit);
    for (number, face) in fit.faces.iter().enumerate() {
        let Primitive::Cylinder { radius, axis, .. } = face.surface else { continue };
        let deviation = face.uncertainty.and_then(|of| of.radius);
        let kind = if face.side < 0.0 { "bore" } else { "shaft" };
        let [low, high] = extents[number];
        // A sliver of a face may hold no triangle, and then it has no place either.
        if !(high - low).norm().is_finite() {
            continue;
        }
        let is_same = |(other, row): &(Primitive, CylinderFigures)| {
            row.kind == kind && is_one(other, &face.surface, (high - low).norm())
        };
        if let Some((_, row)) = found.iter_mut().find(|row| is_same(row)) {
            let middle = Point::from(row.at);
            let half = 0.5 * row.length_mm * Vector::from(row.axis);
            let along = |p: &Point| (p - middle).dot(&Vector::from(row.axis));
            let ends = [low, high, middle - half, middle + half];
            let [least, most] = [f64::min, f64::max]
                .map(|of| ends.iter().map(along).reduce(of).unwrap_or_default());
            row.at = (middle + 0.5 * (least + most) * Vector::from(row.axis)).into();
            row.length_mm = most - least;
            // All are one cylinder, which the best known face tells.
            row.radius_deviation_mm =
                [row.radius_deviation_mm, deviation].into_iter().flatten().reduce(f64::min);
            row.faces.push(number);
            continue;
        }
        let row = CylinderFigures {
            kind,
            radius_mm: radius,
            radius_deviation_mm: deviation,
            at: (low + 0.5 * (high - low)).into(),
            axis: axis.into(),
            length_mm: (high - low).norm(),
            sweep_deg: 0.0,
            faces: vec![number],
        };
        found.push((face.surface, row));
    }
    let arcs = arcs(fit);
    let named = |(_, row): (Primitive, CylinderFigures)| {
        let covered =
            covered(row.faces.iter().flat_map(|&face| arcs[face].iter().copied()).collect());
        let kind = match (covered >= TAU, row.kind) {
            (false, "bore") => "fillet",
            (false, _) => "round",
            (true, kind) => kind,
        };
        let axis = upright(row.axis);
        CylinderFigures { kind, axis, sweep_deg: covered.to_degrees(), ..row }
    };
    let mut rows: Vec<CylinderFigures> = found.into_iter().map(named).collect();
    rows.sort_by(|a, b| b.radius_mm.total_cmp(&a.radius_mm));
    rows
}

/// The one of two opposite directions whose largest coordinate is positive, without negative zeros.
fn upright(axis: [f64; 3]) -> [f64; 3] {
    let largest = axis[Vector::from(axis).iamax()];
    axis.map(|x| if largest < 0.0 { 0.0 - x } else { x + 0.0 })
}

/// Surfaces that CAD programs take for one: they store lengths to so many mm.
const SAME: f64 = 1e-6;

/// Whether two cylinders are one, over a length.
fn is_one(a: &Primitive, b: &Primitive, length: f64) -> bool {
    let (
        Primitive::Cylinder { origin, axis, radius },
        Primitive::Cylinder { axis: other, radius: wide, .. },
    ) = (*a, *b)
    else {
        return false;
    };
    let from_axis = |p: Point| (p - origin).cross(&axis).norm();
    let at = b.origin();
    (radius - wide).abs() <= SAME
        && [at, at + length * other].into_iter().all(|p| from_axis(p) <= SAME)
}

/// The ends of the axis of each face.
fn extents(fit: &ExactFit) -> Vec<[Point; 2]> {
    let lines = fit.faces.iter().map(|face| {
        let surface = &face.surface;
        (surface.origin(), surface.axis().unwrap_or_else(Vector::z))
    });
    let lines: Vec<(Point, Vector)> = lines.collect();
    let mut ends = vec![(f64::INFINITY, f64::NEG_INFINITY); lines.len()];
    for (&face, &triangle) in fit.of_triangle.iter().zip(&fit.mesh.triangles) {
        let (origin, axis) = lines[face as usize];
        let (low, high) = &mut ends[face as usize];
        for corner in fit.mesh.corners(triangle) {
            let along = (corner - origin).dot(&axis);
            (*low, *high) = (low.min(along), high.max(along));
        }
    }
    let points = |((origin, axis), (low, high))| [low, high].map(|h: f64| origin + h * axis);
    lines.into_iter().zip(ends).map(points).collect()
}

/// For each face on a cylinder the angles of its triangles about the axis, from 0 to 2π, as first and last angle. The
/// last one may be beyond 2π. All faces on one cylinder count from the same direction.
fn arcs(fit: &ExactFit) -> Vec<Vec<[f64; 2]>> {
    let mut arcs = vec![Vec::new(); fit.faces.len()];
    for (&face, &triangle) in fit.of_triangle.iter().zip(&fit.mesh.triangles) {
        let Primitive::Cylinder { origin, axis, .. } = fit.faces[face as usize].surface else {
            continue;
        };
        // The axes of two faces on one cylinder may be opposite.
        let axis = if axis[axis.iamax()] < 0.0 { -axis } else { axis };
        let (x, y) = plane_axes(axis);
        let angles = fit.mesh.corners(triangle).map(|p| {
            let off = p - origin;
            off.dot(&y).atan2(off.dot(&x))
        });
        let from = |angle: f64| (angle - angles[0] + PI).rem_euclid(TAU) - PI;
        let low = angles.map(from).into_iter().fold(0.0, f64::min);
        let high = angles.map(from).into_iter().fold(0.0, f64::max);
        let start = (angles[0] + low).rem_euclid(TAU);
        arcs[face as usize].push([start, start + high - low]);
    }
    arcs
}

/// How much of a turn some arcs cover, up to 2π. Gaps of the size of rounding errors are none.
fn covered(mut arcs: Vec<[f64; 2]>) -> f64 {
    arcs.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let Some(first) = arcs.first().map(|arc| arc[0]) else { return 0.0 };
    let (mut end, mut gaps) = (first, 0.0);
    for [start, stop] in arcs.into_iter().chain([[first + TAU; 2]]) {
        if start > end + SAME {
            gaps += start - end;
        }
        end = end.max(stop);
    }
    TAU - gaps
}
