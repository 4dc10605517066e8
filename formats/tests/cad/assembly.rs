//! Assemblies: parts have the places that transformations and mapped items give them, or they are refused.

use formats::cad::CadModel;

use crate::{model, read, step_file};

/// A file of one part, with the number of its representation and of the context.
fn part() -> (String, String, String) {
    let good = step_file(&model::one_face("part"));
    let name = "=MANIFOLD_SURFACE_SHAPE_REPRESENTATION(";
    let at = good.find(name).expect("a representation");
    let id = good[..at].rsplit('\n').next().expect("its number").to_owned();
    let record = good[at..].split(';').next().expect("its end");
    let context = record.rsplit(',').next().expect("a context").trim_end_matches(')').to_owned();
    (good, id, context)
}

/// The part with an assembly around it. `PART` and `CONTEXT` stand for the part's representation and context.
fn assembled(more: &str) -> String {
    let (good, part, context) = part();
    let more = more.replace("PART", &part).replace("CONTEXT", &context);
    good.replacen("DATA;\n", &format!("DATA;\n{more}"), 1)
}

/// A placement at (10, 20, 30), and one at the origin, without axes.
const PLACEMENTS: &str = "#9001=CARTESIAN_POINT('',(10.,20.,30.));\n\
    #9002=CARTESIAN_POINT('',(0.,0.,0.));\n\
    #9003=DIRECTION('',(0.,0.,1.));\n\
    #9004=DIRECTION('',(0.,1.,0.));\n\
    #9005=AXIS2_PLACEMENT_3D('',#9001,#9003,#9004);\n\
    #9006=AXIS2_PLACEMENT_3D('',#9002,$,$);\n";

fn good(text: &str) -> CadModel {
    read(text).unwrap_or_else(|e| panic!("{e}"))
}

fn fault(text: &str) -> String {
    read(text).map_or_else(|e| e.to_string(), |_| panic!("it was read"))
}

/// Where the point (1, 2, 3) of the part is in the model.
fn places(model: &CadModel) -> Vec<[f64; 3]> {
    let places = model.faces[0].places.iter();
    places.map(|place| place.point([1.0, 2.0, 3.0]).map(|x| (x * 1e9).round() / 1e9)).collect()
}

#[test]
fn a_part_has_the_place_that_its_assembly_gives_it() {
    assert_eq!(places(&good(&part().0)), [[1.0, 2.0, 3.0]]);
    // The x axis of the part points along y.
    let turned = [[8.0, 21.0, 33.0]];
    let related = |operator: &str| {
        assembled(&format!(
            "{PLACEMENTS}#9010=SHAPE_REPRESENTATION('',(#9005),CONTEXT);\n{operator}\
             #9012=(REPRESENTATION_RELATIONSHIP('','',PART,#9010)\
             REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#9011)\
             SHAPE_REPRESENTATION_RELATIONSHIP());\n"
        ))
    };
    let items = "#9011=ITEM_DEFINED_TRANSFORMATION('','',#9006,#9005);\n";
    assert_eq!(places(&good(&related(items))), turned);
    let operator = "#9011=CARTESIAN_TRANSFORMATION_OPERATOR_3D('',#9004,$,#9001,$,$);\n";
    assert_eq!(places(&good(&related(operator))), turned);
    let mirrored = "#9007=DIRECTION('',(-1.,0.,0.));\n\
        #9008=DIRECTION('',(1.,0.,0.));\n\
        #9011=CARTESIAN_TRANSFORMATION_OPERATOR_3D('',#9007,#9004,#9001,2.,#9003);\n";
    assert_eq!(places(&good(&related(mirrored))), [[8.0, 24.0, 36.0]]);
    let unknown = "#9011=BENT_TRANSFORMATION('');\n";
    let said = fault(&related(unknown));
    assert!(said.contains("unsupported kind: BENT_TRANSFORMATION (#9011)"), "{said}");
}

