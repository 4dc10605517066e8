//! The figures of a cloud of points and of the mesh that was made of it.

use formats::Points;

use crate::geometry::{Point, bounds};
use crate::stages::cloud::{self, GridUse};

/// A cloud of points as it was read, and how it became a mesh.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct CloudFigures {
    /// Valid points of the file.
    pub points: usize,
    /// Points of the file that are not valid.
    pub invalid_points: u64,
    /// The scans of the file, in its order.
    pub scans: Vec<ScanFigures>,
    /// Where the places of the report are measured from in the scan's own frame.
    pub origin_mm: [f64; 3],
    /// How the mesh was made; `None` until it is.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub mesh: Option<CloudMeshFigures>,
}

/// One scan of a cloud.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct ScanFigures {
    /// Valid points.
    pub points: usize,
    /// Rows and columns of the scanner's grid, if the file has one.
    pub grid: Option<[usize; 2]>,
    /// Where the scanner stood, if the file says so.
    pub viewpoint_mm: Option<[f64; 3]>,
    /// The lowest and the highest coordinates; `None` if there is no point.
    pub bounds_mm: Option<[[f64; 3]; 2]>,
}

/// How a mesh was made of a cloud.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct CloudMeshFigures {
    /// How it was made ([`cloud::GridUse`]): along the "grid" of the scan, or by the "stars" of
    /// its points.
    pub mesher: &'static str,
    /// The median distance between neighbouring points.
    pub spacing_mm: f64,
    /// Standard deviation of the points' noise along the normal.
    pub noise_mm: f64,
    /// The distance between two layers of points, as those of a thin wall.
    pub layers_mm: Option<f64>,
    /// The distance of the places whose means stand for the points, if these are much denser than their noise lets tell.
    pub averaged_mm: Option<f64>,
    /// Points that were left out as outliers.
    pub outliers: usize,
    /// Points at the place of another one.
    pub duplicates: usize,
}

impl CloudFigures {
    /// The figures of a cloud before a mesh is made of it. Its unit is so many `mm`.
    pub(super) fn of(cloud: &Points, mm: f64) -> Self {
        let in_mm = |p: [f64; 3]| p.map(|x| mm * x);
        let scan = |scan: &formats::points::PointScan| {
            let points = &cloud.positions[scan.points.clone()];
            ScanFigures {
                points: points.len(),
                grid: scan.grid.as_ref().map(|grid| [grid.rows, grid.columns]),
                viewpoint_mm: scan.viewpoint.map(in_mm),
                bounds_mm: (!points.is_empty()).then(|| {
                    let places = points.iter().map(|&p| Point::from(p));
                    bounds(places).map(|p| in_mm(p.coords.into()))
                }),
            }
        };
        CloudFigures {
            points: cloud.len(),
            invalid_points: cloud.lost.points(),
            scans: cloud.scans.iter().map(scan).collect(),
            origin_mm: in_mm(cloud.origin),
            mesh: None,
        }
    }
}

impl CloudMeshFigures {
    /// The figures of a mesh that was made of a cloud whose unit is so many `mm`.
    pub(super) fn of(report: &cloud::Report, mm: f64) -> Self {
        CloudMeshFigures {
            mesher: if let GridUse::Followed { .. } = report.grid { "grid" } else { "stars" },
            spacing_mm: mm * report.spacing,
            noise_mm: mm * report.noise,
            layers_mm: report.layers.map(|distance| mm * distance),
            averaged_mm: report.averaged.map(|distance| mm * distance),
            outliers: report.outliers,
            duplicates: report.duplicates,
        }
    }
}
