//! Headers: their content and what they declare.

use formats::Location;

use super::{LIST, POINTS, SQUARE, XYZ, ascii, binary, header};
use crate::support::{polygons, refusal, soup};

#[test]
fn comments_stand_anywhere() {
    let text = ascii("3 0 1 2\n");
    let (head, body) = text.split_at(text.find("end_header").expect("an end"));
    for comment in
        ["comment", "comment element vertex 9", "obj_info end_header", "comment\tply", ""]
    {
        let head = head.replace('\n', &format!("\n{comment}\n"));
        assert_eq!(soup("comment.ply", head + body).points, SQUARE, "{comment}");
    }
}

/// Rhinoceros ends the lines of the header with CR alone, and binary rows follow.
#[test]
fn line_ends_of_binary_headers() {
    let elements = format!("element vertex 4\nproperty uchar t\n{XYZ}element face 1\n{LIST}");
    let square = binary("binary_little_endian", false);
    let body = &square[square.len() - (48 + 17)..];
    for end in ["\n", "\r\n", "\r"] {
        // The first byte after the header may look like another line end.
        for tag in [b'\n', b'\r', b'e'] {
            let head = header("binary_little_endian", &elements).replace('\n', end);
            let mut file = head.into_bytes();
            for point in body[..48].chunks(12) {
                file.push(tag);
                file.extend(point);
            }
            file.extend(&body[48..]);
            let soup = soup("ends.ply", file);
            assert_eq!(soup.points, SQUARE, "{end:?} {tag}");
            assert_eq!(polygons(&soup), [[0, 1, 2, 3]]);
        }
    }
}

#[test]
fn line_ends_of_header_and_rows_may_differ() {
    let text = ascii("3 0 1 2\n3 0 2 3\n");
    let (head, rows) = text.split_at(text.find("0 0 0").expect("rows"));
    for (end, other) in [("\n", "\r\n"), ("\r\n", "\n")] {
        let text = head.replace('\n', end) + &rows.replace('\n', other);
        let soup = soup("mixed.ply", text);
        assert_eq!(soup.points, SQUARE);
        assert_eq!(polygons(&soup), [[0, 1, 2], [0, 2, 3]]);
    }
}

#[test]
fn spaces_and_tabs_separate() {
    let text = ascii("3 0 1 2\n");
    let odd = text
        .replace("format ascii 1.0", "format   ascii 1.0\t")
        .replace("element vertex 4", " element vertex\t4")
        .replace("property float y", "property \t\t float  y ")
        .replace("3 0 1 2", "\t3  0\t1 2 ");
    assert_eq!(soup("spaces.ply", odd).points, SQUARE);
}

/// Editors on Windows write a byte order mark there.
#[test]
fn byte_order_mark_before_the_header() {
    let text = "\u{feff}".to_owned() + &ascii("3 0 1 2\n");
    assert_eq!(soup("mark.ply", text).points, SQUARE);
}

#[test]
fn both_names_of_the_corner_list() {
    for name in ["vertex_index", "vertex_indices"] {
        for element in ["face", "tristrips"] {
            let text = ascii("3 0 1 2\n").replace("vertex_indices", name);
            let text = text.replace("element face", &format!("element {element}"));
            assert_eq!(polygons(&soup("name.ply", text)), [[0, 1, 2]]);
        }
    }
}

#[test]
fn properties_stand_in_any_order() {
    let elements = format!(
        "element vertex 3\nproperty uchar red\nproperty double z\nproperty float nx\n\
         property short y\nproperty list uchar short near\nproperty float x\nproperty float q\n\
         element face 1\nproperty float area\n{LIST}property char face_type\n"
    );
    let text = header("ascii", &elements)
        + "255 9 .5 0 0 0 1\n255 9 .5 0 2 8 8 7 1\n0 9 .5 5 1 -3 0 1\n0.5 3 0 1 2 90\n";
    let text = soup("order.ply", text);
    let mut file = header("binary_big_endian", &elements).into_bytes();
    for ([x, y], near) in [([0i8, 0], 0u8), ([7, 0], 2), ([0, 5], 1)] {
        file.push(255);
        file.extend(9f64.to_be_bytes());
        file.extend(0.5f32.to_be_bytes());
        file.extend(i16::from(y).to_be_bytes());
        file.push(near);
        file.extend([0xff, 0xfe].repeat(near.into()));
        file.extend(f32::from(x).to_be_bytes());
        file.extend(1f32.to_be_bytes());
    }
    file.extend(0.5f32.to_be_bytes());
    file.extend([3, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2, 90]);
    for soup in [text, soup("order.ply", file)] {
        assert_eq!(soup.points, [[0., 0., 9.], [7., 0., 9.], [0., 5., 9.]]);
        assert_eq!(polygons(&soup), [[0, 1, 2]]);
    }
}

#[test]
fn nothing_announced_is_nothing_read() {
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let none = "element vertex 0\nelement face 0\n";
        let empty = format!("element vertex 0\n{XYZ}element face 0\n{LIST}");
        for elements in ["", none, &empty] {
            let word = "neither points nor faces";
            refusal("empty.ply", header(format, elements), word);
        }
    }
}

#[test]
fn points_alone_are_refused() {
    let vertices = format!("element vertex 4\n{XYZ}");
    let lists = "element point_list 1\nproperty list uchar uint point_indices\nproperty float f\n";
    for (more, rows) in [
        ("", ""),
        (&*format!("element face 0\n{LIST}"), ""),
        // A range image uses this name for its rows instead of faces.
        (&*format!("element range_grid 2\n{LIST}"), "1 0\n0\n"),
        (lists, "3 0 1 2 1.1\n"),
    ] {
        let text = header("ascii", &(vertices.clone() + more)) + POINTS + rows;
        let error = refusal("points.ply", text, "has points but no faces");
        assert!(error.help.contains("Mesh the points"));
    }
}

#[test]
fn stray_header_lines_are_refused_by_line() {
    let good = ascii("3 0 1 2\n");
    for (from, to, word, line) in [
        ("element vertex", "bye\nelement vertex", "bye", 3),
        ("float y", "bool y", "unknown type \u{201c}bool\u{201d}", 5),
        ("float y", "\0\0\0\t\x07 y", "unknown type", 5),
        ("property float y", "prop", "prop", 5),
        ("property float y", "property", "unknown type", 5),
        ("property float y", "property float", "without a name", 5),
        ("property float y", "property float y w", "without a name", 5),
        ("vertex 4", "vertex", "without name and count", 3),
        ("vertex 4", "vertex 4.0", "without name and count", 3),
        ("vertex 4", "vertex 4 5", "without name and count", 3),
        ("format ascii 1.0", "format", "unknown format", 2),
        ("format ascii 1.0", "format ascii 1.0\nformat ascii 1.0", "unknown header line", 3),
    ] {
        let error = refusal("stray.ply", good.replacen(from, to, 1), word);
        assert_eq!(error.place, Some(Location::Line(line)), "{to}");
    }
}

#[test]
fn byte_order_mark_before_every_format() {
    let text = ascii("3 0 1 2\n").replace('\n', "\r\n");
    assert_eq!(soup("mark", "\u{feff}".to_owned() + &text).points, SQUARE);
    let marked = [b"\xef\xbb\xbf", &binary("binary_little_endian", false)[..]].concat();
    assert_eq!(soup("mark", marked).points, SQUARE);
}
