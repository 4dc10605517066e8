//! PCD: the three encodings, grids, and what its header may say.

use formats::points::{Note, ScanGrid};

use crate::seeds::{ASCII_PCD, columns, columns_without_padding, packed, pcd, records};
use crate::support::{cloud, places, refusal};

const PLACES: [[f64; 3]; 5] =
    [[0.5, 0.25, 1.0], [1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0], [1.5, 10.0, -1.0]];

fn encodings() -> [Vec<u8>; 4] {
    [
        pcd("ascii", ASCII_PCD.as_bytes()),
        pcd("binary", &records()),
        pcd("binary_compressed", &packed(&columns())),
        pcd("binary_compressed", &packed(&columns_without_padding())),
    ]
}

#[test]
fn every_encoding_reads_the_same() {
    for file in encodings() {
        let cloud = cloud("scan.pcd", file);
        assert_eq!(places(&cloud), PLACES);
        assert_eq!(cloud.origin, [0.0; 3]);
        let normals = cloud.normals.as_ref().expect("normals");
        assert_eq!(normals[0], [0.0, 0.0, 1.0]);
        assert_eq!(normals[4], [1.0, 0.0, 0.0]);
        let scan = &cloud.scans[0];
        assert_eq!(scan.viewpoint, Some([0.0, 0.0, -1.0]));
        let grid = scan.grid.as_ref().expect("a grid");
        assert_eq!((grid.rows, grid.columns), (2, 3));
        assert_eq!(grid.cells, [0, 1, ScanGrid::EMPTY, 2, 3, 4]);
        assert_eq!((grid.point(1, 0), grid.point(0, 2), grid.point(2, 0)), (Some(2), None, None));
        assert_eq!(cloud.lost.not_finite, 1);
        assert_eq!(cloud.lost.colours, 6);
        assert_eq!(cloud.unit, None);
    }
}

/// A header for three points of `x y z`, and the lines that replace some of it.
fn small(swaps: &[(&str, &str)]) -> String {
    let text = "# .PCD v.7 - Point Cloud Data file format\nVERSION .7\nFIELDS x y z\n\
                SIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\n\
                VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n0 0 1\n1 0 0\n0 1 0\n";
    swaps.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "no {from:?} in the header");
        text.replace(from, to)
    })
}

