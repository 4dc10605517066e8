//! Clouds of points: what a scanner measured, before anybody meshed it.
//!
//! [`read_points`] reads E57, LAS, LAZ, PLY without faces, columns of text (XYZ,
//! TXT, ASC, CSV, PTS), PCD and PTX. [`ReadOptions`] choose some of the points. [`read_content`] reads a file that holds either a
//! mesh or a cloud. The readers deliver what the file says: points in the
//! file's order, not thinned, and duplicates included. A point that the scanner
//! did not see is left out and counted in [`Lost`].

mod builder;
mod column;
mod columns;
mod degrees;
mod e57;
mod grid;
mod las;
mod of_mesh;
mod options;
mod pcd;
mod ptx;
mod read;
mod remarks;
mod text;

use std::fmt;
use std::ops::Range;

pub(crate) use builder::{GridShape, LeftOut, Order, PointsBuilder, ScanEnd};
pub(crate) use column::Column;
pub use columns::Columns;
pub use options::ReadOptions;
pub use read::{Content, PointFormat, SceneContent, read_content, read_points, read_points_from};

use crate::LengthUnit;
use crate::words::{grouped, plural};

/// A cloud of points from one or several scans.
///
/// A point lies at [`Points::origin`] plus its position. Coordinates far from
/// zero, such as those of a map projection, keep every digit in this way.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Points {
    /// Where the positions are measured from, in whole units of the file. It is
    /// zero unless the cloud is far from zero.
    pub origin: [f64; 3],
    /// Positions relative to the origin, in the file's unit. All are finite, and
    /// the pose of each scan is applied.
    pub positions: Vec<[f64; 3]>,
    /// One normal for each position, where the file has normals. Their lengths
    /// are the file's. A normal is zero where the file has no finite one.
    pub normals: Option<Vec<[f32; 3]>>,
    /// The scans, in the file's order. Together they hold every position once.
    pub scans: Vec<PointScan>,
    /// The unit of the file: metres for E57, that of the coordinate system for LAS
    /// and LAZ, and metres for PTS and PTX (by custom, see [`Note::MetresByCustom`]).
    /// It is `None` for formats without a unit.
    pub unit: Option<LengthUnit>,
    /// What the file holds and the cloud does not.
    pub lost: Lost,
    /// What the user should know about how the file was read.
    pub notes: Vec<Note>,
}

impl Points {
    /// The number of points.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there is no point. The readers never deliver such a cloud.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The coordinates of point `index` as the file has them.
    ///
    /// # Panics
    /// There is no such point.
    pub fn absolute(&self, index: usize) -> [f64; 3] {
        let position = self.positions[index];
        [0, 1, 2].map(|axis| self.origin[axis] + position[axis])
    }
}

/// The points that a scanner measured from one place.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PointScan {
    /// The indices of the scan's positions. The range is empty if the scanner saw
    /// nothing.
    pub points: Range<usize>,
    /// Where the scanner stood, relative to [`Points::origin`], if the file says
    /// so.
    pub viewpoint: Option<[f64; 3]>,
    /// How the scanner's frame was placed, if the file says so. The positions
    /// have it applied already.
    pub pose: Option<Pose>,
    /// The grid in which the scanner measured, if the file has one. A file may
    /// claim a grid that its points do not form.
    pub grid: Option<ScanGrid>,
}

/// An affine map from a scanner's frame to the frame of the cloud:
/// `axes[0] * x + axes[1] * y + axes[2] * z + translation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Where the three axes of the scanner's frame point to.
    pub axes: [[f64; 3]; 3],
    /// Where the scanner's zero lies, relative to [`Points::origin`].
    pub translation: [f64; 3],
}

impl Pose {
    /// Whether it moves nothing.
    pub(crate) fn is_still(&self) -> bool {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        *self == Pose { axes, translation: [0.0; 3] }
    }

    pub(crate) fn turn(&self, v: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| self.axes[0][i] * v[0] + self.axes[1][i] * v[1] + self.axes[2][i] * v[2])
    }
}

/// A raster of rows and columns with at most one point in each cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScanGrid {
    /// The number of rows, at least two.
    pub rows: usize,
    /// The number of columns, at least two.
    pub columns: usize,
    /// For each cell the index of its position, or [`ScanGrid::EMPTY`]. The cells of
    /// one row follow each other. There are `rows * columns` cells.
    pub cells: Vec<u32>,
}

