//! Steps are cut, and steep flanks are not.

use super::*;

/// The edges of a cloud's grid of which `is_step` says that they cross a step: how many there are,
/// how many are cut, and how many others are cut.
fn cut_edges(cloud: &Points, is_step: impl Fn(GridCell, GridCell) -> bool) -> [usize; 3] {
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
fn longer(
    cloud: &Points,
    multiple: f64,
    is_step: impl Fn(GridCell, GridCell) -> bool,
) -> [usize; 2] {
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
    let angle =
        |(row, column): GridCell| (-0.05 - 0.004 * row as f64, 0.004 * (column as f64 - 100.0));
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
