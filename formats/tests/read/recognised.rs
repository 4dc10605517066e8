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

#[test]
fn splats_and_usd_are_named() {
    let splat = "ply\nformat binary_little_endian 1.0\nelement chunk 1\nproperty float min_x\nelement vertex 1\n\
                 property uint packed_position\nend_header\nabcdefgh";
    let zip = |name: &str| {
        let mut zip = b"PK\x03\x04".to_vec();
        zip.extend([0; 22]);
        zip.extend([name.len() as u8, 0, 0, 0]);
        zip.extend(name.bytes());
        zip
    };
    refusal("a.ply", splat, "compressed Gaussian splat");
    refusal("a.spz", "NGSP\u{1}\0\0\0", "compressed Gaussian splat");
    refusal("a.usdz", zip("scene.usdc"), "USDZ");
    refusal("a.usdz", zip("a.USDA"), "USDZ");
    refusal("a.usda", "#usda 1.0\n(\n)\n", "USDZ");
    refusal("a.3mf", zip("[Content_Types].xml"), "ZIP archive");
}

#[test]
fn comments_name_units() {
    use formats::LengthUnit::{Centimetre, Inch, Millimetre};

    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let off = "OFF\n# units: cm\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let ply = "ply\nformat ascii 1.0\ncomment Units: inches\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n\
               0 1 0\n3 0 1 2\n";
    let stl = "solid part UNITS=mm\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
               endloop\nendfacet\nendsolid\n";
    let mut binary = b"COLOR=\xff\xff\0\xff,UNITS=in".to_vec();
    binary.resize(80, b' ');
    binary.extend(1_u32.to_le_bytes());
    binary.extend([0; 50]);
    let maya =
        format!("# This file uses centimeters as units for non-parametric coordinates.\n{obj}");
    for (name, content, unit) in [
        ("a.obj", maya.into_bytes(), Some(Centimetre)),
        ("a.obj", format!("# Units: mm\n{obj}# Units: inches\n").into_bytes(), None),
        ("a.obj", obj.into(), None),
        ("a.off", off.into(), Some(Centimetre)),
        ("a.ply", ply.into(), Some(Inch)),
        ("a.stl", stl.into(), Some(Millimetre)),
        ("a.stl", binary, Some(Inch)),
    ] {
        let soup = soup(name, &content);
        assert_eq!(soup.unit, unit, "{name}");
        assert_eq!(soup.unit_comment.is_some(), unit.is_some());
    }
}
