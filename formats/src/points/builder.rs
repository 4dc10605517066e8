//! Collects the points that a reader delivers.

use std::path::{Path, PathBuf};

use super::{PointScan, Points, Pose, ScanGrid};
use crate::far::{LARGE_MM, bounds, decimal_power, origin_of_axis, take_off_decimals};
use crate::{Error, Result};

/// A cloud whose middle is farther from zero than so many of its extents gets an
/// origin of its own. Nearer clouds lose nothing that matters: 100 extents cost
/// two of the 15 digits of an `f64`.
const FAR: f64 = 100.0;

/// Collects points, and leaves out those that are none.
pub(crate) struct PointsBuilder {
    path: PathBuf,
    points: Points,
    /// What the positions are relative to while the file is read.
    base: [f64; 3],
    /// The first position of the scan at hand.
    first: usize,
    /// What became of each record of the scan at hand, if a grid needs it: the
    /// index of its position or [`ScanGrid::EMPTY`].
    records: Option<Vec<u32>>,
    /// How many points of the scan at hand are at exactly 0 0 0.
    zeros: u64,
}

/// What a reader says about a scan after its last point.
#[derive(Default)]
pub(crate) struct ScanEnd {
    /// In the frame of the cloud.
    pub(crate) viewpoint: Option<[f64; 3]>,
    pub(crate) pose: Option<Pose>,
    pub(crate) grid: Option<GridShape>,
}

/// How the records of a scan fill a grid.
pub(crate) struct GridShape {
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) order: Order,
}

/// Why a point is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LeftOut {
    /// The scanner saw nothing: 0 0 0.
    Nothing,
    /// The file marks it as invalid or withheld.
    Marked,
    /// It is of a class of noise.
    Noise,
    /// The caller's options exclude it.
    Filtered,
}

pub(crate) enum Order {
    /// The records of one row follow each other.
    Rows,
    /// The records of one column follow each other.
    Columns,
    /// The cells of one row follow each other, and each names its record or is
    /// [`ScanGrid::EMPTY`].
    Indexed(Vec<u32>),
}

impl PointsBuilder {
    /// A builder of points, with normals if `has_normals`.
    pub(crate) fn new(path: &Path, has_normals: bool) -> PointsBuilder {
        let normals = has_normals.then(Vec::new);
        PointsBuilder {
            path: path.to_path_buf(),
            points: Points { normals, ..Points::default() },
            base: [0.0; 3],
            first: 0,
            records: None,
            zeros: 0,
        }
    }

    /// The cloud as it is so far, for what a reader knows besides the points.
    pub(crate) fn cloud(&mut self) -> &mut Points {
        &mut self.points
    }

    /// Starts a scan. Only a scan that `may_have_grid` can end with a grid.
    pub(crate) fn begin_scan(&mut self, may_have_grid: bool) {
        self.first = self.points.len();
        self.records = may_have_grid.then(Vec::new);
        self.zeros = 0;
    }

    /// Adds a point in the scanner's frame, or counts why it is none.
    #[inline]
    pub(crate) fn push(&mut self, xyz: [f64; 3], normal: [f64; 3]) -> Result<()> {
        if !xyz.iter().all(|x| x.is_finite()) {
            self.points.lost.not_finite += 1;
            return self.record(ScanGrid::EMPTY);
        }
        let index = self.points.len();
        if index >= ScanGrid::EMPTY as usize {
            return Err(self.too_many());
        }
        self.zeros += u64::from(xyz == [0.0; 3]);
        self.points.positions.push(xyz);
        if let Some(normals) = &mut self.points.normals {
            let finite = normal.iter().all(|x| x.is_finite());
            normals.push(if finite { normal.map(|x| x as f32) } else { [0.0; 3] });
        }
        self.record(index as u32)
    }

    /// Adds a record that is left out, and counts it.
    pub(crate) fn leave_out(&mut self, why: LeftOut) -> Result<()> {
        let lost = &mut self.points.lost;
        *match why {
            LeftOut::Nothing => &mut lost.at_zero,
            LeftOut::Marked => &mut lost.marked,
            LeftOut::Noise => &mut lost.noise,
            LeftOut::Filtered => &mut lost.filtered,
        } += 1;
        self.record(ScanGrid::EMPTY)
    }

    #[inline]
    fn record(&mut self, index: u32) -> Result<()> {
        let Some(records) = &mut self.records else { return Ok(()) };
        if records.len() >= ScanGrid::EMPTY as usize {
            return Err(self.too_many());
        }
        records.push(index);
        Ok(())
    }

    fn too_many(&self) -> Error {
        let help = "Thin the scan or cut it into parts.";
        Error::new(&self.path, "has more than four billion points", help)
    }

    /// Ends the scan at hand.
    ///
    /// # Errors
    /// The pose takes a point beyond the range of numbers.
    pub(crate) fn end_scan(&mut self, end: ScanEnd) -> Result<()> {
        self.remove_zeros();
        let grid = self.records.take().zip(end.grid).and_then(|(records, shape)| {
            let (rows, columns) = (shape.rows, shape.columns);
            let cells = cells(records, &shape)?;
            Some(ScanGrid { rows, columns, cells })
        });
        let pose = end.pose.map(|pose| self.place(pose)).transpose()?;
        if pose.is_none() && self.base != [0.0; 3] {
            for position in &mut self.points.positions[self.first..] {
                *position = minus(*position, self.base);
            }
        }
        let viewpoint = end.viewpoint.map(|v| minus(v, self.base));
        let points = self.first..self.points.len();
        self.points.scans.push(PointScan { points, viewpoint, pose, grid });
        Ok(())
    }

