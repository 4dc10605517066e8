//! Coordinates in degrees of longitude and latitude, whose heights are lengths. Taken for lengths, they would give a
//! surface that stands 111,320 times as steep as the ground, since a degree of the equator has so many metres.

use std::path::Path;

use super::{Column, Points, ScanGrid};
use crate::Error;
use crate::far::{bounds, decimal_power};

/// Steps of the plane that are so many times finer than those of the heights are in another unit. Lengths have the
/// same steps in all directions, or finer heights. Likewise no surface of lengths is so steep throughout, or so many
/// times as high as it is wide. Degrees of the gentlest ground are: a rise of 1 in 1000 looks like one of 111.
pub(super) const FINER: f64 = 100.0;

/// The steepest one in so many pairs of neighbours may be walls of a part, or the edges of cells without a height.
const WALLS: usize = 10;

pub(super) const PROJECT: &str =
    "Project it to a system with coordinates in metres, for example with PDAL or QGIS.";

/// Whether two axes of all positions are in the ranges of longitudes and latitudes. Some programs count longitudes
/// to 360.
pub(super) fn are_in_range(positions: &[[f64; 3]], [longitude, latitude]: [usize; 2]) -> bool {
    positions.iter().all(|position| {
        (-180.0..=360.0).contains(&position[longitude]) && position[latitude].abs() <= 90.0
    })
}

/// The columns of longitudes and latitudes, if these are names of both.
pub(super) fn named(names: &[String]) -> Option<[usize; 2]> {
    let find = |axis| names.iter().position(|name| Column::degrees(name) == Some(axis));
    Some([find(0)?, find(1)?])
}

/// Whether the plane of a cloud is in degrees although nothing names them: its digits are finer than those of the
/// heights, and it is much higher than wide. Numbers without a last digit are finer than any.
pub(super) fn are_told_by_digits(positions: &[[f64; 3]]) -> bool {
    let [low, high] = bounds(positions);
    let [x, y, z] = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    let power = |axis: usize| decimal_power(positions.iter().map(|position| position[axis]));
    let is_fine = |heights: f64| {
        let mut plane = [0, 1].into_iter().map(|axis| power(axis).unwrap_or(f64::INFINITY));
        plane.all(|power| power >= FINER * heights)
    };
    z > FINER * x.max(y) && are_in_range(positions, [0, 1]) && power(2).is_some_and(is_fine)
}

/// The error of a cloud with such columns.
pub(super) fn refusal(path: &Path) -> Error {
    Error::new(path, "has coordinates in degrees", PROJECT)
}

/// Refuses a raster of heights whose cells are in degrees, by its slopes.
pub(super) fn check_raster(
    path: &Path,
    cloud: &Points,
    grid: &ScanGrid,
    cell: [f64; 2],
) -> Result<(), Error> {
    let height = |cell: usize| {
        let point = grid.cells.get(cell).filter(|&&point| point != ScanGrid::EMPTY)?;
        cloud.positions.get(*point as usize).map(|position| position[2])
    };
    let [mut steep, mut pairs] = [0, 0];
    for at in 0..grid.cells.len() {
        let right = (at + 1) % grid.columns != 0;
        for (other, size) in [(at + usize::from(right), cell[0]), (at + grid.columns, cell[1])] {
            if let (true, Some(a), Some(b)) = (other != at, height(at), height(other)) {
                pairs += 1;
                steep += usize::from((a - b).abs() > FINER * size);
            }
        }
    }
    if steep * WALLS <= pairs || !are_in_range(&cloud.positions, [0, 1]) {
        return Ok(());
    }
    let percent = 100 * steep / pairs;
    let what = format!(
        "seems to have cells in degrees: of the heights of neighbours, {percent} % differ by more than {FINER} cells"
    );
    let help =
        format!("{PROJECT} If its cells are lengths, write them in the unit of the heights.");
    Err(Error::new(path, what, help))
}
