//! The figures of one body.

use super::{ExactFigures, InputFigures, PatchFigures, ScanSource, ShapeFigures};
use crate::convert::{Body, BodyFit, SurfaceFit};
use crate::deviation::{Deviation, FaceToScan};
use crate::mesh::Bound;
use crate::spline::Surface;
use crate::stages::adapt::Adapted;
use crate::stages::{fill, fit, smooth, thin};

/// What the conversion of one component did and how well. Only one face has the figures that are optional
/// before `faces`, and only a network of faces has a list of them.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct BodyFigures {
    /// The scan's file and the component.
    pub input: InputFigures,
    /// Standard deviation of the scan's noise along the normal; 0 if the scan shows none.
    pub noise_mm: f64,
    /// The tolerance that the body was made for.
    pub tolerance_mm: f64,
    /// Whether the body keeps it ([`Body::tolerance_met`]).
    pub tolerance_met: bool,
    /// What smoothing did.
    pub smooth: SmoothFigures,
    /// What was filled.
    pub fill: FillFigures,
    /// What was thinned for the map and the fit.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub thin: Option<ThinFigures>,
    /// How good the map to the parameter plane is.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub parameterize: Option<MapFigures>,
    /// The surfaces, and how far the smoothed points are from the faces.
    pub fit: FitFigures,
    /// How far the points as measured are from the faces.
    pub deviation: DeviationFigures,
    /// How far the faces are from the triangles of the smoothed scan.
    pub face_to_scan: FaceToScanFigures,
    /// How far a trim loop may be from its rim.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub rim_tolerance_mm: Option<f64>,
    /// The loops that bound the face and its islands.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub trim: Option<Vec<TrimFigures>>,
    /// The elements of the B-rep, and their area.
    pub shape: ShapeFigures,
    /// Each face, in the order of the B-rep.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub faces: Option<Vec<PatchFigures>>,
    /// What exact faces are.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub exact: Option<ExactFigures>,
}

/// What smoothing did.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct SmoothFigures {
    /// The support h; its median if it changes over the scan, 0 without smoothing.
    pub h_mm: f64,
    /// Root mean square of how far the points were moved.
    pub moved_rms_mm: f64,
    /// The farthest that a point was moved.
    pub moved_max_mm: f64,
    /// Corners of the boundary that were kept.
    pub corners: usize,
    /// Points that were left out of the fits.
    pub outliers: usize,
    /// The step of which all heights of the scan along one axis are multiples, if there is one.
    pub height_step_mm: Option<f64>,
}

/// What was filled.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct FillFigures {
    /// The holes, in the order in which trim loops name them.
    pub holes: Vec<HoleFigures>,
}

/// One hole of the scan.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct HoleFigures {
    /// Vertices of its rim.
    pub rim_vertices: usize,
    /// Length of its rim.
    pub rim_length_mm: f64,
    /// Islands in it.
    pub islands: usize,
    /// Vertices that fill it.
    pub added_vertices: usize,
    /// Triangles that fill it.
    pub added_triangles: usize,
    /// Whether it is cut out of the face.
    pub trimmed: bool,
    /// How it was filled ([`fill::Strategy`]): "front", "wide ears", "guided front" or "least area".
    pub method: &'static str,
    /// Folds of the fill ([`fill::Faults`]).
    pub folds: usize,
    /// Places where the fill cuts through the scan or itself ([`fill::Faults`]).
    pub cuts: usize,
}

/// What was thinned for the smoothing and the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct ThinFigures {
    /// Measured vertices that are left.
    pub vertices: usize,
    /// Measured vertices that were removed.
    pub removed: usize,
    /// The distance of the places whose means stand for the vertices, if these are much denser than their noise lets tell.
    pub averaged_mm: Option<f64>,
}

/// How good the map to the parameter plane is.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct MapFigures {
    /// Where the outer boundary is: on the "sides" of the surface, or "free" inside them.
    pub outline: &'static str,
    /// Bays of the boundary that were closed.
    pub bays: usize,
    /// Triangles that close them.
    pub bay_triangles: usize,
    /// Inverted triangles.
    pub flipped: usize,
    /// Vertices that were moved so that no triangle is inverted.
    pub mended: usize,
    /// Edges that were split.
    pub split_edges: usize,
    /// Mean stretch of the map (L²); 1 if lengths keep their proportion.
    pub stretch_l2: f64,
    /// The largest stretch.
    pub stretch_max: f64,
    /// Length of the scan along u divided by that along v.
    pub aspect: f64,
}

