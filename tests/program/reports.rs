//! `--report`: the schema of the figures, the page, the picture.

use std::path::{Path, PathBuf};

use crate::common::{arg, convert, converted, fixture, json, root};
use jsonschema::Validator;
use serde_json::Value;

fn schema() -> Validator {
    let schema = json(&root().join("docs/report.schema.json"));
    jsonschema::draft202012::new(&schema).expect("the schema is one")
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// The report of a conversion with some options.
fn report(scan: &Path, options: &[&str]) -> Value {
    let folder = folder();
    let (step, report) = (folder.path().join("a.step"), folder.path().join("a.json"));
    let output = convert(&[&[arg(scan), arg(&step), "--report", arg(&report)], options].concat());
    assert!(matches!(output.status.code(), Some(0 | 3)), "{options:?}: {output:?}");
    json(&report)
}

/// A scan of two sheets, one of which is a little larger.
fn two_sheets(folder: &Path) -> PathBuf {
    let mut text = String::new();
    for (n, x) in [(6, 0.0), (5, 100.0)] {
        for k in 0..n * n {
            text += &format!("v {} {} 0\n", x + f64::from(k / n), k % n);
        }
    }
    for (n, first) in [(6, 1), (5, 37)] {
        for k in 0..(n - 1) * (n - 1) {
            let at = |i: i32, j: i32| first + (k / (n - 1) + i) * n + k % (n - 1) + j;
            text += &format!("f {} {} {} {}\n", at(0, 0), at(1, 0), at(1, 1), at(0, 1));
        }
    }
    let path = folder.join("two.obj");
    std::fs::write(&path, text).expect("a file");
    path
}

#[test]
fn reports_are_as_the_schema_has_them() {
    let schema = schema();
    let (relief, folder) = (fixture("relief.ply"), folder());
    let two = two_sheets(folder.path());
    let cases: [(&Path, &[&str]); 9] = [
        (&relief, &[]),
        (&relief, &["--tolerance", "0.2", "--units", "cm", "--outliers", "1"]),
        (&relief, &["--tolerance", "0.000001", "--max-net", "400", "--smooth", "off"]),
        (&relief, &["--keep-fills", "--net", "9x8", "--fit", "blend", "--iges", "brep"]),
        (&relief, &["--fill-only-holes-below", "60", "--fit", "global", "--schema", "ap203"]),
        (&relief, &["--kappa", "0.1", "--depth", "3", "--smooth", "4", "--outer", "0"]),
        (&relief, &["--boundary-corners", "none", "--corners", "0,0,0;99,0,0;99,99,0;0,99,0"]),
        (&two, &["--component", "all"]),
        (&two, &["--component", "1", "--boundary-corners", "37,41"]),
    ];
    for (scan, options) in cases {
        let report = report(scan, options);
        let wrong: Vec<String> =
            schema.iter_errors(&report).map(|e| format!("{}: {e}", e.instance_path())).collect();
        assert!(wrong.is_empty(), "{options:?}: {wrong:#?}");
    }
    let named = report(&relief, &["--net", "9x8"]);
    // A given net has no κ, and no knot is repeated.
    assert_eq!(named["fit"]["kappa_mm"], Value::Null);
    assert_eq!(named["fit"]["places"], 6 * 6 * (9 - 3) * (8 - 3));
    let all = report(&two, &["--component", "all"]);
    assert_eq!(all["components"].as_array().map(Vec::len), Some(2));
}

/// Every object in a value with its path.
fn objects(value: &Value, way: &str, found: &mut Vec<String>) {
    match value {
        Value::Object(fields) => {
            found.push(way.to_owned());
            fields.iter().for_each(|(key, v)| objects(v, &format!("{way}/{key}"), found));
        }
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(k, v)| objects(v, &format!("{way}/{k}"), found));
        }
        _ => {}
    }
}

#[test]
fn the_schema_refuses_a_missing_key_and_one_with_another_name() {
    let schema = schema();
    let whole = report(&fixture("relief.ply"), &[]);
    let mut ways = Vec::new();
    objects(&whole, "", &mut ways);
    let mut tried = 0;
    for way in ways.iter().filter(|way| !way.ends_with("/repairs")) {
        let fields = whole.pointer(way).and_then(Value::as_object).expect("an object");
        for key in fields.keys().filter(|key| !["hole", "island"].contains(&key.as_str())) {
            let mut broken = whole.clone();
            let object = broken.pointer_mut(way).and_then(Value::as_object_mut).expect("an object");
            let value = object.remove(key).expect("the key");
            assert!(!schema.is_valid(&broken), "{way}/{key} is missed");
            let object = broken.pointer_mut(way).and_then(Value::as_object_mut).expect("an object");
            object.insert(format!("{key}_"), value);
            assert!(!schema.is_valid(&broken), "{way}/{key} by another name");
            tried += 1;
        }
    }
    assert!(tried > 80, "{tried}");
    for (way, wrong) in [
        ("/tolerance_mm", Value::from("0.1")),
        ("/fit/net", Value::from(vec![9])),
        ("/input/units", Value::from("furlong")),
        ("/outputs/0/sha256", Value::from("no")),
        ("/fit/within_pct", Value::from(101)),
    ] {
        let mut broken = whole.clone();
        *broken.pointer_mut(way).expect(way) = wrong;
        assert!(!schema.is_valid(&broken), "{way}");
    }
}

