//! The report of `check`: how far a CAD file is from a scan.

use formats::cad::CadModel;

use super::hints::unit_by_cad;
use super::{DeviationFigures, ScanSource, VERSION};
use crate::check;
use crate::convert::MeasuredScene;
use crate::deviation::Deviation;

/// How far the faces of a CAD file and a scan are from each other.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct CheckFigures {
    /// The version of this library.
    pub scan2step: &'static str,
    /// The CAD file.
    pub cad: CadFigures,
    /// The scan.
    pub scan: CheckedScan,
    /// Distances of the scan's points from the faces.
    pub scan_to_face: DistanceFigures,
    /// Distances of samples of the faces from the scan's triangles.
    pub face_to_scan: DistanceFigures,
    /// The parts of an assembly, each in all of its places.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub parts: Option<Vec<CheckedPart>>,
    /// The tolerance that was asked for, if one was.
    pub tolerance_mm: Option<f64>,
    /// What could be wrong, and what to do about it.
    pub hints: Vec<String>,
    /// The percentage of points, and of samples, that may exceed it.
    pub outliers_pct: f64,
    /// Whether both directions keep the tolerance, if there is one.
    pub tolerance_met: Option<bool>,
}

/// A part of an assembly.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct CheckedPart {
    /// Its name.
    pub name: String,
    /// How far its points are from the faces in each of its places.
    pub places: Vec<CheckedPlace>,
}

/// A part of an assembly in one of its places.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct CheckedPlace {
    /// The names of the groups around it, and its own.
    pub path: Vec<String>,
    /// The distances of its points from the faces.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub distances: DistanceFigures,
}

/// What a CAD file has.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct CadFigures {
    /// The file as the caller named it.
    pub file: String,
    /// The part's name; empty if it has none.
    pub name: String,
    /// Faces.
    pub faces: usize,
    /// Loops of all the faces.
    pub loops: usize,
    /// Area of all the faces.
    pub area_mm2: f64,
    /// Volume of all the solids, if there are any.
    pub volume_mm3: Option<f64>,
    /// The lowest and the highest coordinates of the faces.
    pub bounds_mm: [[f64; 3]; 2],
    /// The farthest that an edge is from the surface of its face.
    pub max_off_surface_mm: f64,
    /// How far the chords that stand for edges may be from them.
    pub resolution_mm: f64,
}

/// The part of a scan that faces were measured against.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CheckedScan {
    /// The file as the caller named it.
    pub file: String,
    /// The symbol of the unit of its numbers.
    pub units: &'static str,
    /// Whether neither the file nor the caller names the unit.
    pub units_assumed: bool,
    /// The lowest and the highest coordinates of the components that the faces were measured against.
    pub bounds_mm: [[f64; 3]; 2],
    /// Components of the scan.
    pub components: usize,
    /// Components that the faces were measured against.
    pub components_measured: usize,
    /// Triangles in the other components.
    pub left_out_triangles: usize,
}

/// Distances in one direction.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct DistanceFigures {
    /// Mean, percentiles and the largest distance.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub deviation: DeviationFigures,
    /// How many points were measured.
    pub points: usize,
    /// How many of them exceed the tolerance, if one was asked for.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub beyond: Option<usize>,
}

impl DistanceFigures {
    fn of(d: &Deviation, tolerance: Option<f64>) -> Self {
        DistanceFigures {
            deviation: DeviationFigures::of(d),
            points: d.distances.len(),
            beyond: tolerance.map(|tolerance| d.beyond(tolerance)),
        }
    }

    /// Whether at most so many percent of the points exceed the tolerance. Without a tolerance
    /// they do.
    pub fn keeps(&self, outliers_pct: f64) -> bool {
        let most = outliers_pct / 100.0 * self.points as f64;
        self.beyond.is_none_or(|beyond| beyond as f64 <= most)
    }
}

impl CheckFigures {
    /// The figures of what [`check::check`] found between the model read from `file` and `measured` of
    /// the components of a scan. `tolerance` is mm.
    pub fn of(
        found: &check::Report,
        (file, model): (impl Into<String>, &CadModel),
        (source, measured): (&ScanSource, MeasuredComponents),
        tolerance: Option<f64>,
        outliers_pct: f64,
    ) -> Self {
        let [scan_to_face, face_to_scan] = [&found.scan_to_face, &found.face_to_scan]
            .map(|deviation| DistanceFigures::of(deviation, tolerance));
        let keeps = |_| scan_to_face.keeps(outliers_pct) && face_to_scan.keeps(outliers_pct);
        let tolerance_met = tolerance.map(keeps);
        let unit = (source.unit, source.unit_assumed);
        let hint = unit_by_cad(unit, found.scan_bounds, found.face_bounds);
        CheckFigures {
            scan2step: VERSION,
            cad: CadFigures {
                file: file.into(),
                name: model.name.clone(),
                faces: found.faces,
                loops: found.loops,
                area_mm2: found.area,
                volume_mm3: found.volume,
                bounds_mm: found.face_bounds,
                max_off_surface_mm: found.max_off_surface,
                resolution_mm: found.resolution,
            },
            scan: CheckedScan::of(source, measured, found.scan_bounds),
            scan_to_face,
            face_to_scan,
            parts: None,
            tolerance_mm: tolerance,
            hints: hint.into_iter().collect(),
            outliers_pct,
            tolerance_met,
        }
    }
}

impl CheckFigures {
    /// The same with the figures of the parts of a scene, of whose mesh the distances are.
    #[must_use]
    pub fn of_parts(self, found: &check::Report, scene: &MeasuredScene) -> Self {
        let mut parts: Vec<CheckedPart> = (scene.parts.iter())
            .map(|part| CheckedPart { name: part.name.clone(), places: Vec::new() })
            .collect();
        for place in &scene.places {
            let distances = &found.scan_to_face.distances;
            let (Some(points), Some(own)) =
                (scene.mesh.points.get(place.points.clone()), distances.get(place.points.clone()))
            else {
                continue;
            };
            let deviation = Deviation::of(points, own.to_vec());
            let path = scene.scene.path(place.node).into_iter().map(str::to_owned).collect();
            let distances = DistanceFigures::of(&deviation, self.tolerance_mm);
            parts[place.part].places.push(CheckedPlace { path, distances });
        }
        CheckFigures { parts: Some(parts), ..self }
    }
}

/// How many components of a scan were measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeasuredComponents {
    /// Components of the scan.
    pub all: usize,
    /// Components that the faces were measured against.
    pub measured: usize,
    /// Triangles in the other components.
    pub left_out: usize,
}

impl CheckedScan {
    fn of(source: &ScanSource, parts: MeasuredComponents, bounds_mm: [[f64; 3]; 2]) -> Self {
        CheckedScan {
            file: source.file.clone(),
            units: source.unit.symbol(),
            units_assumed: source.unit_assumed,
            bounds_mm,
            components: parts.all,
            components_measured: parts.measured,
            left_out_triangles: parts.left_out,
        }
    }
}
