//! Detection of formats, gzip, and files that are not meshes.

use std::fs;
use std::io::Write;

use formats::{Format, read_scan};

use crate::support::{case, gzip, polygons, refusal, refused, soup};

const OBJ: &str = "# a triangle\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn content_goes_before_extension() {
    for name in ["scan.ply", "scan.stl", "scan.glb", "scan", "scan.txt"] {
        assert_eq!(polygons(&soup(name, OBJ)), [[0, 1, 2]]);
        assert_eq!(Format::of(&case(name, OBJ).path).ok(), Some(Format::Obj));
    }
}

#[test]
fn extension_decides_where_content_is_silent() {
    let comments = "# comment\n".repeat(2000);
    assert_eq!(soup("late.obj", format!("{comments}{OBJ}")).points.len(), 3);
    refusal("late.txt", format!("{comments}{OBJ}"), "not in a known mesh format");
    assert_eq!(
        Format::of(&case("A.OBJ.GZ", gzip(comments.as_bytes())).path).ok(),
        Some(Format::Obj)
    );
}

#[test]
fn gzip_is_unwrapped_by_content() {
    for name in ["scan.obj.gz", "scan.obj", "scan"] {
        assert_eq!(soup(name, gzip(OBJ.as_bytes())).points.len(), 3);
    }
    // Several gzip members are one file.
    let (a, b) = OBJ.split_at(20);
    let members = [gzip(a.as_bytes()), gzip(b.as_bytes())].concat();
    assert_eq!(soup("scan.obj.gz", members.clone()).points.len(), 3);

    // Archives and tapes append zeros, here more than a buffer contains.
    let padded = [members.clone(), vec![0; 70_000]].concat();
    assert_eq!(soup("scan.obj.gz", padded).points.len(), 3);
    let between = [gzip(a.as_bytes()), vec![0; 512], gzip(b.as_bytes())].concat();
    assert_eq!(soup("scan.obj.gz", between).points.len(), 3);
    let followed = [members, b"more".to_vec()].concat();
    refusal("scan.obj.gz", followed, "unexpected end of file");
}

#[test]
fn damaged_gzip_is_refused() {
    let long = OBJ.replace("# a", &"# a very long comment, 0123456789\n".repeat(4000));
    let zip = gzip(long.as_bytes());
    refusal("cut.obj.gz", &zip[..zip.len() - 9], "cannot be read to its end");
    refusal("cut.obj.gz", &zip[..5], "unzipped");
    refusal("twice.obj.gz", gzip(&gzip(OBJ.as_bytes())), "twice");
}

#[test]
fn gzip_bombs_cost_little() {
    // Each of them would have a gigabyte after complete decompression.
    let zeros = gzip(&vec![0; 64 << 20]).repeat(16);
    refusal("bomb.gz", &zeros, "not in a known mesh format");
    refusal("bomb.obj.gz", &zeros, "100 times");
    let header = b"ply\nformat ascii 1.0\ncomment ";
    let header = [gzip(header), zeros].concat();
    refusal("bomb.ply.gz", header, "100 times");
    let spaces = [gzip(b"{"), gzip(&vec![b' '; 64 << 20]).repeat(16)].concat();
    refusal("bomb.gltf.gz", spaces, "100 times");
}

#[test]
fn what_is_no_mesh_is_refused_by_name() {
    refusal("nothing.ply", "", "is empty");
    refusal("words.txt", "Hello", "not in a known mesh format");
    refusal("cloud.pcd", "# .PCD v0.7\nVERSION 0.7\n", "PCD");
    refusal("model.3mf", b"PK\x03\x04\0\0", "ZIP");
    refusal("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "has points but no faces");
    refusal("empty.obj", "# nothing\n", "neither points nor faces");
}

#[test]
fn what_cannot_be_opened_is_refused() {
    let inside = case("file", "");
    let folder = inside.path.parent().expect("a folder").to_path_buf();
    refused(read_scan(&folder), "folder");
    refused(read_scan(&folder.join("absent.ply")), "cannot be opened");
    fs::write(folder.join("short.stl"), [7; 30]).expect("written");
    refused(read_scan(&folder.join("short.stl")), "no STL file");
}

#[test]
fn content_of_every_format_goes_before_extension() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nelement face 1\nproperty list uchar int vertex_index\n\
               end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let files = [(Format::Obj, OBJ.into()), (Format::Ply, ply.into())];
    let files = files.into_iter().chain([
        (Format::Stl, ASCII_STL.into()),
        (Format::Stl, binary_stl()),
        (Format::Gltf, gltf().into_bytes()),
        (Format::Glb, glb()),
    ]);
    for (format, file) in files {
        for name in
            ["scan.ply", "scan.obj", "scan.gltf", "scan.glb", "scan.stl", "scan.PLY.GZ", "x"]
        {
            let case = case(name, &file);
            assert_eq!(Format::of(&case.path).ok(), Some(format), "{name}");
            let soup = read_scan(&case.path).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(soup.points, [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]);
            assert_eq!(polygons(&soup), [[0, 1, 2]]);
        }
        // A binary STL is recognized by its length, which is unknown for a compressed file.
        let soup = soup("scan.stl.gz", gzip(&file));
        assert_eq!(polygons(&soup), [[0, 1, 2]], "{format:?}");
    }
}

const ASCII_STL: &str = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
                         vertex 0 1 0\nendloop\nendfacet\nendsolid\n";