impl ScanGrid {
    /// The content of a cell without a point.
    pub const EMPTY: u32 = u32::MAX;

    /// The index of the position in a cell. It is `None` if the cell is empty or
    /// outside of the grid.
    pub fn point(&self, row: usize, column: usize) -> Option<u32> {
        if row >= self.rows || column >= self.columns {
            return None;
        }
        let cell = self.cells.get(row * self.columns + column).copied();
        cell.filter(|&point| point != ScanGrid::EMPTY)
    }
}

/// What a file holds and its [`Points`] do not.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Lost {
    /// Points with a coordinate that is not a finite number.
    pub not_finite: u64,
    /// Points at exactly 0 0 0 in the scanner's frame. Scanners write them where
    /// they saw nothing. In PTX each is left out, in other formats only if a scan
    /// has more than one.
    pub at_zero: u64,
    /// Points that the file marks as invalid (E57) or withheld (LAS).
    pub marked: u64,
    /// Points of the classes of noise, 7 and 18, of LAS.
    pub noise: u64,
    /// Points that the [`ReadOptions`] exclude.
    pub filtered: u64,
    /// Lines of a text file that hold no point.
    pub unreadable_lines: u64,
    /// Points that have a colour.
    pub colours: u64,
    /// Points that have an intensity.
    pub intensities: u64,
    /// The names of the other columns, in the file's order. At most 100 are told.
    pub columns: Vec<String>,
    /// The number of the other columns whose names are not told.
    pub more_columns: u64,
}

/// Something about a file that its reader decided, and that the user should know.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Note {
    /// The format or the file names no unit, but its programs write metres.
    MetresByCustom,
    /// Only a comment of the file names its unit.
    UnitByComment {
        /// What it says.
        comment: String,
    },
    /// The numbers have decimal commas.
    DecimalCommas,
    /// The first columns of a text file number the points. They are not used.
    PointNumbers {
        /// One if it counts up or has times, two for the row and the column of a raster.
        columns: usize,
    },
    /// The first of four or more columns without names rises with every point, and was taken for x. It may be a time.
    FirstColumnRises,
    /// The points are the centres of Gaussian splats, which no scanner measured on a surface.
    Splats,
    /// A PTS, XYZ or LAS file announces another number of points than it has.
    CountDiffers {
        /// The number that the file announces.
        announced: u64,
        /// The number of points that it has, invalid ones included.
        found: u64,
    },
    /// The last line of a text file was cut off and is left out.
    LastLineCut,
    /// A grid's number of cells is not its rows times its columns, or several points
    /// are in one cell, or most cells are empty. It is ignored.
    GridIgnored,
    /// Variable length records of a LAS file are cut off. They are ignored, and the
    /// unit may be missing with them.
    RecordsCut,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Note::MetresByCustom => {
                f.write_str("the file names no unit; programs usually write metres here")
            }
            Note::PointNumbers { columns: 1 } => {
                f.write_str("the first column numbers the points or has their times; unless columns are named, it is not used")
            }
            Note::Splats => f.write_str(
                "the points are the centres of Gaussian splats, which were fitted to pictures and not measured on a surface; \
                 distances from them are not distances from the object",
            ),
            Note::FirstColumnRises => f.write_str(
                "the first column rises with every point and was taken for x; if it has times, name the columns of x, y and z",
            ),
            Note::PointNumbers { .. } => f.write_str(
                "the first two columns number the points in a raster; unless columns are named, they are not used",
            ),
            Note::UnitByComment { comment } => {
                write!(f, "the unit is that of the comment \u{201c}{comment}\u{201d}")
            }
            Note::DecimalCommas => f.write_str("the numbers were read with decimal commas"),
            Note::CountDiffers { announced, found } => {
                write!(
                    f,
                    "the file announces {}, but has {}",
                    plural(*announced, "point"),
                    grouped(*found)
                )
            }
            Note::LastLineCut => f.write_str("the last line was cut off and is left out"),
            Note::RecordsCut => {
                f.write_str("records about the points are cut off; they are ignored")
            }
            Note::GridIgnored => {
                f.write_str("the file's rows and columns do not match its points; they are ignored")
            }
        }
    }
}
