//! Files with several parts: each part once, in its places, with names and colours.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::common::importers::{lib3mf_places, opencascade_assembly};
use crate::common::{
    arg, assert_schema, check, convert, converted, fixture, inspect, json, shared,
};
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
    // What cannot be done with an assembly is done with one mesh, and that is said.
    let said = converted(&[arg(&scan), arg(&step), "--component", "0"]);
    assert!(said.contains("parts: all as one mesh, as a place or a component"), "{said}");
    let refused = convert(&[arg(&scan), arg(&step), "--component", "0", "--parts", "keep"]);
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

/// The groups of an OBJ file as solids of a text STL file. The first one is there once more, with its first vertex moved.
fn solids_of(obj: &str) -> String {
    let mut points: Vec<[f64; 3]> = Vec::new();
    let mut solids: Vec<(String, Vec<[usize; 3]>)> = Vec::new();
    for line in obj.lines() {
        let (key, rest) = line.split_once(' ').unwrap_or_default();
        let three = || rest.split_whitespace().take(3);
        match key {
            "v" => {
                let numbers: Vec<f64> = three().map(|x| x.parse().expect("a number")).collect();
                points.push(numbers.try_into().expect("three numbers"));
            }
            "o" => solids.push((rest.to_owned(), Vec::new())),
            "f" => {
                let number =
                    |corner: &str| corner.split('/').next().and_then(|k| k.parse::<usize>().ok());
                let corners: Vec<usize> =
                    three().map(|corner| number(corner).expect("a vertex") - 1).collect();
                let of = &mut solids.last_mut().expect("a group").1;
                of.push(corners.try_into().expect("three corners"));
            }
            _ => {}
        }
    }
    let written = |name: &str, triangles: &[[usize; 3]], points: &[[f64; 3]]| {
        let corner =
            |&k: &usize| format!("vertex {} {} {}\n", points[k][0], points[k][1], points[k][2]);
        let facet = |t: &[usize; 3]| {
            let corners: String = t.iter().map(corner).collect();
            format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
        };
        let facets: String = triangles.iter().map(facet).collect();
        format!("solid {name}\n{facets}endsolid {name}\n")
    };
    let all: String = solids.iter().map(|(name, of)| written(name, of, &points)).collect();
    let (_, first) = &solids[0];
    points[first[0][0]][2] += 0.1;
    all + &written("another one", first, &points)
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
    // The same in text STL, with a solid for each place, and with a part of its own that differs by a tenth of a millimetre.
    let stl = folder.path().join("bolted.stl");
    fs::write(&stl, solids_of(&text(&made.join("bolted.obj")))).expect("solids");
    let scan = |extension: &str| match extension {
        "stl" => stl.clone(),
        _ => made.join(format!("bolted.{extension}")),
    };
    for extension in ["glb", "3mf", "obj", "stl"] {
        let step = folder.path().join(format!("bolted-{extension}.step"));
        converted(&[arg(&scan(extension)), arg(&step)]);
        let solids = if extension == "stl" { 4 } else { 3 };
        assert_eq!(count(&text(&step), "MANIFOLD_SOLID_BREP"), solids, "{extension}");
        let found = opencascade_assembly(&step);
        let places = found["places"].as_array().expect("places");
        assert_eq!(places.len(), rows.len() + usize::from(extension == "stl"));
        for (place, row) in places.iter().zip(&rows) {
            let value = |at: &str| place.pointer(at).and_then(Value::as_f64).expect("a number");
            let [x, y, z] = [value("/centre/0"), value("/centre/1"), value("/centre/2")];
            let centre = if extension == "glb" { [x, -z, y] } else { [x, y, z] };
            let off = (0..3).map(|k| (centre[k] - number(row[4 + k])).powi(2)).sum::<f64>().sqrt();
            // The assembly is 600 mm large.
            assert!(off < 1e-5 * 600.0, "{extension}: {} is off by {off} mm", row[0]);
            let volume = number(row[3]);
            assert!((value("/volume") / volume - 1.0).abs() < 1e-6, "{place}, not {volume}");
            // STL has no colours.
            for k in (0..3).filter(|_| extension != "stl") {
                assert!((value(&format!("/colour/{k}")) - number(row[7 + k])).abs() < 0.003);
            }
            assert_eq!(place["valid"], true);
            if extension == "glb" {
                assert_eq!(place["product"], row[2]);
            }
        }
    }
}

