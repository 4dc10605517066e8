//! Rows: strips, lists, and rows that do not agree with the header.

use formats::Location;

use super::{LIST, POINTS, SQUARE, XYZ, ascii, binary, header};
use crate::support::{polygons, refusal, soup};

/// Binary strips over the square. Their vertex numbers have the type short.
fn strips(name: &str, swap: bool, rows: &[&[i16]]) -> Vec<u8> {
    let square = binary(name, swap);
    let count = rows.len();
    let elements = format!(
        "element vertex 4\n{XYZ}element tristrips {count}\n\
         property list int short vertex_indices\n"
    );
    let mut file = header(name, &elements).into_bytes();
    file.extend(&square[square.len() - (48 + 17)..square.len() - 17]);
    for row in rows {
        let length = row.len() as i32;
        file.extend(if swap { length.to_be_bytes() } else { length.to_le_bytes() });
        let order = |i: &i16| if swap { i.to_be_bytes() } else { i.to_le_bytes() };
        row.iter().for_each(|i| file.extend(order(i)));
    }
    file
}

#[test]
fn binary_strips() {
    for (name, swap) in [("binary_little_endian", false), ("binary_big_endian", true)] {
        let rows: [&[i16]; 3] = [&[-1, 0, 1, 3, 2, -1], &[0, 1, -1, -1, 2, 3, 0], &[]];
        let soup = soup("strips.ply", strips(name, swap, &rows));
        assert_eq!(soup.points, SQUARE);
        assert_eq!(polygons(&soup), [[0, 1, 3], [3, 1, 2], [2, 3, 0]]);
    }
}

#[test]
fn strips_beside_faces() {
    let elements =
        format!("element vertex 4\n{XYZ}element face 1\n{LIST}element tristrips 1\n{LIST}");
    let text = header("ascii", &elements) + POINTS + "3 0 1 2\n3 0 2 3\n";
    assert_eq!(polygons(&soup("both.ply", text)), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn bad_vertex_numbers_in_strips_are_refused() {
    let name = "binary_little_endian";
    refusal("range.ply", strips(name, false, &[&[0, 1, 4]]), "vertex 4, but only 4");
    refusal("range.ply", strips(name, false, &[&[0, 1, 2, -1, 9, 0, 1]]), "vertex 9, but only 4");
}

#[test]
fn only_minus_one_starts_a_new_strip() {
    let strip = strips("binary_little_endian", false, &[&[0, 1, 2, -7, 0, 2, 3]]);
    refusal("negative.ply", strip, "negative");
}

#[test]
fn lists_without_entries_are_passed_over() {
    let elements = format!("element vertex 4\n{XYZ}element face 3\n{LIST}");
    let square = binary("binary_little_endian", false);
    let mut file = header("binary_little_endian", &elements).into_bytes();
    file.extend(&square[square.len() - (48 + 17)..square.len() - 17]);
    file.push(0);
    file.extend(&square[square.len() - 17..]);
    file.push(0);
    assert_eq!(polygons(&soup("zero.ply", file.clone())), [[0, 1, 2, 3]]);
    // A wrong length shifts everything that follows.
    let at = file.len() - 19;
    file[at] = 255;
    let error = refusal("derailed.ply", file, "ends after 0 of the 3");
    assert_eq!(error.place, Some(Location::Face(0)));
}

#[test]
fn rows_that_disagree_with_the_header_are_refused() {
    let good = ascii("3 0 1 2\n3 0 2 3\n");
    let swaps = [
        // A column that is missing in the header, and a column that is missing in the rows.
        ("3 0 1 2\n", "3 0 1 2 255\n", Some(Location::Line(14))),
        ("1 1 0\n", "1 1 0 0 0 1\n", Some(Location::Line(12))),
        ("float z\n", "float z\nproperty float q\n", Some(Location::Line(12))),
        // A list with a length that is too large or too small.
        ("3 0 1 2\n", "4 0 1 2\n", Some(Location::Line(15))),
        ("3 0 1 2\n", "2 0 1 2\n", Some(Location::Line(14))),
    ];
    for (from, to, place) in swaps {
        let error = refusal("row.ply", good.replacen(from, to, 1), "more values in a row");
        assert_eq!(error.place, place, "{to}");
    }
    // A list that only the header has. The first number of the next row is not a valid length.
    let list = good.replace("float z\n", &format!("float z\n{LIST}"));
    refusal("list.ply", list.replace("1 0 0\n", ".5 0 0\n"), "unreadable vertex");
}

#[test]
fn more_rows_than_announced_are_refused() {
    let good = ascii("3 0 1 2\n");
    let word = "more data than its header declares";
    refusal("rows.ply", good.clone() + "3 0 2 3\n", word);
    refusal("text.ply", good.clone() + "the end\n", word);
    // DOS programs end text with their own mark.
    assert_eq!(soup("dos.ply", good + "\x1a").points, SQUARE);
}

#[test]
fn huge_counts_cost_nothing() {
    for name in ["binary_little_endian", "binary_big_endian"] {
        let square = binary(name, name.contains("big"));
        let at = square.windows(16).position(|w| w == b"element vertex 4").expect("vertices");
        let huge = [&square[..at], b"element vertex 4000000000", &square[at + 16..]].concat();
        let error = refusal("huge.ply", huge, "ends after 5 of the 4000000000");
        assert_eq!(error.place, Some(Location::Vertex(5)));
    }
}

/// A binary file that is sent as text gets an additional byte for each line feed, or three bytes
/// for each byte that is not UTF-8.
#[test]
fn binaries_damaged_as_text_are_refused() {
    let elements = format!("element vertex 11\n{XYZ}element face 1\n{LIST}");
    let mut file = header("binary_little_endian", &elements).into_bytes();
    (0..33).for_each(|i| file.extend((i as f32).to_le_bytes()));
    file.push(3);
    [8, 9, 10i32].iter().for_each(|i| file.extend(i.to_le_bytes()));
    assert_eq!(polygons(&soup("sound.ply", &file)), [[8, 9, 10]]);
    let lines: Vec<u8> =
        file.iter().flat_map(|&b| if b == b'\n' { vec![13, b] } else { vec![b] }).collect();
    refusal("lines.ply", lines, "");
    refusal("mangled.ply", String::from_utf8_lossy(&file).as_bytes(), "");
}

#[test]
fn strips_name_what_is_negative() {
    let rows: [&[i16]; 2] = [&[0, 1, 2], &[0, 1, 2, -2]];
    let file = strips("binary_big_endian", true, &rows);
    let error = refusal("negative.ply", file, "strip with the negative vertex number -2");
    assert_eq!(error.place, Some(Location::Element("row of tristrips", 1)));
}

#[test]
fn a_point_alone_is_no_number() {
    for word in [".", "-.", ".e5"] {
        let text = ascii("3 0 1 2\n").replace("1 1 0\n", &format!("1 {word} 0\n"));
        let error = refusal("point.ply", text, "unreadable vertex");
        assert_eq!(error.place, Some(Location::Line(12)), "{word}");
    }
}
