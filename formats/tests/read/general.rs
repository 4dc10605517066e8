//! Recognition, gzip, and files that are no mesh.

use std::fs;

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
    refusal("late.txt", format!("{comments}{OBJ}"), "no known mesh format");
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
    // Several members are one file.
    let (a, b) = OBJ.split_at(20);
    let members = [gzip(a.as_bytes()), gzip(b.as_bytes())].concat();
    assert_eq!(soup("scan.obj.gz", members).points.len(), 3);
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
    // A gigabyte each, if one were to unzip it all.
    let zeros = gzip(&vec![0; 64 << 20]).repeat(16);
    refusal("bomb.gz", &zeros, "no known mesh format");
    refusal("bomb.obj.gz", &zeros, "64 MiB");
    let header = b"ply\nformat ascii 1.0\ncomment ";
    let header = [gzip(header), zeros].concat();
    refusal("bomb.ply.gz", header, "64 MiB");
    let spaces = [gzip(b"{"), gzip(&vec![b' '; 64 << 20]).repeat(16)].concat();
    refusal("bomb.gltf.gz", spaces, "200 times");
}

#[test]
fn what_is_no_mesh_is_refused_by_name() {
    refusal("nothing.ply", "", "is empty");
    refusal("words.txt", "Hello", "no known mesh format");
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