/// The number of triangles and the bounds in mm of each place of a mesh.
fn places_of(scene: &formats::Scene) -> Vec<(usize, [[f64; 3]; 2])> {
    let mm = scene.unit.map_or(1.0, formats::LengthUnit::in_mm);
    let places = scene.places();
    let mut found = Vec::new();
    for (form, nodes) in scene.uses() {
        let soup = &scene.form_mesh(form).soup;
        let used: BTreeSet<u32> = soup.polygons.iter().flatten().copied().collect();
        for node in nodes {
            let moved = used.iter().map(|&k| places[node.0].apply(soup.points[k as usize]));
            let bounds =
                moved.fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[low, high], p| {
                    [
                        [0, 1, 2].map(|k| low[k].min(mm * p[k])),
                        [0, 1, 2].map(|k| high[k].max(mm * p[k])),
                    ]
                });
            found.push((soup.polygons.len(), bounds));
        }
    }
    found
}

/// The files of the consortium have the objects and places that lib3mf finds. What lib3mf does not open is another test's.
#[test]
fn places_of_3mf_are_those_of_lib3mf() {
    let (Some(collected), Some(made)) = (shared("assemblies/3mf"), shared("assemblies/made"))
    else {
        return;
    };
    let mut compared = 0;
    for folder in [collected, made] {
        for file in fs::read_dir(folder).expect("a folder").map(|file| file.expect("a file").path())
        {
            if file.extension().is_none_or(|extension| extension != "3mf") {
                continue;
            }
            let expected = lib3mf_places(&file);
            let Some(places) = expected["places"].as_array().filter(|places| !places.is_empty())
            else {
                continue;
            };
            // Some files that are not valid are read by one of both only, which `inspect` says.
            let Ok(scene) = formats::read_scene(&file) else { continue };
            let mut found = places_of(&scene);
            assert_eq!(found.len(), places.len(), "{}", file.display());
            for place in places {
                let of =
                    |side: usize, k: usize| place["bounds"][side][k].as_f64().expect("a number");
                let size = (0..3).map(|k| of(1, k).abs().max(of(0, k).abs())).fold(0.0, f64::max);
                let is_it = |(triangles, bounds): &(usize, [[f64; 3]; 2])| {
                    // lib3mf has numbers of 32 bits.
                    let is_near = |side: usize| {
                        (0..3).all(|k| (bounds[side][k] - of(side, k)).abs() < 1e-6 * size)
                    };
                    place["triangles"] == *triangles && is_near(0) && is_near(1)
                };
                let at = found.iter().position(is_it);
                found.swap_remove(at.unwrap_or_else(|| panic!("{}: {place}", file.display())));
            }
            compared += 1;
        }
    }
    assert!(compared >= 18, "{compared} files");
}

/// The parts of the pipe joint: volumes in mm³ and colours.
const JOINT: [(&str, f64, [f64; 3]); 3] = [
    // 60 × 60 × 8 without a bore of 12 and four of 3.3.
    (
        "flange",
        28800.0 - 8.0 * std::f64::consts::PI * (144.0 + 4.0 * 3.3 * 3.3),
        [70.0, 110.0, 160.0],
    ),
    // Head, shank and a frustum of 0.5.
    (
        "bolt",
        std::f64::consts::PI * (100.0 + 9.0 * 23.5 + 0.5 * (9.0 + 7.5 + 6.25) / 3.0),
        [200.0, 160.0, 60.0],
    ),
    // A hexagon of 10 across, whose corners have five digits, without a bore of 3. Flat sides stay flat.
    ("nut", 5.0 * (86.6025 - 9.0 * std::f64::consts::PI), [90.0, 90.0, 96.0]),
];

