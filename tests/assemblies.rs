//! Files with several parts: each part once, in its places, with names and colours.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::importers::opencascade_assembly;
use common::{arg, convert, converted, inspect, json, shared};
use serde_json::Value;

/// A box in OBJ, whose first vertex has the number `first`.
fn obj_box([x, y, z]: [f64; 3], size: [f64; 3], first: usize) -> String {
    let corner = |k: usize| {
        let at = [x, y, z].into_iter().zip(size).enumerate();
        let at = at.map(|(axis, (low, size))| low + size * (k >> axis & 1) as f64);
        at.map(|v| format!(" {v}")).collect::<String>()
    };
    let points: String = (0..8).map(|k| format!("v{}\n", corner(k))).collect();
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let face =
        |quad: &[usize; 4]| format!("f{}\n", quad.map(|k| format!(" {}", first + k)).concat());
    points + &quads.iter().map(face).collect::<String>()
}

/// Two equal boxes and another one.
fn boxes() -> String {
    let mut text = String::from("mtllib boxes.mtl\n");
    for (number, (name, at, size, material)) in [
        ("left", [0.0, 0.0, 0.0], [10.0, 20.0, 30.0], "red"),
        ("right", [50.0, 0.0, 0.0], [10.0, 20.0, 30.0], "red"),
        ("lid');#1", [0.0, 0.0, 40.0], [60.0, 20.0, 2.0], "blue"),
    ]
    .into_iter()
    .enumerate()
    {
        text += &format!("o {name}\nusemtl {material}\n{}", obj_box(at, size, 1 + 8 * number));
    }
    text
}

/// A folder with a file of boxes and their colours.
fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let scan = folder.path().join("boxes.obj");
    fs::write(&scan, boxes()).expect("a scan");
    let colours = "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n";
    fs::write(folder.path().join("boxes.mtl"), colours).expect("colours");
    (folder, scan)
}

fn text(file: &Path) -> String {
    fs::read_to_string(file).expect("a file")
}

/// How often an entity is in a STEP file.
fn count(file: &str, entity: &str) -> usize {
    file.matches(&format!("={entity}(")).count()
}

