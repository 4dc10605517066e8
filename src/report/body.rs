//! The figures of solids and shells.

use super::figures::{DeviationFigures, FillFigures, SmoothFigures, filled_holes};
use super::{
    InputFigures, OutputFile, PatchFigures, ScanSource, Settings, ShapeFigures, StageFigures,
    VERSION, hints,
};
use crate::convert::{BodyConversion, TargetShape};

/// What a run made of the bodies of a scan, and how well.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct BodyReport {
    /// The version of this library.
    pub scan2step: &'static str,
    /// The figures of each solid. In the JSON those of the first stand beside the other fields, and
    /// all are in `components` if there are several.
    #[cfg_attr(feature = "serde", serde(flatten, serialize_with = "super::serialize_parts"))]
    pub solids: Vec<BodyFigures>,
    /// Whether the caller named the tolerance.
    pub tolerance_named: bool,
    /// The percentage of points that may exceed the tolerance.
    pub outliers_pct: f64,
    /// What the caller asked for; `options` in the JSON.
    #[cfg_attr(feature = "serde", serde(rename = "options"))]
    pub settings: Settings,
    /// What could be better, and what to do about it.
    pub hints: Vec<String>,
    /// The words of a command line that makes the same files; empty if there is none. The caller
    /// fills it in.
    pub command: Vec<String>,
    /// How long each stage took. The caller fills it in.
    pub stages: Vec<StageFigures>,
    /// The files that were written. The caller fills it in.
    pub outputs: Vec<OutputFile>,
    /// Seconds since the run began. The caller fills it in.
    pub seconds: f64,
    /// The largest resident memory of the process, in MB (10⁶ bytes). The caller fills it in.
    pub peak_rss_mb: f64,
}

/// What the conversion of one body did and how well.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct BodyFigures {
    /// The scan's file and the component.
    pub input: InputFigures,
    /// Standard deviation of the scan's noise along the normal.
    pub noise_mm: f64,
    /// The tolerance that the solid was made for.
    pub tolerance_mm: f64,
    /// Whether the solid keeps it ([`BodyConversion::tolerance_met`]).
    pub tolerance_met: bool,
    /// What smoothing did.
    pub smooth: SmoothFigures,
    /// The gaps that were filled. All fills are kept.
    pub fill: FillFigures,
    /// How far the smoothed points are from the faces.
    pub fit: BodyFitFigures,
    /// How far the points as measured are from the faces.
    pub deviation: DeviationFigures,
    /// How far samples of the faces are from the triangles of the smoothed scan. Samples on fills are
    /// left out.
    pub face_to_scan: DeviationFigures,
    /// The solid.
    pub shape: ShapeFigures,
    /// Each face, in the order of the B-rep.
    pub faces: Vec<PatchFigures>,
}

/// The fit of the surface of a body.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct BodyFitFigures {
    /// How the surface was fitted: "subdivision".
    pub method: &'static str,
    /// Degree along u and v.
    pub degree: [usize; 2],
    /// The control net of one face; `None`, as there are several faces.
    pub net: Option<[usize; 2]>,
    /// Statistics of the distances.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub deviation: DeviationFigures,
    /// The percentage of points within the tolerance.
    pub within_pct: f64,
}

impl BodyReport {
    /// The report of some solids of one scan. The command, stages, outputs, seconds and memory are
    /// empty or 0 until the caller fills them in.
    pub fn of(solids: &[BodyConversion], source: &ScanSource, settings: Settings) -> Self {
        let outliers = settings.outliers / 100.0;
        BodyReport {
            scan2step: VERSION,
            solids: solids.iter().map(|s| BodyFigures::of(s, source, outliers)).collect(),
            tolerance_named: settings.tolerance.is_some(),
            outliers_pct: settings.outliers,
            hints: hints::of_bodies(solids, source, &settings),
            settings,
            command: Vec::new(),
            stages: Vec::new(),
            outputs: Vec::new(),
            seconds: 0.0,
            peak_rss_mb: 0.0,
        }
    }
}

#[cfg(feature = "html")]
impl BodyReport {
    /// The name of the scan's file without its folder; empty if there is no solid.
    pub(super) fn name(&self) -> String {
        self.solids.first().map_or(String::new(), |solid| super::file_name(&solid.input.file))
    }
}

impl BodyFigures {
    /// The figures of one solid. The share `outliers` of points may exceed the tolerance.
    pub fn of(solid: &BodyConversion, source: &ScanSource, outliers: f64) -> Self {
        let all = solid.fit_deviation.distances.len();
        let within = all - solid.fit_deviation.beyond(solid.tolerance);
        BodyFigures {
            input: InputFigures::of(&solid.input, source),
            noise_mm: solid.noise,
            tolerance_mm: solid.tolerance,
            tolerance_met: solid.tolerance_met(outliers),
            smooth: SmoothFigures::of(&solid.smooth),
            fill: FillFigures {
                holes: filled_holes(
                    &solid.fill,
                    &vec![solid.shape == TargetShape::Shell; solid.fill.holes.len()],
                ),
            },
            fit: BodyFitFigures {
                method: "subdivision",
                degree: [3, 3],
                net: None,
                deviation: DeviationFigures::of(&solid.fit_deviation),
                within_pct: 100.0 * within as f64 / all.max(1) as f64,
            },
            deviation: DeviationFigures::of(&solid.deviation),
            face_to_scan: DeviationFigures::of(&solid.face_to_scan.deviation),
            shape: ShapeFigures::of_body(solid),
            faces: PatchFigures::all(solid),
        }
    }
}
