//! STEP files: structure, references, strings and numbers.

use std::collections::BTreeSet;
use std::io::ErrorKind;

use formats::Brep;
use formats::brep::{BrepSurface, ModelFault};
use formats::step::{Options, Schema, write};

use crate::model;
use crate::step_file;

const SCHEMAS: [Schema; 3] = [Schema::Ap203, Schema::Ap214, Schema::Ap242];

/// The content of the numbered entity instances in their order.
fn entities(file: &str) -> Vec<String> {
    let (_, data) = file.split_once("DATA;\n").unwrap();
    let (data, _) = data.split_once("ENDSEC;").unwrap();
    let mut bodies = Vec::new();
    for (i, statement) in data.split_terminator(";\n").enumerate() {
        let (number, body) = statement.split_once('=').unwrap();
        assert_eq!(number, format!("#{}", i + 1));
        bodies.push(body.to_string());
    }
    bodies
}

/// The entity instances that a text refers to. Strings do not count.
fn references(body: &str) -> Vec<usize> {
    let outside_strings = body.split('\'').step_by(2).collect::<String>();
    let names = outside_strings.split('#').skip(1);
    names.map(|s| s.split(|c: char| !c.is_ascii_digit()).next().unwrap().parse().unwrap()).collect()
}

fn all<'a>(bodies: &'a [String], kind: &str) -> Vec<&'a str> {
    let start = format!("{kind}(");
    bodies.iter().filter_map(|b| b.strip_prefix(&start)).collect()
}

#[test]
fn header_names_the_schema() {
    for (schema, name) in SCHEMAS.into_iter().zip([
        "CONFIG_CONTROL_DESIGN",
        "AUTOMOTIVE_DESIGN {",
        "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF {",
    ]) {
        let file = step_file(&model::one_face("part"), schema);
        assert!(file.starts_with("ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(("));
        assert!(file.contains("FILE_NAME('part','1970-01-01T00:00:00',"));
        assert!(file.contains(&format!("FILE_SCHEMA(('{name}")));
        assert!(file.ends_with("ENDSEC;\nEND-ISO-10303-21;\n"));
        assert!(file.is_ascii());
    }
}

#[test]
fn references_are_defined_before_and_nothing_hangs_loose() {
    // Entities that connect other entities, so that nothing refers to them.
    let ties = [
        "APPLICATION_PROTOCOL_DEFINITION",
        "PRODUCT_RELATED_PRODUCT_CATEGORY",
        "PRODUCT_CATEGORY_RELATIONSHIP",
        "SHAPE_DEFINITION_REPRESENTATION",
        "CC_DESIGN_",
        "APPROVAL_DATE_TIME",
        "APPROVAL_PERSON_ORGANIZATION",
    ];
    for schema in SCHEMAS {
        let bodies = entities(&step_file(&model::two_faces("#1 'x'"), schema));
        let mut used = BTreeSet::new();
        for (i, body) in bodies.iter().enumerate() {
            let refs = references(body);
            assert!(refs.iter().all(|r| (1..=i).contains(r)), "#{}={body}", i + 1);
            used.extend(refs);
        }
        for (i, body) in bodies.iter().enumerate() {
            let loose = !used.contains(&(i + 1));
            assert!(!loose || ties.iter().any(|tie| body.starts_with(tie)), "#{}={body}", i + 1);
        }
    }
}

#[test]
fn faces_share_edges_and_vertices() {
    for (brep, [faces, bounds, edges, uses, vertices]) in
        [(model::one_face(""), [1, 2, 8, 8, 8]), (model::two_faces(""), [2, 2, 11, 12, 10])]
    {
        let bodies = entities(&step_file(&brep, Schema::Ap242));
        let count = |kind| all(&bodies, kind).len();
        assert_eq!(count("OPEN_SHELL"), 1);
        assert_eq!(count("ADVANCED_FACE"), faces);
        assert_eq!(count("B_SPLINE_SURFACE_WITH_KNOTS"), faces);
        assert_eq!([count("FACE_OUTER_BOUND"), count("FACE_BOUND")], [faces, bounds]);
        assert_eq!([count("EDGE_CURVE"), count("SURFACE_CURVE")], [edges, edges]);
        assert_eq!([count("PCURVE"), count("ORIENTED_EDGE")], [uses, uses]);
        assert_eq!(count("VERTEX_POINT"), vertices);
        let shared =
            all(&bodies, "SURFACE_CURVE").iter().filter(|s| references(s).len() == 3).count();
        assert_eq!(shared, uses - edges);
    }
}

#[test]
fn the_outer_bound_comes_first_and_direction_is_kept() {
    let of = |brep: &Brep| entities(&step_file(brep, Schema::Ap242));
    let bodies = of(&model::one_face(""));
    let face = all(&bodies, "ADVANCED_FACE")[0];
    let bounds = references(face);
    assert!(bodies[bounds[0] - 1].starts_with("FACE_OUTER_BOUND("));
    assert!(bodies[bounds[1] - 1].starts_with("FACE_BOUND("));
    assert!(face.ends_with(",.T.)"));
    let reversed = |bodies: &[String]| {
        all(bodies, "ORIENTED_EDGE").iter().filter(|e| e.ends_with(".F.)")).count()
    };
    assert_eq!(reversed(&bodies), 2);

    let bodies = of(&model::inverted(""));
    assert!(all(&bodies, "ADVANCED_FACE")[0].ends_with(",.F.)"));
    assert_eq!(reversed(&bodies), 6);
}

