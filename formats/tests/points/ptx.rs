//! PTX: scans with their poses and grids.

use formats::LengthUnit;
use formats::points::{Note, ScanGrid};

use crate::support::{cloud, places, refusal};

/// A scan of two columns and three rows with this matrix.
fn scan(position: &str, matrix: &str) -> String {
    format!(
        "2\n3\n{position}\n1 0 0\n0 1 0\n0 0 1\n{matrix}\n1 0 0 0.5\n1 1 0 0.5\n0 0 0 0.5\n\
         2 0 0 0.5\n2 1 0 0.5\n2 2 5 0.5\n"
    )
}

const STAY: &str = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1";

#[test]
fn cells_go_down_the_columns() {
    let cloud = cloud("scan.ptx", scan("0 0 0", STAY));
    assert_eq!(cloud.len(), 5);
    let grid = cloud.scans[0].grid.as_ref().expect("a grid");
    assert_eq!((grid.rows, grid.columns), (3, 2));
    assert_eq!(grid.cells, [0, 2, 1, 3, ScanGrid::EMPTY, 4]);
    assert_eq!((cloud.lost.at_zero, cloud.lost.intensities), (1, 5));
    assert_eq!((cloud.unit, cloud.notes), (Some(LengthUnit::Metre), vec![Note::MetresByCustom]));
}

#[test]
fn each_scan_has_its_pose() {
    // The first scan is turned: its x axis points to y, and its y axis to -x.
    let turn = "0 1 0 0\n-1 0 0 0\n0 0 1 0\n400000.25 5800000.5 100 1";
    let far = "1 0 0 0\n0 1 0 0\n0 0 1 0\n400010.25 5800000.5 100 1";
    let text = scan("400000.25 5800000.5 100", turn) + &scan("400010.25 5800000.5 100", far);
    let cloud = cloud("scans.ptx", text);
    assert_eq!(cloud.scans.len(), 2);
    assert_eq!([&cloud.scans[0].points, &cloud.scans[1].points], [&(0..5), &(5..10)]);
    assert_eq!(places(&cloud)[1], [399999.25, 5800001.5, 100.0]);
    assert_eq!(places(&cloud)[9], [400012.25, 5800002.5, 105.0]);
    assert!(cloud.origin[1] > 5.7e6);
    let second = &cloud.scans[1];
    let pose = second.pose.expect("a pose");
    let place = |v: [f64; 3]| [0, 1, 2].map(|i| v[i] + cloud.origin[i]);
    assert_eq!(place(pose.translation), [400010.25, 5800000.5, 100.0]);
    assert_eq!(place(second.viewpoint.expect("a viewpoint")), [400010.25, 5800000.5, 100.0]);
    assert_eq!(cloud.scans[0].pose.expect("a pose").axes[0], [0.0, 1.0, 0.0]);
    assert_eq!(second.grid.as_ref().and_then(|grid| grid.point(0, 0)), Some(5));
}

#[test]
fn a_pose_loses_no_digit() {
    let far = "1 0 0 0\n0 1 0 0\n0 0 1 0\n400000 5800000 100 1";
    let text = scan("0 0 0", far).replace("1 1 0 0.5", "1.0000000001234 1 0 0.5");
    let cloud = cloud("scan.ptx", text);
    let translation = cloud.scans[0].pose.expect("a pose").translation;
    assert_eq!(cloud.positions[1][0] - translation[0], 1.0000000001234);
}

#[test]
fn a_position_counts_where_the_matrix_moves_nothing() {
    let cloud = cloud("scan.ptx", scan("1 2 3", STAY));
    assert_eq!(cloud.scans[0].viewpoint, Some([1.0, 2.0, 3.0]));
}

#[test]
fn colours_are_counted() {
    let text = scan("0 0 0", STAY).replace("0.5\n", "0.5 1 2 3\n");
    let lost = cloud("scan.ptx", text).lost;
    assert_eq!((lost.colours, lost.intensities), (5, 5));
}

#[test]
fn one_row_is_no_grid() {
    let text = scan("0 0 0", STAY).replacen("2\n3\n", "6\n1\n", 1);
    let cloud = cloud("scan.ptx", text);
    assert_eq!((cloud.len(), &cloud.scans[0].grid), (5, &None));
}

#[test]
fn a_scan_that_saw_nothing_is_kept_beside_others() {
    let nothing = format!("1\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n{STAY}\n0 0 0 1\n0 0 0 1\n");
    let cloud = cloud("scan.ptx", nothing.clone() + &scan("0 0 0", STAY));
    assert_eq!((cloud.scans.len(), cloud.len(), cloud.lost.at_zero), (2, 5, 3));
    refusal("scan.ptx", nothing, "no valid point: all 2 are missing");
}

#[test]
fn contradictions_are_refused() {
    let good = scan("0 0 0", STAY);
    for (from, to, word) in [
        ("2\n3\n", "2\n4\n", "ends after 6 of the 8 cells of scan 0 (cell 6)"),
        ("2\n3\n", "4000000000\n4000000000\n", "ends after 6 of the 16000000000000000000 cells"),
        ("2\n3\n", "18446744073709551615\n3\n", "too many cells"),
        ("2\n3\n", "2\n2\n", "for the number of columns of a scan (line 15)"),
        ("0 0 1 0\n", "0 0 0 0\n", "places nothing for scan 0 (line 10)"),
        ("0 0 1 0\n", "1 0 0 0\n", "places nothing"),
        ("0 0 0 1\n", "0 0 0 0\n", "places nothing"),
        ("0 0 0 1\n", "0 0 nan 1\n", "where 4 numbers should be (line 10)"),
        ("0 0 0 1\n", "0 0 0\n", "where 4 numbers should be (line 10)"),
        ("1 1 0 0.5\n", "1 1\n", "unreadable point \u{201c}1 1\u{201d} (line 12)"),
        ("1 1 0 0.5\n", "1 one 0 0.5\n", "unreadable point"),
        ("1 0 0 0\n", "1e120 0 0 0\n", "beyond the range of numbers"),
    ] {
        assert!(good.contains(from));
        let file = good.replacen(from, to, 1).replace("2 2 5", "2e200 2 5");
        refusal("scan.ptx", file, word);
    }
    let few_lines: String = good.split_inclusive('\n').take(4).collect();
    refusal("scan.ptx", few_lines, "ends in the header of scan 0");
}
