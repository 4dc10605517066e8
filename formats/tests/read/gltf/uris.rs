//! The places of a file's buffers.

use std::fs;

use formats::{Location, read_scan};

use super::{SQUARE, bad, data_uri, json, one_triangle, square_bytes};
use crate::support::{case, polygons, refusal, refused, soup};

#[test]
fn files_of_every_name() {
    for (name, uri) in [
        ("square.bin", "square.bin"),
        ("square.bin", "./square.bin"),
        ("square.bin", "./././/square.bin"),
        ("a b.bin", "a b.bin"),
        ("a b.bin", "a%20b.bin"),
        ("a b.bin", "%61%20%62%2Ebin"),
        ("Größe 数.bin", "Größe 数.bin"),
        ("Größe.bin", "Gr%C3%B6%c3%9fe.bin"),
        ("50%.bin", "50%25.bin"),
        ("a#b&c=d.bin", "a%23b&c=d.bin"),
        ("a+b.bin", "a+b.bin"),
        ("..square..bin", "..square..bin"),
        ("no extension", "no extension"),
        ("data", "data"),
    ] {
        let case = case("square.gltf", json(&[("a%20b/square.bin", uri)]));
        fs::write(case.path.with_file_name(name), square_bytes()).expect("a buffer");
        let soup = read_scan(&case.path).unwrap_or_else(|e| panic!("{uri}: {e}"));
        assert_eq!(soup.points, SQUARE, "{uri}");
    }
}

#[test]
fn absent_files_are_refused_by_name() {
    for uri in ["absent.bin", "a%20b/absent.bin", "absent/square.bin", "BoxTextured0.bin"] {
        let name = uri.replace("%20", " ");
        let place = bad(&[("a%20b/square.bin", uri)], &name);
        assert_eq!(place, Some(Location::Element("buffer", 0)), "{uri}");
    }
    let error = refusal("alone.gltf", json(&[]), "square.bin");
    assert!(error.help.contains("beside the glTF file"));
}

#[test]
fn files_may_be_longer_than_declared_but_not_shorter() {
    let case = case("square.gltf", json(&[("a%20b/square.bin", "square.bin")]));
    let file = case.path.with_file_name("square.bin");
    fs::write(&file, [&square_bytes()[..], &[0xff; 99]].concat()).expect("a buffer");
    assert_eq!(read_scan(&case.path).unwrap_or_else(|e| panic!("{e}")).points, SQUARE);
    for length in [0, 1, 59] {
        fs::write(&file, &square_bytes()[..length]).expect("a buffer");
        let word = format!("holds {length} of 60 bytes");
        let error = refused(read_scan(&case.path), &word);
        assert_eq!(error.place, Some(Location::Element("buffer", 0)));
    }
}

#[test]
fn buffers_that_nothing_uses_need_not_be_there() {
    let more = r#""buffers": [{"byteLength": 9, "uri": "textures.bin"}, "#;
    let text = json(&[
        (r#""buffers": ["#, more),
        (r#""buffer": 0"#, r#""buffer": 1"#),
        (r#""buffer": 0"#, r#""buffer": 1"#),
        ("a%20b/square.bin", &data_uri(&square_bytes())),
    ]);
    assert_eq!(soup("textures.gltf", text).points, SQUARE);
}

#[test]
fn data_of_every_media_type() {
    let percent = data_uri(&square_bytes());
    let percent = percent.split_once(',').expect("a comma").1;
    for kind in ["", "text/plain", "application/gltf-buffer", "image/png;charset=utf-8"] {
        let text = json(&[("a%20b/square.bin", &format!("data:{kind},{percent}"))]);
        let soup = soup("data.gltf", text);
        assert_eq!(soup.points, SQUARE, "{kind}");
        assert_eq!(polygons(&soup), [[0, 1, 2], [0, 2, 3]]);
    }
    let base64 = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    for kind in [";base64", "text/plain;base64", "a/b;charset=utf-8;base64", "image/png;BASE64"] {
        let soup = soup("data.gltf", one_triangle(&format!("data:{kind},{base64}")));
        assert_eq!(soup.points, [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], "{kind}");
    }
    for (uri, word) in [
        ("data:;base64,", "holds 0 of 36"),
        ("data:;base64,AAAA", "holds 3 of 36"),
        ("data:;base64,AAAAA", "not a valid data URI"),
        ("data:;base64,AA AA", "not a valid data URI"),
        ("data:;base64", "not a valid data URI"),
        ("data:", "not a valid data URI"),
    ] {
        let error = refusal("data.gltf", one_triangle(uri), word);
        assert_eq!(error.place, Some(Location::Element("buffer", 0)), "{uri}");
    }
}