#[test]
fn knots_stand_once_with_their_multiplicity() {
    let bodies = entities(&step_file(&model::one_face(""), Schema::Ap242));
    let surface = all(&bodies, "B_SPLINE_SURFACE_WITH_KNOTS")[0];
    assert!(surface.starts_with("'',3,3,(("));
    assert!(surface.contains("(4,1,1,1,1,4),\n(4,1,1,1,1,4),\n(0.,0.2,0.4,0.6"));
    let curves = all(&bodies, "B_SPLINE_CURVE_WITH_KNOTS");
    assert_eq!(curves.iter().filter(|c| c.contains("(13,13),\n(0.,1.)")).count(), 4);
    assert_eq!(curves.len(), 16);
}

#[test]
fn poles_read_back_to_the_last_bit() {
    let brep = model::one_face("");
    let BrepSurface::Spline(surface) = &brep.surfaces[0] else { panic!() };
    let bodies = entities(&step_file(&brep, Schema::Ap242));
    let start = bodies.iter().position(|b| b.starts_with("CARTESIAN_POINT")).unwrap();
    for (body, pole) in bodies[start..].iter().zip(surface.poles()) {
        let numbers = body.trim_start_matches("CARTESIAN_POINT('',(").trim_end_matches("))");
        let numbers: Vec<f64> = numbers.split(',').map(|x| x.parse().unwrap()).collect();
        assert_eq!(numbers, pole);
    }
}

#[test]
fn names_are_escaped() {
    let file = step_file(&model::one_face("Größe 'A' \\ 😀"), Schema::Ap214);
    let name = r"'Gr\X2\00F600DF\X0\e \X\27A\X\27 \\ \X4\0001F600\X0\'";
    let bodies = entities(&file);
    assert!(all(&bodies, "PRODUCT")[0].starts_with(&format!("{name},{name},")));
    assert!(all(&bodies, "SHELL_BASED_SURFACE_MODEL")[0].starts_with(name));
    assert!(file.contains(&format!("FILE_NAME({name},")));
}

#[test]
fn units_uncertainty_and_flat_context() {
    let file = step_file(&Brep { uncertainty_mm: 2.5e-6, ..model::one_face("") }, Schema::Ap242);
    assert!(file.contains("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))"));
    assert!(file.contains("LENGTH_MEASURE(2.5E-06)"));
    assert!(file.contains("REPRESENTATION_CONTEXT('2D SPACE','')"));
}

#[test]
fn ap203_is_administered() {
    let brep = model::one_face("");
    let options = Options {
        schema: Schema::Ap203,
        time_stamp: "2024-02-29T13:05:59Z".into(),
        ..Default::default()
    };
    let mut out = Vec::new();
    write(&brep, &options, &mut out).unwrap();
    let bodies = entities(&String::from_utf8(out).unwrap());
    assert_eq!(all(&bodies, "CALENDAR_DATE"), ["2024,29,2)"]);
    assert!(all(&bodies, "LOCAL_TIME")[0].starts_with("13,5,59.,"));
    assert_eq!(all(&bodies, "CC_DESIGN_PERSON_AND_ORGANIZATION_ASSIGNMENT").len(), 4);
    assert_eq!(all(&bodies, "CC_DESIGN_DATE_AND_TIME_ASSIGNMENT").len(), 2);
    assert_eq!(all(&bodies, "CC_DESIGN_APPROVAL").len(), 1);
    assert_eq!(all(&bodies, "CC_DESIGN_SECURITY_CLASSIFICATION").len(), 1);
    assert_eq!(all(&bodies, "MECHANICAL_CONTEXT").len(), 1);
    let others = entities(&step_file(&brep, Schema::Ap242));
    assert!(all(&others, "APPROVAL").is_empty());
}

#[test]
fn the_same_part_gives_the_same_bytes() {
    for schema in SCHEMAS {
        let file = step_file(&model::two_faces("part"), schema);
        assert_eq!(file, step_file(&model::two_faces("part"), schema));
    }
}

#[test]
fn broken_promises_are_refused_before_anything_is_written() {
    let break_it = |how: fn(&mut Brep)| {
        let mut brep = model::one_face("");
        how(&mut brep);
        let mut out = Vec::new();
        let error = write(&brep, &Options::default(), &mut out).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidInput);
        assert!(out.is_empty());
        error.to_string()
    };
    assert_eq!(break_it(|b| b.faces.clear()), ModelFault::Empty.to_string());
    assert_eq!(break_it(|b| b.uncertainty_mm = 0.0), "its uncertainty is 0 mm");
    let text = break_it(|b| b.faces[0].loops[0].reverse());
    assert_eq!(text, "the loop is open before edge 0 in loop 0 of face 0");
    let text = break_it(|b| {
        let hole = &mut b.faces[0].loops[1];
        hole.reverse();
        hole.iter_mut().for_each(|of_loop| of_loop.forward = !of_loop.forward);
    });
    assert_eq!(text, "loop 1 of face 0 has the wrong orientation");
    let text = break_it(|b| b.edges[2].ends.reverse());
    assert!(text.starts_with("edge 2 ends 100 mm from its vertex"), "{text}");
}
