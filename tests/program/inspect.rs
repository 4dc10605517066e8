//! `scan2step inspect`, and the repairs of faulty meshes. Each case is a small mesh with one fault.

use std::fmt::Write;

use crate::common::{arg, fixture, inspect, inspected};
use serde_json::{Value, json};

/// A mesh as text.
#[derive(Clone, Default)]
struct Obj {
    text: String,
    vertices: usize,
}

impl Obj {
    fn vertex(&mut self, x: f64, y: f64, z: f64) -> usize {
        writeln!(self.text, "v {x} {y} {z}").expect("text grows");
        self.vertices += 1;
        self.vertices
    }

    fn face(&mut self, corners: &[usize]) {
        let corners: Vec<String> = corners.iter().map(usize::to_string).collect();
        writeln!(self.text, "f {}", corners.join(" ")).expect("text grows");
    }

    /// Adds a sheet of n × n squares in a plane of height z and returns the number of its first
    /// vertex. Each square has two triangles. Squares for which `hole` is true are omitted.
    fn sheet(&mut self, n: usize, z: f64, hole: impl Fn(usize, usize) -> bool) -> usize {
        let first = self.vertices + 1;
        for i in 0..(n + 1) * (n + 1) {
            self.vertex((i % (n + 1)) as f64, (i / (n + 1)) as f64, z);
        }
        for (x, y) in (0..n * n).map(|i| (i % n, i / n)).filter(|&(x, y)| !hole(x, y)) {
            let a = first + y * (n + 1) + x;
            self.face(&[a, a + 1, a + n + 2]);
            self.face(&[a, a + n + 2, a + n + 1]);
        }
        first
    }