/// The fitted surfaces, and how far the smoothed points are from the faces.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct FitFigures {
    /// How the surface was fitted: as [`fit::Method`] says, "blend", "refined" or "global"; for several
    /// faces, "subdivision"; or "exact".
    pub method: &'static str,
    /// Degree along u and v.
    pub degree: [usize; 2],
    /// Control points along u and v; `None` if there are several faces.
    pub net: Option<[usize; 2]>,
    /// Statistics of the distances.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub deviation: DeviationFigures,
    /// The percentage of points that keep the tolerance.
    pub within_pct: f64,
    /// What only the fit of one surface has.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub of_surface: Option<SurfaceFitFigures>,
}

/// The figures that only the fit of one surface has.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct SurfaceFitFigures {
    /// Knots along u, each as often as it is repeated.
    pub knots_u: usize,
    /// Knots along v, each as often as it is repeated.
    pub knots_v: usize,
    /// How many of the points within the tolerance are farther from the face, because a trim loop, which
    /// smooths the rim, cuts them off.
    pub cut_off: usize,
    /// Mean distance between points and the surface at their parameters.
    pub mean_parametric_mm: f64,
    /// The paper's κ, by which the first knots were placed; `None` for a net that was named.
    pub kappa_mm: Option<f64>,
    /// How many surfaces were fitted.
    pub rounds: usize,
    /// Steps of the conjugate gradients.
    pub steps: usize,
    /// Places where the surface is turned over; `None` if they were not counted.
    pub folds: Option<usize>,
    /// Places that were looked at for this.
    pub places: Option<usize>,
}

/// Distances of a set of points.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct DeviationFigures {
    /// Root mean square.
    pub rms_mm: f64,
    /// The distance that 95 % of the points keep.
    pub p95_mm: f64,
    /// The distance that 99 % of the points keep.
    pub p99_mm: f64,
    /// The largest distance.
    pub max_mm: f64,
    /// The point that has it.
    pub max_at: [f64; 3],
}

/// Distances of the faces from the scan's triangles.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct FaceToScanFigures {
    /// Root mean square over an even sample of the places.
    pub rms_mm: f64,
    /// The distance that 95 % of the same keep.
    pub p95_mm: f64,
    /// The largest distance.
    pub max_mm: f64,
    /// The place that has it.
    pub max_at: [f64; 3],
    /// How far the scan's flat triangles are from the surface that they stand for, there.
    pub chord_error_mm: f64,
    /// Places that were compared with the triangles: of one face one for each triangle.
    pub places: usize,
    /// Places that are farther away than the tolerance and the chord error.
    pub beyond: usize,
}

/// A loop that bounds the face, or an island.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct TrimFigures {
    /// Its position in the list; `loop` in the JSON.
    #[cfg_attr(feature = "serde", serde(rename = "loop"))]
    pub number: usize,
    /// Whether the face, or an island's face, is inside it.
    pub outer: bool,
    /// What it goes around; `None` for the four sides of the surface.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub of: Option<TrimOf>,
    /// Control points of its curves.
    pub control_points: usize,
    /// The farthest that its edges are from the surface.
    pub max_off_surface_mm: f64,
    /// The farthest that the rim's vertices are from its edges.
    pub max_from_rim_mm: f64,
}

/// What a trim loop goes around. Both are `None` for the outer boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct TrimOf {
    /// The hole, or the one that the island is in: a position among [`FillFigures::holes`].
    pub hole: Option<usize>,
    /// The island.
    pub island: Option<usize>,
}

impl BodyFigures {
    /// The figures of one body of a scan. The share `outliers` of points may exceed the tolerance.
    pub fn of(body: &Body, source: &ScanSource, outliers: f64) -> Self {
        let face = body.face();
        BodyFigures {
            input: InputFigures::of(&body.input, source),
            noise_mm: body.noise,
            tolerance_mm: body.tolerance,
            tolerance_met: body.tolerance_met(outliers),
            smooth: SmoothFigures::of(&body.smooth),
            fill: FillFigures { holes: filled_holes(&body.fill, &body.trimmed) },
            thin: body.thin().map(ThinFigures::of),
            parameterize: face.map(map),
            fit: FitFigures::of(body),
            deviation: DeviationFigures::of(&body.deviation),
            face_to_scan: FaceToScanFigures::of(&body.face_to_scan),
            rim_tolerance_mm: face.map(|f| f.rim_tolerance),
            trim: face.map(trim),
            shape: ShapeFigures::of(body),
            faces: match &body.fit {
                BodyFit::Face(_) => None,
                BodyFit::Network(fit) => Some(PatchFigures::all(body, fit)),
                BodyFit::Exact(fit) => Some(PatchFigures::exact(fit)),
            },
            exact: body.exact().map(ExactFigures::of),
        }
    }
}

impl ThinFigures {
    fn of(thin::Report { vertices, removed, averaged, .. }: thin::Report) -> Self {
        ThinFigures { vertices, removed, averaged_mm: averaged }
    }
}