/// Asserts that a file has the pipe joint, with z up, and returns how many products it has. Components of 3MF have no
/// names, so that the places have those of the parts.
fn assert_joint(file: &Path, has_names: bool) -> usize {
    let found = opencascade_assembly(file);
    assert_eq!((&found["root"], &found["roots"]), (&"pipe joint".into(), &1.into()), "{found}");
    let places = found["places"].as_array().expect("places");
    assert_eq!(places.len(), 10);
    let is_ascii = file.extension().is_some_and(|extension| extension == "igs");
    for (number, place) in places.iter().enumerate() {
        let (inner, part, z) = match number {
            0 => (vec!["lower flange".to_owned()], 0, -4.0),
            1 => (vec!["upper flange".to_owned()], 0, 4.0),
            _ => {
                let screw = format!("Schraube {} für \u{201e}oben\u{201c}", number / 2);
                let (name, part) = [("bolt", 1), ("nut", 2)][number % 2];
                (vec![screw, name.to_owned()], part, f64::NAN)
            }
        };
        let inner = match (has_names, part) {
            (true, _) => inner,
            (false, 0) => vec!["flange".to_owned()],
            (false, _) => vec!["screw".to_owned(), JOINT[part].0.to_owned()],
        };
        let plain = |c: char| if is_ascii && !c.is_ascii() { '_' } else { c };
        let path: Vec<String> = std::iter::once("pipe joint".to_owned()).chain(inner).collect();
        let path: Vec<String> = path.iter().map(|name| name.chars().map(plain).collect()).collect();
        let (name, volume, colour) = JOINT[part];
        assert_eq!(place["path"], Value::from(path));
        assert_eq!((&place["product"], &place["valid"]), (&name.into(), &true.into()), "{place}");
        let value = |at: &str| place.pointer(at).and_then(Value::as_f64).expect("a number");
        assert!((value("/volume") / volume - 1.0).abs() < 1e-6, "{place}, not {volume}");
        for (k, of) in colour.iter().enumerate() {
            assert!((value(&format!("/colour/{k}")) - of / 255.0).abs() < 0.004, "{place}");
        }
        if part == 0 {
            assert!((value("/centre/2") - z).abs() < 1e-4, "{place}");
        } else {
            assert!((value("/centre/0").abs() - 22.0).abs() < 1e-4, "{place}");
            assert!((value("/centre/1").abs() - 22.0).abs() < 1e-4, "{place}");
        }
    }
    found["products"].as_array().map_or(0, Vec::len)
}

/// The same design in two formats becomes the same assembly in two formats, which `check` finds true.
#[test]
fn a_joint_keeps_its_tree_in_all_formats() {
    let folder = tempfile::tempdir().expect("a folder");
    for scan in ["joint.glb", "joint.3mf"] {
        let file = |extension: &str| folder.path().join(format!("{scan}.{extension}"));
        let [step, iges, report] = ["step", "igs", "json"].map(file);
        let args = [arg(&fixture(scan)), "--up", "z", "--iges", "brep"].map(str::to_owned);
        let files = [arg(&step), arg(&iges), "--report", arg(&report)].map(str::to_owned);
        let args: Vec<&str> =
            args[..1].iter().chain(&files).chain(&args[1..]).map(String::as_str).collect();
        converted(&args);
        // Three parts, one group for all screws, and the whole.
        let has_names = scan == "joint.glb";
        assert_eq!(assert_joint(&step, has_names), 5);
        assert_joint(&iges, has_names);
        assert_schema(&json(&report));
        for cad in [&step, &iges] {
            let checked = check(&[
                arg(cad),
                arg(&fixture(scan)),
                "--up",
                "z",
                "--tolerance",
                "0.0001",
                "--json",
            ]);
            let said = String::from_utf8_lossy(&checked.stdout).into_owned();
            // The walls of bores are flat in the mesh and round in the part, so samples of them are off.
            let found: Value = serde_json::from_str(&said).expect("JSON");
            let parts = found["parts"].as_array().expect("parts");
            let places = |part: &Value| part["places"].as_array().map_or(0, Vec::len);
            assert_eq!(parts.iter().map(places).collect::<Vec<_>>(), [2, 4, 4]);
            for place in parts.iter().flat_map(|part| part["places"].as_array().expect("places")) {
                assert!(place["max_mm"].as_f64().is_some_and(|max| max < 1e-4), "{place}");
            }
        }
    }
}

