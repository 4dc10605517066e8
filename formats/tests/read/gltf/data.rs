//! Buffers and accessors.

use formats::{LengthUnit, read_scan};

use super::{SQUARE, data_uri, good, json, one_triangle, square_bytes, square_glb, with_buffer};
use crate::support::{polygons, refusal, refused, soup};

#[test]
fn external_embedded_and_binary() {
    let uri = ("a%20b/square.bin", data_uri(&square_bytes()));
    let embedded = json(&[(uri.0, &uri.1)]);
    let soups = [
        good(&[], &square_bytes()),
        soup("square.gltf", &embedded),
        soup("square.obj", "\u{feff}\n ".to_owned() + &embedded),
        soup("square.glb", square_glb(&[])),
        soup("square", square_glb(&[])),
    ];
    for soup in soups {
        assert_eq!(soup.points, SQUARE);
        assert_eq!(polygons(&soup), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(soup.unit, Some(LengthUnit::Metre));
    }
}

#[test]
fn base64_with_or_without_padding() {
    for uri in [
        "DATA:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA",
        "data:application/gltf-buffer;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAA==",
        "data:a/b;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAA",
    ] {
        let soup = soup("data.gltf", one_triangle(uri));
        assert_eq!(soup.points, [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]);
    }
    let broken = json(&[("a%20b/square.bin", "data:;base64,AA*A")]);
    refusal("data.gltf", broken, "data URI");
}

#[test]
fn indices_of_every_width() {
    for (kind, width) in [(5121, 1), (5123, 2), (5125, 4)] {
        let mut bytes = square_bytes()[..48].to_vec();
        for i in [0u32, 1, 2, 0, 2, 3] {
            bytes.extend(&i.to_le_bytes()[..width]);
        }
        let (length, total) = (6 * width, 48 + 6 * width);
        let soup = good(
            &[
                (r#""byteLength": 60"#, &format!(r#""byteLength": {total}"#)),
                (r#""byteLength": 12"#, &format!(r#""byteLength": {length}"#)),
                (r#""componentType": 5123"#, &format!(r#""componentType": {kind}"#)),
            ],
            &bytes,
        );
        assert_eq!(polygons(&soup), [[0, 1, 2], [0, 2, 3]]);
    }
}

#[test]
fn interleaved_positions() {
    let mut bytes = Vec::new();
    for point in SQUARE {
        point.iter().for_each(|v| bytes.extend((*v as f32).to_le_bytes()));
        bytes.extend([0xff; 4]);
    }
    // The last item needs no padding.
    bytes.truncate(60);
    let swaps = [
        (r#""byteLength": 48"#, r#""byteLength": 60, "byteStride": 16"#),
        (r#", "indices": 1"#, ""),
    ];
    assert_eq!(good(&swaps, &bytes).points, SQUARE);
}

#[test]
fn quantized_positions() {
    for (kind, one, normalized, expected) in [
        (5120, 127, true, 1.0),
        (5121, 255, true, 1.0),
        (5122, 32767, true, 1.0),
        (5123, 65535, true, 1.0),
        (5120, -128, true, -1.0),
        (5122, -300, false, -300.0),
        (5123, 60000, false, 60000.0),
    ] {
        let width = if kind < 5122 { 1 } else { 2 };
        let mut bytes = vec![0; 60];
        bytes[12..12 + width].copy_from_slice(&i32::to_le_bytes(one)[..width]);
        bytes[24..24 + width].copy_from_slice(&i32::to_le_bytes(one)[..width]);
        let kind = format!(r#""componentType": {kind}, "normalized": {normalized}"#);
        let swaps = [
            (r#""scene": 0"#, r#""extensionsRequired": ["KHR_mesh_quantization"], "scene": 0"#),
            (r#""byteLength": 48"#, r#""byteLength": 48, "byteStride": 12"#),
            (r#""componentType": 5126"#, kind.as_str()),
        ];
        let points = good(&swaps, &bytes).points;
        assert_eq!(points[1], [expected, 0., 0.], "{kind}");
        assert_eq!(points[2][0], expected);
    }
}

/// The square with a moved third point as a sparse accessor.
fn sparse(base: &str, index: u8, count: u64) -> String {
    let point = [0, 0, 0, 0x41, 0, 0, 0x80, 0x3f, 0, 0, 0, 0];
    let uri = data_uri(&[&[index, 0, 0, 0][..], &point].concat());
    json(&[
        (r#""bufferView": 0, "componentType""#, &format!(r#"{base} "componentType""#)),
        (
            r#""type": "VEC3""#,
            &format!(
                r#""type": "VEC3", "sparse": {{"count": {count},
                "indices": {{"bufferView": 2, "componentType": 5121}},
                "values": {{"bufferView": 3}}}}"#
            ),
        ),
        (
            r#""byteLength": 12}"#,
            r#""byteLength": 12}, {"buffer": 1, "byteLength": 1},
            {"buffer": 1, "byteOffset": 4, "byteLength": 12}"#,
        ),
        (r#"square.bin"}"#, &format!(r#"square.bin"}}, {{"byteLength": 16, "uri": "{uri}"}}"#)),
    ])
}

#[test]
fn sparse_positions() {
    let read = |text: &str| read_scan(&with_buffer(text, &square_bytes()).path);
    let moved = read(&sparse(r#""bufferView": 0,"#, 2, 1)).expect("readable");
    assert_eq!(moved.points, [SQUARE[0], SQUARE[1], [8., 1., 0.], SQUARE[3]]);
    let zeros = read(&sparse("", 2, 1)).expect("readable");
    assert_eq!(zeros.points, [[0.; 3], [0.; 3], [8., 1., 0.], [0.; 3]]);
    refused(read(&sparse("", 4, 1)), "out of order or range");
    refused(read(&sparse("", 2, 0)), "wrong count");
    refused(read(&sparse("", 2, 2)), "beyond its buffer view");
    refused(read(&sparse("", 2, 9)), "wrong count");
    let many = sparse("", 2, 1).replace(r#""count": 4"#, r#""count": 4000000000"#);
    refused(read(&many), "items without data");
}
