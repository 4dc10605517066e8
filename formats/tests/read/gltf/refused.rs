//! Files that are refused.

use formats::{Location, read_scan};

use super::{SQUARE, bad, glb, good, json, square_bytes, square_glb, with_buffer};
use crate::support::{case, refusal, refused, soup};

#[test]
fn buffers_stay_in_the_folder() {
    for uri in [
        "../secret.bin",
        "a%20b/../../secret.bin",
        "%2e%2e/secret.bin",
        "a%2f..%2f..%2fsecret.bin",
        "/etc/passwd",
        "%2Fetc%2Fpasswd",
        "C:/secret.bin",
        "..\\\\secret.bin",
        "file:///etc/passwd",
        "http://localhost/secret.bin",
        "",
        "a%00b",
        "%ff",
    ] {
        let place = bad(&[("a%20b/square.bin", uri)], "outside of the file's folder");
        assert_eq!(place, Some(Location::Element("buffer", 0)), "{uri}");
    }
    bad(&[("a%20b/square.bin", "a%20b")], "not in a regular file");
    bad(&[("a%20b/square.bin", "absent.bin")], "absent.bin");
}

#[test]
#[cfg(unix)]
fn links_out_of_the_folder_are_not_followed() {
    let secret = case("secret.bin", square_bytes());
    let case = with_buffer(&json(&[("a%20b/square.bin", "link.bin")]), &[]);
    let link = case.path.with_file_name("link.bin");
    std::os::unix::fs::symlink(&secret.path, link).expect("a link");
    refused(read_scan(&case.path), "outside of the file's folder");
}