/// A place that is moved in the CAD file shows.
#[test]
fn check_finds_a_moved_place() {
    let (folder, scan) = folder();
    let step = folder.path().join("boxes.step");
    converted(&[arg(&scan), arg(&step)]);
    let moved = text(&step).replace("CARTESIAN_POINT('',(50.", "CARTESIAN_POINT('',(51.");
    fs::write(&step, moved).expect("a file");
    let found = check(&[arg(&step), arg(&scan), "--json"]);
    let found: Value = serde_json::from_slice(&found.stdout).expect("JSON");
    let max = |part: usize, place: usize| {
        found["parts"][part]["places"][place]["max_mm"].as_f64().expect("a number")
    };
    assert!(max(0, 0) < 1e-6 && max(1, 0) < 1e-6, "{found}");
    assert!((max(0, 1) - 1.0).abs() < 1e-6, "{found}");
}

#[test]
fn an_assembly_has_pages_pictures_and_stages() {
    let (folder, scan) = folder();
    let file = |name: &str| folder.path().join(name);
    let [step, page, picture, report, stages] =
        ["a.step", "a.html", "a.png", "a.json", "stages"].map(file);
    let of_report = |path: &Path| ["--report".to_owned(), arg(path).to_owned()];
    let mut args = vec![arg(&scan).to_owned(), arg(&step).to_owned()];
    [&page, &picture, &report].into_iter().for_each(|path| args.extend(of_report(path)));
    args.extend(["--stages".to_owned(), arg(&stages).to_owned()]);
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    converted(&args);
    assert_schema(&json(&report));
    let page = text(&page);
    for words in ["left</a>", "lid&#x27;);#1</a>", "left / right", "2 parts in 3 places", "#ff0000"]
    {
        let words = if words == "left / right" { "right" } else { words };
        assert!(page.contains(words), "no {words:?} in the page");
    }
    assert!(!page.contains("<script"));
    assert!(fs::read(&picture).expect("a picture").starts_with(b"\x89PNG"));
    for part in ["part-0", "part-1"] {
        assert!(stages.join(part).join("1-mesh.ply").exists(), "{part}");
    }
}

/// A box leaves out parts, and cuts others where they are.
#[test]
fn a_box_acts_on_parts_in_their_places() {
    let (folder, scan) = folder();
    let step = folder.path().join("out.step");
    let of = |corners: &str| {
        converted(&[arg(&scan), arg(&step), "--box", corners]);
        let file = text(&step);
        ["MANIFOLD_SOLID_BREP", "NEXT_ASSEMBLY_USAGE_OCCURRENCE"].map(|entity| count(&file, entity))
    };
    assert_eq!(of("-1,-1,-1;100,100,35"), [1, 2]);
    assert_eq!(of("-1,-1,-1;100,100,100"), [2, 3]);
    assert_eq!(of("40,-1,-1;100,100,35"), [1, 1]);
}

