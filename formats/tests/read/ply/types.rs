//! Every type of number, with both names and both byte orders.

use formats::Location;

use super::{LIST, XYZ, ascii, header};
use crate::support::{polygons, refusal, soup};

const KINDS: [[&str; 2]; 8] = [
    ["char", "int8"],
    ["uchar", "uint8"],
    ["short", "int16"],
    ["ushort", "uint16"],
    ["int", "int32"],
    ["uint", "uint32"],
    ["float", "float32"],
    ["double", "float64"],
];

/// The number of integer types.
const INTEGERS: usize = 6;

const ORDERS: [(&str, bool); 2] = [("binary_little_endian", false), ("binary_big_endian", true)];

/// `value` in the type `kind`.
fn number(kind: usize, value: i64, swap: bool) -> Vec<u8> {
    let mut bytes = match kind {
        0 | 1 => vec![value as u8],
        2 | 3 => (value as u16).to_le_bytes().to_vec(),
        4 | 5 => (value as u32).to_le_bytes().to_vec(),
        6 => (value as f32).to_le_bytes().to_vec(),
        _ => (value as f64).to_le_bytes().to_vec(),
    };
    if swap {
        bytes.reverse();
    }
    bytes
}

/// A triangle at (0,0,9), (7,0,9), (0,100,9). Its coordinates have the type `xyz`, the length of
/// its list has the type `count`, and its corners have the type `corner`.
fn triangle(
    order: (&str, bool),
    xyz: [usize; 2],
    count: [usize; 2],
    corner: [usize; 2],
) -> Vec<u8> {
    let [xyz_name, count_name, corner_name] = [xyz, count, corner].map(|[i, j]| KINDS[i][j]);
    let elements = format!(
        "element vertex 3\nproperty {xyz_name} x\nproperty {xyz_name} y\nproperty {xyz_name} z\n\
         element face 1\nproperty list {count_name} {corner_name} vertex_index\n"
    );
    let mut file = header(order.0, &elements).into_bytes();
    for value in [0, 0, 9, 7, 0, 9, 0, 100, 9] {
        file.extend(number(xyz[0], value, order.1));
    }
    file.extend(number(count[0], 3, order.1));
    [0, 1, 2].iter().for_each(|i| file.extend(number(corner[0], *i, order.1)));
    file
}

#[track_caller]
fn check(file: Vec<u8>) {
    let soup = soup("types.ply", file);
    assert_eq!(soup.points, [[0., 0., 9.], [7., 0., 9.], [0., 100., 9.]]);
    assert_eq!(polygons(&soup), [[0, 1, 2]]);
}

#[test]
fn coordinates_of_every_type() {
    for order in ORDERS {
        for kind in 0..KINDS.len() {
            for name in 0..2 {
                check(triangle(order, [kind, name], [1, name], [4, name]));
            }
        }
    }
}

#[test]
fn list_lengths_of_every_integer_type() {
    for order in ORDERS {
        for kind in 0..INTEGERS {
            for name in 0..2 {
                check(triangle(order, [6, name], [kind, name], [4, name]));
            }
        }
    }
}

#[test]
fn corners_of_every_integer_type() {
    for order in ORDERS {
        for kind in 0..INTEGERS {
            for name in 0..2 {
                check(triangle(order, [6, name], [1, name], [kind, name]));
            }
        }
    }
}

#[test]
fn ascii_of_every_type() {
    let text = ascii("4 0 1 2 3\n");
    for name in KINDS.as_flattened() {
        let text = text.replace("float", name).replace("1 1 0\n", "100 1 0\n");
        assert_eq!(soup("types.ply", text).points[2], [100., 1., 0.], "{name}");
    }
    for name in KINDS[..INTEGERS].as_flattened() {
        let text = text.replace("uchar int", &format!("{name} {name}"));
        assert_eq!(polygons(&soup("types.ply", text)), [[0, 1, 2, 3]], "{name}");
    }
}

#[test]
fn negative_integer_coordinates() {
    for (kind, least) in [(0, -128), (2, -32768), (4, -2_147_483_648)] {
        for order in ORDERS {
            let mut file = triangle(order, [kind, 0], [1, 0], [4, 0]);
            let body = file.len() - (9 * number(kind, 0, false).len() + 1 + 12);
            let bytes = number(kind, least, order.1);
            file[body..body + bytes.len()].copy_from_slice(&bytes);
            assert_eq!(soup("negative.ply", file).points[0], [least as f64, 0., 9.]);
        }
    }
    let text = ascii("3 0 1 2\n").replace("float", "int").replace("1 1 0\n", "-409 +249 -0\n");
    assert_eq!(soup("negative.ply", text).points[2], [-409., 249., 0.]);
}

#[test]
fn doubles_keep_their_digits() {
    let elements =
        format!("element vertex 3\n{XYZ}element face 1\n{LIST}").replace("float", "double");
    let (value, corners) = (5_123_456.123_456_789_f64, [0, 1, 2i32]);
    for (name, swap) in ORDERS {
        let mut file = header(name, &elements).into_bytes();
        let order = |mut bytes: Vec<u8>| {
            if swap {
                bytes.reverse();
            }
            bytes
        };
        (0..9).for_each(|_| file.extend(order(value.to_le_bytes().to_vec())));
        file.push(3);
        corners.iter().for_each(|i| file.extend(order(i.to_le_bytes().to_vec())));
        assert_eq!(soup("double.ply", file).points, [[value; 3]; 3]);
    }
}

#[test]
fn binary_points_without_a_number_are_kept() {
    for kind in [6, 7] {
        for (order, value) in ORDERS.into_iter().zip([f64::NAN, f64::NEG_INFINITY]) {
            let width = 4 * (kind - 5);
            let mut file = triangle(order, [kind, 0], [1, 0], [4, 0]);
            let at = file.len() - (9 * width + 1 + 12) + 3 * width;
            let mut bytes = match kind {
                6 => (value as f32).to_le_bytes().to_vec(),
                _ => value.to_le_bytes().to_vec(),
            };
            if order.1 {
                bytes.reverse();
            }
            file[at..at + width].copy_from_slice(&bytes);
            let soup = soup("nan.ply", file);
            assert!(!soup.points[1][0].is_finite());
            assert_eq!(soup.points[2], [0., 100., 9.]);
        }
    }
}

#[test]
fn negative_list_lengths_are_refused() {
    for kind in [0, 2, 4] {
        for order in ORDERS {
            let mut file = triangle(order, [6, 0], [kind, 0], [4, 0]);
            let width = number(kind, 0, false).len();
            let at = file.len() - 12 - width;
            file[at..at + width].fill(0xff);
            refusal("length.ply", file, "");
        }
    }
}

#[test]
fn the_greatest_corner_is_out_of_range() {
    for (kind, greatest) in [(1, u64::from(u8::MAX)), (3, u16::MAX.into()), (5, u32::MAX.into())] {
        let mut file = triangle(ORDERS[0], [6, 0], [1, 0], [kind, 0]);
        let width = number(kind, 0, false).len();
        let at = file.len() - width;
        file[at..].fill(0xff);
        let error = refusal("range.ply", file, &format!("vertex {greatest}, but only 3"));
        assert_eq!(error.place, Some(Location::Face(0)));
    }
}
