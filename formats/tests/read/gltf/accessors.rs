//! Numbers in buffers of every type.

use formats::{Location, read_scan};

use super::{SQUARE, data_uri, good, json, square_bytes, with_buffer};
use crate::support::{polygons, refused, soup};

/// The square whose index list is replaced by `corners` of the given type.
fn listed(kind: u32, width: usize, mode: u32, corners: &[u32]) -> String {
    let mut bytes = square_bytes()[..48].to_vec();
    corners.iter().for_each(|i| bytes.extend(&i.to_le_bytes()[..width]));
    let (length, total, count) = (corners.len() * width, bytes.len(), corners.len());
    json(&[
        (r#""byteLength": 60"#, &format!(r#""byteLength": {total}"#)),
        (r#""byteLength": 12"#, &format!(r#""byteLength": {length}"#)),
        (r#""componentType": 5123"#, &format!(r#""componentType": {kind}"#)),
        (r#""count": 6"#, &format!(r#""count": {count}"#)),
        (r#""indices": 1"#, &format!(r#""indices": 1, "mode": {mode}"#)),
        ("a%20b/square.bin", &data_uri(&bytes)),
    ])
}

const WIDTHS: [(u32, usize, u32); 3] =
    [(5121, 1, u8::MAX as u32), (5123, 2, u16::MAX as u32), (5125, 4, u32::MAX)];

#[test]
fn modes_with_corners_of_every_width() {
    for (kind, width, _) in WIDTHS {
        let read =
            |mode, corners: &[u32]| polygons(&soup("m.gltf", listed(kind, width, mode, corners)));
        assert_eq!(read(4, &[0, 1, 2, 0, 2, 3]), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(read(5, &[1, 2, 0, 3]), [[1, 2, 0], [2, 3, 0]]);
        assert_eq!(read(6, &[3, 0, 1, 2]), [[0, 1, 3], [1, 2, 3]]);
        // The remaining corners are not a triangle.
        assert_eq!(read(4, &[0, 1, 2, 3, 0]), [[0, 1, 2]]);
        for (mode, corners) in [(0, 4), (1, 4), (2, 4), (3, 4), (4, 2), (5, 2), (6, 2)] {
            let case = with_buffer(&listed(kind, width, mode, &vec![0; corners]), &[]);
            refused(read_scan(&case.path), "no triangles");
        }
    }
}

/// Unlike in WebGL, the largest number does not begin a new strip.
#[test]
fn restarts_are_refused() {
    for (kind, width, greatest) in WIDTHS {
        let case = with_buffer(&listed(kind, width, 5, &[0, 1, 2, greatest, 0, 2, 3]), &[]);
        let error = refused(read_scan(&case.path), &format!("vertex {greatest}, but only 4"));
        assert_eq!(error.place, Some(Location::Element("accessor", 1)));
    }
}

#[test]
fn data_need_not_be_aligned() {
    let bytes = [&[0xff; 3][..], &square_bytes()[..48], &[0xff; 2], &square_bytes()[48..]].concat();
    let swaps = [
        (r#""byteLength": 60"#, r#""byteLength": 65"#),
        (r#""byteLength": 48"#, r#""byteLength": 51"#),
        (r#""byteOffset": 48"#, r#""byteOffset": 53"#),
        (
            r#""bufferView": 0, "componentType""#,
            r#""bufferView": 0, "byteOffset": 3, "componentType""#,
        ),
    ];
    let soup = good(&swaps, &bytes);
    assert_eq!(soup.points, SQUARE);
    assert_eq!(polygons(&soup), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn positions_behind_normals_in_one_view() {
    let mut bytes = Vec::new();
    for point in SQUARE {
        [9., 9., 9.].iter().chain(&point).for_each(|v| bytes.extend((*v as f32).to_le_bytes()));
    }
    bytes.extend(&square_bytes()[48..]);
    let swaps = [
        (r#""byteLength": 60"#, r#""byteLength": 108"#),
        (r#""byteLength": 48"#, r#""byteLength": 96, "byteStride": 24"#),
        (r#""byteOffset": 48"#, r#""byteOffset": 96"#),
        (
            r#""bufferView": 0, "componentType""#,
            r#""bufferView": 0, "byteOffset": 12, "componentType""#,
        ),
    ];
    assert_eq!(good(&swaps, &bytes).points, SQUARE);
}

#[test]
fn quantized_positions_of_every_type() {
    for (kind, width, value, plain, normal) in [
        (5120, 1, 100i32, 100., 100. / 127.),
        (5120, 1, -127, -127., -1.),
        (5120, 1, -128, -128., -1.),
        (5121, 1, 200, 200., 200. / 255.),
        (5122, 2, -32767, -32767., -1.),
        (5122, 2, -32768, -32768., -1.),
        (5123, 2, 65535, 65535., 1.),
    ] {
        for (normalized, expected) in [("", plain), (r#", "normalized": true"#, normal)] {
            let mut bytes = vec![0; 60];
            for axis in 0..3 {
                let at = 8 + axis * width;
                bytes[at..at + width].copy_from_slice(&value.to_le_bytes()[..width]);
            }
            bytes[48..].copy_from_slice(&square_bytes()[48..]);
            let kind = format!(r#""componentType": {kind}{normalized}"#);
            let swaps = [
                (r#""scene": 0"#, r#""extensionsUsed": ["KHR_mesh_quantization"], "scene": 0"#),
                (r#""byteLength": 48"#, r#""byteLength": 48, "byteStride": 8"#),
                (r#""componentType": 5126"#, kind.as_str()),
            ];
            let points = good(&swaps, &bytes).points;
            let found = points[1];
            assert!(found.iter().all(|v| (v - expected).abs() < 1e-12), "{kind}: {found:?}");
            assert_eq!(points[2], [0.; 3]);
        }
    }
}

/// The square with points 1 and 3 replaced, as in Khronos's example.
#[test]
fn sparse_positions_of_every_width() {
    for (kind, width, _) in WIDTHS {
        let mut bytes = vec![0xff; 4];
        [1u32, 3].iter().for_each(|i| bytes.extend(&i.to_le_bytes()[..width]));
        let values = bytes.len() as u32 + 3;
        bytes.extend([0xff; 3]);
        [8., 7., 6., 5., 4., 3f32].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        let (total, uri) = (bytes.len(), data_uri(&bytes));
        let sparse = format!(
            r#""type": "VEC3", "sparse": {{"count": 2,
            "indices": {{"bufferView": 2, "byteOffset": 4, "componentType": {kind}}},
            "values": {{"bufferView": 2, "byteOffset": {values}}}}}"#
        );
        let view = format!(r#""byteLength": 12}}, {{"buffer": 1, "byteLength": {total}}}"#);
        let buffer = format!(r#"square.bin"}}, {{"byteLength": {total}, "uri": "{uri}"}}"#);
        let swaps = [
            (r#""type": "VEC3""#, sparse.as_str()),
            (r#""byteLength": 12}"#, &view),
            (r#"square.bin"}"#, &buffer),
        ];
        let expected = [SQUARE[0], [8., 7., 6.], SQUARE[2], [5., 4., 3.]];
        assert_eq!(good(&swaps, &square_bytes()).points, expected);
    }
}

#[test]
fn sparse_corners() {
    // The sixth corner, 3, becomes 1, with a base and without one.
    let sparse = r#""type": "SCALAR", "sparse": {"count": 1,
        "indices": {"bufferView": 2, "componentType": 5121},
        "values": {"bufferView": 2, "byteOffset": 4}}"#;
    let bytes = data_uri(&[5, 0, 0, 0, 1, 0]);
    let buffer = format!(r#"square.bin"}}, {{"byteLength": 6, "uri": "{bytes}"}}"#);
    let swaps = [
        (r#""type": "SCALAR""#, sparse),
        (r#""byteLength": 12}"#, r#""byteLength": 12}, {"buffer": 1, "byteLength": 6}"#),
        (r#"square.bin"}"#, buffer.as_str()),
    ];
    assert_eq!(polygons(&good(&swaps, &square_bytes())), [[0, 1, 2], [0, 2, 1]]);
    let none = [(r#""bufferView": 1, "#, ""), swaps[0], swaps[1], swaps[2]];
    assert_eq!(polygons(&good(&none, &square_bytes())), [[0, 0, 0], [0, 0, 1]]);
}

#[test]
fn bounds_are_not_believed() {
    for bounds in [
        r#""min": [5, 5, 5], "max": [6, 6, 6]"#,
        r#""max": [1.0, 1.0]"#,
        r#""min": [], "max": "far""#,
        r#""min": [1e300, -1e300, 0]"#,
    ] {
        let kind = format!(r#""type": "VEC3", {bounds}"#);
        assert_eq!(
            good(&[(r#""type": "VEC3""#, &kind)], &square_bytes()).points,
            SQUARE,
            "{bounds}"
        );
    }
}

#[test]
fn points_without_a_number_are_kept() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::from_bits(0x7f80_0001)] {
        let mut bytes = square_bytes();
        bytes[40..44].copy_from_slice(&value.to_le_bytes());
        let points = good(&[], &bytes).points;
        assert!(!points[3][1].is_finite());
        assert_eq!(points[..3], SQUARE[..3]);
    }
}

#[test]
fn one_accessor_for_many_and_many_for_one() {
    // The strip and the list share the points. Each of them has its own copy.
    let two = r#"[{"attributes": {"POSITION": 0}, "mode": 5}, {"attributes""#;
    let soup = good(&[(r#"[{"attributes""#, two)], &square_bytes());
    assert_eq!(soup.points, [SQUARE, SQUARE].concat());
    assert_eq!(polygons(&soup), [[0, 1, 2], [1, 3, 2], [4, 5, 6], [4, 6, 7]]);
}