    /// Adds a torus of m × n squares. If `klein`, it is reversed once on its way around, so that it
    /// is a Klein bottle.
    fn tube(&mut self, m: usize, n: usize) {
        let first = self.vertices + 1;
        for (i, j) in (0..m * n).map(|k| (k / n, k % n)) {
            let [a, b] =
                [i as f64 / m as f64, j as f64 / n as f64].map(|t| t * std::f64::consts::TAU);
            let r = 10.0 + 3.0 * b.cos();
            self.vertex(r * a.cos(), r * a.sin(), 3.0 * b.sin());
        }
        for (i, j) in (0..m * n).map(|k| (k / n, k % n)) {
            let at = |i: usize, j: usize| first + i % m * n + j % n;
            self.face(&[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }

    /// The output of `inspect --json`.
    fn inspected(&self) -> Value {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("scan.obj");
        std::fs::write(&path, &self.text).expect("the scan is written");
        inspected(&path)
    }
}

fn solid(_: usize, _: usize) -> bool {
    false
}

/// Compares the components, the boundary loops, the genus and whether the mesh is a disk with holes
/// with `expected`.
#[track_caller]
fn is(found: &Value, expected: (usize, usize, f64, bool)) {
    let (components, loops, genus, disk) = expected;
    assert_eq!(found["components"], components, "components of {found}");
    assert_eq!(found["boundary_loops"], loops, "loops of {found}");
    assert_eq!(found["genus"].as_f64(), Some(genus), "genus of {found}");
    assert_eq!(found["disk"], disk, "{found}");
}

#[track_caller]
fn repaired(found: &Value, kinds: &[(&str, usize)]) {
    let expected: serde_json::Map<String, Value> =
        kinds.iter().map(|&(kind, n)| (kind.into(), json!(n))).collect();
    assert_eq!(found["repairs"], Value::Object(expected));
}

#[test]
fn a_sound_scan_needs_little_repair() {
    let found = inspected(&fixture("relief.ply"));
    is(&found, (1, 3, 0.0, true));
    repaired(&found, &[("rim_triangles_trimmed", 3)]);
    assert_eq!(found["shape"], "face");
    assert_eq!(found["units"], "mm");
    assert_eq!(found["units_assumed"], true);
    assert_eq!(found["file_vertices"], found["vertices"]);
    assert_eq!(found["file_triangles"], found["triangles"]);
    let noise = found["noise_mm"].as_f64().expect("a number");
    assert!((0.01..0.2).contains(&noise), "{noise}");
    let outer = |l: &&Value| l["outer"] == true;
    let loops = found["loops"].as_array().expect("a list");
    let longest = loops.iter().max_by(|a, b| length(a).total_cmp(&length(b)));
    assert_eq!(loops.iter().filter(outer).collect::<Vec<_>>(), [longest.expect("a loop")]);
}

fn length(ring: &Value) -> f64 {
    ring["length_mm"].as_f64().expect("a number")
}

#[test]
fn text_says_the_same() {
    let output = inspect(&[arg(&fixture("relief.ply"))]);
    let said = String::from_utf8_lossy(&output.stdout);
    for words in [
        "mm (assumed",
        "a disk with 2 holes",
        "becomes     a face, as it is one sheet (--shape to change)",
        "tolerance   about 0.18",
        "three times the noise of 0.0",
        "outline     the four sides of the face",
        "size        100.3 × 80.2",
        "repaired    3 triangles trimmed off ragged rims",
        "outer loop",
        "hole  ",
        "noise",
        "the only one",
    ] {
        assert!(said.contains(words), "{words} in {said}");
    }
}

#[test]
fn corners_of_their_own_are_welded() {
    let mut scan = Obj::default();
    for (x, y) in [(0., 0.), (1., 0.), (0., 1.), (1., 1.)] {
        let ring = [(x, y), (x + 1., y), (x + 1., y + 1.), (x, y + 1.)];
        let corners = ring.map(|(x, y)| scan.vertex(x, y, -0.0 * x));
        scan.face(&corners[..3]);
        scan.face(&[corners[0], corners[2], corners[3]]);
    }
    let found = scan.inspected();
    is(&found, (1, 1, 0.0, true));
    repaired(&found, &[("welded_vertices", 7)]);
    assert_eq!((&found["file_vertices"], &found["vertices"]), (&json!(16), &json!(9)));
}

#[test]
fn polygons_are_cut_up_within_their_outline() {
    let mut scan = Obj::default();
    let u = [(0., 0.), (6., 0.), (6., 5.), (4., 5.), (4., 2.), (2., 2.), (2., 5.), (0., 5.)];
    let corners = u.map(|(x, y)| scan.vertex(x, 0.25 * x, y));
    scan.face(&corners);
    let found = scan.inspected();
    is(&found, (1, 1, 0.0, true));
    repaired(&found, &[("polygons_triangulated", 1)]);
    assert_eq!(found["triangles"], 6);
    // The perimeter in the slanted plane. No triangle bridges the notch.
    let along = |dx: f64| dx * (1.0f64 + 0.25 * 0.25).sqrt();
    let perimeter = 2.0 * along(6.0) + 5.0 * 2.0 + 3.0 * 2.0;
    assert!((length(&found["loops"][0]) - perimeter).abs() < 1e-9, "{found}");
}

#[test]
fn useless_faces_and_vertices_go() {
    let mut scan = Obj::default();
    scan.sheet(3, 0.0, solid);
    scan.face(&[1, 2, 6]);
    scan.face(&[6, 2, 1]);
    scan.face(&[1, 1, 2]);
    let nowhere = scan.vertices + 1;
    scan.text += "v nan 0 0\n";
    scan.vertices += 1;
    scan.face(&[1, 2, nowhere]);
    scan.vertex(99.0, 99.0, 99.0);
    let found = scan.inspected();
    is(&found, (1, 1, 0.0, true));
    repaired(
        &found,
        &[
            ("duplicate_faces", 2),
            ("degenerate_faces", 1),
            ("non_finite_vertices", 1),
            ("faces_with_non_finite_vertices", 1),
            ("unused_vertices", 1),
        ],
    );
}

#[test]
fn triangles_without_area_are_flipped_away() {
    let mut scan = Obj::default();
    let square = [(0., 0.), (2., 0.), (2., 2.), (0., 2.), (1., 0.), (1., -1.)];
    let [a, b, c, d, middle, low] = square.map(|(x, y)| scan.vertex(x, y, 0.0));
    for face in [[a, b, c], [a, c, d], [b, a, middle], [a, low, middle], [middle, low, b]] {
        scan.face(&face);
    }
    let found = scan.inspected();
    is(&found, (1, 1, 0.0, true));
    repaired(&found, &[("degenerate_faces", 1)]);
    assert_eq!(found["triangles"], 5);
}

#[test]
fn faces_are_turned_to_agree() {
    let mut scan = Obj::default();
    scan.sheet(3, 0.0, solid);
    let turned = scan.text.replace("f 1 2 6", "f 2 1 6").replace("f 6 11 10", "f 11 6 10");
    let found = Obj { text: turned, ..scan }.inspected();
    is(&found, (1, 1, 0.0, true));
    repaired(&found, &[("flipped_faces", 2)]);
}

#[test]
fn a_fin_is_cut_off_and_the_sheet_stays_whole() {
    let mut scan = Obj::default();
    scan.sheet(9, 0.0, solid);
    let tip = scan.vertex(4.5, 4.0, 1.0);
    scan.face(&[45, 46, tip]);
    let found = scan.inspected();
    is(&found, (2, 1, 0.0, true));
    assert_eq!(found["triangles"], 162);
    repaired(&found, &[("dust_components", 1), ("opened_edges", 1), ("opened_vertices", 2)]);
}

#[test]
fn sheets_that_meet_in_an_edge_come_apart() {
    let mut scan = Obj::default();
    scan.sheet(4, 0.0, solid);
    // A sheet upright through an edge in the middle of the first one.
    let row = |scan: &mut Obj, y: f64, z: f64| [0., 1., 2., 3.].map(|x| scan.vertex(x, y, z));
    let (low, high) = (row(&mut scan, 2.5, -1.0), row(&mut scan, 2.5, 1.0));
    let [left, right] = [0., 3.].map(|x| scan.vertex(x, 2.5, 0.0));
    let middle = [left, 12, 13, right];
    for (below, above) in [(low, middle), (middle, high)] {
        for k in 0..3 {
            scan.face(&[below[k], below[k + 1], above[k + 1], above[k]]);
        }
    }
    let found = scan.inspected();
    is(&found, (2, 1, 0.0, true));
    assert_eq!(found["triangles"], 32);
}

#[test]
fn a_vertex_in_which_two_sheets_meet_is_opened() {
    let mut scan = Obj::default();
    scan.sheet(2, 0.0, |x, y| x != y);
    let found = scan.inspected();
    is(&found, (2, 1, 0.0, true));
    repaired(&found, &[("opened_vertices", 1), ("unused_vertices", 2)]);
}

#[test]
fn holes_that_touch_have_one_rim() {
    let mut scan = Obj::default();
    scan.sheet(6, 0.0, |x, y| (x, y) == (2, 2) || (x, y) == (3, 3));
    let found = scan.inspected();
    // After it is opened, the shared vertex joins the two rims to one.
    is(&found, (1, 2, 0.0, true));
    assert_eq!(found["repairs"]["opened_vertices"], 1);
}

#[test]
fn spikes_go_and_leave_no_hole() {
    let mut scan = Obj::default();
    scan.sheet(9, 0.0, solid);
    let spiked = scan.text.replace("v 4 4 0", "v 4 4 70").replace("v 7 2 0", "v 7 2 -50");
    let found = Obj { text: spiked, ..scan }.inspected();
    is(&found, (1, 1, 0.0, true));
    repaired(&found, &[("spikes_dropped", 2), ("unused_vertices", 2)]);
    assert_eq!(found["bounds_mm"], json!([[0.0, 0.0, 0.0], [9.0, 9.0, 0.0]]));
}

#[test]
fn dust_is_counted() {
    let mut scan = Obj::default();
    scan.sheet(20, 0.0, solid);
    scan.sheet(12, 5.0, solid);
    for height in 10..13 {
        scan.sheet(1, f64::from(height), solid);
    }
    let found = scan.inspected();
    is(&found, (5, 1, 0.0, true));
    repaired(&found, &[("dust_components", 3)]);
    assert_eq!(found["left_out_triangles"], 2 * 144 + 6);
}

#[test]
fn surfaces_that_are_no_disk_are_named() {
    let mut torus = Obj::default();
    torus.tube(12, 8);
    // Warped: a torus would be one exact face, in which handles are no repairs.
    let warped = |line: &str| {
        let Some(place) = line.strip_prefix("v ") else { return format!("{line}\n") };
        let p: Vec<f64> = place.split(' ').map(|x| x.parse().expect("a number")).collect();
        format!("v {} {} {}\n", p[0], p[1], p[2] + 0.2 * (7.0 * p[0] + 3.0 * p[1]).sin())
    };
    torus.text = torus.text.lines().map(warped).collect();
    let found = torus.inspected();
    is(&found, (1, 0, 1.0, false));
    assert_eq!(found["shape"], "solid");

    // The tube has a radius of 3.
    let handle = &found["handles"].as_array().expect("a list of handles")[0];
    assert_eq!(found["handles"].as_array().map(Vec::len), Some(1), "{found}");
    let length = handle["length_mm"].as_f64().expect("a length");
    assert!((12.0..30.0).contains(&length), "{handle}");
    let [x, y] = [0, 1].map(|k| handle["at"][k].as_f64().expect("a coordinate"));
    assert!((x.hypot(y) - 10.0).abs() < 2.0, "{handle}");
    let faces = found["faces_about"].as_u64().expect("a number of faces");
    assert!((8..40).contains(&faces), "{found}");

    let mut handle = torus.clone();
    handle.text = handle.text.replacen("f 1 9 10 2\n", "", 1);
    let found = handle.inspected();
    is(&found, (1, 1, 1.0, false));
    assert_eq!(found["shape"], "solid", "the gap is small");

    let mut strip = Obj::default();
    let n = 16;
    for (i, side) in (0..2 * n).map(|k| (k / 2, k % 2)) {
        let a = std::f64::consts::TAU * i as f64 / n as f64;
        let w = if side == 0 { -0.3 } else { 0.3 };
        let r = 1.0 + w * (a / 2.0).cos();
        strip.vertex(r * a.cos(), r * a.sin(), w * (a / 2.0).sin());
    }
    for i in 0..n {
        let (a, b) = (2 * i + 1, 2 * i + 2);
        let (c, d) = if i + 1 < n { (a + 2, b + 2) } else { (2, 1) };
        strip.face(&[a, c, d, b]);
    }
    let found = strip.inspected();
    is(&found, (1, 1, 0.5, false));
    assert_eq!(found["orientable"], false);
    assert_eq!(found["shape"], Value::Null);
}

#[test]
fn the_user_may_name_the_outer_loop_and_the_piece() {
    let mut scan = Obj::default();
    // A slot whose rim is longer than the outer boundary, with the teeth of a comb.
    let first = scan.sheet(12, 0.0, |x, y| {
        (1..11).contains(&x) && (y == 1 || x % 2 == 1 && (2..11).contains(&y))
    });
    scan.sheet(4, 9.0, solid);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scan.obj");
    std::fs::write(&path, &scan.text).expect("the scan is written");
    let outer_length = |args: &[&str]| {
        let output = inspect(&[&[arg(&path), "--json"], args].concat());
        let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let loops = found["loops"].as_array().expect("a list").clone();
        loops.iter().filter(|l| l["outer"] == true).map(length).sum::<f64>()
    };
    assert_eq!(outer_length(&[]), 48.0);
    assert!(outer_length(&["--outer", "1.0,1.0,0.0"]) > 60.0);
    assert_eq!(outer_length(&["--outer", &(first - 1).to_string()]), 48.0);
    for point in ["-0.5,0.0,0.0", "-1,0,0", "0,0,0"] {
        assert_eq!(outer_length(&["--outer", point]), 48.0, "{point}");
    }
    assert_eq!(outer_length(&["--component", "1"]), 16.0);
    assert_eq!(inspect(&[arg(&path), "--component", "2"]).status.code(), Some(1));
    assert_eq!(inspect(&[arg(&path), "--component", "all"]).status.code(), Some(2));
}

#[test]
fn a_triangle_can_become_a_face() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scan.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("the scan is written");
    let said = inspect(&[arg(&path)]).stdout;
    assert!(String::from_utf8_lossy(&said).contains("a disk without holes"));
    let mut square = Obj::default();
    let corners = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(x, y)| square.vertex(x, y, 0.0));
    square.face(&corners);
    std::fs::write(&path, square.text).expect("the scan is written");
    let said = inspect(&[arg(&path)]).stdout;
    assert!(String::from_utf8_lossy(&said).contains("a disk without holes"));
}

#[test]
fn what_has_no_usable_triangle_is_refused() {
    let mut line = Obj::default();
    let corners = [0., 1., 2., 3.].map(|x| line.vertex(x, 0.0, 0.0));
    line.face(&corners[..3]);
    line.face(&corners[1..]);
    let mut point = Obj::default();
    let corners = [0; 3].map(|_| point.vertex(1.0, 2.0, 3.0));
    point.face(&corners);
    for scan in [line, point] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("scan.obj");
        std::fs::write(&path, &scan.text).expect("the scan is written");
        let output = inspect(&[arg(&path)]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("no usable triangle") && said.contains("\nhelp: "), "{said}");
    }
}