#[test]
fn parts_are_converted_once_and_placed() {
    let (folder, scan) = folder();
    let [step, report] = ["boxes.step", "boxes.json"].map(|name| folder.path().join(name));
    let said = converted(&[arg(&scan), arg(&step), "--report", arg(&report)]);
    assert!(said.contains("parts: kept, as all of its meshes are closed"), "{said}");
    let file = text(&step);
    let counts =
        ["MANIFOLD_SOLID_BREP", "NEXT_ASSEMBLY_USAGE_OCCURRENCE", "PRODUCT", "STYLED_ITEM"];
    assert_eq!(counts.map(|entity| count(&file, entity)), [2, 3, 3, 2]);
    let report = json(&report);
    let parts = report["parts"].as_array().expect("parts");
    assert_eq!(parts.len(), 2);
    assert_eq!((&parts[0]["name"], &parts[0]["colour"]), (&"left".into(), &vec![255, 0, 0].into()));
    let matrix = [[1.0, 0.0, 0.0, 50.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let found = &parts[0]["places"][1];
    assert_eq!(found["path"], Value::from(vec!["right"]));
    for (row, expected) in found["matrix"].as_array().expect("rows").iter().zip(matrix) {
        for (x, expected) in row.as_array().expect("a row").iter().zip(expected) {
            assert!((x.as_f64().expect("a number") - expected).abs() < 1e-9, "{found}");
        }
    }
    assert_eq!(parts[0]["shape"]["kind"], "solid");
    assert_eq!(parts[1]["shape"]["faces"], 6);
    let found = opencascade_assembly(&step);
    assert_eq!(found["root"], "boxes");
    let places = found["places"].as_array().expect("places");
    let expected = [
        ("left", 6000.0, [5.0, 10.0, 15.0]),
        ("right", 6000.0, [55.0, 10.0, 15.0]),
        ("lid');#1", 2400.0, [30.0, 10.0, 41.0]),
    ];
    assert_eq!(places.len(), expected.len());
    for (place, (name, volume, centre)) in places.iter().zip(expected) {
        assert_eq!(place["path"], Value::from(vec!["boxes", name]));
        assert_eq!((&place["valid"], &place["solids"]), (&true.into(), &1.into()));
        let off =
            |found: &Value, expected: f64| (found.as_f64().expect("a number") - expected).abs();
        assert!(off(&place["volume"], volume) < 1e-6 * volume, "{place}");
        assert!((0..3).all(|k| off(&place["centre"][k], centre[k]) < 1e-6), "{place}");
        let red = f64::from(u8::from(name != "lid');#1"));
        assert!(off(&place["colour"][0], red) < 1e-3, "{place}");
    }
}

#[test]
fn the_user_chooses_parts() {
    let (folder, scan) = folder();
    let step = folder.path().join("out.step");
    let of = |parts: &str| {
        converted(&[arg(&scan), arg(&step), "--parts", parts]);
        let file = text(&step);
        let counts = ["MANIFOLD_SOLID_BREP", "NEXT_ASSEMBLY_USAGE_OCCURRENCE"];
        counts.map(|entity| count(&file, entity))
    };
    assert_eq!(of("keep"), [2, 3]);
    assert_eq!(of("merge"), [3, 0]);
    assert_eq!(of("1"), [1, 0]);
    assert_eq!(of("name:right"), [1, 0]);
    assert!(text(&step).contains("CARTESIAN_POINT('',(50."), "the place of the part");
    for (parts, word) in
        [("2", "has no part 2"), ("name:top", "has no part called"), ("some", "not keep")]
    {
        let refused = convert(&[arg(&scan), arg(&step), "--parts", parts]);
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(!refused.status.success() && said.contains(word), "{said}");
    }
    // What cannot be written of an assembly is written of one mesh, and that is said.
    let iges = folder.path().join("out.igs");
    let said = converted(&[arg(&scan), arg(&iges)]);
    assert!(said.contains("parts: all as one mesh, as IGES files have no parts yet"), "{said}");
    let refused = convert(&[arg(&scan), arg(&iges), "--parts", "keep"]);
    assert_eq!(refused.status.code(), Some(1));
}

/// A part that cannot be converted leaves the others.
#[test]
fn no_part_is_lost_in_silence() {
    let (folder, scan) = folder();
    let step = folder.path().join("out.step");
    // Three points in one place are no surface.
    let flat = "o flat\nv 0 0 90\nv 0 0 90\nv 0 0 90\nf 25 26 27\n";
    fs::write(&scan, boxes() + flat).expect("a scan");
    let args = [arg(&scan), arg(&step), "--parts", "keep"];
    let made = convert(&args);
    let said = String::from_utf8_lossy(&made.stderr).into_owned();
    assert_eq!(made.status.code(), Some(3), "{said}");
    assert!(said.contains("left out: part 2, flat, in 1 place"), "{said}");
    assert_eq!(count(&text(&step), "NEXT_ASSEMBLY_USAGE_OCCURRENCE"), 3);
    fs::remove_file(&step).expect("a file");
    let strict = convert(&[&args[..], &["--strict"]].concat());
    assert_eq!(strict.status.code(), Some(1));
    assert!(!step.exists());
}

#[test]
fn inspect_lists_parts_and_places() {
    let (_folder, scan) = folder();
    let found = inspect(&[arg(&scan)]);
    let said = String::from_utf8_lossy(&found.stdout).into_owned();
    for line in
        ["2 parts in 3 places", "--parts 0   left, in 2 places: 12 triangles", "right (part 0)"]
    {
        assert!(said.contains(line), "no {line:?} in {said}");
    }
    let found = inspect(&[arg(&scan), "--json"]);
    let found: Value = serde_json::from_slice(&found.stdout).expect("JSON");
    assert_eq!(found["parts"][0]["places"].as_array().map(Vec::len), Some(2));
    assert_eq!(found["parts"][1]["triangles"], 12);
}

#[test]
fn a_thousand_bricks_cost_what_one_costs() {
    let folder = tempfile::tempdir().expect("a folder");
    let [scan, step] = ["wall.obj", "wall.step"].map(|name| folder.path().join(name));
    let brick = |i: usize| {
        let at = [25.0 * (i % 40) as f64, 0.0, 12.0 * (i / 40) as f64];
        format!("o brick\n{}", obj_box(at, [24.0, 11.0, 11.0], 1 + 8 * i))
    };
    fs::write(&scan, (0..1000).map(brick).collect::<String>()).expect("a scan");
    converted(&[arg(&scan), arg(&step)]);
    let file = text(&step);
    let counts = ["MANIFOLD_SOLID_BREP", "NEXT_ASSEMBLY_USAGE_OCCURRENCE"];
    assert_eq!(counts.map(|entity| count(&file, entity)), [1, 1000]);
    assert!(file.len() < 2_000_000, "{} bytes", file.len());
}

/// The collected assemblies through the program and OpenCASCADE, against their tables.
#[test]
fn made_assemblies_are_what_was_designed() {
    let Some(made) = shared("assemblies/made") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let table = text(&made.join("bolted.tsv"));
    let rows: Vec<Vec<&str>> =
        table.lines().skip(1).map(|line| line.split('\t').collect()).collect();
    let number = |cell: &str| cell.parse::<f64>().expect("a number");
    for extension in ["glb", "obj"] {
        let step = folder.path().join(format!("bolted-{extension}.step"));
        converted(&[arg(&made.join(format!("bolted.{extension}"))), arg(&step)]);
        let found = opencascade_assembly(&step);
        let places = found["places"].as_array().expect("places");
        assert_eq!(places.len(), rows.len());
        for (place, row) in places.iter().zip(&rows) {
            let value = |at: &str| place.pointer(at).and_then(Value::as_f64).expect("a number");
            let [x, y, z] = [value("/centre/0"), value("/centre/1"), value("/centre/2")];
            let centre = if extension == "glb" { [x, -z, y] } else { [x, y, z] };
            let off = (0..3).map(|k| (centre[k] - number(row[4 + k])).powi(2)).sum::<f64>().sqrt();
            // The assembly is 600 mm large.
            assert!(off < 1e-5 * 600.0, "{extension}: {} is off by {off} mm", row[0]);
            let volume = number(row[3]);
            assert!((value("/volume") / volume - 1.0).abs() < 1e-6, "{place}, not {volume}");
            for k in 0..3 {
                assert!((value(&format!("/colour/{k}")) - number(row[7 + k])).abs() < 0.003);
            }
            assert_eq!(place["valid"], true);
            if extension == "glb" {
                assert_eq!(place["product"], row[2]);
            }
        }
    }
}