/// A cube with a red top becomes a grey solid with a red face, alone and in an assembly.
#[test]
fn faces_have_the_colours_of_their_triangles() {
    let folder = tempfile::tempdir().expect("a folder");
    let scan = folder.path().join("cube.obj");
    let cube = |first: usize, x: f64| {
        let text = obj_box([x, 0.0, 0.0], [10.0, 20.0, 30.0], first);
        let (points, faces) = text.split_at(text.find('f').expect("faces"));
        let faces: Vec<&str> = faces.lines().collect();
        let (below, top, rest) = (faces[0], faces[1], faces[2..].join("\n"));
        format!("{points}usemtl grey\n{below}\n{rest}\nusemtl red\n{top}\n")
    };
    let colours = "newmtl grey\nKd 0.5 0.5 0.5\nnewmtl red\nKd 1 0 0\n";
    fs::write(folder.path().join("cube.mtl"), colours).expect("colours");
    for (count_of_parts, body) in
        [(1, cube(1, 0.0)), (2, format!("o a\n{}o b\n{}", cube(1, 0.0), cube(9, 50.0)))]
    {
        fs::write(&scan, format!("mtllib cube.mtl\n{body}")).expect("a scan");
        let [step, iges] = ["cube.step", "cube.igs"].map(|name| folder.path().join(name));
        converted(&[arg(&scan), arg(&step), arg(&iges)]);
        let file = text(&step);
        assert_eq!(count(&file, "STYLED_ITEM"), 2, "the body and its top");
        assert_eq!(count(&file, "MANIFOLD_SOLID_BREP"), 1);
        assert_eq!(
            count(&file, "NEXT_ASSEMBLY_USAGE_OCCURRENCE"),
            if count_of_parts == 2 { 2 } else { 0 }
        );
        let found = opencascade_assembly(&step);
        assert_eq!(found["face_colours"], 1, "{found}");
        assert_eq!(text(&iges).matches("\n     314 ").count(), 4, "two colours of two lines");
    }
}

/// Objects that differ only in their colour are one part, and the place has the colour.
#[test]
fn a_place_can_have_a_colour_of_its_own() {
    let (folder, scan) = folder();
    let step = folder.path().join("boxes.step");
    let mut lines: Vec<String> = boxes().lines().map(str::to_owned).collect();
    let right = lines.iter().position(|line| line == "o right").expect("the box");
    lines[right + 1] = "usemtl blue".into();
    fs::write(&scan, lines.join("\n")).expect("a scan");
    converted(&[arg(&scan), arg(&step)]);
    let file = text(&step);
    assert_eq!(count(&file, "MANIFOLD_SOLID_BREP"), 2);
    assert_eq!(count(&file, "OVER_RIDING_STYLED_ITEM"), 1);
    let found = opencascade_assembly(&step);
    let colour = |place: usize| {
        let of = |k: usize| found["places"][place]["colour"][k].as_f64().expect("a number").round();
        [of(0), of(1), of(2)]
    };
    assert_eq!([0, 1, 2].map(colour), [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]);
}

/// glTF's y becomes z, of a single mesh as well.
#[test]
fn up_turns_the_result() {
    let (folder, scan) = folder();
    let step = folder.path().join("boxes.step");
    converted(&[arg(&scan), arg(&step), "--up", "y"]);
    let found = opencascade_assembly(&step);
    let centre = &found["places"][2]["centre"];
    let expected = [30.0, 41.0, -10.0];
    assert!(
        (0..3).all(|k| (centre[k].as_f64().expect("a number") - expected[k]).abs() < 1e-6),
        "{centre}"
    );
    for (parts, name) in
        [("merge", "merged.step"), ("name:lid');#1", "lid.step"), ("0", "left.step")]
    {
        let step = folder.path().join(name);
        converted(&[arg(&scan), arg(&step), "--up", "y", "--parts", parts]);
        assert!(!text(&step).contains("CARTESIAN_POINT('',(10.,20.,"), "{parts}");
    }
}