impl SmoothFigures {
    pub(super) fn of(report: &smooth::Report) -> Self {
        SmoothFigures {
            h_mm: report.h,
            moved_rms_mm: report.moved_rms,
            moved_max_mm: report.moved_max,
            corners: report.corners.len(),
            outliers: report.outliers,
            height_step_mm: report.height_step,
        }
    }
}

/// The figures of holes, and whether each was cut out.
fn filled_holes(report: &fill::Report, trimmed: &[bool]) -> Vec<HoleFigures> {
    let figures = |(hole, &trimmed): (&fill::Hole, &bool)| HoleFigures {
        rim_vertices: hole.rim_vertices,
        rim_length_mm: hole.rim_length,
        islands: hole.islands,
        added_vertices: hole.added_vertices,
        added_triangles: hole.added_triangles,
        trimmed,
        method: match hole.strategy {
            fill::Strategy::Front => "front",
            fill::Strategy::WideEars => "wide ears",
            fill::Strategy::GuidedFront => "guided front",
            fill::Strategy::LeastArea => "least area",
        },
        folds: hole.faults.folds,
        cuts: hole.faults.cuts,
    };
    report.holes.iter().zip(trimmed).map(figures).collect()
}

fn map(c: &SurfaceFit) -> MapFigures {
    let report = &c.parameterize;
    MapFigures {
        outline: if c.outer.is_some() { "sides" } else { "free" },
        bays: report.bays.count,
        bay_triangles: report.bays.added_triangles,
        flipped: report.flipped,
        mended: report.mended,
        split_edges: report.split_edges,
        stretch_l2: report.stretch.l2,
        stretch_max: report.stretch.max,
        aspect: report.stretch.aspect,
    }
}

impl FitFigures {
    fn of(body: &Body) -> Self {
        let all = body.fit_deviation.distances.len();
        let within = all - body.missed.points;
        let face = body.face();
        let surface = face.map(|face| &face.surface);
        FitFigures {
            method: match &body.fit {
                BodyFit::Face(face) => fit_method(face.adapted.fit.method),
                BodyFit::Network(_) => "subdivision",
                BodyFit::Exact(_) => "exact",
            },
            degree: surface.map_or([3, 3], |surface| [surface.u.degree(), surface.v.degree()]),
            net: surface.map(Surface::shape),
            deviation: DeviationFigures::of(&body.fit_deviation),
            within_pct: 100.0 * within as f64 / all.max(1) as f64,
            of_surface: face.map(|face| SurfaceFitFigures::of(body, face)),
        }
    }
}

impl SurfaceFitFigures {
    fn of(body: &Body, face: &SurfaceFit) -> Self {
        let Adapted { fit, mean_error, kappa, rounds, folds, .. } = &face.adapted;
        SurfaceFitFigures {
            knots_u: face.surface.u.knots().len(),
            knots_v: face.surface.v.knots().len(),
            cut_off: body.cut_off(),
            mean_parametric_mm: *mean_error,
            kappa_mm: *kappa,
            rounds: *rounds,
            steps: fit.steps,
            folds: folds.map(|folds| folds.inverted),
            places: folds.map(|folds| folds.samples),
        }
    }
}

/// The name of a method on the command line and in reports.
pub(super) fn fit_method(method: fit::Method) -> &'static str {
    match method {
        fit::Method::Blend => "blend",
        fit::Method::Refined => "refined",
        fit::Method::Global => "global",
    }
}

impl DeviationFigures {
    /// The figures of some distances.
    pub fn of(d: &Deviation) -> Self {
        DeviationFigures {
            rms_mm: d.rms,
            p95_mm: d.p95,
            p99_mm: d.p99,
            max_mm: d.max,
            max_at: d.max_at,
        }
    }
}

impl FaceToScanFigures {
    fn of(d: &FaceToScan) -> Self {
        FaceToScanFigures {
            rms_mm: d.rms,
            p95_mm: d.p95,
            max_mm: d.max,
            max_at: d.max_at,
            chord_error_mm: d.chord_error,
            places: d.places,
            beyond: d.beyond,
        }
    }
}

fn trim(c: &SurfaceFit) -> Vec<TrimFigures> {
    let sides = c.outer.map(|(control_points, max_from_rim_mm)| TrimFigures {
        number: 0,
        outer: true,
        of: None,
        control_points,
        max_off_surface_mm: 0.0,
        max_from_rim_mm,
    });
    let first = usize::from(sides.is_some());
    // An island is a face of its own, with an outer loop.
    let others = c.trim.iter().enumerate().map(|(i, l)| TrimFigures {
        number: first + i,
        outer: !matches!(l.of, Bound::Hole(_)),
        of: Some(TrimOf { hole: l.of.hole(), island: l.of.island() }),
        control_points: l.control_points,
        max_off_surface_mm: l.max_off_surface,
        max_from_rim_mm: l.max_from_rim,
    });
    sides.into_iter().chain(others).collect()
}