#[test]
fn pieces_are_listed_with_what_they_are() {
    let mut scan = Obj::default();
    scan.tube(40, 20);
    scan.sheet(12, 50.0, |x, y| (3..5).contains(&x) && (3..5).contains(&y));
    // A piece with few of the triangles is taken in another way.
    scan.sheet(5, 300.0, solid);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scan.obj");
    std::fs::write(&path, &scan.text).expect("the scan is written");
    let found = inspected(&path);
    let pieces = found["pieces"].as_array().expect("a list of pieces");
    let told: Vec<_> = pieces.iter().map(|p| [&p["triangles"], &p["loops"], &p["genus"]]).collect();
    let expected = [[1600, 0, 1], [280, 2, 0], [50, 1, 0]].map(|all| all.map(|x| json!(x)));
    assert_eq!(told, expected.each_ref().map(|all| all.each_ref()));
    assert_eq!((&found["component"], &pieces[1]["size_mm"][0]), (&json!(0), &json!(12.0)));
    assert_eq!(pieces[2]["size_mm"][0], json!(5.0));
    let output = inspect(&[arg(&path), "--component", "2"]);
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("outer loop  20.00 mm"), "{said}");
    let output = inspect(&[arg(&path), "--component", "1"]);
    let said = String::from_utf8_lossy(&output.stdout);
    for words in ["number 1 of 3, where 0 is the largest", "--component 0", "12.00 × 12.00 × 0 mm"]
    {
        assert!(said.contains(words), "{words} in {said}");
    }
}

