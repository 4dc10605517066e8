//! The collected scans compared with their index.

use std::fs;
use std::panic::catch_unwind;
use std::path::Path;

use formats::{Result, Soup, read_scan};

use crate::support::{scans, triangles};

/// Valid files that are refused on purpose, and the reasons.
const REFUSED: [(&str, &str); 6] = [
    ("D/ply_int_coords.ply", "no faces"),
    ("D/ply_list_element_points.ply", "no faces"),
    ("D/points-prim.obj", "no faces"),
    ("D/gltf_mode_points/Mesh_PrimitiveMode_00.gltf", "no triangles"),
    ("D/diamond_with_bool.ply", "a type that PLY does not have"),
    ("D/number_formats.obj", "3.1+e2 is no number"),
];

/// Files for which the program that made the index counted differently.
const OTHER_COUNTS: [(&str, usize, usize); 3] = [
    // It welded the corners of this file.
    ("D/stl_two_solids.stl", 72, 24),
    // It does not support fans.
    ("D/gltf_mode_fan/Mesh_PrimitiveMode_05.gltf", 4, 2),
    ("D/gltf_mode_fan_indexed/Mesh_PrimitiveMode_12.gltf", 4, 2),
];

/// Files that are broken for the program that made the index, but not for us.
const SOUND: [(&str, usize, usize); 1] = [
    // It lost the vertex after the byte order mark.
    ("E/e_bom_crlf.obj.gz", 7575, 14852),
];

/// A row of the index.
struct Scan {
    class: String,
    path: String,
    /// The numbers of vertices and triangles, if the file could be read.
    counts: Option<(usize, usize)>,
    /// The number of faces with vertex numbers out of range.
    bad_faces: usize,
}

fn index(folder: &Path) -> Vec<Scan> {
    let text = fs::read_to_string(folder.join("INDEX.tsv")).expect("the index is readable");
    let mut lines = text.lines();
    let titles: Vec<&str> = lines.next().unwrap_or_default().split('\t').collect();
    let column = |title| titles.iter().position(|t| *t == title).expect("a column of the index");
    let [class, path, vertices, faces, bad] =
        ["class", "path", "vertices", "faces", "bad_index_faces"].map(column);
    let row = |line: &str| {
        let cells: Vec<&str> = line.split('\t').collect();
        let number = |c: usize| cells[c].parse().ok();
        Scan {
            class: cells[class].to_owned(),
            path: cells[path].to_owned(),
            counts: number(vertices).zip(number(faces)),
            bad_faces: number(bad).unwrap_or(0),
        }
    };
    lines.map(row).collect()
}

/// The differences between a scan of class A or D and its row.
fn judge_good(scan: &Scan, read: &Result<Soup>) -> Option<String> {
    let refused = REFUSED.iter().any(|(path, _)| *path == scan.path);
    let other = OTHER_COUNTS.iter().find(|(path, ..)| *path == scan.path);
    let expected = other.map(|&(_, v, f)| (v, f)).or(scan.counts);
    match (read, refused) {
        (Err(_), true) => None,
        (Err(e), false) => Some(format!("refused: {e}")),
        (Ok(_), true) => Some("read, but should be refused".into()),
        (Ok(soup), false) => compare(soup, expected),
    }
}

/// The same for class E. A broken file may be refused but not read wrongly.
fn judge_broken(scan: &Scan, read: &Result<Soup>) -> Option<String> {
    if let Some(&(_, v, f)) = SOUND.iter().find(|(path, ..)| *path == scan.path) {
        return match read {
            Ok(soup) => compare(soup, Some((v, f))),
            Err(e) => Some(format!("refused: {e}")),
        };
    }
    match read {
        Ok(_) if scan.bad_faces > 0 => Some("read despite bad vertex numbers".into()),
        Ok(soup) => compare(soup, scan.counts),
        Err(_) => None,
    }
}

fn compare(soup: &Soup, expected: Option<(usize, usize)>) -> Option<String> {
    let found = (soup.points.len(), triangles(soup));
    let expected = expected.filter(|&counts| counts != found)?;
    Some(format!("{found:?} vertices and triangles, not {expected:?}"))
}

#[test]
fn collected_scans_read_as_indexed() {
    let Some(folder) = scans() else {
        eprintln!("SKIPPED: the collected scans (../../shared/scans) are not there");
        return;
    };
    let mut wrong = Vec::new();
    for scan in index(&folder) {
        let path = folder.join(&scan.path);
        let Ok(read) = catch_unwind(|| read_scan(&path)) else {
            wrong.push(format!("{}: panics", scan.path));
            continue;
        };
        if let Err(e) = &read {
            eprintln!("{}: {} ({:?}) -- {}", scan.path, e.what, e.place, e.help);
        }
        let verdict = match scan.class.as_str() {
            "A" | "B" | "D" => judge_good(&scan, &read),
            _ => judge_broken(&scan, &read),
        };
        wrong.extend(verdict.map(|verdict| format!("{}: {verdict}", scan.path)));
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}
