//! Files that are refused.

use formats::Location;

use super::{ascii, binary, header};
use crate::support::{read, refusal};

#[test]
fn bad_vertex_numbers_are_refused() {
    let error = refusal("range.ply", ascii("3 0 1 2\n3 0 1 4\n"), "vertex 4, but only 4");
    assert_eq!(error.place, Some(Location::Face(1)));
    let error = refusal("negative.ply", ascii("3 0 1 2\n3 0 1 -1\n"), "negative");
    assert_eq!(error.place, Some(Location::Face(1)));
}

#[test]
fn bad_headers_are_refused() {
    let good = ascii("3 0 1 2\n");
    let swaps = [
        ("format ascii 1.0\n", "", "no format line"),
        ("ascii", "utf8", "unknown format"),
        ("element face", "element vertex", "two elements"),
        ("float y", "float x", "two properties"),
        ("float y", "float w", "without y"),
        ("vertex_indices", "corners", "without a list vertex_indices"),
        ("float y", "real y", "unknown type"),
        ("float y", "list uchar float y", "without y"),
        ("list uchar", "list float", "length is not an integer"),
        ("uchar int", "uchar float", "not integers"),
        ("vertex 4", "vertex -4", "without name and count"),
        ("vertex 4", "vertex 99999999999999999999", "without name and count"),
        ("element vertex 4\n", "", "before the first element"),
        ("end_header\n", "", "unknown header line"),
    ];
    for (from, to, word) in swaps {
        assert!(good.contains(from));
        let error = refusal("header.ply", good.replacen(from, to, 1), word);
        assert!(matches!(error.place, Some(Location::Line(_)) | None), "{error}");
    }
    refusal("open.ply", "ply\nformat ascii 1.0\n", "no end_header");
    refusal("long.ply", format!("ply\ncomment {}", "x".repeat(1 << 20)), "endless header");
    refusal("lines.ply", "ply\n".to_owned() + &"comment\n".repeat(20_000), "endless header");
}

#[test]
fn wrong_counts_are_refused() {
    let good = ascii("3 0 1 2\n");
    for huge in ["5", "300000000", "18446744073709551615"] {
        refusal("few.ply", good.replace("face 1", &format!("face {huge}")), "ends after 1");
    }
    refusal("many.ply", good.clone() + "3 0 2 3\n", "more data");
    let row = good.replace("1 1 0\n", "1 1 0 255\n");
    let error = refusal("row.ply", row, "more values");
    assert_eq!(error.place, Some(Location::Line(12)));
    refusal("list.ply", good.replace("3 0 1 2", "4000000000 0 1 2"), "ends after 0");
    refusal("list.ply", good.replace("3 0 1 2", "-3 0 1 2"), "unreadable face");
    let number = refusal("word.ply", good.replace("1 1 0", "1 1,5 0"), "unreadable vertex");
    assert!(number.help.contains("decimal points"));
    refusal("real.ply", good.replace("3 0 1 2", "3 0 1 2.5"), "unreadable face");
}

#[test]
fn cut_binaries_are_refused() {
    for file in [binary("binary_little_endian", false), binary("binary_big_endian", true)] {
        let body = file.len() - (48 + 17);
        for cut in body..file.len() {
            let error = refusal("cut.ply", &file[..cut], "ends after");
            assert!(matches!(error.place, Some(Location::Vertex(_) | Location::Face(0))));
        }
        let mut long = file.clone();
        long.extend([0; 9]);
        assert!(read("padded.ply", &long).is_ok());
        long.push(1);
        refusal("long.ply", &long, "more data");
    }
    let camera = header("binary_little_endian", "element camera 9000000000\nproperty double f\n");
    refusal("camera.ply", camera + "12345678", "ends after 1 of the 9000000000");
}
