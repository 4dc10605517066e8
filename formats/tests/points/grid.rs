//! Rasters of heights.

use formats::points::ScanGrid;

use crate::support::{cloud, places, refusal};

const HEAD: &str = "ncols 3\nnrows 2\nxllcorner 500000\nyllcorner 4600000\ncellsize 0.5\n";

#[test]
fn a_raster_is_a_grid_of_points() {
    let rows = "NODATA_value -9999\n1 2 3\n4 -9999 6\n";
    for name in ["dem.asc", "dem.txt", "dem.grd", "stdin", "dem.xyz"] {
        let cloud = cloud(name, HEAD.to_owned() + rows);
        assert!(cloud.unit.is_none() && cloud.notes.is_empty());
        assert_eq!(cloud.lost.marked, 1);
        let [x, y] = [500_000.0, 4_600_000.0];
        let expected = [
            [x + 0.25, y + 0.75, 1.0],
            [x + 0.75, y + 0.75, 2.0],
            [x + 1.25, y + 0.75, 3.0],
            [x + 0.25, y + 0.25, 4.0],
            [x + 1.25, y + 0.25, 6.0],
        ];
        assert_eq!(places(&cloud), expected);
        let cells = vec![0, 1, 2, 3, ScanGrid::EMPTY, 4];
        assert_eq!(cloud.scans[0].grid, Some(ScanGrid { rows: 2, columns: 3, cells }));
        assert!(cloud.scans[0].viewpoint.is_some_and(|v| v[2] > 6.0));
    }
}

#[test]
fn headers_are_written_in_several_ways() {
    let centre = "NROWS   2\r\nNCOLS 3\r\nXLLCENTER -1\r\nYLLCENTER 2\r\nDX 2\r\nDY 1\r\n1\r\n2 3 4 5\r\n6\r\n";
    let cloud = cloud("dem.asc", centre);
    assert_eq!(places(&cloud)[0], [-1.0, 3.0, 1.0]);
    assert_eq!(places(&cloud)[5], [3.0, 2.0, 6.0]);
}

#[test]
fn damaged_rasters_are_refused() {
    refusal("dem.asc", HEAD.to_owned() + "1 2 3\n4 5\n", "ends after 5 of its 6 cells");
    refusal("dem.asc", HEAD.to_owned() + "1 2 3\n4 5 6 7\n", "more heights");
    refusal("dem.asc", HEAD.to_owned() + "1 2 3\n4 five 6\n", "five");
    refusal("dem.asc", HEAD, "has no points");
    refusal("dem.asc", "ncols 3\nnrows 2\n1 2 3\n4 5 6\n", "header lacks");
    refusal("dem.asc", HEAD.replace("0.5", "0") + "1 2 3\n4 5 6\n", "header lacks");
    let huge = HEAD.replace("ncols 3", "ncols 18446744073709551615");
    refusal("dem.asc", huge + "1 2 3\n4 5 6\n", "");
    let none = HEAD.to_owned() + "nodata_value 0\n0 0 0\n0 0 0\n";
    refusal("dem.asc", none, "no valid point");
}

/// A raster of 20 x 20 cells of this size, whose heights are `height` of the place in metres, where a cell has so many.
fn terrain(cell: f64, metres: f64, height: impl Fn(f64, f64) -> f64) -> String {
    let head = format!("ncols 20\nnrows 20\nxllcorner 11.25\nyllcorner 47.5\ncellsize {cell}\n");
    let at = |i: usize| metres * (i % 20) as f64;
    let heights = (0..400).map(|i| format!("{} ", height(at(i), at(i / 20))));
    head + &heights.collect::<String>()
}

#[test]
fn cells_in_degrees_are_refused() {
    // Hills, a plain with a rise of 1 in 500, and whole metres, most of whose neighbours are as high.
    let hills = |x: f64, y: f64| 300.0 + 40.0 * (x / 150.0).sin() + 0.1 * y;
    let plain = |x: f64, y: f64| 20.0 + 0.002 * (x + y);
    let whole = |x: f64, y: f64| (300.0 + 0.005 * x + 0.004 * y).round();
    let second = 1.0 / 3600.0;
    for text in
        [terrain(second, 30.9, hills), terrain(second, 30.9, plain), terrain(second, 30.9, whole)]
    {
        let error = refusal("dem.asc", text, "cells in degrees");
        assert!(error.help.contains("Project it"), "{error}");
    }
    // The same ground in metres, a thin wall, and a hole without a height that the header does not declare.
    let wall = |x: f64, y: f64| if x > 4.0 && x < 6.0 { 500.0 } else { y };
    let hole = |x: f64, y: f64| if x == 5.0 && y == 5.0 { -9999.0 } else { x };
    for text in [
        terrain(1.0, 30.9, hills),
        terrain(0.05, 1.0, wall),
        terrain(0.05, 0.05, plain),
        terrain(0.05, 1.0, hole),
    ] {
        assert_eq!(cloud("dem.asc", text).len(), 400);
    }
}

#[test]
fn cells_without_a_height_may_have_fewer_digits_than_the_header_or_more() {
    for (header, cell) in [
        ("-3.4028234663852886e+38", "-3.40282e+38"),
        ("-3.40282346638528898e+38", "-3.4028235e+38"),
        ("-3.4e+38", "-3.40282347e+38"),
        ("1.70141e+38", "1.701411835E38"),
        ("-9999", "-9999.0000"),
        ("-99999.99", "-100000"),
        ("-9999.9", "-9999.900390625"),
    ] {
        let text = format!("{HEAD}NODATA_value {header}\n1 2 3\n4 {cell} 6\n");
        let cloud = cloud("dem.asc", text);
        assert_eq!((cloud.len(), cloud.lost.marked), (5, 1), "{header} {cell}");
    }
    let undeclared = format!("{HEAD}1 2 3\n4 -3.40282e+38 6\n");
    assert_eq!(cloud("dem.asc", undeclared).lost.marked, 1);
    let heights = format!("{HEAD}NODATA_value 0\n1e-9 -0.001 3\n4 0 -9999\n");
    assert_eq!(cloud("dem.asc", heights).lost.marked, 1);
}
