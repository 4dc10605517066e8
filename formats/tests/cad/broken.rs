//! Broken CAD files: the errors, and that nothing panics.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use formats::cad::read_cad_from;
use formats::iges::Form;

#[path = "../read/mutations/damage.rs"]
mod damage;

use crate::{iges_file, model, read, step_file};

/// The error for a file.
fn fault(text: &str) -> String {
    let Err(fault) = read(text) else { panic!("a broken file was read") };
    fault.to_string()
}

/// A good file with more entities, and with some of them among the faces of its shell.
fn with_faces(more: &str, faces: &str) -> String {
    let good = step_file(&model::one_face("part"));
    good.replacen("OPEN_SHELL('',(", &format!("OPEN_SHELL('',({faces},"), 1).replacen(
        "DATA;\n",
        &format!("DATA;\n{more}"),
        1,
    )
}

#[test]
fn trimmed_surfaces_share_their_basis() {
    let good = step_file(&model::one_face("part"));
    let at = good.find("=ADVANCED_FACE('',").expect("a face") + 1;
    let face = &good[at..at + good[at..].find(';').expect("its end")];
    let (_, surface) = face.rsplit_once("),").expect("its surface");
    let surface = surface.split(',').next().expect("its surface");
    let part =
        |id: u64| format!("#{id}=RECTANGULAR_TRIMMED_SURFACE('',{surface},0.,1.,0.,1.,.T.,.T.);\n");
    let on = |id: u64, part: u64| {
        format!("#{id}={};\n", face.replace(&format!("),{surface},"), &format!("),#{part},")))
    };
    let more = part(90_001) + &part(90_002) + &on(90_003, 90_001) + &on(90_004, 90_002);
    let model = read(&with_faces(&more, "#90003,#90004")).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(model.faces.len(), 3);
    assert!(
        model
            .faces
            .iter()
            .all(|face| std::sync::Arc::ptr_eq(&face.surface, &model.faces[0].surface))
    );
}

#[test]
fn long_entities_that_are_used_often_take_no_time() {
    let long = "x".repeat(100_000);
    let often = vec!["#90002"; 20_000].join(",");
    let good = step_file(&model::one_face("part"));
    let plane = "#90010=PLANE('',#90011);\n#90011=AXIS2_PLACEMENT_3D('',#90012,$,$);\n#90012=CARTESIAN_POINT('',(0.,0.,0.));\n";
    let more = format!(
        "#90001=ADVANCED_FACE('',({often}),#90010,.T.);\n#90002=FACE_BOUND('{long}',#90003,.T.);\n\
         #90003=VERTEX_LOOP('',#90004);\n{plane}"
    );
    assert!(fault(&with_faces(&more, "#90001")).contains("is used too often"));
    // An item that a representation has several times is read once.
    let items = vec!["#90001"; 20_000].join(",");
    let more = format!(
        "#90000=SHAPE_REPRESENTATION('',({items}),#90005);\n#90001=DIRECTION('{long}',(1.,0.,0.));\n\
         #90005=(GEOMETRIC_REPRESENTATION_CONTEXT(3));\n"
    );
    let model = read(&good.replacen("DATA;\n", &format!("DATA;\n{more}"), 1));
    assert_eq!(model.unwrap_or_else(|e| panic!("{e}")).faces.len(), 1);
}

