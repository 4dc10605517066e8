//! Grids with known surfaces: reliefs with steps and flanks, missing cells, scans all around,
//! made-up grids and noise.

use std::f64::consts::TAU;

use formats::Points;
use formats::points::{PointScan, ScanGrid};

use super::jumps::GridEdges;
use super::raster::{Cell, GridStep, Raster};
use super::*;

/// A scan of a grid with the points that `place` gives to its cells.
fn scan(rows: usize, columns: usize, mut place: impl FnMut(Cell) -> Option<[f64; 3]>) -> Points {
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

/// The edges of a cloud's grid of which `is_step` says that they cross a step: how many there are,
/// how many are cut, and how many others are cut.
fn cut_edges(cloud: &Points, is_step: impl Fn(Cell, Cell) -> bool) -> [usize; 3] {
    let points = points(cloud);
    let raster = Raster::new(&points, cloud.scans[0].grid.as_ref().unwrap()).unwrap();
    let edges = GridEdges::new(&raster);
    let mut counts = [0; 3];
    for step in [GridStep::Column, GridStep::Row] {
        for cell in raster.cells() {
            let Some(next) = raster.moved(cell, step, 1) else { continue };
            if raster.point(cell).and(raster.point(next)).is_none() {
                continue;
            }
            let cut = !edges.is_joined(cell, step);
            let of_step = is_step(cell, next);
            counts[0] += usize::from(of_step);
            counts[1] += usize::from(of_step && cut);
            counts[2] += usize::from(!of_step && cut);
        }
    }
    counts
}

/// A smooth relief of hills.
fn hills(x: f64, y: f64) -> f64 {
    20.0 * (x / 60.0).sin() * (y / 50.0).cos()
}

/// Whether a cell is on the plateau: a disk of radius 80 in the middle of 400 × 500 cells.
fn on_plateau((row, column): Cell) -> bool {
    (row as f64 - 200.0).hypot(column as f64 - 250.0) < 80.0
}

/// A plateau on hills, scanned with noise of 0.2 units.
fn plateau(step: f64) -> Points {
    relief([400, 500], 0.2, |x, y| {
        let height = if on_plateau((-y as usize, x as usize)) { step } else { 0.0 };
        Some(hills(x, y) + height)
    })
}

/// A wall of 25 units around a disk in hills.
fn flank(degrees: f64) -> Points {
    let slope = degrees.to_radians().tan();
    relief([300, 300], 0.2, |x, y| {
        let distance = (x - 150.0).hypot(y + 150.0) - 80.0;
        Some(hills(x, y) + (slope * distance).clamp(0.0, 25.0))
    })
}

#[test]
fn plateaus_are_cut_off() {
    for (step, least) in [(3.0, 0.97), (5.0, 1.0), (8.0, 1.0), (20.0, 1.0)] {
        let [all, cut, lost] = cut_edges(&plateau(step), |a, b| on_plateau(a) != on_plateau(b));
        println!("step {step}: {cut} of {all} edges cut, {lost} others");
        assert!(cut as f64 >= least * all as f64, "step {step}: {cut} of {all}");
        assert!(lost <= 4, "step {step}: {lost} others cut");
    }
}

#[test]
fn steep_flanks_stay() {
    for degrees in [70.0, 75.0, 80.0] {
        let [_, _, lost] = cut_edges(&flank(degrees), |_, _| false);
        println!("flank of {degrees}°: {lost} edges cut");
        assert!(lost <= 10, "flank of {degrees}°: {lost}");
    }
}

/// How many edges of a cloud's grid are longer than a multiple of the median of all, and how many
/// of these are across a step.
fn longer(cloud: &Points, multiple: f64, is_step: impl Fn(Cell, Cell) -> bool) -> [usize; 2] {
    let points = points(cloud);
    let raster = Raster::new(&points, cloud.scans[0].grid.as_ref().unwrap()).unwrap();
    let steps = [GridStep::Column, GridStep::Row];
    let mut all: Vec<f64> = steps.iter().flat_map(|&step| raster.lengths(step)).collect();
    all.retain(|length| !length.is_nan());
    let limit = multiple * median(&mut all).unwrap();
    let mut counts = [0; 2];
    for step in steps {
        let lengths = raster.lengths(step);
        for (cell, _) in raster.cells().zip(&lengths).filter(|(_, length)| **length > limit) {
            let next = raster.moved(cell, step, 1).unwrap();
            counts[0] += 1;
            counts[1] += usize::from(is_step(cell, next));
        }
    }
    counts
}

#[test]
fn lengths_alone_miss_steps_and_cut_flanks() {
    let [_, of_step] = longer(&plateau(3.0), 4.0, |a, b| on_plateau(a) != on_plateau(b));
    println!("longer than 4 medians: {of_step} edges of a step of 3");
    assert!(of_step < 50, "{of_step}");
    for degrees in [75.0, 80.0] {
        let [lost, _] = longer(&flank(degrees), 4.0, |_, _| false);
        println!("longer than 4 medians: {lost} edges of a flank of {degrees}°");
        assert!(lost > 100, "flank of {degrees}°: {lost}");
    }
}

/// What a ray of the scanner in a hall meets: the floor or a column that stands on it.
fn hall(up: f64, around: f64) -> Option<(f64, bool)> {
    let floor = -1.5 / up.sin();
    // A round column of radius 0.3, three metres away.
    let (b, c) = (3.0 * around.cos(), 9.0 - 0.09);
    let column = (b * b > c).then(|| (b - (b * b - c).sqrt()) / up.cos());
    match column {
        Some(column) if column < floor => Some((column, true)),
        _ => Some((floor, false)),
    }
}

#[test]
fn a_column_is_cut_from_the_floor_that_is_seen_at_a_low_angle() {
    let angle = |(row, column): Cell| (-0.05 - 0.004 * row as f64, 0.004 * (column as f64 - 100.0));
    let seen = |cell| hall(angle(cell).0, angle(cell).1);
    let mut random = Random(4);
    let mut cloud = scan(250, 201, |cell| {
        let ((up, around), (range, _)) = (angle(cell), seen(cell)?);
        let range = range + 0.001 * random.normal();
        Some([range * up.cos() * around.cos(), -range * up.cos() * around.sin(), range * up.sin()])
    });
    cloud.scans[0].viewpoint = Some([0.0; 3]);
    // The column ends at its foot without a jump.
    let is_step = |a, b| {
        let ((near, is_column), (far, other)) = (seen(a).unwrap(), seen(b).unwrap());
        is_column != other && (near - far).abs() > 0.1
    };
    let [all, cut, lost] = cut_edges(&cloud, is_step);
    println!("column: {cut} of {all} edges cut, {lost} others");
    // The sides of the column turn away from the scanner, so a few steps are led up to.
    assert!(all > 200 && cut as f64 > 0.97 * all as f64, "{cut} of {all}");
    assert!(lost <= 4, "{lost} others cut");
}

#[test]
fn every_square_has_two_triangles() {
    let cloud = relief([30, 40], 0.0, |x, y| Some(hills(x, y)));
    let mesh = mesh(&cloud);
    assert_eq!(mesh.mesh.triangles.len(), 2 * 29 * 39);
    assert_eq!(mesh.cut, 0);
    assert!((mesh.spacing - 1.0).abs() < 0.1, "{}", mesh.spacing);
}

#[test]
fn a_missing_cell_costs_four_triangles() {
    let flat = |missing: Cell| {
        relief([9, 9], 0.0, |x, y| ((-y as usize, x as usize) != missing).then_some(0.0))
    };
    // Inside: three of four points make one triangle. In the corner: one triangle is left.
    assert_eq!(mesh(&flat((6, 6))).mesh.triangles.len(), 2 * 64 - 4);
    assert_eq!(mesh(&flat((0, 8))).mesh.triangles.len(), 2 * 64 - 1);
}

#[test]
fn a_point_before_the_surface_is_cut_off() {
    let cloud = relief([15, 15], 0.0, |x, y| Some(if (x, y) == (7.0, -7.0) { 30.0 } else { 0.0 }));
    let mesh = mesh(&cloud);
    assert_eq!(mesh.cut, 4);
    let far = 7 * 15 + 7;
    assert!(mesh.mesh.triangles.iter().flatten().all(|v| v.0 != far));
    assert_eq!(mesh.mesh.triangles.len(), 2 * 14 * 14 - 4);
}

#[test]
fn the_shorter_diagonal_is_taken() {
    // A ridge from one corner to the other is kept only by the diagonals along it.
    let cloud = relief([9, 9], 0.0, |x, y| Some(-(x + y).abs()));
    for [a, b, c] in mesh(&cloud).mesh.triangles {
        let cell = |v: VertexId| (v.0 / 9, v.0 % 9);
        let above = [a, b, c].map(cell).iter().any(|(row, column)| row > column);
        let below = [a, b, c].map(cell).iter().any(|(row, column)| row < column);
        assert!(!(above && below));
    }
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

#[test]
fn a_scan_all_around_is_not_joined_with_itself() {
    let mesh = mesh(&all_around());
    assert_eq!(mesh.mesh.triangles.len(), 2 * 39 * 89);
    let column = |v: &VertexId| v.0 % 90;
    let joins =
        |t: &[VertexId; 3]| t.iter().any(|v| column(v) == 0) && t.iter().any(|v| column(v) == 89);
    assert!(!mesh.mesh.triangles.iter().any(joins));
}

/// The share of triangles that are counter-clockwise seen from a place.
fn seen_from(cloud: &Points, mesh: &GridSurface, place: [f64; 3]) -> f64 {
    let point = |v: VertexId| Point::from(cloud.positions[v.index()]);
    let is_seen = |t: &&[VertexId; 3]| {
        let [a, b, c] = t.map(point);
        (b - a).cross(&(c - a)).dot(&(Point::from(place) - a)) > 0.0
    };
    mesh.mesh.triangles.iter().filter(is_seen).count() as f64 / mesh.mesh.triangles.len() as f64
}

#[test]
fn triangles_face_the_viewpoint() {
    let mut cloud = all_around();
    assert_eq!(seen_from(&cloud, &mesh(&cloud), [0.0; 3]), 1.0);
    // Seen from outside the same grid runs the other way round.
    cloud.scans[0].viewpoint = Some([1e6, 0.0, 0.0]);
    let mirrored = scan(20, 20, |(row, column)| Some([column as f64, row as f64, 0.0]));
    for z in [-50.0, 50.0] {
        let mut cloud = mirrored.clone();
        cloud.scans[0].viewpoint = Some([10.0, 10.0, z]);
        let mesh = mesh(&cloud);
        assert_eq!(mesh.outside, Outside::Viewpoint);
        assert_eq!(seen_from(&cloud, &mesh, [10.0, 10.0, z]), 1.0);
    }
}

#[test]
fn without_a_viewpoint_normals_zero_or_rows_decide() {
    let plain = scan(20, 20, |(row, column)| Some([column as f64, row as f64, 5.0]));
    for side in [-1.0_f32, 1.0] {
        let mut cloud = plain.clone();
        cloud.normals = Some(vec![[0.0, 0.0, side]; 400]);
        let mesh = mesh(&cloud);
        assert_eq!(mesh.outside, Outside::Normals);
        assert_eq!(seen_from(&cloud, &mesh, [0.0, 0.0, 5.0 + 100.0 * f64::from(side)]), 1.0);
    }
    // Too few normals are none.
    let mut few = plain.clone();
    few.normals = Some(vec![[0.0, 0.0, 1.0]; 7]);
    assert_eq!(mesh(&few).outside, Outside::Zero);
    let of_zero = mesh(&plain);
    assert_eq!(of_zero.outside, Outside::Zero);
    assert_eq!(seen_from(&plain, &of_zero, [0.0; 3]), 1.0);
    // The zero is beside this surface, which it sees from both sides.
    let waves = scan(60, 60, |(row, column)| {
        Some([column as f64 + 1.0, row as f64, 10.0 * (column as f64 / 3.0).sin()])
    });
    let of_rows = mesh(&waves);
    assert_eq!(of_rows.outside, Outside::RowOrder);
    assert_eq!(seen_from(&waves, &of_rows, [30.0, 30.0, 1e6]), 1.0);
}

#[test]
fn the_noise_along_the_normal_is_measured() {
    for noise in [0.01, 0.1, 0.5] {
        let cloud = relief([200, 200], noise, |x, y| Some(hills(x, y)));
        let ratio = mesh(&cloud).noise / noise;
        println!("noise {noise}: {ratio} of it measured");
        // The slopes of the hills take a few percent off what is along the ray.
        assert!((0.9..1.03).contains(&ratio), "noise {noise}: {ratio}");
    }
    // Displacements along a tilted plane are no noise.
    let mut random = Random(2);
    let plane = scan(100, 100, |(row, column)| {
        let x = column as f64 + 0.2 * random.normal();
        Some([x, row as f64 + 0.2 * random.normal(), 2.0 * x])
    });
    let noise = mesh(&plane).noise;
    assert!(noise < 1e-9, "{noise}");
}

#[test]
fn steps_are_no_noise() {
    let ratio = mesh(&plateau(6.0)).noise / 0.2;
    assert!((0.9..1.03).contains(&ratio), "{ratio}");
}

#[test]
fn flat_patches_of_a_scanner_with_coarse_steps_are_left_out() {
    // Steps of 0.5 in depth, on a slope with one step in ten units.
    let cloud = relief([200, 200], 0.0, |x, y| Some(0.5 * (0.1 * x + 0.02 * y).round()));
    let noise = mesh(&cloud).noise;
    println!("steps of 0.5: noise {noise}");
    // A uniform error within a step has a deviation of 0.29 steps.
    assert!((0.05..0.2).contains(&noise), "{noise}");
}

#[test]
fn made_up_grids_are_not_believed() {
    // Points in any order, to which a header gives rows and columns.
    let mut random = Random(3);
    let cloud = scan(40, 50, |_| {
        Some([50.0 * random.uniform(), 40.0 * random.uniform(), random.uniform()])
    });
    assert_eq!(surface(&cloud).err().unwrap(), GridDoubt::MadeUp);
}

#[test]
fn grids_that_are_none_are_not_believed() {
    let mut twice = relief([20, 20], 0.0, |_, _| Some(0.0));
    twice.scans[0].grid.as_mut().unwrap().cells[7] = 8;
    assert_eq!(surface(&twice).err().unwrap(), GridDoubt::Inconsistent);
    let mut beyond = relief([20, 20], 0.0, |_, _| Some(0.0));
    beyond.scans[0].grid.as_mut().unwrap().cells[7] = 400;
    assert_eq!(surface(&beyond).err().unwrap(), GridDoubt::Inconsistent);
    let mut rows = relief([20, 20], 0.0, |_, _| Some(0.0));
    rows.scans[0].grid.as_mut().unwrap().rows = usize::MAX;
    assert_eq!(surface(&rows).err().unwrap(), GridDoubt::Inconsistent);
    // Blocks of three by three cells between empty rows and columns.
    let is_empty = |x: f64| (x as i64).rem_euclid(4) == 0;
    let blocks = |x, y| (!is_empty(x) && !is_empty(y)).then_some(0.0);
    let sparse = surface(&relief([60, 60], 0.0, blocks));
    assert_eq!(sparse.err().unwrap(), GridDoubt::Sparse);
    let empty = scan(20, 20, |_| None);
    assert_eq!(surface(&empty).err().unwrap(), GridDoubt::MadeUp);
}

#[test]
fn the_vertices_are_the_points_and_missing_cells_are_closed() {
    let cloud = relief([30, 30], 0.1, |x, y| ((x, y) != (12.0, -12.0)).then(|| hills(x, y)));
    let made = triangulate_grid(&cloud, &Options::default()).unwrap();
    assert_eq!(made.soup.points, cloud.positions);
    assert_eq!(made.soup.polygons.len(), 2 * 29 * 29 - 2);
    assert!(made.vertex_of.iter().enumerate().all(|(i, &vertex)| vertex == i as u32));
    assert_eq!(
        made.report.grid,
        GridUse::Followed { cut: 0, outside: Outside::Viewpoint },
        "{:?}",
        made.report
    );
}

#[test]
fn a_point_without_neighbours_has_no_vertex() {
    let cloud = relief([30, 30], 0.0, |x, y| Some(if (x, y) == (7.0, -7.0) { 30.0 } else { 0.0 }));
    let made = triangulate_grid(&cloud, &Options::default()).unwrap();
    assert_eq!(made.vertex_of.iter().filter(|&&vertex| vertex == LEFT_OUT).count(), 1);
    assert_eq!((made.report.outliers, made.soup.points.len()), (1, 899));
    // The place behind it is closed.
    assert_eq!(made.soup.polygons.len(), 2 * 29 * 29 - 2);
}

#[test]
fn the_unit_and_the_place_do_not_matter() {
    let plain = relief([40, 40], 0.1, |x, y| Some(hills(x, y)));
    let reference = triangulate_grid(&plain, &Options::default()).unwrap();
    for scale in [1e-200, 1e200] {
        let mut cloud = plain.clone();
        cloud.positions.iter_mut().flatten().for_each(|x| *x *= scale);
        cloud.scans[0].viewpoint = plain.scans[0].viewpoint.map(|v| v.map(|x| x * scale));
        let made = triangulate_grid(&cloud, &Options::default()).unwrap();
        assert_eq!(made.soup.polygons, reference.soup.polygons);
        let ratio = made.report.noise / scale / reference.report.noise;
        assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
    }
}

#[test]
fn only_the_grid_of_a_single_scan_is_followed() {
    let one = relief([20, 20], 0.0, |_, _| Some(0.0));
    let refusal = |cloud: &Points, spacing| triangulate_grid(cloud, &Options { spacing }).err();
    assert_eq!(refusal(&one, None), None);
    assert_eq!(refusal(&one, Some(3.0)), Some(GridUse::OtherSpacing));
    let mut two = one.clone();
    two.scans.push(PointScan { points: 400..400, ..PointScan::default() });
    assert_eq!(refusal(&two, None), Some(GridUse::Several));
    two.scans[0].grid = None;
    assert_eq!(refusal(&two, None), Some(GridUse::Absent));
    assert_eq!(refusal(&Points::default(), None), Some(GridUse::Absent));
}