#[test]
fn old_and_odd_headers_are_read() {
    for swaps in [
        &[][..],
        &[("# .PCD v.7 - Point Cloud Data file format\n", "")],
        &[("# .PCD v.7", "# my own")],
        &[
            ("# .PCD v.7 - Point Cloud Data file format\n", ""),
            ("VERSION .7\n", ""),
            ("COUNT 1 1 1\n", ""),
        ],
        &[("COUNT 1 1 1\n", ""), ("FIELDS", "COLUMNS")],
        &[("POINTS 3\n", "")],
        &[("VIEWPOINT 0 0 0 1 0 0 0\n", "")],
        &[("\n", "\r\n")],
        &[("DATA ascii\n", "DATA ascii\n\n# a comment\n")],
        &[("0 1 0\n", "0 1 0")],
    ] {
        let cloud = cloud("scan.pcd", small(swaps));
        assert_eq!(places(&cloud), [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let scan = &cloud.scans[0];
        // The place of the scanner is the header's default, and means nothing.
        assert_eq!((&scan.grid, scan.viewpoint), (&None, None));
    }
}

#[test]
fn one_row_is_no_grid() {
    for swaps in [[("WIDTH 3", "WIDTH 1"), ("HEIGHT 1", "HEIGHT 3")], [("WIDTH", "WIDTH"); 2]] {
        let cloud = cloud("scan.pcd", small(&swaps));
        assert_eq!((&cloud.scans[0].grid, cloud.notes.len()), (&None, 0));
    }
    let cloud = cloud("scan.pcd", small(&[("WIDTH 3", "WIDTH 2"), ("HEIGHT 1", "HEIGHT 2")]));
    assert_eq!((&cloud.scans[0].grid, cloud.notes), (&None, vec![Note::GridIgnored]));
}

#[test]
fn fields_may_have_any_order_and_type() {
    let types = [("F", 4), ("F", 8), ("I", 1), ("I", 2), ("I", 4), ("I", 8)];
    let types = types.into_iter().chain([("U", 1), ("U", 2), ("U", 4), ("U", 8)]);
    for (letter, size) in types {
        let value = |x: i64| match (letter, size) {
            ("F", 4) => (x as f32).to_le_bytes().to_vec(),
            ("F", 8) => (x as f64).to_le_bytes().to_vec(),
            _ => x.to_le_bytes()[..size].to_vec(),
        };
        let head = format!(
            "VERSION 0.7\nFIELDS label z y x\nSIZE 2 {size} {size} {size}\n\
             TYPE U {letter} {letter} {letter}\nCOUNT 3 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\n\
             DATA binary\n"
        );
        let file = [head.as_bytes(), &[9; 6], &value(3), &value(2), &value(1)].concat();
        let cloud = cloud("scan.pcd", file);
        assert_eq!(places(&cloud), [[1.0, 2.0, 3.0]], "{letter}{size}");
        assert_eq!(cloud.lost.columns, ["label"]);
    }
}

#[test]
fn several_zeros_are_no_points() {
    let zeros = small(&[("0 0 1\n1 0 0\n", "0 0 0\n0 0 0\n")]);
    let cloud_without = cloud("scan.pcd", zeros);
    assert_eq!(places(&cloud_without), [[0.0, 1.0, 0.0]]);
    assert_eq!(cloud_without.lost.at_zero, 2);
    let one = cloud("scan.pcd", small(&[("0 0 1\n", "0 0 0\n")]));
    assert_eq!((one.len(), one.lost.at_zero), (3, 0));
}

#[test]
fn contradictions_are_refused() {
    for (swap, word) in [
        (("SIZE 4 4 4", "SIZE 3 3 3"), "the field x of type F and size 3"),
        (("SIZE 4 4 4", "SIZE 4 4"), "do not match its FIELDS"),
        (("COUNT 1 1 1", "COUNT 1 1 8589934592"), "points of"),
        (("COUNT 1 1 1", "COUNT 1 1 2"), "no fields x, y and z"),
        (("FIELDS x y z", "FIELDS x y w"), "no fields x, y and z"),
        (("FIELDS x y z\n", ""), "no FIELDS line"),
        (("DATA ascii\n", "DATA zipped\n"), "unknown encoding"),
        (("POINTS 3", "POINTS three"), "three"),
        (("POINTS 3", "POINTS 4000000000"), "ends after 3 of its 4,000,000,000 points (point 3)"),
        (("POINTS 3", "POINTS 2"), "more data than its header announces (line 14)"),
        (("1 0 0\n", "1 0\n"), "has not 3 values (line 13)"),
        (("1 0 0\n", "1 0 zero\n"), "unreadable point \u{201c}1 0 zero\u{201d} (line 13)"),
        (("VERSION .7", "VERSION .7\nnonsense"), "the unknown header line"),
    ] {
        refusal("scan.pcd", small(&[swap]), word);
    }
    let points = pcd("binary", &records()[..100]);
    refusal("scan.pcd", points, "ends after 3 of its 6 points (point 3)");
    let longer = pcd("binary", &[records(), vec![1]].concat());
    refusal("scan.pcd", longer, "more data than its header announces");
}

#[test]
fn damaged_packing_is_refused() {
    let body = packed(&columns());
    let cut = pcd("binary_compressed", &body[..body.len() - 3]);
    refusal("scan.pcd", cut, "bytes of packed points");
    let mut sizes = body.clone();
    sizes[4] ^= 1;
    refusal("scan.pcd", pcd("binary_compressed", &sizes), "unpacks to");
    sizes[..8].fill(0xff);
    refusal("scan.pcd", pcd("binary_compressed", &sizes), "unpacks to");
    let mut back = body;
    back[8] = 0xff;
    refusal("scan.pcd", pcd("binary_compressed", &back), "do not unpack");
}

#[test]
fn a_file_sent_as_text_is_told() {
    let xs: Vec<u8> = (0..30).flat_map(|i: u8| (f32::from(i) + 0.1).to_le_bytes()).collect();
    let head = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 10\nHEIGHT 1\n\
                DATA binary\n";
    let file = [head.as_bytes(), &xs].concat();
    assert_eq!(cloud("scan.pcd", &file).len(), 10);
    let text = String::from_utf8_lossy(&file).into_owned();
    let error = refusal("scan.pcd", text, "its bytes were converted to UTF-8 text");
    assert!(error.help.contains("binary file"));
}
