//! PLY: supported features, and helpers for errors.

mod body;
mod head;
mod refused;
mod types;

use crate::support::{polygons, soup};

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";
const LIST: &str = "property list uchar int vertex_indices\n";
const POINTS: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
const SQUARE: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

fn header(format: &str, rest: &str) -> String {
    format!("ply\nformat {format} 1.0\n{rest}end_header\n")
}

/// An ASCII file with four vertices and `faces`.
fn ascii(faces: &str) -> String {
    let count = faces.lines().count();
    let elements = format!("element vertex 4\n{XYZ}element face {count}\n{LIST}");
    header("ascii", &elements) + POINTS + faces
}

/// A binary square of one quad. `order` converts every number.
fn binary(name: &str, swap: bool) -> Vec<u8> {
    let order = |mut bytes: Vec<u8>| {
        if swap {
            bytes.reverse();
        }
        bytes
    };
    let head = format!("element vertex 4\n{XYZ}element face 1\n{LIST}");
    let mut file = header(name, &head).into_bytes();
    for v in SQUARE.as_flattened() {
        file.extend(order((*v as f32).to_le_bytes().to_vec()));
    }
    file.push(4);
    for i in 0..4i32 {
        file.extend(order(i.to_le_bytes().to_vec()));
    }
    file
}

#[test]
fn ascii_and_both_endians() {
    let files = [
        ascii("4 0 1 2 3\n").into_bytes(),
        binary("binary_little_endian", false),
        binary("binary_big_endian", true),
    ];
    for file in files {
        let soup = soup("square.ply", file);
        assert_eq!(soup.points, SQUARE);
        assert_eq!(polygons(&soup), [[0, 1, 2, 3]]);
        assert_eq!(soup.unit, None);
    }
}

#[test]
fn every_scalar_type_makes_coordinates_and_corners() {
    type Bytes = fn(i8) -> Vec<u8>;
    let types: [(&str, Bytes); 8] = [
        ("char", |v| v.to_le_bytes().to_vec()),
        ("uint8", |v| (v as u8).to_le_bytes().to_vec()),
        ("short", |v| i16::from(v).to_le_bytes().to_vec()),
        ("uint16", |v| (v as u16).to_le_bytes().to_vec()),
        ("int32", |v| i32::from(v).to_le_bytes().to_vec()),
        ("uint", |v| (v as u32).to_le_bytes().to_vec()),
        ("float32", |v| f32::from(v).to_le_bytes().to_vec()),
        ("double", |v| f64::from(v).to_le_bytes().to_vec()),
    ];
    for (i, (kind, bytes)) in types.into_iter().enumerate() {
        let corner = if i < 6 { kind } else { "ushort" };
        let head = format!(
            "element vertex 3\nproperty {kind} z\nproperty float q\nproperty {kind} x\n\
             property {kind} y\nelement face 1\nproperty list {corner} {corner} vertex_index\n"
        );
        let mut file = header("binary_little_endian", &head).into_bytes();
        for [x, y, z] in [[0, 0, 9], [7, 0, 9], [0, 5, 9]] {
            file.extend([bytes(z), vec![1, 2, 3, 4], bytes(x), bytes(y)].concat());
        }
        let index = if i < 6 { bytes } else { types_ushort };
        file.extend([3, 0, 1, 2].into_iter().flat_map(index));
        let soup = soup("types.ply", file);
        assert_eq!(soup.points, [[0., 0., 9.], [7., 0., 9.], [0., 5., 9.]], "{kind}");
        assert_eq!(polygons(&soup), [[0, 1, 2]]);
    }
}

fn types_ushort(v: i8) -> Vec<u8> {
    (v as u16).to_le_bytes().to_vec()
}

