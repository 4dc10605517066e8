//! Grids with known surfaces: reliefs with steps and flanks, missing cells, scans all around,
//! made-up grids and noise.

mod belief;
mod facing;
mod jumps;
mod noise;
mod triangles;

use std::f64::consts::TAU;

use formats::Points;
use formats::points::{PointScan, ScanGrid};

use super::jumps::GridEdges;
use super::raster::{GridCell, GridStep, Raster};
use super::*;

/// A scan of a grid with the points that `place` gives to its cells.
fn scan(
    rows: usize,
    columns: usize,
    mut place: impl FnMut(GridCell) -> Option<[f64; 3]>,
) -> Points {
    let mut cloud = Points::default();
    let cells = (0..rows * columns).map(|number| {
        let Some(position) = place((number / columns, number % columns)) else {
            return ScanGrid::EMPTY;
        };
        cloud.positions.push(position);
        cloud.positions.len() as u32 - 1
    });
    let grid = ScanGrid { rows, columns, cells: cells.collect() };
    let points = 0..cloud.positions.len();
    cloud.scans = vec![PointScan { points, grid: Some(grid), ..PointScan::default() }];
    cloud
}

/// A scan by parallel rays from above, one unit apart, of the height at x and y.
fn relief(
    [rows, columns]: [usize; 2],
    noise: f64,
    height: impl Fn(f64, f64) -> Option<f64>,
) -> Points {
    let mut random = Random(1);
    let mut cloud = scan(rows, columns, |(row, column)| {
        let (x, y) = (column as f64, -(row as f64));
        Some([x, y, height(x, y)? + noise * random.normal()])
    });
    cloud.scans[0].viewpoint = Some([columns as f64 / 2.0, -(rows as f64) / 2.0, 1e4]);
    cloud
}

/// The generator xorshift64*.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A standard normal number by the method of Box and Muller.
    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }
}

/// The triangles along the grid before they are mended, with lengths in the unit of the cloud.
fn surface(cloud: &Points) -> Result<GridSurface, GridDoubt> {
    let frame = WorkFrame::new(&cloud.positions);
    let mut surface = GridSurface::new(cloud, &cloud.scans[0], &frame)?;
    surface.spacing = frame.length(surface.spacing);
    surface.noise = frame.length(surface.noise);
    Ok(surface)
}

fn mesh(cloud: &Points) -> GridSurface {
    surface(cloud).unwrap()
}

fn points(cloud: &Points) -> Vec<Point> {
    cloud.positions.iter().map(|&p| Point::from(p)).collect()
}

/// A smooth relief of hills.
fn hills(x: f64, y: f64) -> f64 {
    20.0 * (x / 60.0).sin() * (y / 50.0).cos()
}

/// Whether a cell is on the plateau: a disk of radius 80 in the middle of 400 × 500 cells.
fn on_plateau((row, column): GridCell) -> bool {
    (row as f64 - 200.0).hypot(column as f64 - 250.0) < 80.0
}

/// A plateau on hills, scanned with noise of 0.2 units.
fn plateau(step: f64) -> Points {
    relief([400, 500], 0.2, |x, y| {
        let height = if on_plateau((-y as usize, x as usize)) { step } else { 0.0 };
        Some(hills(x, y) + height)
    })
}

/// A scan of a ball of radius 10 all around, from its centre.
fn all_around() -> Points {
    let mut cloud = scan(40, 90, |(row, column)| {
        let (up, around) = (1.2 - 0.06 * row as f64, -TAU * column as f64 / 90.0);
        Some([10.0 * up.cos() * around.cos(), 10.0 * up.cos() * around.sin(), 10.0 * up.sin()])
    });
    cloud.scans[0].viewpoint = Some([0.0; 3]);
    cloud
}
