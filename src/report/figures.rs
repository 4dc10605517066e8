//! The figures of one face.

use super::{InputFigures, ScanSource, ShapeFigures};
use crate::convert::Conversion;
use crate::deviation::{Deviation, FaceToScan};
use crate::mesh::Bound;
use crate::stages::{fill, fit, smooth};

/// What the conversion of one component did and how well.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct FaceFigures {
    /// The scan's file and the component.
    pub input: InputFigures,
    /// Standard deviation of the scan's noise along the normal; 0 if the scan shows none.
    pub noise_mm: f64,
    /// The tolerance that the face was made for.
    pub tolerance_mm: f64,
    /// Whether the face keeps it ([`Conversion::tolerance_met`]).
    pub tolerance_met: bool,
    /// What smoothing did.
    pub smooth: SmoothFigures,
    /// What was filled.
    pub fill: FillFigures,
    /// What was thinned for the map and the fit.
    pub thin: ThinFigures,
    /// How good the map to the parameter plane is.
    pub parameterize: MapFigures,
    /// The surface, and how far the smoothed points are from the face.
    pub fit: FitFigures,
    /// How far the points as measured are from the face.
    pub deviation: DeviationFigures,
    /// How far the face is from the triangles of the smoothed scan.
    pub face_to_scan: FaceToScanFigures,
    /// How far a trim loop may be from its rim.
    pub rim_tolerance_mm: f64,
    /// The loops that bound the face and its islands.
    pub trim: Vec<TrimFigures>,
    /// The elements of the B-rep, and their area.
    pub shape: ShapeFigures,
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

/// What was thinned for the map and the fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct ThinFigures {
    /// Measured vertices that are left.
    pub vertices: usize,
    /// Measured vertices that were removed.
    pub removed: usize,
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

/// The fitted surface, and how far the smoothed points are from the face.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct FitFigures {
    /// How the surface was fitted ([`fit::Method`]): "blend", "refined" or "global".
    pub method: &'static str,
    /// Degree along u and v.
    pub degree: [usize; 2],
    /// Control points along u and v.
    pub net: [usize; 2],
    /// Knots along u, each as often as it is repeated.
    pub knots_u: usize,
    /// Knots along v, each as often as it is repeated.
    pub knots_v: usize,
    /// Root mean square of the distances.
    pub rms_mm: f64,
    /// The distance that 95 % of the points keep.
    pub p95_mm: f64,
    /// The distance that 99 % of the points keep.
    pub p99_mm: f64,
    /// The largest distance.
    pub max_mm: f64,
    /// The point that has it.
    pub max_at: [f64; 3],
    /// The percentage of points that keep the tolerance.
    pub within_pct: f64,
    /// How many of these are farther from the face than the tolerance, because a trim loop, which smooths
    /// the rim, cuts them off.
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

/// Distances of the face from the scan's triangles.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct FaceToScanFigures {
    /// Root mean square over an even sample of the triangles.
    pub rms_mm: f64,
    /// The distance that 95 % of the same keep.
    pub p95_mm: f64,
    /// The largest distance.
    pub max_mm: f64,
    /// The place that has it.
    pub max_at: [f64; 3],
    /// How far the scan's flat triangles are from the surface that they stand for, there.
    pub chord_error_mm: f64,
    /// Triangles that were looked at.
    pub triangles: usize,
    /// Triangles that the face leaves by more than the tolerance and their chord error.
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

impl FaceFigures {
    /// The figures of one conversion of a scan. The share `outliers` of points may exceed the
    /// tolerance.
    pub fn of(c: &Conversion, source: &ScanSource, outliers: f64) -> Self {
        FaceFigures {
            input: InputFigures::of(&c.input, source),
            noise_mm: c.noise,
            tolerance_mm: c.tolerance,
            tolerance_met: c.tolerance_met(outliers),
            smooth: SmoothFigures::of(&c.smooth),
            fill: FillFigures { holes: filled_holes(&c.fill, &c.trimmed) },
            thin: ThinFigures { vertices: c.thin.vertices, removed: c.thin.removed },
            parameterize: map(c),
            fit: FitFigures::of(c),
            deviation: DeviationFigures::of(&c.deviation),
            face_to_scan: FaceToScanFigures::of(&c.face_to_scan),
            rim_tolerance_mm: c.rim_tolerance,
            trim: trim(c),
            shape: ShapeFigures::of_face(c),
        }
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
        }
    }
}

/// The figures of holes, and whether each was cut out.
pub(super) fn filled_holes(report: &fill::Report, trimmed: &[bool]) -> Vec<HoleFigures> {
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

fn map(c: &Conversion) -> MapFigures {
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
    fn of(c: &Conversion) -> Self {
        let d = &c.fit_deviation;
        let within = d.distances.len() - c.missed.points;
        FitFigures {
            method: fit_method(c.fit.fit.method),
            degree: [c.surface.u.degree(), c.surface.v.degree()],
            net: c.surface.shape(),
            knots_u: c.surface.u.knots().len(),
            knots_v: c.surface.v.knots().len(),
            rms_mm: d.rms,
            p95_mm: d.p95,
            p99_mm: d.p99,
            max_mm: d.max,
            max_at: d.max_at,
            within_pct: 100.0 * within as f64 / d.distances.len().max(1) as f64,
            cut_off: c.cut_off(),
            mean_parametric_mm: c.fit.mean_error,
            kappa_mm: c.fit.kappa,
            rounds: c.fit.rounds,
            steps: c.fit.fit.steps,
            folds: c.fit.folds.map(|folds| folds.inverted),
            places: c.fit.folds.map(|folds| folds.samples),
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
            triangles: d.triangles,
            beyond: d.beyond,
        }
    }
}

fn trim(c: &Conversion) -> Vec<TrimFigures> {
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
