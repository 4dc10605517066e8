//! The page of the report in a real browser without a window.

mod common;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use common::{arg, converted, fixture, root};
use serde_json::Value;

/// The first of several programs that exists.
fn program(names: &[&str], what: &str) -> PathBuf {
    let places = std::env::var_os("PATH").unwrap_or_default();
    let own = root().join("target/browser");
    let folders: Vec<PathBuf> =
        std::iter::once(own).chain(std::env::split_paths(&places)).collect();
    let found = names.iter().flat_map(|name| folders.iter().map(move |f| f.join(name)));
    let found = found.into_iter().find(|path| path.is_file());
    found.unwrap_or_else(|| panic!("{what} is absent; tests/run installs it"))
}

/// The visible parts of a report, and its screenshots.
struct Looked {
    said: Value,
    shots: tempfile::TempDir,
}

impl Looked {
    fn at(scan: &Path, options: &[&str]) -> Looked {
        let shots = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| shots.path().join(name);
        let (step, page) = (path("a.step"), path("a.html"));
        converted(&[&[arg(scan), arg(&step), "--report", arg(&page)], options].concat());
        let chromium = program(&["chromium", "chrome", "google-chrome"], "Chromium");
        let driver = program(&["chromedriver"], "Chromium's driver");
        let mut look = Command::new("/usr/bin/python3");
        look.arg("-B").arg(root().join("tests/browser/look.py"));
        look.args([&chromium, &driver, &page]).arg(shots.path());
        let output = look.output().expect("Python runs");
        let wrong = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "look.py: {wrong}");
        let said = serde_json::from_slice(&output.stdout).expect("look.py prints JSON");
        Looked { said, shots }
    }

    /// The pixels of a screenshot.
    fn shot(&self, name: &str) -> Vec<[u8; 3]> {
        let file = self.shots.path().join(format!("{name}.png"));
        let file = std::io::BufReader::new(std::fs::File::open(file).expect("the screenshot"));
        let mut reader = png::Decoder::new(file).read_info().expect("it is a PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut pixels).expect("it is whole");
        let samples = info.color_type.samples();
        pixels.chunks(samples).map(|p| [p[0], p[1], p[2]]).collect()
    }

    /// The share of pixels that differ between two screenshots.
    fn changed(&self, one: &str, two: &str) -> f64 {
        let (one, two) = (self.shot(one), self.shot(two));
        assert_eq!(one.len(), two.len());
        let far = |(a, b): &(&[u8; 3], &[u8; 3])| (0..3).any(|k| a[k].abs_diff(b[k]) > 8);
        one.iter().zip(&two).filter(far).count() as f64 / one.len() as f64
    }

    /// The share of pixels of a screenshot that satisfy a condition.
    fn share(&self, name: &str, is: fn([u8; 3]) -> bool) -> f64 {
        let pixels = self.shot(name);
        pixels.iter().filter(|p| is(**p)).count() as f64 / pixels.len() as f64
    }
}

/// Several tests look at the same page.
static RELIEF: LazyLock<Looked> =
    LazyLock::new(|| Looked::at(&fixture("relief.ply"), &["--units", "mm"]));

fn is_red([r, _, b]: [u8; 3]) -> bool {
    r > b.saturating_add(30)
}

fn is_blue([r, _, b]: [u8; 3]) -> bool {
    b > r.saturating_add(30)
}

fn is_dark([r, g, b]: [u8; 3]) -> bool {
    r < 60 && g < 60 && b < 60
}

#[test]
fn a_page_renders_turns_and_says_no_error() {
    let looked = &*RELIEF;
    let said = &looked.said;
    assert_eq!(said["console"], Value::Array(Vec::new()), "the console says nothing");
    assert_eq!(said["requests"], Value::Array(Vec::new()), "nothing is loaded");
    assert_eq!(said["live"], true);
    assert_eq!(said["heading"], "relief.ply");
    assert_eq!((&said["holes"], &said["loops"]), (&Value::from(2), &Value::from(2)));
    assert_eq!(said["histograms"], 1, "one of the four is shown");
    assert_eq!(said["wide"], false, "the page fits the window");
    let readouts = said["readouts"].as_array().expect("readouts");
    assert!(readouts.iter().any(|r| r.as_str().is_some_and(|r| r.ends_with(" mm"))), "{said}");

    assert!(looked.share("front", is_red) > 0.02 && looked.share("front", is_blue) > 0.02);
    for (one, two) in [
        ("front", "turned"),
        ("turned", "near"),
        ("reset", "touched"),
        ("front", "distance"),
        ("distance", "smoothed"),
        ("smoothed", "face"),
        ("face", "net"),
        ("face", "curvature"),
        ("curvature", "zebra"),
        ("front", "hole"),
    ] {
        let changed = looked.changed(one, two);
        // The rim of a hole and a net consist only of lines.
        assert!(changed > 0.002, "{one} and {two} differ in {changed} of their pixels");
    }
    assert!(looked.changed("front", "turned") > 0.1);
    assert!(looked.changed("front", "reset") < 0.001, "the view comes back");
}

