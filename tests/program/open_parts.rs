//! Clean meshes that are not closed: gaps that are closed, and shells of exact faces with free edges.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;

use crate::common::importers::opencascade_solid;
use crate::common::{arg, convert, converted, fixture, inspect, json, number};
use scan2step::formats::{Soup, read_scan};
use serde_json::{Value, json};

pub(crate) type Triangle = [[f64; 3]; 3];

/// The triangles of polygons that their first corners see as a whole.
pub(crate) fn fans(polygons: &[Vec<[f64; 3]>]) -> Vec<Triangle> {
    let fan = |p: &Vec<[f64; 3]>| (2..p.len()).map(|k| [p[0], p[k - 1], p[k]]).collect::<Vec<_>>();
    polygons.iter().flat_map(fan).collect()
}

/// The top, the bottom and the sides of a prism, each a polygon.
fn prism(outline: &[[f64; 2]], height: f64) -> Vec<Vec<[f64; 3]>> {
    let top = outline.iter().map(|&[x, y]| [x, y, height]).collect();
    let bottom = outline.iter().rev().map(|&[x, y]| [x, y, 0.0]).collect();
    let n = outline.len();
    let side = |k: usize| {
        let ([a, b], [c, d]) = (outline[k], outline[(k + 1) % n]);
        vec![[a, b, 0.0], [c, d, 0.0], [c, d, height], [a, b, height]]
    };
    [top, bottom].into_iter().chain((0..n).map(side)).collect()
}

/// Points of a circle from angle 0 on, as many for each turn.
fn circle(radius: f64, points: usize) -> Vec<[f64; 2]> {
    let angle = |k: usize| TAU * k as f64 / points as f64;
    (0..points).map(|k| [radius * angle(k).cos(), radius * angle(k).sin()]).collect()
}

fn block() -> Vec<Vec<[f64; 3]>> {
    prism(&[[0.0, 0.0], [30.0, 0.0], [30.0, 20.0], [0.0, 20.0]], 10.0)
}

/// The plate whose bore has a radius.
fn plate(radius: f64) -> Vec<Vec<[f64; 3]>> {
    crate::common::plate(&circle(radius, 32))
}

/// A cube of size 20 whose sides have six by six squares.
fn cut_cube() -> Vec<Triangle> {
    let at = |k: usize| 20.0 * k as f64 / 6.0;
    let mut all = Vec::new();
    for (axis, side) in (0..3).flat_map(|axis| [0.0, 20.0].map(|side| (axis, side))) {
        for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
            let place = |i: usize, j: usize| {
                let mut p = [side; 3];
                (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (at(i), at(j));
                p
            };
            let mut square =
                vec![place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)];
            if side == 0.0 {
                square.reverse();
            }
            all.extend(fans(&[square]));
        }
    }
    all
}

