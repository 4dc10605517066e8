//! The types of `scan2step::report`: what the library says of a conversion is what the program
//! writes.

mod common;

use std::path::Path;

use common::fixture;
use formats::{LengthUnit, Soup};
use jsonschema::Validator;
use scan2step::report::{OutputFile, Report, ScanSource, Settings};
use scan2step::{Builder, Conversion, Options, convert};
use serde_json::Value;

fn schema() -> Validator {
    let schema = common::json(&common::root().join("docs/report.schema.json"));
    jsonschema::draft202012::new(&schema).expect("the schema is one")
}

fn relief() -> Soup {
    formats::read_scan(&fixture("relief.ply")).expect("a scan")
}

/// The report of a conversion of a scan with some options.
fn report(file: &Path, soup: &Soup, options: &Options) -> Report {
    let conversion = convert(soup, options, &mut |_| Ok(())).expect("a face");
    report_of(&conversion, file, soup, options)
}

fn report_of(made: &Conversion, file: &Path, soup: &Soup, options: &Options) -> Report {
    let source = ScanSource::of(file.display().to_string(), soup, options);
    Report::of(made, &source, Settings::of(options, &source))
}

fn built(options: Builder) -> Options {
    options.build().expect("sound options")
}

#[test]
fn a_report_of_the_library_is_as_the_schema_has_it() {
    let (schema, soup) = (schema(), relief());
    let options = built(Options::builder().unit(LengthUnit::Centimetre).tolerance(0.5).net([9, 8]));
    let mut report = report(Path::new("relief.ply"), &soup, &options);
    let whole = |report: &Report| -> Value {
        serde_json::from_str(&report.to_json()).expect("the text is JSON")
    };
    // Only the caller knows what was written.
    assert!(!schema.is_valid(&whole(&report)));
    let sha256 = "0".repeat(64);
    report.outputs.push(OutputFile { file: "relief.step".into(), bytes: 1, sha256 });
    let value = whole(&report);
    let wrong: Vec<String> = schema.iter_errors(&value).map(|e| e.to_string()).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert_eq!(value["input"]["units"], "cm");
    assert_eq!(value["fit"]["net"], serde_json::json!([9, 8]));
    assert_eq!(value["options"]["tolerance"], 0.5);
    assert_eq!(value["fit"]["max_mm"], report.bodies[0].fit.deviation.max_mm);
    assert!(value.get("components").is_none() && value.get("faces").is_none());
}

#[test]
fn several_faces_stand_in_a_list_and_the_first_one_beside() {
    let mut soup = Soup::default();
    for (first, n, x) in [(0, 6, 0.0), (36, 5, 100.0)] {
        for k in 0..n * n {
            soup.points.push([x + f64::from(k / n), f64::from(k % n), 0.0]);
        }
        for (i, j) in (0..n - 1).flat_map(|i| (0..n - 1).map(move |j| (i, j))) {
            let a = first + i * n + j;
            soup.polygons.push([a, a + n, a + n + 1, a + 1]);
        }
    }
    let options = Options::default();
    let report = report(Path::new("two.obj"), &soup, &options);
    // One component would leave out a large part of the scan, as the default option does.
    assert!(report.hints.iter().any(|hint| hint.contains("--component all")), "{report:?}");
    let options = built(Options::builder().all_components(true));
    let report = self::report(Path::new("two.obj"), &soup, &options);
    assert!(report.hints.iter().all(|hint| !hint.contains("--component all")), "{report:?}");
    let value: Value = serde_json::from_str(&report.to_json()).expect("JSON");
    assert_eq!(value["components"].as_array().map(Vec::len), Some(2));
    assert_eq!(value["components"][0]["input"], value["input"]);
    assert_eq!(value["components"][1]["input"]["vertices"], 25);
    assert_eq!(value["options"]["component"], "all");
}

/// Fills in what only the run of the program knows: its command, its times and its files.
#[cfg(feature = "cli")]
fn fill_in(report: &mut Report, program: &Value) {
    use scan2step::report::StageFigures;

    let number = |value: &Value| value.as_f64().expect("a number");
    let text = |value: &Value| value.as_str().expect("text").to_owned();
    report.seconds = number(&program["seconds"]);
    report.peak_rss_mb = number(&program["peak_rss_mb"]);
    let words = program["command"].as_array().expect("a command").iter();
    report.command = words.map(text).collect();
    let stages = program["stages"].as_array().expect("stages").iter();
    report.stages = stages
        .map(|stage| StageFigures {
            name: text(&stage["name"]),
            seconds: number(&stage["seconds"]),
            peak_rss_mb: number(&stage["peak_rss_mb"]),
        })
        .collect();
    let outputs = program["outputs"].as_array().expect("outputs").iter();
    report.outputs = outputs
        .map(|file| OutputFile {
            file: text(&file["file"]),
            bytes: file["bytes"].as_u64().expect("a length"),
            sha256: text(&file["sha256"]),
        })
        .collect();
}

#[cfg(feature = "cli")]
#[test]
fn the_library_and_the_program_write_the_same_bytes() {
    use scan2step::stages::{fit, parameterize, smooth};
    use scan2step::{Cut, ScanPlace};

    let (scan, soup) = (fixture("relief.ply"), relief());
    let places = |vertices: [usize; 4]| vertices.map(ScanPlace::Vertex).to_vec();
    let point = ScanPlace::Point([1.5, 0.0, 2.0]);
    let new = Options::builder;
    let cases: [(&[&str], Builder); 5] = [
        (&[], new()),
        (
            &["--tolerance", "0.2", "--units", "cm", "--outliers", "50", "--outline", "trimmed"],
            new()
                .tolerance(0.2)
                .unit(LengthUnit::Centimetre)
                .outliers(0.5)
                .outline(parameterize::Outline::Free),
        ),
        (
            &["--keep-fills", "--net", "9x8", "--fit", "blend", "--map", "mean-value"],
            new()
                .cut(Cut::None)
                .net([9, 8])
                .fit(fit::Method::Blend)
                .map(parameterize::MapMethod::MeanValue),
        ),
        (
            &["--kappa", "0.1", "--depth", "3", "--smooth", "4", "--fill-only-holes-below", "60"],
            new()
                .kappa(0.1)
                .depth(3_u32)
                .smooth(smooth::Support::Fixed(4.0))
                .cut(Cut::FromLength(60.0)),
        ),
        (
            &[
                "--corners",
                "0,40,1000,2000",
                "--boundary-corners",
                "1.5,0,2;1.5,0,2",
                "--outer",
                "0",
            ],
            new()
                .corner_places(places([0, 40, 1000, 2000]))
                .boundary_corner_places(vec![point, point])
                .outer_place(ScanPlace::Vertex(0)),
        ),
    ];
    for (arguments, options) in cases {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = |name: &str| folder.path().join(name);
        let (step, json) = (file("a.step"), file("a.json"));
        let named = [common::arg(&scan), common::arg(&step), "--report", common::arg(&json)];
        let output = common::convert(&[&named, arguments].concat());
        assert!(matches!(output.status.code(), Some(0 | 3)), "{arguments:?}: {output:?}");
        let written = std::fs::read_to_string(&json).expect("a report");
        let mut report = report(&scan, &soup, &built(options.name("relief")));
        fill_in(&mut report, &serde_json::from_str(&written).expect("JSON"));
        assert!(report.to_json() == written, "{arguments:?}:\n{}\n{written}", report.to_json());
    }
}
