//! Solids that are built by hand: written, read back, and imported by OpenCASCADE and FreeCAD.

mod common;

// The models are those of the writers' own tests.
#[path = "../formats/tests/write/bodies.rs"]
mod bodies;
#[allow(dead_code)]
#[path = "../formats/tests/write/model.rs"]
mod model;

use common::importers::{freecad_solid, opencascade_solid};
use common::number;
use formats::Brep;
use formats::cad::read_cad;
use formats::{iges, step};
use std::fs::File;
use std::path::{Path, PathBuf};

/// Writes a model as STEP and as IGES.
fn files(folder: &Path, brep: &Brep) -> [PathBuf; 2] {
    let [step_path, iges_path] =
        ["step", "igs"].map(|end| folder.join("solid").with_extension(end));
    let mut out = File::create(&step_path).expect("a temporary file");
    step::write(brep, &step::Options::default(), &mut out).expect("it is sound");
    let mut out = File::create(&iges_path).expect("a temporary file");
    let options = iges::Options { form: iges::Form::Brep, ..Default::default() };
    iges::write(brep, &options, &mut out).expect("it is sound");
    [step_path, iges_path]
}

#[test]
fn opencascade_finds_them_valid_without_healing() {
    for (name, brep, volume) in bodies::all() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for path in files(folder.path(), &brep) {
            let found = opencascade_solid(&path);
            let counts = [
                ("solids", brep.solids.len()),
                ("shells", brep.shells.len()),
                ("faces", brep.faces.len()),
                ("edges", brep.edges.len()),
                ("vertices", brep.vertices.len()),
            ];
            for (part, count) in counts {
                assert_eq!(found[part], count, "{part} of {name} in {found}");
            }
            assert_eq!(found["valid"], true, "{name}: {found}");
            assert_eq!(found["uses"], serde_json::json!({ "2": brep.edges.len() }), "{name}");
            assert_eq!(found["argument_faults"], serde_json::json!([]), "{name}");
            let off = (number(&found, "/volume") - volume).abs();
            assert!(off < 1e-9 * volume, "{name}: {found} instead of {volume}");
        }
    }
}

#[test]
fn freecad_cuts_and_rounds_them() {
    for (name, brep, volume) in bodies::all() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let [path, _] = files(folder.path(), &brep);
        let Some(found) = freecad_solid(&path) else { return };
        assert_eq!(found["solids"], brep.solids.len(), "{name}: {found}");
        assert_eq!(found["valid"], true, "{name}: {found}");
        assert_eq!(found["check"], serde_json::Value::Null, "{name}: {found}");
        assert!((number(&found, "/volume") - volume).abs() < 1e-3 * volume, "{name}: {found}");
        assert_eq!(found["cut_valid"], true, "{name}: {found}");
        let (cut, rounded) = (number(&found, "/cut_volume"), number(&found, "/fillet_volume"));
        assert!(cut > 0.1 * volume && cut < 0.9 * volume, "{name}: {found}");
        assert!(rounded < cut && rounded > 0.9 * cut, "{name}: {found}");
    }
}

#[test]
fn our_own_readers_read_them_back() {
    for (name, brep, _) in bodies::all() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for path in files(folder.path(), &brep) {
            let model = read_cad(&path).expect("it is a file of ours");
            assert_eq!(model.faces.len(), brep.faces.len(), "{name}");
            assert!(model.shells.iter().all(|shell| shell.closed), "{name}");
            let shells: Vec<usize> = model.shells.iter().map(|shell| shell.faces.len()).collect();
            let written: Vec<usize> = brep.shells.iter().map(|shell| shell.faces.len()).collect();
            assert_eq!(shells, written, "{name}");
            let solids = model.solids.iter().map(|solid| (solid.outer, solid.voids.len()));
            let written = brep.solids.iter().map(|solid| (solid.outer.0, solid.voids.len()));
            assert!(solids.eq(written), "{name}");
        }
    }
}