/// Writes a binary STL file.
pub(crate) fn write_stl(path: &Path, triangles: &[Triangle]) {
    let mut bytes = vec![0; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        let numbers = [[0.0; 3]].iter().chain(triangle).flatten().map(|&x| x as f32);
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    std::fs::write(path, bytes).expect("a file");
}

/// What the program said, its report, and what OpenCASCADE reads without healing.
struct Made {
    said: String,
    report: Value,
    read: Value,
}

fn made(triangles: &[Triangle], options: &[&str]) -> Made {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [scan, step, report] =
        ["part.stl", "part.step", "part.json"].map(|name| folder.path().join(name));
    write_stl(&scan, triangles);
    let files = [arg(&scan), arg(&step), "--report", arg(&report)];
    let said = converted(&[&files[..], options].concat());
    let report = json(&report);
    crate::common::assert_schema(&report);
    let read = opencascade_solid(&step);
    assert_eq!(read["valid"], true, "{said}\n{read}");
    Made { said, report, read }
}

impl Made {
    /// The number of faces of each kind that there are.
    fn kinds(&self) -> Value {
        let all = self.report["shape"]["surfaces"].as_object().expect("an object").clone();
        all.into_iter().filter(|(_, n)| *n != 0).collect::<serde_json::Map<_, _>>().into()
    }

    /// Checks that it is a solid of some kinds of faces and a volume, and how its gaps were closed.
    fn is_solid(&self, kinds: &Value, volume: f64, closed_by: &[&str]) {
        assert_eq!(self.report["shape"]["kind"], "solid", "{}", self.said);
        assert_eq!(&self.kinds(), kinds, "{}", self.said);
        let off = number(&self.read, "/volume") / volume - 1.0;
        assert!(off.abs() < 1e-6, "{off:e}: {}", self.read);
        assert_eq!(self.read["solids"], 1, "{}", self.read);
        let gaps = self.report["exact"]["gaps"].as_array().expect("a list");
        let found: Vec<&str> = gaps.iter().filter_map(|gap| gap["closed_by"].as_str()).collect();
        assert_eq!(found, closed_by, "{}", self.said);
        let said = format!("{} closed", scan2step::words::plural(closed_by.len(), "gap"));
        assert!(self.said.contains(&said), "{}", self.said);
    }

    /// Checks that it is an open shape of some kinds of faces, with so many free edges.
    fn is_open(&self, shape: &str, kinds: &Value, free: usize) {
        assert_eq!(self.report["shape"]["kind"], shape, "{}", self.said);
        assert_eq!(&self.kinds(), kinds, "{}", self.said);
        assert_eq!(self.report["shape"]["free_edges"], free, "{}", self.said);
        assert_eq!((&self.read["solids"], &self.read["shells"]), (&0.into(), &1.into()));
        assert_eq!(self.read["uses"]["1"], free, "{}", self.read);
        assert!(self.said.contains("free edge"), "{}", self.said);
        let fallbacks = self.report["exact"]["facets"].as_array().expect("a list");
        assert!(fallbacks.is_empty(), "{fallbacks:?}");
    }
}

#[test]
fn small_gaps_are_closed_on_the_faces_beside_them() {
    // One of the two triangles of a side.
    let mut triangles = fans(&block());
    triangles.remove(6);
    let made_of = made(&triangles, &[]);
    made_of.is_solid(&json!({ "plane": 6 }), 6000.0, &["extension"]);
    assert!(made_of.said.contains("closed by extending the faces beside it"), "{}", made_of.said);

    // A strip of a cylinder from rim to rim.
    let mut drum = prism(&circle(12.0, 32), 40.0);
    drum.remove(5);
    let kinds = json!({ "plane": 2, "cylinder": 1 });
    made(&fans(&drum), &[]).is_solid(&kinds, PI * 144.0 * 40.0, &["extension"]);
}

#[test]
fn a_missing_corner_is_where_the_faces_meet() {
    let mut triangles = cut_cube();
    triangles.retain(|triangle| !triangle.contains(&[20.0; 3]));
    let made = made(&triangles, &[]);
    made.is_solid(&json!({ "plane": 6 }), 8000.0, &["extension"]);
    assert_eq!(made.report["exact"]["gaps"][0]["added_vertices"], 1);
}

#[test]
fn a_bracket_with_some_triangles_less_is_the_same() {
    let Soup { points, polygons, .. } = read_scan(&fixture("bracket.stl")).expect("a mesh");
    let all = polygons.iter().map(|t| [t[0], t[1], t[2]].map(|v| points[v as usize]));
    let all: Vec<Triangle> = all.collect();
    let whole = made(&all, &[]);
    // Triangles that do not touch each other, each on its own place.
    let some: Vec<Triangle> =
        all.iter().enumerate().filter(|(k, _)| k % 300 != 7).map(|of| *of.1).collect();
    let part = made(&some, &[]);
    let volume = number(&whole.read, "/volume");
    part.is_solid(&whole.kinds(), volume, &vec!["extension"; all.len() - some.len()]);
}

#[test]
fn a_box_without_its_lid_is_a_shell_or_gets_a_lid() {
    let open = fans(&block()[1..]);
    made(&open, &[]).is_open("shell", &json!({ "plane": 5 }), 4);
    made(&open, &["--shape", "solid"]).is_solid(&json!({ "plane": 6 }), 6000.0, &["plane"]);
}

#[test]
fn free_edges_are_as_exact_as_others() {
    let drum = prism(&circle(12.0, 32), 40.0);
    let cylinder = json!({ "cylinder": 1 });
    // Without its caps a drum has two circles.
    made(&fans(&drum[2..]), &[]).is_open("shell", &cylinder, 2);
    // Half of its skin has two arcs and two lines.
    made(&fans(&drum[2..18]), &[]).is_open("face", &cylinder, 4);
    // A rim that is not flat is one of arcs.
    let saddle = |[x, y, z]: [f64; 3]| [x, y, z + if z > 0.0 { 0.02 * x * x } else { 0.0 }];
    let bent = fans(&drum[2..]).iter().map(|t| t.map(saddle)).collect::<Vec<_>>();
    made(&bent, &[]).is_open("shell", &cylinder, 33);
    // A sheet with two round ends.
    let end = |centre: f64, from: f64| {
        let angle = move |k: usize| from + PI * k as f64 / 12.0;
        (0..=12).map(move |k| [centre + 6.0 * angle(k).cos(), 6.0 * angle(k).sin()])
    };
    let slot: Vec<[f64; 2]> = end(20.0, -FRAC_PI_2).chain(end(-20.0, FRAC_PI_2)).collect();
    made(&fans(&prism(&slot, 8.0)[..1]), &[]).is_open("face", &json!({ "plane": 1 }), 4);
}

#[test]
fn a_bore_without_its_wall_is_open_or_gets_its_wall() {
    let plate = fans(&plate(9.0));
    let open = &plate[..plate.len() - 64];
    made(open, &[]).is_open("shell", &json!({ "plane": 6 }), 2);
    let kinds = json!({ "plane": 6, "cylinder": 1 });
    let volume = 8.0 * (2400.0 - 81.0 * PI);
    made(open, &["--shape", "solid"]).is_solid(&kinds, volume, &["bore", "bore"]);
}

/// A sheet is no solid, and nothing that is wrong is made of it in silence.
#[test]
fn fills_that_would_lie_on_the_mesh_are_refused() {
    let cube = cut_cube();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [scan, step] = ["sheet.stl", "sheet.step"].map(|name| folder.path().join(name));
    write_stl(&scan, &cube[cube.len() - 72..]);
    let output = convert(&[arg(&scan), arg(&step), "--shape", "solid"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    // Neither exact faces nor B-splines make a solid of it.
    assert!(said.contains("would lie on the faces beside it"), "{said}");
    assert!(said.contains("would enclose no volume"), "{said}");
}

#[test]
fn edges_may_be_sharp_from_an_angle_on_or_nowhere() {
    let drum = fans(&prism(&circle(12.0, 32), 40.0));
    let round = json!({ "plane": 2, "cylinder": 1 });
    for (edges, kinds) in [("auto", &round), ("20", &round), ("10", &json!({ "plane": 34 }))] {
        let made = made(&drum, &["--edges", edges]);
        assert_eq!(&made.kinds(), kinds, "--edges {edges}: {}", made.said);
        let expected = edges.parse::<f64>().map_or(json!(edges), |degrees| json!(degrees));
        assert_eq!(made.report["options"]["edges"], expected);
    }
    let off = made(&drum, &["--edges", "off"]);
    assert!(off.kinds()["spline"].as_u64().is_some_and(|n| n > 0), "{}", off.said);
    assert!(off.said.contains("--edges off leaves no sharp edges"), "{}", off.said);
    let wrong = convert(&["part.stl", "part.step", "--edges", "180"]);
    assert_eq!(wrong.status.code(), Some(2));
}

#[test]
fn inspect_tells_what_an_open_part_becomes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scan = folder.path().join("open.stl");
    write_stl(&scan, &fans(&block()[1..]));
    let told = inspect(&[arg(&scan)]);
    let told = String::from_utf8_lossy(&told.stdout).into_owned();
    assert!(told.contains("a shell of 5 faces: 5 planes"), "{told}");
}
