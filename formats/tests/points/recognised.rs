//! The content decides what a file is, and the name only where it is silent.

use formats::points::PointFormat;

use crate::seeds;
use crate::support::{cloud, read, refusal};

#[test]
fn names_do_not_matter() {
    for (name, content) in seeds::all() {
        let expected = format!("{:?}", cloud(name, &content).positions);
        for other in ["scan", "scan.dat", "scan.xyz", "scan.pcd", "scan.ply", "scan.ptx"] {
            let read = read(other, &content).unwrap_or_else(|e| panic!("{name} as {e}"));
            assert_eq!(format!("{:?}", read.positions), expected, "{name} as {other}");
        }
    }
}

#[test]
fn extensions_are_known() {
    for (name, format) in [
        ("a.PCD", Some(PointFormat::Pcd)),
        ("a.xyz.gz", Some(PointFormat::Text)),
        ("a.pts", Some(PointFormat::Pts)),
        ("a.ptx", Some(PointFormat::Ptx)),
        ("a.ply", Some(PointFormat::Ply)),
        ("a.e57", Some(PointFormat::E57)),
        ("a.las", Some(PointFormat::Las)),
        ("a.LAZ", Some(PointFormat::Las)),
        ("a.obj", None),
        ("pcd", None),
    ] {
        assert_eq!(PointFormat::by_extension(name.as_ref()), format, "{name}");
    }
}

#[test]
fn other_files_are_refused_by_name() {
    for (content, word) in [
        (&b"LASF\0\0"[..], "ends in its header"),
        (b"ASTM-E57\0", "ends in its header"),
        (b"PK\x03\x04", "ZIP"),
        (b"<!doctype html>\n1 2 3\n", "web page"),
        (
            b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
           endloop\nendfacet\nendsolid\n",
            "has faces",
        ),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "has faces"),
        (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "has faces"),
        (b"1\x002\x003\x00\n\x00", "UTF-16"),
    ] {
        for name in ["scan.xyz", "scan.ply", "scan"] {
            refusal(name, content, word);
        }
    }
}

#[test]
fn a_mesh_by_its_extension_is_no_cloud() {
    // OFF may leave out its keyword.
    refusal("scan.off", "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "has faces");
}