/// The texts of a list.
fn texts(list: &Value) -> Vec<&str> {
    list.as_array().expect("a list").iter().map(|text| text.as_str().expect("text")).collect()
}

#[test]
fn a_page_is_whole_on_a_desktop_and_on_a_telephone() {
    let looked = Looked::at(&fixture("ring.obj"), &[]);
    let clipped = looked.said["clipped"].as_object().expect("sizes");
    assert_eq!(clipped.len(), 6);
    for (size, parts) in clipped {
        assert_eq!(texts(parts), Vec::<&str>::new(), "{size}");
    }
    let curvature = looked.said["curvature"].as_str().expect("a text");
    let end = curvature
        .strip_prefix("Mean curvature: colours from −")
        .and_then(|s| s.split_once(" to +"));
    let end =
        end.filter(|(low, high)| high.strip_suffix(" 1/mm") == Some(*low)).expect(curvature).0;
    // The ring is about 30 mm thick, so that it has a curvature of some hundredths.
    let end: f64 = end.parse().expect(curvature);
    assert!((0.03..0.3).contains(&end), "{curvature}");
    // The stripes of the faces are dark and bright, and their tints are neither.
    assert!(looked.share("zebra", is_dark) > looked.share("face", is_dark) + 0.02);
    assert_eq!(looked.said["console"], Value::Array(Vec::new()));
}

#[test]
fn a_keyboard_and_a_screen_reader_reach_every_figure() {
    let looked = &*RELIEF;
    let said = &looked.said;
    assert_eq!(texts(&said["unnamed"]), Vec::<&str>::new());
    let keys = &said["keys"];
    let stops = keys["stops"].as_array().expect("stops");
    let is_stop = |name: &str| stops.iter().any(|stop| stop[0] == name);
    for name in [
        "theme",
        "view",
        "show-face",
        "colours",
        "face-colours",
        "front",
        "bottom",
        "nearer",
        "range",
        "0-0",
        "0-7",
        "Holes",
        "copy",
    ] {
        assert!(is_stop(name), "{name}: {stops:?}");
    }
    for stop in stops {
        assert_eq!(stop[1], true, "no line shows the focus at {}", stop[0]);
    }
    assert!(looked.changed("keys-before", "keys-turned") > 0.05);
    let sides = ["front", "back", "left", "right", "top", "bottom"];
    let told: Vec<String> = sides.iter().map(|side| format!("Seen from: {side}")).collect();
    assert_eq!(texts(&keys["sides"])[..6], told);
    assert_eq!(keys["sides"][6], "Overview");
    for (one, two) in [("side-1", "side-2"), ("side-3", "side-4"), ("side-5", "side-6")] {
        assert!(looked.changed(one, two) > 0.005, "{one} and {two} look alike");
    }
    let middle = keys["middle"].as_str().expect("text");
    assert!(middle.starts_with("Deviation in the middle of the view: "), "{middle}");
    let worst = said["worst"].as_str().and_then(|worst| worst.strip_prefix("worst: "));
    let pinned = keys["pinned"].as_str().expect("text");
    assert_eq!(Some(pinned.trim_start_matches(['+', '−'])), worst, "the first place is the worst");
    assert_eq!(said["command"], "scan2step convert relief.ply a.step --units=mm --report=a.html");
    assert_ne!(said["copied"], "Copy the command");
}

#[test]
fn a_page_is_light_or_dark_as_the_system_or_its_button_says() {
    let looked = &*RELIEF;
    assert!(looked.share("front", is_dark) < 0.05);
    assert!(looked.share("dark", is_dark) > 0.4);
    assert!(looked.share("light-again", is_dark) < 0.05);
    assert_eq!(looked.said["still"], true, "without WebGL there is a still picture");
}

#[test]
fn a_name_that_is_a_program_does_not_run() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scan = folder.path().join(common::PLANTED);
    std::fs::copy(fixture("relief.ply"), &scan).expect("a copy");
    let looked = Looked::at(&scan, &["--keep-fills"]);
    assert_eq!(looked.said["heading"], common::PLANTED);
    assert_eq!(looked.said["unplanted"], true, "it did not run");
    assert_eq!(looked.said["console"], Value::Array(Vec::new()));
}
