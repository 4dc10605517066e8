//! `convert_file`: a file is converted to a file, or there is an error that names it.

use crate::common::fixture;
use scan2step::{Options, TargetShape, convert_file};

/// The names of the files in a folder.
fn names(folder: &std::path::Path) -> Vec<String> {
    let names = folder.read_dir().expect("a folder");
    names.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
}

#[test]
fn a_file_becomes_a_file() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let options = Options::builder().tolerance(0.5).build().expect("options");
    for (name, mark) in [("a.step", "ISO-10303-21;\n"), ("b.IGS", "S      1\n")] {
        let out = folder.path().join(name);
        std::fs::write(&out, "an older one").expect("written");
        let conversion = convert_file(fixture("relief.ply"), &out, &options).expect("a face");
        assert!(conversion.bodies().all(|body| body.tolerance_met(0.0)));
        let text = std::fs::read_to_string(&out).expect("text");
        assert!(text.contains(mark) && text.len() > 10_000, "{name}");
    }
    assert_eq!(names(folder.path()).len(), 2, "nothing else is left");
}

#[test]
fn a_closed_scan_becomes_the_solid_that_the_program_makes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("ring.step");
    let made = convert_file(fixture("ring.obj"), &out, &Options::default()).expect("a solid");
    let shapes: Vec<_> = made.bodies().map(|body| body.shape).collect();
    assert_eq!(shapes, [TargetShape::Solid]);
    let text = std::fs::read_to_string(&out).expect("text");
    assert!(text.contains("MANIFOLD_SOLID_BREP"));
}

#[test]
fn an_error_names_the_file_and_leaves_none() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let empty = folder.path().join("empty.obj");
    std::fs::write(&empty, "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 2\n").expect("written");
    let options = Options::default();
    let failed = |scan: &std::path::Path, out: &str| {
        let out = folder.path().join(out);
        let error = convert_file(scan, &out, &options).expect_err("no face");
        assert!(!out.exists() && names(folder.path()) == ["empty.obj"]);
        assert!(!error.help().is_empty());
        error.to_string()
    };
    assert!(failed(&empty, "a.step").contains("empty.obj: no usable triangle"));
    assert!(failed(&empty, "a.dxf").contains("a.dxf: not .step"));
    assert!(failed(&folder.path().join("none.ply"), "a.step").contains("none.ply"));
    let nowhere = failed(&fixture("relief.ply"), "none/a.step");
    assert!(nowhere.contains("a.step: cannot be written"), "{nowhere}");
}