#[test]
fn mapped_items_place_parts_again_and_again() {
    let twice = "#9020=REPRESENTATION_MAP(#9006,PART);\n\
        #9021=MAPPED_ITEM('',#9020,#9005);\n\
        #9022=MAPPED_ITEM('',#9020,#9006);\n\
        #9023=SHAPE_REPRESENTATION('',(#9021,#9022),CONTEXT);\n";
    let model = good(&assembled(&format!("{PLACEMENTS}{twice}")));
    assert_eq!(places(&model), [[8.0, 21.0, 33.0], [1.0, 2.0, 3.0]]);
    assert_eq!(model.faces.len(), 1, "the face is kept once");
    let mut nested = format!("{PLACEMENTS}{twice}");
    for n in 0..30 {
        let (id, inner) = (9100 + 10 * n, 9023 + if n == 0 { 0 } else { 10 * (n - 1) + 80 });
        nested += &format!(
            "#{id}=REPRESENTATION_MAP(#9006,#{inner});\n#{}=MAPPED_ITEM('',#{id},#9005);\n\
             #{}=MAPPED_ITEM('',#{id},#9006);\n#{}=SHAPE_REPRESENTATION('',(#{},#{}),CONTEXT);\n",
            id + 1,
            id + 2,
            id + 3,
            id + 1,
            id + 2
        );
    }
    assert!(fault(&assembled(&nested)).contains("places of parts"), "two to the power of thirty");
    let within_itself = "#9020=REPRESENTATION_MAP(#9006,#9023);\n\
        #9021=MAPPED_ITEM('',#9020,#9005);\n\
        #9023=SHAPE_REPRESENTATION('',(#9021),CONTEXT);\n";
    let said = fault(&assembled(&format!("{PLACEMENTS}{within_itself}")));
    assert!(said.contains("puts an assembly into itself (#9021)"), "{said}");
}

#[test]
fn no_part_is_reached_without_its_place() {
    let (good, ..) = part();
    let definition = good.split("=PRODUCT_DEFINITION(").next().expect("a product");
    let definition = definition.rsplit('\n').next().expect("its number");
    // The assembly says that it has the part, and not where.
    let usage = format!("#9030=NEXT_ASSEMBLY_USAGE_OCCURRENCE('1','','',#9031,{definition},$);\n");
    let said = fault(&assembled(&usage));
    assert!(said.contains("puts a part into an assembly without a place (#9030)"), "{said}");
    // A representation has another face, and nothing places it, although there is an assembly.
    let lost = "#9020=REPRESENTATION_MAP(#9006,PART);\n\
        #9021=MAPPED_ITEM('',#9020,#9005);\n\
        #9023=SHAPE_REPRESENTATION('',(#9021),CONTEXT);\n\
        #9024=SHAPE_REPRESENTATION('',(#9025),CONTEXT);\n\
        #9025=ADVANCED_FACE('',(),#9026,.T.);\n\
        #9026=SPHERICAL_SURFACE('',#9006,2.);\n";
    let said = fault(&assembled(&format!("{PLACEMENTS}{lost}")));
    // The group of the second representation is an assembly of nothing, so its place is unknown.
    assert!(said.contains("its place is unknown (#9025)"), "{said}");
}

#[test]
fn names_may_be_short() {
    let mut text = step_file(&model::one_face("part"));
    for (long, short) in [
        ("ADVANCED_FACE(", "ADVFC("),
        ("CARTESIAN_POINT(", "CRTPNT("),
        ("MANIFOLD_SURFACE_SHAPE_REPRESENTATION(", "MSSR("),
        ("B_SPLINE_SURFACE_WITH_KNOTS(", "BSSWK("),
        ("ORIENTED_EDGE(", "ORNEDG("),
        ("EDGE_CURVE(", "EDGCRV("),
        ("OPEN_SHELL(", "OPNSHL("),
    ] {
        assert!(text.contains(long), "{long}");
        text = text.replace(long, short);
    }
    assert_eq!(good(&text).faces.len(), 1);
}
