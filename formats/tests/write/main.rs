//! The files that the STEP and IGES writers write.

mod assembly;
mod bodies;
mod exact;
mod exact_solids;
mod iges;
mod model;
mod schema;
mod solids;
mod step;

use std::fs;
use std::path::PathBuf;

use formats::Brep;
use formats::brep::{BrepCurve, BrepSurface};
use formats::iges::{self as iges_format, Form};
use formats::step::{self as step_format, Schema};

fn step_file(brep: &Brep, schema: Schema) -> String {
    let options = step_format::Options { schema, ..Default::default() };
    let mut out = Vec::new();
    step_format::write(brep, &options, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

fn iges_file(brep: &Brep, form: Form) -> String {
    let options = iges_format::Options { form, file_name: "bump.igs".into(), ..Default::default() };
    let mut out = Vec::new();
    iges_format::write(brep, &options, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

/// The model must satisfy its own promise. Otherwise the other tests would test nothing.
#[test]
fn edges_lie_on_the_surface() {
    let brep = model::two_faces("");
    for face in &brep.faces {
        let BrepSurface::Spline(surface) = &brep.surfaces[face.surface.0] else { panic!() };
        for of_loop in face.loops.iter().flatten() {
            let BrepCurve::Spline(curve) = &brep.edges[of_loop.edge.0].curve else { panic!() };
            for t in (0..=20).map(|i| f64::from(i) / 20.0) {
                let [u, v] = of_loop.pcurve.point(t);
                let (p, q) = (curve.point(t), surface.point(u, v));
                assert!((p[0] - q[0]).hypot(p[1] - q[1]).hypot(p[2] - q[2]) < 1e-10);
            }
        }
    }
}

/// Writes every kind of file to the directory `SCAN2STEP_WRITE_TO`, where the checks in
/// tests/roundtrip can read them. Without this variable it does nothing.
#[test]
fn example_files() {
    let Some(directory) = std::env::var_os("SCAN2STEP_WRITE_TO").map(PathBuf::from) else {
        return;
    };
    for (brep, _) in exact::all_exact() {
        let stem = &brep.name;
        fs::write(directory.join(format!("{stem}.step")), step_file(&brep, Schema::Ap242)).unwrap();
        for (end, form) in [("144.igs", Form::Trimmed), ("186.igs", Form::Brep)] {
            fs::write(directory.join(format!("{stem}-{end}")), iges_file(&brep, form)).unwrap();
        }
    }
    fs::write(directory.join("assembly.step"), assembly::file(Schema::Ap242)).unwrap();
    fs::write(directory.join("assembly-ap203.step"), assembly::file(Schema::Ap203)).unwrap();
    for (stem, brep) in [
        ("sheet", model::one_face("Größe 'A' 😀")),
        ("pair", model::two_faces("pair")),
        ("inverted", model::inverted("inverted")),
    ] {
        for (end, schema) in [
            ("ap203.step", Schema::Ap203),
            ("ap214.step", Schema::Ap214),
            ("ap242.step", Schema::Ap242),
        ] {
            fs::write(directory.join(format!("{stem}-{end}")), step_file(&brep, schema)).unwrap();
        }
        for (end, form) in [("144.igs", Form::Trimmed), ("514.igs", Form::Brep)] {
            fs::write(directory.join(format!("{stem}-{end}")), iges_file(&brep, form)).unwrap();
        }
    }
}
