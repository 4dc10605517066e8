//! The topology of the collected scans compared with their index, if they are present.

use std::collections::HashMap;

use crate::common::shared;
use scan2step::mesh::{self, Choice, Components};

/// A row of the index by the names of its columns.
type Row = HashMap<String, String>;

fn index(text: &str) -> Vec<Row> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split('\t').collect();
    let row = |line: &str| {
        let cells = line.split('\t').map(str::to_owned);
        names.iter().map(|n| (*n).to_owned()).zip(cells).collect()
    };
    lines.map(row).collect()
}

/// Whether the index counts in the same way as we do. It keeps duplicate and degenerate faces, and
/// it opens an edge with three faces even if one of them is removed here.
fn comparable(row: &Row) -> bool {
    let none = ["nonmanifold_edges", "degenerate_faces", "duplicate_faces"];
    let orderly = none.iter().all(|name| row[*name] == "0");
    // It does not support fans.
    orderly && !row["largest_genus"].is_empty()
}

/// Scans that are refused although the index has their topology, and the reasons: they are
/// compressed, or some corners are not vertices.
const REFUSED: [(&str, &str); 5] = [
    ("D/gltf_duck_draco/Duck.gltf", "KHR_draco_mesh_compression"),
    ("E/issue-140-zero-face-idx.obj", "a face with vertex 0"),
    ("E/gltf_ioor/IndexOutOfRange.gltf", "vertex 255, but only 24"),
    ("E/e_oob_index.ply.gz", "vertex 8306, but only 7575"),
    ("E/e_neg_index.ply.gz", "negative vertex number"),
];

/// Scans with points that differ only by rounding, which the index does not weld. Here they are one point,
/// so that the holes of these scans are whole: components, loops and genus.
const ROUNDED: [(&str, [f64; 3]); 4] = [
    ("B/featuretype.stl", [1.0, 0.0, 9.0]),
    ("D/stl_upper_case.STL", [1.0, 0.0, 1.0]),
    ("D/gltf_strips_412prims.gltf", [4.0, 0.0, 8.0]),
    ("D/stl_octagonal_pocket.stl", [1.0, 0.0, 1.0]),
];

#[test]
fn topology_is_as_indexed() {
    let Some(list) = shared("scans/INDEX.tsv") else { return };
    let folder = list.parent().expect("it lies in a folder");
    let rows = index(&std::fs::read_to_string(&list).expect("the index is readable"));
    let mut wrong = Vec::new();
    let mut compared = 0;
    for row in rows.iter().filter(|row| comparable(row)) {
        let path = folder.join(&row["path"]);
        let read = formats::read_scan(&path).map_err(|e| e.to_string());
        let built = read.and_then(|soup| mesh::from_soup(&soup, 1.0).map_err(|e| e.to_string()));
        let build = match built {
            Ok(build) => build,
            Err(why) => {
                let is_known =
                    REFUSED.iter().any(|(of, word)| row["path"] == *of && why.contains(word));
                if !is_known {
                    wrong.push(why);
                }
                continue;
            }
        };
        let scan = Components::new(build).with_handles(Some(0.0));
        let largest = scan.take(Choice::Largest).expect("there is one");
        let found = [scan.count() as f64, largest.topology.loops as f64, largest.topology.genus()];
        let number = |name: &str| row[name].parse::<f64>().expect("a number");
        let rounded = ROUNDED.iter().find(|(path, _)| row["path"] == *path);
        let indexed = ["components", "largest_loops", "largest_genus"].map(number);
        let expected = rounded.map_or(indexed, |of| of.1);
        compared += 1;
        if found != expected {
            wrong.push(format!("{}: {found:?}, not {expected:?}", row["path"]));
        }
    }
    println!("{compared} scans compared");
    assert!(compared > 130, "only {compared} compared");
    assert!(
        wrong.is_empty(),
        "refused, or other components, loops and genus:\n{}",
        wrong.join("\n")
    );
}