/// The page and the picture of a scan in their own folder.
fn page_and_picture(scan: &Path, options: &[&str]) -> (String, Vec<u8>) {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let (step, page, picture) = (path("a.step"), path("a.html"), path("a.png"));
    let files = [arg(scan), arg(&step), "--report", arg(&page), "--report", arg(&picture)];
    converted(&[&files, options].concat());
    let page = std::fs::read_to_string(page).expect("the page");
    (page, std::fs::read(picture).expect("the picture"))
}

/// A page without its table of times, which is the only part that may differ between runs.
fn without_times(page: &str) -> String {
    let (front, rest) = page.split_once("id=\"times\"").expect("the table of times");
    let (_, back) = rest.split_once("</section>").expect("its end");
    format!("{front}{back}")
}

#[test]
fn pages_and_pictures_are_the_same_in_any_folder_on_any_number_of_threads() {
    let relief = fixture("relief.ply");
    let (page, picture) = page_and_picture(&relief, &["--threads", "1"]);
    let (again, same) = page_and_picture(&relief, &["--threads", "3"]);
    assert!(without_times(&page) == without_times(&again), "the pages differ");
    assert!(picture == same, "the pictures differ");
}

#[test]
fn a_page_needs_nothing_but_itself() {
    let (page, _) = page_and_picture(&fixture("relief.ply"), &[]);
    for reach in ["http://", "https://", "src=\"/", "@import", "url(", "fetch(", "XMLHttpRequest"] {
        assert!(!page.contains(reach), "{reach}");
    }
    assert!(page.contains("default-src 'none'"), "nothing may be loaded");
    // The content that is visible without scripts.
    for words in ["<svg class=\"plane\"", "<svg class=\"histogram", "cut out", "data:image/png"] {
        assert!(page.contains(words), "{words}");
    }
}

#[test]
fn what_the_user_names_is_text() {
    let folder = folder();
    let scan = folder.path().join(crate::common::PLANTED);
    std::fs::copy(fixture("relief.ply"), &scan).expect("a copy");
    let (page, picture) = page_and_picture(&scan, &[]);
    assert!(page.contains("&lt;img src=x onerror=planted=1&gt;"));
    assert!(!page.contains("<img src=x") && page.matches("<script").count() == 2);
    assert!(!picture.is_empty());
}

