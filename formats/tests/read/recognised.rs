//! Files that begin like files of another format.

use formats::Format;

use crate::support::{case, polygons, refusal, soup};

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// A binary STL of one triangle.
fn stl(header: &str) -> Vec<u8> {
    let mut file = format!("{header:<80}").into_bytes();
    file.extend(1u32.to_le_bytes());
    file.extend([0; 12]);
    [0., 0., 0., 1., 0., 0., 0., 1., 0f32].iter().for_each(|v| file.extend(v.to_le_bytes()));
    file.extend([0; 2]);
    file
}

#[test]
fn binary_stl_begins_with_any_word() {
    for header in [
        "ply ",
        "ply made by hand",
        "ply\nformat",
        "solid",
        "solid a",
        "glTF",
        "{",
        "OFF",
        "<html>",
    ] {
        for name in ["scan.stl", "scan.ply", "scan.glb", "scan"] {
            let case = case(name, stl(header));
            assert_eq!(Format::of(&case.path).ok(), Some(Format::Stl), "{header}");
            assert_eq!(polygons(&soup(name, stl(header))), [[0, 1, 2]], "{header}");
        }
        // If the file is longer, only the name tells the format.
        if header.starts_with("solid") || header.starts_with("ply ") {
            let longer = [stl(header), vec![0; 7]].concat();
            assert_eq!(polygons(&soup("scan.stl", longer)), [[0, 1, 2]], "{header}");
        }
    }
}

#[test]
fn pages_and_pointers_are_refused_by_name() {
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n";
    let page = format!("\n<!DOCTYPE html>\n<html><pre>\n{OBJ}</pre></html>\n");
    let mark = format!("\u{feff}<HTML>\n{OBJ}");
    for name in ["scan.obj", "scan.ply", "scan.stl", "scan.gltf", "scan.glb", "scan"] {
        let error = refusal(name, pointer, "git-lfs pointer");
        assert!(error.help.contains("git lfs pull"));
        for page in [&page, &mark] {
            let error = refusal(name, page, "web page");
            assert!(error.help.contains("Download"));
        }
    }
}

#[test]
fn utf_16_without_its_mark_is_refused_by_name() {
    let ply = "ply\nformat ascii 1.0\n";
    for text in [OBJ, ply, "solid a\nfacet", "{\"asset\": {}}", "# a\r\n"] {
        for name in ["scan.obj", "scan.ply", "scan.stl", "scan.gltf", "scan"] {
            for bytes in [u16::to_le_bytes, u16::to_be_bytes] {
                let file: Vec<u8> = text.encode_utf16().flat_map(bytes).collect();
                let error = refusal(name, file, "is UTF-16 text");
                assert!(error.help.contains("UTF-8"), "{}", error.help);
            }
        }
    }
}