    /// Leaves out the points at 0 0 0 of the scan at hand if there are several:
    /// programs write them for rays without an echo. A single one may be
    /// measured.
    fn remove_zeros(&mut self) {
        if self.zeros < 2 {
            return;
        }
        self.points.lost.at_zero += self.zeros;
        let cloud = &mut self.points;
        let mut kept = self.first;
        let mut new_index = Vec::new();
        for old in self.first..cloud.positions.len() {
            let is_zero = cloud.positions[old] == [0.0; 3];
            if self.records.is_some() {
                new_index.push(if is_zero { ScanGrid::EMPTY } else { kept as u32 });
            }
            if !is_zero {
                cloud.positions[kept] = cloud.positions[old];
                if let Some(normals) = &mut cloud.normals {
                    normals[kept] = normals[old];
                }
                kept += 1;
            }
        }
        cloud.positions.truncate(kept);
        if let Some(normals) = &mut cloud.normals {
            normals.truncate(kept);
        }
        for record in self.records.iter_mut().flatten().filter(|r| **r != ScanGrid::EMPTY) {
            *record = new_index[*record as usize - self.first];
        }
    }

    /// Applies `pose` to the scan at hand, and returns it relative to the base.
    fn place(&mut self, mut pose: Pose) -> Result<Pose> {
        if self.points.scans.is_empty() {
            // Only whole numbers of this size are added without an error.
            let base = pose.translation.map(f64::round);
            if base.iter().all(|x| x.abs() < 1e15) {
                self.base = base;
            }
        }
        pose.translation = minus(pose.translation, self.base);
        if pose.is_still() {
            return Ok(pose);
        }
        for position in &mut self.points.positions[self.first..] {
            *position = plus(pose.turn(*position), pose.translation);
            if !position.iter().all(|x| x.is_finite()) {
                let what = "has a scan that its matrix moves beyond the range of numbers";
                return Err(Error::new(&self.path, what, crate::source::EXPORT_AGAIN));
            }
        }
        if let Some(normals) = &mut self.points.normals {
            for normal in &mut normals[self.first..] {
                *normal = pose.turn(normal.map(f64::from)).map(|x| x as f32);
            }
        }
        Ok(pose)
    }

    /// The finished cloud.
    ///
    /// # Errors
    /// No point is left.
    pub(crate) fn finish(mut self) -> Result<Points> {
        if self.points.is_empty() {
            return Err(self.no_points());
        }
        self.set_origin();
        Ok(self.points)
    }

    fn no_points(&self) -> Error {
        let lost = &self.points.lost;
        let invalid = lost.not_finite + lost.at_zero + lost.marked;
        let what = match (invalid + lost.noise, lost.filtered) {
            (0, 0) => "has no points".to_owned(),
            (_, 0) if lost.noise > 0 => {
                format!("has no valid point: {invalid} are invalid and {} are noise", lost.noise)
            }
            (all, 0) => format!("has no valid point: all {all} are missing or not finite"),
            (_, filtered) => format!("has no point that was asked for: {filtered} are others"),
        };
        let help = "Check that the right object was exported from the scanner's program.";
        Error::new(&self.path, what, help)
    }

    /// Chooses the origin and makes everything relative to it.
    fn set_origin(&mut self) {
        self.points.origin = self.chosen_origin();
        // Both are whole numbers.
        let origin = self.points.origin;
        let shift = minus(self.base, origin);
        if shift == [0.0; 3] {
            return;
        }
        let is_based = self.base != [0.0; 3];
        let coordinates = self.points.positions.as_flattened().iter().copied();
        let power = if is_based { None } else { decimal_power(coordinates) };
        match power {
            Some(power) => take_off_decimals(&mut self.points.positions, origin, power),
            None => {
                for position in &mut self.points.positions {
                    *position = plus(*position, shift);
                }
            }
        }
        for scan in &mut self.points.scans {
            scan.viewpoint = scan.viewpoint.map(|v| plus(v, shift));
            if let Some(pose) = &mut scan.pose {
                pose.translation = plus(pose.translation, shift);
            }
        }
    }

    fn chosen_origin(&self) -> [f64; 3] {
        let [low, high] = bounds(&self.points.positions);
        let bounds = [0, 1, 2].map(|axis| [low[axis], high[axis]].map(|x| x + self.base[axis]));
        let greatest = |of: [f64; 3]| of.into_iter().fold(0.0, f64::max);
        let extent = greatest(bounds.map(|[low, high]| high - low));
        let middle = greatest(bounds.map(|[low, high]| (low / 2.0 + high / 2.0).abs()));
        let reach = greatest(bounds.map(|[low, high]| low.abs().max(high.abs())));
        let unit = self.points.unit.map_or(1.0, crate::LengthUnit::in_mm);
        let is_far = middle > FAR * extent || reach * unit > LARGE_MM;
        bounds.map(|bounds| if is_far { origin_of_axis(bounds, extent) } else { 0.0 })
    }
}

/// The cells of a grid in the order of its rows. `None` if the records do not
/// fill it.
fn cells(records: Vec<u32>, shape: &GridShape) -> Option<Vec<u32>> {
    let count = shape.rows.checked_mul(shape.columns)?;
    let filled = match &shape.order {
        Order::Rows => records,
        Order::Columns if records.len() == count => {
            let cell = |i: usize| records[i % shape.columns * shape.rows + i / shape.columns];
            (0..count).map(cell).collect()
        }
        Order::Columns => return None,
        Order::Indexed(cells) => {
            let point = |&record: &u32| records.get(record as usize).copied();
            cells.iter().map(|cell| point(cell).unwrap_or(ScanGrid::EMPTY)).collect()
        }
    };
    (filled.len() == count).then_some(filled)
}

fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