/// The colours of a still picture, row by row.
fn pixels(picture: Vec<u8>) -> Vec<u8> {
    let mut reader =
        png::Decoder::new(std::io::Cursor::new(picture)).read_info().expect("it is a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut pixels).expect("it is whole");
    assert_eq!((info.width, info.height), (1600, 1000));
    pixels
}

#[test]
fn all_components_are_in_one_picture_and_on_one_page() {
    let folder = folder();
    let two = two_sheets(folder.path());
    // The columns of the large picture that are not empty.
    let drawn = |component: &str| {
        // Flat sheets are exact planes, which have no map.
        let options = ["--component", component, "--surfaces", "spline"];
        let (page, picture) = page_and_picture(&two, &options);
        let pixels = pixels(picture);
        let column = |x: usize| {
            let mut down = (140..990).map(|y| &pixels[3 * (1600 * y + x)..][..3]);
            down.any(|p| p != [0xf6, 0xf7, 0xf8])
        };
        let drawn: Vec<usize> = (0..1000).filter(|&x| column(x)).collect();
        (page.matches("<svg class=\"plane\"").count(), drawn)
    };
    let (planes, both) = drawn("all");
    assert_eq!(planes, 2);
    let gap = both.windows(2).map(|w| w[1] - w[0]).max().expect("columns");
    assert!(gap > 500, "the sheets are 95 mm from each other, and 5 wide: {gap}");
    let (planes, one) = drawn("0");
    assert_eq!(planes, 1);
    assert!(one.windows(2).all(|w| w[1] == w[0] + 1), "one sheet is one piece");
}

/// A sheet of 30 × 20 squares with a small hole and then a large one.
fn two_holes(folder: &Path) -> PathBuf {
    let mut text = String::new();
    for (i, j) in (0..=30).flat_map(|i| (0..=20).map(move |j| (i, j))) {
        text += &format!("v {i} {j} {}\n", 0.01 * f64::from(i * i));
    }
    let is_hole = |i: i32, j: i32| {
        (4..6).contains(&i) && (4..6).contains(&j) || (15..22).contains(&i) && (6..14).contains(&j)
    };
    for (i, j) in
        (0..30).flat_map(|i| (0..20).map(move |j| (i, j))).filter(|&(i, j)| !is_hole(i, j))
    {
        let at = |i: i32, j: i32| 21 * i + j + 1;
        let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        text += &format!("f {} {} {} {}\n", corners[0], corners[1], corners[2], corners[3]);
    }
    let path = folder.join("holes.obj");
    std::fs::write(&path, text).expect("a file");
    path
}

#[test]
fn the_page_lists_holes_as_inspect_does() {
    let folder = folder();
    let scan = two_holes(folder.path());
    let output = crate::common::inspect(&[arg(&scan)]);
    let said = String::from_utf8(output.stdout).expect("text");
    let lines = said.lines().filter_map(|line| line.trim().strip_prefix("hole "));
    let listed: Vec<&str> = lines.filter_map(|line| line.split([',', ' ']).rev().nth(1)).collect();
    assert_eq!(listed, ["30", "8"], "vertices: {said}");
    let (page, _) = page_and_picture(&scan, &[]);
    let (_, table) = page.split_once("id=\"holes-0\"").expect("the table of holes");
    let (table, _) = table.split_once("</table>").expect("its end");
    let places: Vec<usize> = ["<td>30</td>", "<td>8</td>"]
        .iter()
        .map(|count| table.find(count).unwrap_or_else(|| panic!("{count}: {table}")))
        .collect();
    assert!(places[0] < places[1], "{table}");
    // The number stays that of the list in the JSON report.
    let holes = report(&scan, &[])["fill"]["holes"].clone();
    let first = usize::from(holes[0]["rim_vertices"] == 8);
    assert!(table.contains(&format!("<th scope=\"row\">{first}</th><td>")), "{table}");
    let (_, after) = table.split_once("data-hole=\"0-").expect("a row");
    assert!(after.starts_with(&first.to_string()), "{table}");
}

#[test]
fn a_page_says_how_large_the_object_is_and_how_it_was_made() {
    let folder = folder();
    let scan = two_holes(folder.path());
    let options = ["--units", "cm", "--box=-1,-1,-1;40,40,40", "--threads", "1", "--quiet"];
    let figures = report(&scan, &options);
    let command: Vec<&str> =
        figures["command"].as_array().expect("words").iter().filter_map(Value::as_str).collect();
    assert_eq!(command[..3], ["scan2step", "convert", arg(&scan)]);
    // The last ones are the options that steer the result, and the report.
    assert_eq!(command[4..6], ["--units=cm", "--box=-1,-1,-1;40,40,40"]);
    assert!(command[6].starts_with("--report=/") && command.len() == 7, "{command:?}");
    let [low, high] = [0, 1].map(|end| &figures["input"]["bounds_mm"][end]);
    assert_eq!(
        (low, high),
        (&serde_json::json!([0.0, 0.0, 0.0]), &serde_json::json!([300.0, 200.0, 90.0]))
    );

    let (page, _) = page_and_picture(&scan, &options);
    let area = figures["shape"]["area_mm2"].as_f64().expect("an area");
    // 540 of 600 squares of 1 cm, a little bent.
    assert!((54_000.0..60_000.0).contains(&area), "{area}");
    let area = format!("{area:.0}");
    for words in [
        "300.0 × 200.0 × 90.00 mm",
        "from (0.000, 0.000, 0.000) to (300.000, 200.000, 90.000)",
        &format!("{},{} mm²", &area[..2], &area[2..]),
        "<td>cm <small>this page and the CAD files have mm</small></td>",
        "<span>scan2step</span> <span>convert</span> <span>holes.obj</span> <span>a.step</span> \
         <span>--units=cm</span> <span>&#x27;--box=-1,-1,-1;40,40,40&#x27;</span> \
         <span>--report=a.html</span> <span>--report=a.png</span>",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert!(!page.contains(arg(folder.path())), "the page tells the folder of the scan");
}

#[test]
fn a_picture_shows_the_scan_in_the_colours_of_the_scale() {
    let (_, picture) = page_and_picture(&fixture("relief.ply"), &[]);
    let pixels = pixels(picture);
    let counted = |is: fn(&[u8]) -> bool| pixels.chunks(3).filter(|p| is(p)).count();
    assert!(counted(|p| p[0] > p[2].saturating_add(30)) > 20_000, "above");
    assert!(counted(|p| p[2] > p[0].saturating_add(30)) > 20_000, "below");
    assert!(counted(|p| p == [0xf6, 0xf7, 0xf8]) > 400_000, "background");
}

#[test]
fn a_scan_too_large_for_a_browser_is_thinned_and_the_page_says_so() {
    let folder = folder();
    let scan = crate::common::large_scan(folder.path());
    let (page, _) = page_and_picture(&scan, &[]);
    let (_, note) = page.split_once("Drawn with ").expect("the page says so");
    let drawn: String =
        note.split(" of the").next().unwrap_or("").chars().filter(char::is_ascii_digit).collect();
    let drawn: usize = drawn.parse().expect("a number");
    assert!(drawn <= 300_000 && drawn > 100_000, "{drawn}");
    assert!(note.contains("of the scan's 720,000 triangles"), "{}", &note[..80]);
}
