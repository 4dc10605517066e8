//! Grids that are followed, and those that are not.

use super::*;

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
fn only_the_grid_of_a_single_scan_is_followed() {
    let one = relief([20, 20], 0.0, |_, _| Some(0.0));
    let refusal = |cloud: &Points, spacing| {
        triangulate_grid(cloud, &Options { spacing, ..Options::default() }).err()
    };
    assert_eq!(refusal(&one, None), None);
    assert_eq!(refusal(&one, Some(3.0)), Some(GridUse::OtherSpacing));
    let mut two = one.clone();
    two.scans.push(PointScan { points: 400..400, ..PointScan::default() });
    assert_eq!(refusal(&two, None), Some(GridUse::Several));
    two.scans[0].grid = None;
    assert_eq!(refusal(&two, None), Some(GridUse::Absent));
    assert_eq!(refusal(&Points::default(), None), Some(GridUse::Absent));
}