#[test]
fn compressed_files_may_have_plain_data() {
    for name in ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing"]
    {
        let used = format!(r#""extensionsUsed": ["{name}"], "scene": 0"#);
        for used in [used.clone(), used.replace("Used", "Required")] {
            let plain = good(&[(r#""scene": 0"#, &used)], &square_bytes());
            assert_eq!(plain.points, SQUARE);
            bad(&[(r#""scene": 0"#, &used), (r#""bufferView": 0, "#, "")], "has no data");
        }
    }
    let other = |name| format!(r#""extensionsRequired": ["{name}"], "scene": 0"#);
    bad(&[(r#""scene": 0"#, &other("EXT_unheard_of"))], "EXT_unheard_of");
    good(&[(r#""scene": 0"#, &other("KHR_texture_basisu"))], &square_bytes());
}

#[test]
fn what_does_not_fit_is_refused() {
    let accessor = |i| Some(Location::Element("accessor", i));
    let view = |i| Some(Location::Element("bufferView", i));
    let buffer = |i| Some(Location::Element("buffer", i));
    let huge = "18446744073709551615";
    let cases: &[(&str, &str, &str, Option<Location>)] = &[
        (r#""count": 4"#, r#""count": 5"#, "beyond its buffer view", accessor(0)),
        (r#""count": 4"#, r#""count": 3"#, "vertex 3, but only 3", accessor(1)),
        (r#""count": 4"#, r#""count": 0"#, "vertex 0, but only 0", accessor(1)),
        (r#""count": 6"#, r#""count": 7"#, "beyond its buffer view", accessor(1)),
        (r#""count": 4"#, "\"count\": 18446744073709551615", "beyond", accessor(0)),
        (r#""count": 6"#, r#""count": 0"#, "no triangles", None),
        (r#""byteLength": 48"#, r#""byteLength": 61"#, "beyond its buffer", view(0)),
        (r#""byteOffset": 48"#, r#""byteOffset": 49"#, "beyond its buffer", view(1)),
        ("48, \"byteLength\": 12", "18446744073709551615, \"byteLength\": 12", "beyond", view(1)),
        (r#""byteLength": 60"#, r#""byteLength": 61"#, "holds 60 of 61", buffer(0)),
        ("60", huge, "exceed 8 GiB", buffer(0)),
        (r#""buffer": 0"#, r#""buffer": 1"#, "buffer that does not exist", buffer(1)),
        (r#""bufferView": 0"#, r#""bufferView": 2"#, "does not exist", accessor(0)),
        (r#""bufferView": 0, "#, "", "has no data", accessor(0)),
        (r#""bufferView": 0"#, r#""bufferView": 0, "byteOffset": 4"#, "beyond", accessor(0)),
        (r#""POSITION": 0"#, r#""POSITION": 7"#, "does not exist", accessor(7)),
        (r#""indices": 1"#, r#""indices": 7"#, "does not exist", accessor(7)),
        (r#""indices": 1"#, r#""indices": 0"#, "wrong shape", accessor(0)),
        (r#""POSITION": 0"#, r#""POSITION": 1"#, "wrong shape", accessor(1)),
        (r#""componentType": 5126"#, r#""componentType": 5125"#, "unknown type", accessor(0)),
        (r#""componentType": 5126"#, r#""componentType": 1"#, "unknown type", accessor(0)),
        (r#""componentType": 5123"#, r#""componentType": 5122"#, "unsigned", accessor(1)),
        (r#""componentType": 5123"#, r#""componentType": 5126"#, "unsigned", accessor(1)),
        (r#""type": "VEC3""#, r#""type": "VEC9""#, "unknown type", accessor(0)),
        ("\"byteLength\": 48", "\"byteLength\": 48, \"byteStride\": 8", "overlap", accessor(0)),
        (r#""mesh": 0"#, r#""mesh": 1"#, "mesh that", Some(Location::Element("mesh", 1))),
        (r#""nodes": [0]"#, r#""nodes": [1]"#, "node that", Some(Location::Element("node", 1))),
        (r#""scene": 0"#, r#""scene": 1"#, "scene that", Some(Location::Element("scene", 1))),
        (r#""mesh": 0"#, r#""mesh": 0, "scale": [1e39, 1, 1]"#, "", None),
        (r#""version": "2.0""#, r#""version": "1.0""#, "version 1.0", None),
        (r#""asset""#, r#""assets""#, "not a valid glTF", None),
        (r#""scenes": ["#, r#""scenes": ]"#, "not a valid glTF", None),
    ];
    for (from, to, word, place) in cases {
        let found = bad(&[(from, to)], word);
        assert!(place.is_none() || found == *place, "{to}: {found:?}");
    }
}

#[test]
fn small_files_do_not_expand_without_bound() {
    // 300 nodes use one mesh of 40,000 triangles that consists of zeros.
    let nodes = r#"{"mesh": 0},"#.repeat(300);
    let list: Vec<String> = (0..300).map(|i| i.to_string()).collect();
    let swaps = [
        (r#""nodes": [0]"#, format!(r#""nodes": [{}]"#, list.join(","))),
        (r#"[{"mesh": 0}]"#, format!("[{}]", nodes.trim_end_matches(','))),
        (r#""byteLength": 60"#, r#""byteLength": 960000"#.into()),
        (r#""byteLength": 48"#, r#""byteLength": 960000"#.into()),
        (r#""count": 4"#, r#""count": 80000"#.into()),
        (r#""indices": 1"#, r#""mode": 5"#.into()),
    ];
    let swaps: Vec<(&str, &str)> = swaps.iter().map(|(a, b)| (*a, b.as_str())).collect();
    let case = with_buffer(&json(&swaps), &vec![0; 960_000]);
    refused(read_scan(&case.path), "far more than it holds");
}

#[test]
fn damaged_glb_is_refused() {
    let good = square_glb(&[]);
    for cut in 12..good.len() {
        refusal("cut.glb", &good[..cut], "of its");
    }
    for length in [0u32, 1, 11, 12, 19, 20, 27, 100, u32::MAX] {
        let mut file = good.clone();
        file[8..12].copy_from_slice(&length.to_le_bytes());
        refusal("length.glb", file, "");
    }
    let mut file = good.clone();
    file[4] = 1;
    refusal("version.glb", file, "version");
    let mut file = good.clone();
    file[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    refusal("chunk.glb", file, "length");
    assert_eq!(soup("long.glb", [&good[..], b"more"].concat()).points, SQUARE);
    refusal(
        "blob.glb",
        glb(&json(&[(r#", "uri": "a%20b/square.bin""#, "")]), &[0; 56]),
        "holds 56",
    );
}
