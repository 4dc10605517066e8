//! Files of the 3MF consortium, made assemblies, and attacks.

use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

use formats::scene::{NodeContent, NodeId};
use formats::{Scene, read_scene};

use crate::support::assemblies;

/// The files in a folder of the collection, in the order of their names.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    files.sort();
    files
}

/// Valid files without a mesh: beam lattices.
const NO_MESH: [&str; 2] = ["pyramid.3mf", "variable_voronoi.3mf"];

#[test]
fn files_of_the_consortium() {
    let Some(folder) = assemblies() else {
        eprintln!("SKIPPED: the collected assemblies (../../shared/assemblies) are not there");
        return;
    };
    let mut wrong = Vec::new();
    for path in files(&folder.join("3mf")) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let read = read_scene(&path);
        let verdict = match &read {
            Ok(scene) if name.starts_with("MUSTFAIL") && scene.notes.is_empty() => {
                "read in silence"
            }
            Ok(_) if NO_MESH.contains(&&*name) => "read without a mesh",
            Err(e) if !name.starts_with("MUSTFAIL") && !NO_MESH.contains(&&*name) => &e.to_string(),
            _ => continue,
        };
        wrong.push(format!("{name}: {verdict}"));
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// Attacks that do not concern shapes, so that the tetrahedron in the file is read.
const HARMLESS: [&str; 4] =
    ["entry_name_64k.3mf", "name_1mb.3mf", "xyz_extra_attr.3mf", "xyz_nsattr.3mf"];

#[test]
fn attacks_are_errors() {
    let Some(folder) = assemblies() else {
        eprintln!("SKIPPED: the collected assemblies (../../shared/assemblies) are not there");
        return;
    };
    let mut wrong = Vec::new();
    for path in files(&folder.join("attack")) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let Ok(read) = catch_unwind(|| read_scene(&path)) else {
            wrong.push(format!("{name}: panics"));
            continue;
        };
        let is_whole = |scene: &Scene| {
            let soup = &scene.meshes()[0].soup;
            (soup.points.len(), soup.polygons.len()) == (4, 4) && soup.points[1] == [1., 0., 0.]
        };
        match read {
            Ok(scene) if HARMLESS.contains(&&*name) && is_whole(&scene) => {}
            Err(_) if !HARMLESS.contains(&&*name) => {}
            Ok(_) => wrong.push(format!("{name}: read")),
            Err(e) => wrong.push(e.to_string()),
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// A row of a table of places: path of names, product, volume in mm³, centre in mm, colour.
struct Row {
    path: String,
    product: String,
    volume: f64,
    centre: [f64; 3],
    colour: [u8; 3],
}

fn rows(table: &Path) -> Vec<Row> {
    let text = fs::read_to_string(table).expect("a table");
    let row = |line: &str| {
        let cells: Vec<&str> = line.split('\t').collect();
        let number = |at: usize| cells[at].parse::<f64>().expect("a number");
        Row {
            path: cells[0].to_owned(),
            product: cells[2].to_owned(),
            volume: number(3),
            centre: [4, 5, 6].map(number),
            colour: [7, 8, 9].map(|at| (255.0 * number(at)).round() as u8),
        }
    };
    text.lines().skip(1).map(row).collect()
}

/// The volume and the centre of mass of a mesh.
fn mass(points: &[[f64; 3]], polygons: &formats::soup::Polygons) -> (f64, [f64; 3]) {
    let (mut volume, mut moment) = (0.0, [0.0; 3]);
    for polygon in polygons.iter() {
        let corners: Vec<[f64; 3]> = polygon.iter().map(|&at| points[at as usize]).collect();
        for at in 2..corners.len() {
            let [a, b, c] = [corners[0], corners[at - 1], corners[at]];
            let cross =
                [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
            let part = (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0;
            volume += part;
            moment = [0, 1, 2].map(|k| moment[k] + part * (a[k] + b[k] + c[k]) / 4.0);
        }
    }
    (volume, moment.map(|x| x / volume))
}

/// The volume and the centre of each place.
fn masses(scene: &Scene) -> Vec<(f64, [f64; 3])> {
    let places = scene.nodes().iter().zip(scene.places());
    let of = |(node, place): (&formats::scene::SceneNode, formats::scene::Placement)| {
        let NodeContent::Form(form) = node.content else { return None };
        let mesh = scene.form_mesh(form);
        let points: Vec<[f64; 3]> = mesh.soup.points.iter().map(|p| place.apply(*p)).collect();
        Some(mass(&points, &mesh.soup.polygons))
    };
    places.filter_map(of).collect()
}

/// The differences between the places of a scene and the table. Names of places inside of groups are in glTF only.
fn differences(scene: &Scene, rows: &[Row], is_gltf: bool) -> Vec<String> {
    let mm = scene.unit.map_or(1.0, formats::LengthUnit::in_mm);
    let (places, nodes) = (scene.places(), scene.nodes());
    let mut wrong = Vec::new();
    let found: Vec<usize> =
        (0..nodes.len()).filter(|&n| nodes[n].content != NodeContent::Group).collect();
    if found.len() != rows.len() {
        return vec![format!("{} places, not {}", found.len(), rows.len())];
    }
    for (node, row) in found.into_iter().zip(rows) {
        let NodeContent::Form(form) = nodes[node].content else { continue };
        let mesh = scene.form_mesh(form);
        let points: Vec<[f64; 3]> =
            mesh.soup.points.iter().map(|p| places[node].apply(*p).map(|x| mm * x)).collect();
        let (volume, [x, y, z]) = mass(&points, &mesh.soup.polygons);
        let centre = if is_gltf { [x, -z, y] } else { [x, y, z] };
        let off = (0..3).map(|k| (centre[k] - row.centre[k]).powi(2)).sum::<f64>().sqrt();
        // The meshes have a chord error of 0.1 mm on parts of some 10 mm.
        if off > 0.1 || (volume / row.volume - 1.0).abs() > 0.02 {
            wrong.push(format!("{}: off by {off}, volume {volume}, not {}", row.path, row.volume));
        }
        // Half of a step may be rounded up or down.
        let is_near = |colour: [u8; 3]| (0..3).all(|k| colour[k].abs_diff(row.colour[k]) <= 1);
        if !mesh.colour.is_some_and(is_near)
            || mesh.name.as_deref().unwrap_or_default() != row.product
        {
            wrong.push(format!(
                "{}: {:?} {:?}, not {:?}",
                row.path, mesh.name, mesh.colour, row.colour
            ));
        }
        let name = nodes[node].name.as_deref().unwrap_or_default();
        let outer = nodes[node].parent.and_then(|NodeId(parent)| nodes[parent].name.clone());
        let names: Vec<&str> = row.path.split(" / ").collect();
        let expected = names.last().copied().unwrap_or_default();
        // Without a name of its own, a place has that of its product in glTF, and a dash in 3MF.
        let expected = match (expected, is_gltf) {
            ("", true) => row.product.as_str(),
            ("", false) => "-",
            (expected, _) => expected,
        };
        let is_inner = names.len() > 2;
        let of_group = if is_inner { outer == Some(names[1].to_owned()) } else { true };
        if !of_group || (is_gltf || !is_inner) && name != expected {
            wrong.push(format!("{} is {name} in {outer:?}", row.path));
        }
    }
    wrong
}

#[test]
fn made_assemblies_have_all_places() {
    let Some(folder) = assemblies() else {
        eprintln!("SKIPPED: the collected assemblies (../../shared/assemblies) are not there");
        return;
    };
    let mut wrong = Vec::new();
    for name in ["bolted", "bracket", "drive", "hotend"] {
        let file = |extension: &str| folder.join("made").join(format!("{name}.{extension}"));
        let rows = rows(&file("tsv"));
        let mut kinds: Vec<&str> = rows.iter().map(|row| row.product.as_str()).collect();
        kinds.sort_unstable();
        kinds.dedup();
        for extension in ["glb", "3mf"] {
            let scene = read_scene(&file(extension)).unwrap_or_else(|e| panic!("{e}"));
            let title = format!("{name}.{extension}");
            if scene.forms().len() != kinds.len() {
                wrong.push(format!(
                    "{title}: {} forms of {} products",
                    scene.forms().len(),
                    kinds.len()
                ));
            }
            let found = differences(&scene, &rows, extension == "glb");
            wrong.extend(found.into_iter().map(|text| format!("{title}: {text}")));
        }
        let obj = read_scene(&file("obj")).unwrap_or_else(|e| panic!("{e}"));
        let obj = obj.split_groups().expect("groups");
        if obj.forms().len() != kinds.len() {
            wrong.push(format!(
                "{name}.obj: {} forms of {} products",
                obj.forms().len(),
                kinds.len()
            ));
        }
        let names: Vec<_> =
            obj.nodes().iter().map(|node| node.name.clone().unwrap_or_default()).collect();
        let expected =
            rows.iter().map(|row| row.path.split_once(" / ").map_or("", |(_, name)| name));
        let expected: Vec<_> =
            expected.map(|name| if name.is_empty() { "x" } else { name }).collect();
        if names != expected {
            wrong.push(format!("{name}.obj: {names:?}, not {expected:?}"));
        }
        for (place, row) in masses(&obj).into_iter().zip(&rows) {
            let off = (0..3).map(|k| (place.1[k] - row.centre[k]).powi(2)).sum::<f64>().sqrt();
            if off > 0.1 || (place.0 / row.volume - 1.0).abs() > 0.02 {
                wrong.push(format!("{name}.obj: {} is off by {off}", row.path));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}
