//! Reading from memory and other streams.

use std::io::{self, Cursor, Read};
use std::path::Path;

use formats::{Result, Soup, read_scan, read_scan_from};

use crate::seeds;
use crate::support::{case, polygons, refused};

fn from(name: &str, content: impl AsRef<[u8]>, folder: Option<&Path>) -> Result<Soup> {
    read_scan_from(Path::new(name), Cursor::new(content.as_ref().to_vec()), folder)
}

#[test]
fn a_stream_reads_as_its_file_does() {
    for (name, content) in seeds::all() {
        let soup = from(name, &content, None).unwrap_or_else(|e| panic!("{e}"));
        let file = read_scan(&case(name, &content).path).unwrap_or_else(|e| panic!("{e}"));
        // The comparison is textual, because some coordinates are not numbers.
        assert_eq!(format!("{soup:?}"), format!("{file:?}"));
    }
}

#[test]
fn a_stream_need_not_exist_under_its_name() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let soup = from("/no/such/folder/scan", seeds::gzip(obj.as_bytes()), None);
    assert_eq!(polygons(&soup.unwrap_or_else(|e| panic!("{e}"))), [[0, 1, 2]]);
    let error = refused(from("no/such.obj", &obj[..20], None), "coordinates");
    assert_eq!(error.file, Path::new("no/such.obj"));
    refused(from("nothing.obj", "", None), "is empty");
}

/// A binary STL has no mark and a stream no length. So its first triangles tell its format.
#[test]
fn a_binary_stl_needs_no_name() {
    let mut stl = [b" ".repeat(80), vec![1, 0, 0, 0]].concat();
    let numbers = [0.0, 0.0, 1.0, 0.0, 0.0, 5.0, 1e-3, 0.0, 5.0, 0.0, -2e3, 5.0_f32];
    stl.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    stl.extend([7, 9]);
    for content in [stl.clone(), seeds::gzip(&stl)] {
        let soup = from("stdin", &content, None).unwrap_or_else(|e| panic!("{e}"));
        assert!(!soup.polygons.is_empty());
        let options = formats::points::ReadOptions::default();
        let either = options.read_content_from("stdin".as_ref(), Cursor::new(content));
        assert!(matches!(either, Ok(formats::Content::Mesh(same)) if same == soup));
    }
    // Small integers, as in another binary format.
    let integers: Vec<u8> = (1..200_u32).flat_map(u32::to_le_bytes).collect();
    refused(from("stdin", &integers, None), "not in a known mesh format");
    // The coordinates are no numbers.
    let mut noise = stl[..84].to_vec();
    noise.extend([0xff; 50]);
    refused(from("stdin", &noise, None), "not in a known mesh format");
}

const GLTF: &str = r#"{"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "buffers": [{"byteLength": 36, "uri": "zeros.bin"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}]}"#;

#[test]
fn a_stream_refers_to_files_only_if_told_where() {
    let buffer = case("zeros.bin", [0; 36]);
    let folder = buffer.path.parent().expect("a folder");
    assert_eq!(from("scan.gltf", GLTF, Some(folder)).expect("readable").points.len(), 3);
    // The name alone does not open a file.
    let name = folder.join("scan.gltf").to_string_lossy().into_owned();
    refused(from(&name, GLTF, None), "zeros.bin");
    let outside = GLTF.replace("zeros.bin", "../zeros.bin");
    refused(from("scan.gltf", outside, Some(folder)), "outside of the file's folder");
}

struct Broken;

impl Read for Broken {
    fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        Err(io::Error::other("the line is dead"))
    }
}

#[test]
fn a_broken_stream_is_told() {
    refused(read_scan_from(Path::new("scan.obj"), Broken, None), "the line is dead");
    let begun = Cursor::new(b"v 0 0 0\n".repeat(2000)).chain(Broken);
    refused(read_scan_from(Path::new("scan.obj"), begun, None), "the line is dead");
}

#[test]
fn an_endless_stream_is_refused() {
    refused(read_scan_from(Path::new("scan.obj"), io::repeat(b' '), None), "64 MiB");
}