/// The nine coordinates of the triangle.
fn floats() -> Vec<u8> {
    [0., 0., 0., 1., 0., 0., 0., 1., 0f32].iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn binary_stl() -> Vec<u8> {
    [&[b' '; 80][..], &1u32.to_le_bytes(), &[0; 12], &floats(), &[0; 2]].concat()
}

fn gltf() -> String {
    let data: String = floats().iter().map(|b| format!("%{b:02x}")).collect();
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "nodes": [{{"mesh": 0}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
        "buffers": [{{"byteLength": 36, "uri": "data:,{data}"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}]}}"#
    )
}

fn glb() -> Vec<u8> {
    let mut json = gltf();
    json += &" ".repeat(json.len().next_multiple_of(4) - json.len());
    let lengths = [json.len() as u32 + 20, json.len() as u32].map(u32::to_le_bytes);
    [b"glTF\x02\0\0\0", &lengths[0][..], &lengths[1], b"JSON", json.as_bytes()].concat()
}

#[test]
fn gzip_by_name_only() {
    assert_eq!(soup("scan.obj.gz", OBJ).points.len(), 3);
    assert_eq!(soup("scan.gz", OBJ).points.len(), 3);
    // Without points at the beginning, only the name tells the format.
    let late = "# comment\n".repeat(2000) + OBJ;
    assert_eq!(soup("scan.obj.gz", &late).points.len(), 3);
    refusal("scan.gz", late, "not in a known mesh format");
}

#[test]
fn gzip_headers_of_every_kind() {
    let named = flate2::GzBuilder::new().filename("scan.obj").comment("by hand").extra("abcd");
    let mut zip = named.mtime(1).write(Vec::new(), flate2::Compression::none());
    zip.write_all(OBJ.as_bytes()).expect("zipped");
    assert_eq!(soup("scan.obj.gz", zip.finish().expect("zipped")).points.len(), 3);
    // Members without content at either end.
    let members = [gzip(b""), gzip(OBJ.as_bytes()), gzip(b"")].concat();
    assert_eq!(soup("scan.obj.gz", members).points.len(), 3);
    refusal("scan.obj.gz", gzip(b""), "is empty");
}

#[test]
fn wrong_sums_of_gzip_are_refused() {
    for long in ["", &*"# a very long comment, 0123456789\n".repeat(4000)] {
        let zip = gzip((OBJ.to_owned() + long).as_bytes());
        // The checksum and the length are the last eight bytes.
        for at in [1, 5] {
            let mut zip = zip.clone();
            let byte = zip.len() - at;
            zip[byte] ^= 1;
            refusal("sum.obj.gz", zip, "corrupt");
        }
        refusal("cut.obj.gz", &zip[..zip.len() - 1], "");
    }
}

#[test]
fn strangers_are_refused_by_name() {
    for (content, word) in [
        (&b"BZh91AY"[..], "bzip2"),
        (b"\xfd7zXZ\0", "xz"),
        (b"\x28\xb5\x2f\xfd\0", "zstd"),
        (b"# .PCD v0.7 - Point Cloud Data\nDATA ascii\n1 2 3\n", "PCD"),
        (b"# .PCD v.7\nDATA binary\n\x01\x02\0\0\xff", "PCD"),
        (b"Kaydara FBX Binary  \0", "FBX"),
        (b"ASTM-E57\x01\0\0\0", "E57"),
        (b"LASF\0\0\0\0", "LAS"),
        (b"ISO-10303-21;\nHEADER;\n", "STEP"),
    ] {
        for name in
            ["scan.ply", "scan.obj", "scan.stl", "scan.glb", "scan.gltf", "scan.pcd", "scan"]
        {
            let error = refusal(name, content, word);
            // A point cloud is refused again after a conversion, because it still has no faces.
            let help =
                if ["PCD", "E57", "LAS"].contains(&word) { "Mesh the points" } else { "Convert" };
            assert!(error.help.contains(help), "{name}: {error}");
            refusal(name, gzip(content), word);
        }
    }
}

/// Text with two bytes per character and the byte order mark that editors write.
fn utf_16(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
    ["\u{feff}", text].iter().flat_map(|t| t.encode_utf16()).flat_map(bytes).collect()
}

#[test]
fn utf_16_is_refused_by_name() {
    for text in [OBJ, ASCII_STL, "ply\nformat ascii 1.0\n", "{\"asset\": {}}"] {
        for name in ["scan.obj", "scan.ply", "scan.stl", "scan.gltf", "scan"] {
            refusal(name, utf_16(text, u16::to_le_bytes), "UTF-16");
        }
    }
}

#[test]
fn utf_16_of_the_other_order_is_refused_by_name() {
    for text in [OBJ, ASCII_STL, "ply\nformat ascii 1.0\n", "{\"asset\": {}}"] {
        for name in ["scan.obj", "scan.ply", "scan.stl", "scan.gltf", "scan"] {
            refusal(name, utf_16(text, u16::to_be_bytes), "UTF-16");
        }
    }
}

#[test]
fn blanks_are_refused() {
    for blanks in [" ", "\n", "\r\n\r\n\t", "\u{feff}"] {
        for name in ["scan.obj", "scan.ply", "scan.stl", "scan.gltf", "scan.glb", "scan"] {
            refusal(name, blanks, "");
        }
    }
}