#[test]
fn other_elements_and_properties_are_passed_over() {
    let elements = format!(
        "element camera 1\nproperty float view\nproperty list uchar float matrix\n\
         element nothing 3000000000\nelement face 2\nproperty uchar red\n{LIST}\
         property list uchar float texcoord\nelement vertex 4\n{XYZ}property uchar red\n\
         element material 1\nproperty int id\n"
    );
    let text = header("ascii", &elements)
        + "1.5 2 0.1 .2\n255 3 0 1 2 6 0 0 1 0 1 1\n0 3 0 2 3 0\n"
        + "0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n5\n";
    let ascii = soup("extra.ply", text);
    let mut file = header("binary_little_endian", &elements).into_bytes();
    file.extend(1.5f32.to_le_bytes());
    file.push(1);
    file.extend(0.5f32.to_le_bytes());
    for face in [[0, 1, 2], [0, 2, 3i32]] {
        file.extend([255, 3]);
        face.iter().for_each(|i| file.extend(i.to_le_bytes()));
        file.push(1);
        file.extend(0.5f32.to_le_bytes());
    }
    for point in SQUARE {
        point.iter().for_each(|v| file.extend((*v as f32).to_le_bytes()));
        file.push(9);
    }
    file.extend(5i32.to_le_bytes());
    for soup in [ascii, soup("extra.ply", file)] {
        assert_eq!(soup.points, SQUARE);
        assert_eq!(polygons(&soup), [[0, 1, 2], [0, 2, 3]]);
    }
}

#[test]
fn strips_become_triangles_of_one_winding() {
    let elements =
        format!("element vertex 4\n{XYZ}element tristrips 1\n{}", LIST.replace("uchar", "int"));
    let text = header("ascii", &elements) + POINTS + "9 0 1 3 2 -1 -1 2 1 0\n";
    let strips = polygons(&soup("strips.ply", text));
    assert_eq!(strips, [[0, 1, 3], [3, 1, 2], [2, 1, 0]]);
}

#[test]
fn loose_ascii_is_read() {
    let text = ascii("3 0 1 2\n\n3 0 2 3\n").replace("face 3", "face 2");
    let loose = [
        text.replace('\n', "\r\n"),
        text.replace('\n', "\r"),
        text.replace("0 0 0\n", "\n  .0 0. \t -.0e0\n\n"),
        text.replace("1 0 0\n", "1\n0\n0\n"),
        text.replace("property", "\t property  ").replace("end_header", "end_header "),
        text.trim_end().to_owned(),
        text.clone() + "\n\n \n",
        text.replace("ply\n", "ply\nobj_info by hand\ncomment\n"),
    ];
    for text in loose {
        let soup = soup("loose.ply", &text);
        assert_eq!(soup.points, SQUARE, "{text}");
        assert_eq!(polygons(&soup), [[0, 1, 2], [0, 2, 3]]);
    }
    let latin = text.replace("ply\n", "ply\ncomment M~ller\n").into_bytes();
    let latin: Vec<u8> = latin.into_iter().map(|b| if b == b'~' { 0xfc } else { b }).collect();
    assert_eq!(soup("latin.ply", latin).points, SQUARE);
}

#[test]
fn points_without_a_number_are_kept() {
    let words = ["nan", "-NaN", "inf", "-Infinity", "1.#QNAN", "-nan(ind)", "1e400"];
    for word in words {
        let text = ascii("3 0 1 2\n").replace("0 1 0\n", &format!("0 {word} 0\n"));
        let soup = soup("nan.ply", text);
        assert_eq!(soup.points.len(), 4);
        assert!(!soup.points[3][1].is_finite(), "{word}");
    }
}

#[test]
fn ascii_keeps_all_digits() {
    let text = ascii("3 0 1 2\n").replace("0 1 0\n", "0 5123456.123456 0\n");
    assert_eq!(soup("digits.ply", text).points[3][1], 5_123_456.123_456);
}

#[test]
fn binary_body_may_begin_like_a_line_end() {
    let head = "element tag 1\nproperty uchar t\nelement vertex 4\nproperty float x\n\
                property float y\nproperty float z\nelement face 1\n";
    let mut file = header("binary_little_endian", &(head.to_owned() + LIST)).into_bytes();
    let square = binary("binary_little_endian", false);
    file.push(b'\n');
    file.extend(&square[square.len() - (48 + 17)..]);
    assert_eq!(soup("newline.ply", file).points, SQUARE);
}

#[test]
fn small_faces_are_left_out() {
    let faces = "0\n1 2\n2 0 1\n3 0 1 2\n";
    assert_eq!(polygons(&soup("small.ply", ascii(faces))), [[0, 1, 2]]);
}