#[test]
fn what_is_wrong_with_a_step_file_is_said() {
    let good = step_file(&model::one_face("part"));
    let replaced = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        fault(&good.replacen(from, to, 1))
    };
    assert_eq!(fault(""), "part: is empty");
    assert_eq!(fault("solid x"), "part: is neither STEP nor IGES");
    let cut = &good[..good.len() / 2];
    let line = cut.lines().count();
    let said = fault(cut);
    assert!(said.contains("is incomplete") && said.contains(&format!("line {line}")), "{said}");
    assert!(fault(&good.replace("END-ISO-10303-21;\n", "")).contains("is incomplete"));
    assert_eq!(replaced("#20=", "#21="), "part: #21 is defined twice (line 34)");
    assert_eq!(
        replaced("(0.,0.2,0.4", "(0.,0.5,0.4").split(" (#").next().unwrap(),
        "part: knots that decrease, or are not finite"
    );
    let said = replaced("B_SPLINE_SURFACE_WITH_KNOTS('',3,3", "B_SPLINE_SURFACE_WITH_KNOTS('',4,3");
    assert!(said.contains("12 knots for 8 poles of degree 4"), "{said}");
    let said = replaced("(4,1,1,1,1,4)", "(4,1,1,1,1,999999999999)");
    assert!(said.contains("knots for 8 poles of degree 3"), "{said}");
    let said = replaced("B_SPLINE_SURFACE_WITH_KNOTS('',3,3", "BLENDED_SURFACE('',3,3");
    assert!(said.contains("is a surface of an unsupported kind: BLENDED_SURFACE (#"), "{said}");
    let said = replaced("ADVANCED_FACE('',(#", "ADVANCED_FACE('',(#9999");
    assert!(said.contains("which it does not contain"), "{said}");
    let said = replaced("VERTEX_POINT('',#", "VERTEX_POINT('',#1,#");
    assert_eq!(said, "part: is APPLICATION_CONTEXT where CARTESIAN_POINT is expected (#1)");
    let said = replaced("VERTEX_POINT('',#", "VERTEX_POINT('',1.,#");
    assert!(said.contains("attribute 2 of VERTEX_POINT is not a reference (#"), "{said}");
    let said = replaced("OPEN_SHELL(", "OPEN_SHELF(");
    assert!(said.contains("is OPEN_SHELF where a shell is expected (#"), "{said}");
    assert_eq!(replaced("SHELL_BASED_SURFACE_MODEL", "GEOMETRIC_CURVE_SET"), "part: has no faces");
    let said = replaced("SHELL_BASED_SURFACE_MODEL(", "SWEPT_DISK_SOLID(");
    assert!(said.contains("is an item of an unsupported kind: SWEPT_DISK_SOLID (#"), "{said}");
    assert!(replaced("SI_UNIT(.MILLI.", "SI_UNIT(.FURLONG.").contains("is a unit of length"));
}

#[test]
fn what_is_wrong_with_an_iges_file_is_said() {
    let good = iges_file(&model::one_face("part"), Form::Trimmed);
    let replaced = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        fault(&good.replacen(from, to, 1))
    };
    let half: String = good.lines().take(40).map(|l| format!("{l}\n")).collect();
    assert_eq!(fault(&half), "part: ends before its last section (line 40)");
    let said = fault(&good.replace("D      2\n", "X      2\n"));
    assert!(said.contains("without its section's letter in column 73 (line "), "{said}");
    assert!(replaced("128,7,7,3,3,", "128,9,7,3,3,").contains("(directory entry "));
    let said = replaced("128,7,7,3,3,", "128,7,7,9,3,");
    assert!(said.contains("directory entry"), "{said}");
    let said = replaced(",2,2HMM,", ",3,2HXX,");
    assert!(said.contains("in an unknown unit: 3 XX"), "{said}");
    let said = replaced("1H,,1H;,", "2H,,1H;,");
    assert!(said.contains("names no delimiters"), "{said}");
}

/// Counts that are larger than the content of the file.
#[test]
fn claims_are_not_believed() {
    let good = iges_file(&model::one_face("part"), Form::Brep);
    for (from, to) in [("502,8,", "502,9999999999,"), ("514,1,", "514,8888888888,")] {
        assert!(good.contains(from));
        // The number replaces blanks, so that the lines still have 80 columns.
        let at = good.find(from).unwrap();
        let line = good[at..].lines().next().unwrap();
        let (data, rest) = line.split_at(64);
        let longer = data.replacen(from, to, 1);
        let said = fault(&good.replacen(line, &format!("{}{rest}", &longer[..64]), 1));
        assert!(said.contains("more parameters") || said.contains("without an end"), "{said}");
    }
}

/// The number of times that each file is damaged.
const ROUNDS: usize = 1_500;

#[test]
fn damaged_files_are_survived() {
    let brep = model::two_faces("pair");
    let mut random = damage::Random(0x9e37_79b9_7f4a_7c15);
    let files = [step_file(&brep), iges_file(&brep, Form::Trimmed), iges_file(&brep, Form::Brep)];
    for good in files {
        let mut survived = 0;
        for _ in 0..ROUNDS {
            let mut file = good.clone().into_bytes();
            damage::damage(&mut file, &mut random);
            let read = || read_cad_from(Path::new("part"), &file).is_ok();
            let read = catch_unwind(AssertUnwindSafe(read));
            survived += usize::from(read.unwrap_or_else(|_| panic!("{}", file.escape_ascii())));
        }
        assert!(survived > 0 && survived < ROUNDS, "{survived} of {ROUNDS} could be read");
    }
}
