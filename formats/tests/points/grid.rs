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
