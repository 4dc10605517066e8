//! Reading of STEP and IGES files: our own files, and files in the style of other programs.

mod assembly;
#[allow(dead_code)]
#[path = "../write/bodies.rs"]
mod bodies;
mod broken;
#[allow(dead_code)]
#[path = "../write/exact.rs"]
mod exact;
mod exact_read;
mod foreign;
#[allow(dead_code)]
#[path = "../write/model.rs"]
mod model;

use std::path::Path;

use formats::brep::{BrepCurve, BrepSurface};
use formats::cad::{CadModel, CadSurface, CurveShape, read_cad_from};
use formats::iges::{self, Form};
use formats::step::{self, Schema};
use formats::{Brep, Result};

fn step_file(brep: &Brep) -> String {
    let options = step::Options { schema: Schema::Ap242, ..Default::default() };
    let mut out = Vec::new();
    step::write(brep, &options, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

fn iges_file(brep: &Brep, form: Form) -> String {
    let mut out = Vec::new();
    iges::write(brep, &iges::Options { form, ..Default::default() }, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

fn read(text: &str) -> Result<CadModel> {
    read_cad_from(Path::new("part"), text.as_bytes())
}

/// Every kind of file of a part.
fn files(brep: &Brep) -> [String; 3] {
    [step_file(brep), iges_file(brep, Form::Trimmed), iges_file(brep, Form::Brep)]
}

/// The model that is read must be exactly the one that was written.
fn check_same(brep: &Brep, model: &CadModel) {
    assert_eq!(model.faces.len(), brep.faces.len());
    for (face, written) in model.faces.iter().zip(&brep.faces) {
        let CadSurface::Spline(surface) = &*face.surface else { panic!() };
        let BrepSurface::Spline(expected) = &brep.surfaces[written.surface.0] else { panic!() };
        assert_eq!(surface, expected);
        assert!(!face.natural);
        assert_eq!(face.loops.len(), written.loops.len());
        for (edges, uses) in face.loops.iter().zip(&written.loops) {
            assert_eq!(edges.len(), uses.len());
            for (edge, of_loop) in edges.iter().zip(uses) {
                let BrepCurve::Spline(expected) = &brep.edges[of_loop.edge.0].curve else {
                    panic!()
                };
                let CurveShape::Spline(found) = &edge.curve.as_ref().unwrap().shape else {
                    panic!()
                };
                let mut poles: Vec<_> = found.poles().to_vec();
                if poles != expected.poles() {
                    poles.reverse();
                }
                assert_eq!(poles, expected.poles());
                assert_eq!(edge.pcurves.len(), 1);
            }
        }
    }
}

#[test]
fn our_own_files_read_back_to_the_last_bit() {
    for brep in [model::one_face("part"), model::two_faces("pair")] {
        for file in files(&brep) {
            check_same(&brep, &read(&file).unwrap());
        }
    }
}

#[test]
fn names_read_back() {
    let name = "Größe 'A' \\ 😀, x; y";
    assert_eq!(read(&step_file(&model::one_face(name))).unwrap().name, name);
    let ascii = name.replace(['ö', 'ß', '😀'], "_");
    for form in [Form::Trimmed, Form::Brep] {
        assert_eq!(read(&iges_file(&model::one_face(name), form)).unwrap().name, ascii);
    }
}

#[test]
fn a_loop_runs_where_its_face_has_it() {
    // Edges are reversed, and a face has the opposite normal. The first corner of each pcurve in
    // the direction of the loop is the last corner of the previous pcurve.
    for brep in [model::two_faces(""), model::inverted("")] {
        for file in files(&brep) {
            for face in read(&file).unwrap().faces {
                for edges in &face.loops {
                    let ends: Vec<_> = edges.iter().map(ends).collect();
                    for (before, after) in ends.iter().zip(ends.iter().cycle().skip(1)) {
                        assert_eq!(before[1], after[0], "{}", face.entity);
                    }
                }
            }
        }
    }
}

/// The ends of an edge's pcurve in the direction of its loop.
fn ends(edge: &formats::cad::CadEdge) -> [[f64; 2]; 2] {
    let CurveShape::Spline(pcurve) = &edge.pcurves[0].shape else { panic!() };
    let (first, last) = (pcurve.poles()[0], pcurve.poles()[pcurve.poles().len() - 1]);
    if edge.pcurve_forward { [first, last] } else { [last, first] }
}