/// The size suggests the unit of a scan that declares none.
#[test]
fn the_likely_unit_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let scan = folder.path().join("a.obj");
    let sized = |size: f64| {
        let mut text = String::new();
        for i in 0..36 {
            let [x, y] = [i % 6, i / 6].map(|k| size * f64::from(k) / 5.0);
            writeln!(text, "v {x} {y} 0").expect("text grows");
        }
        for i in (0..30).filter(|i| i % 6 < 5).map(|i| i + 1) {
            writeln!(text, "f {} {} {} {}", i, i + 1, i + 7, i + 6).expect("text grows");
        }
        std::fs::write(&scan, text).expect("a file");
        let said = inspect(&[arg(&scan)]);
        (
            inspected(&scan)["likely_units"].clone(),
            String::from_utf8_lossy(&said.stdout).into_owned(),
        )
    };
    let (units, said) = sized(0.2);
    assert_eq!(units, json!(["m"]));
    let hint = "0.2828 mm across if its numbers are mm; more likely they are m (282.8 mm); name";
    let words = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains(hint), "{said}");
    assert_eq!(sized(200.0).0, json!([]));
    assert_eq!(sized(200_000.0).0, json!(["um"]));
    // A thing of two inches, of two centimetres, or of two metres.
    assert_eq!(sized(2.0).0, json!(["in", "cm", "m"]));
}

#[test]
fn one_thing_is_no_plural() {
    let folder = tempfile::tempdir().expect("a folder");
    let scan = folder.path().join("a.obj");
    std::fs::write(&scan, "v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n").expect("a file");
    let said = String::from_utf8_lossy(&inspect(&[arg(&scan)]).stdout).into_owned();
    assert!(said.contains("  file        3 vertices, 1 triangle\n"), "{said}");
    assert!(!said.contains("1 triangles") && !said.contains("1 vertices"), "{said}");
}

/// The text fits on a terminal of 80 columns.
#[test]
fn text_fits_on_a_terminal() {
    for name in ["relief.ply", "relief.xyz", "ring.obj", "rolled_sheet.obj"] {
        let output = inspect(&[arg(&fixture(name))]);
        // The first line is the path.
        for line in String::from_utf8_lossy(&output.stdout).lines().skip(1) {
            assert!(line.chars().count() < 80, "{line}");
        }
    }
}
