//! PLY without faces.

use formats::points::{Note, ScanGrid};
use formats::{Content, LengthUnit, read_content, read_scan};

use crate::seeds;
use crate::support::{cloud, places, refusal};

const PLACES: [[f64; 3]; 3] = [[0.5, 0.25, 1.0], [1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];

fn seed(name: &str) -> Vec<u8> {
    seeds::all().into_iter().find(|(n, _)| *n == name).expect("a seed").1
}

#[test]
fn both_orders_of_bytes_read_the_same() {
    for name in ["little.ply", "big.ply"] {
        let cloud = cloud(name, seed(name));
        assert_eq!(places(&cloud), PLACES);
        assert_eq!(cloud.normals, Some(vec![[0.0, 0.0, 1.0]; 3]));
        assert_eq!((cloud.lost.colours, cloud.lost.columns.len()), (3, 0));
        assert_eq!(cloud.unit, None::<LengthUnit>);
    }
}

#[test]
fn a_range_grid_is_read() {
    let cloud = cloud("range.ply", seed("range.ply"));
    assert_eq!(places(&cloud), PLACES);
    assert_eq!((&cloud.normals, cloud.lost.not_finite), (&None, 1));
    let grid = cloud.scans[0].grid.as_ref().expect("a grid");
    assert_eq!((grid.rows, grid.columns), (2, 3));
    // The vertex that is no number leaves an empty cell.
    let nothing = ScanGrid::EMPTY;
    assert_eq!(grid.cells, [0, nothing, 1, nothing, 2, nothing]);
}

#[test]
fn a_range_grid_may_be_wrong() {
    let text = String::from_utf8(seed("range.ply")).expect("text");
    for (from, to) in [("num_cols 3", "num_cols 4"), ("obj_info num_rows 2\n", "")] {
        let cloud = cloud("range.ply", text.replace(from, to));
        assert_eq!(places(&cloud), PLACES);
        assert_eq!((&cloud.scans[0].grid, cloud.notes), (&None, vec![Note::GridIgnored]));
    }
    for (from, to, word) in [
        ("1 3\n", "1 4\n", "vertex 4, but only 4 vertices (cell 4)"),
        ("1 3\n", "1 -4\n", "negative vertex number (cell 4)"),
        ("1 3\n0\n", "1 3\n", "ends after 5 of the 6 rows of element range_grid"),
        ("property float z\n", "", "without z"),
        ("vertex 4", "vertex 3", "vertex 5, but only 3 vertices (cell 0)"),
        ("element vertex 4", "element vertex 4000000000", "more values in a row"),
    ] {
        refusal("range.ply", text.replace(from, to), word);
    }
}

#[test]
fn the_faces_decide_what_a_file_is() {
    let face = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                end_header\n0 0 1\n1 0 0\n0 1 0\n3 0 1 2\n";
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scan.ply");
    std::fs::write(&path, face).expect("a file");
    let content = read_content(&path).unwrap_or_else(|e| panic!("{e}"));
    assert!(matches!(content, Content::Mesh(soup) if soup.polygons.len() == 1));
    refusal("scan.ply", face, "has faces");
    let none = face.replace("face 1", "face 0").replace("3 0 1 2\n", "");
    assert_eq!(cloud("scan.ply", &none).len(), 3);
    std::fs::write(&path, none).expect("a file");
    assert!(matches!(read_content(&path), Ok(Content::Points(points)) if points.len() == 3));
    assert!(read_scan(&path).is_err_and(|e| e.what.contains("no faces")));
}

#[test]
fn nothing_is_refused() {
    let head = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n";
    refusal("scan.ply", head, "has no points");
    refusal("scan.ply", "ply\nformat ascii 1.0\nend_header\n", "has no points");
}

#[test]
fn meshes_without_faces_are_clouds() {
    for (name, text) in [
        ("points.obj", "v 0 0 1\nv 1 0 0\nv 0 1 nan\np 1 2 3\n"),
        ("points.off", "OFF\n3 0 0\n0 0 1\n1 0 0\n0 nan 1\n"),
    ] {
        let cloud = cloud(name, text);
        assert_eq!((cloud.len(), cloud.lost.not_finite), (2, 1));
    }
}

#[test]
fn centres_of_splats_are_no_measured_points() {
    let splats = |names: [&str; 3]| {
        let properties = names.map(|name| format!("property float {name}\n")).concat();
        format!(
            "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
             property float f_dc_0\n{properties}end_header\n1 2 3 0 0 0 0\n4 5 6 0 0 0 0\n"
        )
    };
    let cloud_of = |names| cloud("scan.ply", splats(names));
    let [centres, points] =
        [["opacity", "scale_0", "rot_0"], ["opacity", "scale", "curvature"]].map(cloud_of);
    assert_eq!(centres.notes, [Note::Splats]);
    assert!(centres.remarks().iter().any(|remark| remark.contains("centres of Gaussian splats")));
    assert!(points.notes.is_empty());
    assert_eq!(places(&centres), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
}
