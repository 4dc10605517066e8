//! Comparison of every entity of a STEP file with its schema.
//!
//! The table below is for AP203 (`config_control_design`), AP214 (edition 3) and AP242 (edition 1).
//! It has the number and types of the attributes as in the EXPRESS schemas. If several types are
//! possible, it has the entities that we write. A program that reads these schemas made the table,
//! and our files passed its check without a fault.

use std::collections::HashMap;

use formats::step::{self, Schema};

use crate::model;
use crate::step_file;

/// `S` is a string, `I` an integer, `R` a real number, `L` a logical value, `E` an enumeration, `M`
/// a measure, and `*` a derived attribute. `?` precedes an attribute that may be `$`. `[ ]` is a
/// list of at least one item. Everything else is an entity of one of these types.
const ATTRIBUTES: &[(&str, &str)] = &[
    ("ADVANCED_FACE", "S [FACE_BOUND|FACE_OUTER_BOUND] B_SPLINE_SURFACE_WITH_KNOTS L"),
    ("APPLICATION_CONTEXT", "S"),
    ("APPLICATION_PROTOCOL_DEFINITION", "S S I APPLICATION_CONTEXT"),
    ("APPROVAL", "APPROVAL_STATUS S"),
    ("APPROVAL_DATE_TIME", "CALENDAR_DATE|DATE_AND_TIME|LOCAL_TIME APPROVAL"),
    (
        "APPROVAL_PERSON_ORGANIZATION",
        "ORGANIZATION|PERSON|PERSON_AND_ORGANIZATION APPROVAL APPROVAL_ROLE",
    ),
    ("APPROVAL_ROLE", "S"),
    ("APPROVAL_STATUS", "S"),
    ("AXIS2_PLACEMENT_3D", "S CARTESIAN_POINT ?DIRECTION ?DIRECTION"),
    ("B_SPLINE_CURVE_WITH_KNOTS", "S I [CARTESIAN_POINT] E L L [I] [R] E"),
    ("B_SPLINE_SURFACE_WITH_KNOTS", "S I I [[CARTESIAN_POINT]] E L L L [I] [I] [R] [R] E"),
    ("CALENDAR_DATE", "I I I"),
    ("CARTESIAN_POINT", "S [R]"),
    (
        "CC_DESIGN_APPROVAL",
        "APPROVAL [PRODUCT_DEFINITION|PRODUCT_DEFINITION_FORMATION_WITH_SPECIFIED_SOURCE|\
         SECURITY_CLASSIFICATION]",
    ),
    (
        "CC_DESIGN_DATE_AND_TIME_ASSIGNMENT",
        "DATE_AND_TIME DATE_TIME_ROLE \
         [APPROVAL_PERSON_ORGANIZATION|PRODUCT_DEFINITION|SECURITY_CLASSIFICATION]",
    ),
    (
        "CC_DESIGN_PERSON_AND_ORGANIZATION_ASSIGNMENT",
        "PERSON_AND_ORGANIZATION PERSON_AND_ORGANIZATION_ROLE [PRODUCT|PRODUCT_DEFINITION|\
         PRODUCT_DEFINITION_FORMATION_WITH_SPECIFIED_SOURCE|SECURITY_CLASSIFICATION]",
    ),
    (
        "CC_DESIGN_SECURITY_CLASSIFICATION",
        "SECURITY_CLASSIFICATION [PRODUCT_DEFINITION_FORMATION_WITH_SPECIFIED_SOURCE]",
    ),
    ("COORDINATED_UNIVERSAL_TIME_OFFSET", "I ?I E"),
    ("COLOUR_RGB", "S R R R"),
    ("DATE_AND_TIME", "CALENDAR_DATE LOCAL_TIME"),
    ("DATE_TIME_ROLE", "S"),
    (
        "DEFINITIONAL_REPRESENTATION",
        "S [B_SPLINE_CURVE_WITH_KNOTS] GEOMETRIC_REPRESENTATION_CONTEXT",
    ),
    ("DESIGN_CONTEXT", "S APPLICATION_CONTEXT S"),
    ("DIRECTION", "S [R]"),
    ("EDGE_CURVE", "S VERTEX_POINT VERTEX_POINT SURFACE_CURVE|SEAM_CURVE L"),
    ("EDGE_LOOP", "S [ORIENTED_EDGE]"),
    ("FACE_BOUND", "S EDGE_LOOP L"),
    ("FACE_OUTER_BOUND", "S EDGE_LOOP L"),
    ("FILL_AREA_STYLE", "S [FILL_AREA_STYLE_COLOUR]"),
    ("FILL_AREA_STYLE_COLOUR", "S COLOUR_RGB"),
    ("GEOMETRIC_REPRESENTATION_CONTEXT", "I"),
    ("GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT", "[UNCERTAINTY_MEASURE_WITH_UNIT]"),
    ("GLOBAL_UNIT_ASSIGNED_CONTEXT", "[LENGTH_UNIT|NAMED_UNIT]"),
    ("LENGTH_UNIT", ""),
    ("LOCAL_TIME", "I ?I ?R COORDINATED_UNIVERSAL_TIME_OFFSET"),
    (
        "MANIFOLD_SURFACE_SHAPE_REPRESENTATION",
        "S [AXIS2_PLACEMENT_3D|SHELL_BASED_SURFACE_MODEL] GEOMETRIC_REPRESENTATION_CONTEXT",
    ),
    (
        "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION",
        "S [STYLED_ITEM|AXIS2_PLACEMENT_3D] GEOMETRIC_REPRESENTATION_CONTEXT",
    ),
    ("MECHANICAL_CONTEXT", "S APPLICATION_CONTEXT S"),
    ("NAMED_UNIT", "*"),
    ("OPEN_SHELL", "S [ADVANCED_FACE]"),
    ("ORGANIZATION", "?S S S"),
    ("ORIENTED_EDGE", "S * * EDGE_CURVE L"),
    ("PARAMETRIC_REPRESENTATION_CONTEXT", ""),
    ("PCURVE", "S B_SPLINE_SURFACE_WITH_KNOTS DEFINITIONAL_REPRESENTATION"),
    ("PERSON", "S ?S ?S ?[S] ?[S] ?[S]"),
    ("PERSON_AND_ORGANIZATION", "PERSON ORGANIZATION"),
    ("PERSON_AND_ORGANIZATION_ROLE", "S"),
    ("PLANE_ANGLE_UNIT", ""),
    ("PRESENTATION_STYLE_ASSIGNMENT", "[SURFACE_STYLE_USAGE]"),
    ("PRODUCT", "S S S [PRODUCT_CONTEXT|MECHANICAL_CONTEXT]"),
    ("PRODUCT_CATEGORY", "S ?S"),
    (
        "PRODUCT_CATEGORY_RELATIONSHIP",
        "S S PRODUCT_CATEGORY|PRODUCT_RELATED_PRODUCT_CATEGORY \
         PRODUCT_CATEGORY|PRODUCT_RELATED_PRODUCT_CATEGORY",
    ),
    ("PRODUCT_CONTEXT", "S APPLICATION_CONTEXT S"),
    (
        "PRODUCT_DEFINITION",
        "S S PRODUCT_DEFINITION_FORMATION|PRODUCT_DEFINITION_FORMATION_WITH_SPECIFIED_SOURCE \
         PRODUCT_DEFINITION_CONTEXT|DESIGN_CONTEXT",
    ),
    ("PRODUCT_DEFINITION_CONTEXT", "S APPLICATION_CONTEXT S"),
    ("PRODUCT_DEFINITION_FORMATION", "S ?S PRODUCT"),
    ("PRODUCT_DEFINITION_FORMATION_WITH_SPECIFIED_SOURCE", "S S PRODUCT E"),
    ("PRODUCT_DEFINITION_SHAPE", "S S PRODUCT_DEFINITION"),
    ("PRODUCT_RELATED_PRODUCT_CATEGORY", "S ?S [PRODUCT]"),
    ("REPRESENTATION_CONTEXT", "S S"),
    ("SEAM_CURVE", "S B_SPLINE_CURVE_WITH_KNOTS [PCURVE] E"),
    ("SECURITY_CLASSIFICATION", "S S SECURITY_CLASSIFICATION_LEVEL"),
    ("SECURITY_CLASSIFICATION_LEVEL", "S"),
    (
        "SHAPE_DEFINITION_REPRESENTATION",
        "PRODUCT_DEFINITION_SHAPE MANIFOLD_SURFACE_SHAPE_REPRESENTATION",
    ),
    ("SHELL_BASED_SURFACE_MODEL", "S [OPEN_SHELL]"),
    ("SI_UNIT", "?E E"),
    ("SOLID_ANGLE_UNIT", ""),
    ("STYLED_ITEM", "S [PRESENTATION_STYLE_ASSIGNMENT] SHELL_BASED_SURFACE_MODEL"),
    ("SURFACE_SIDE_STYLE", "S [SURFACE_STYLE_FILL_AREA]"),
    ("SURFACE_STYLE_FILL_AREA", "FILL_AREA_STYLE"),
    ("SURFACE_STYLE_USAGE", "E SURFACE_SIDE_STYLE"),
    ("SURFACE_CURVE", "S B_SPLINE_CURVE_WITH_KNOTS [PCURVE] E"),
    ("UNCERTAINTY_MEASURE_WITH_UNIT", "M LENGTH_UNIT|NAMED_UNIT S ?S"),
    ("VERTEX_POINT", "S CARTESIAN_POINT"),
];

/// The records of an entity instance, each with its name and its attributes.
type Records = Vec<(String, Vec<String>)>;

/// `text` split at the commas outside of strings and lists.
fn cut(text: &str) -> Vec<String> {
    let (mut parts, mut depth, mut quoted) = (vec![String::new()], 0, false);
    for c in text.chars().filter(|c| *c != '\n') {
        match c {
            '\'' => quoted = !quoted,
            '(' if !quoted => depth += 1,
            ')' if !quoted => depth -= 1,
            ',' if !quoted && depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        parts.last_mut().unwrap().push(c);
    }
    if parts == [""] { Vec::new() } else { parts }
}

fn records(body: &str) -> Records {
    let inside = body.strip_prefix('(').and_then(|b| b.strip_suffix(')'));
    let Some(mut rest) = inside else {
        let (name, attributes) = body.split_once('(').unwrap();
        return vec![(name.into(), cut(attributes.strip_suffix(')').unwrap()))];
    };
    let mut records = Vec::new();
    while let Some((name, after)) = rest.split_once('(') {
        let mut depth = 1;
        let end = after.find(|c| {
            depth += i32::from(c == '(') - i32::from(c == ')');
            depth == 0
        });
        let (attributes, after) = after.split_at(end.unwrap());
        records.push((name.trim().into(), cut(attributes)));
        rest = &after[1..];
    }
    records
}

fn holds(value: &str, kind: &str, all: &HashMap<String, Records>) -> bool {
    if let Some(kind) = kind.strip_prefix('?') {
        return value == "$" || holds(value, kind, all);
    }
    if let Some(kind) = kind.strip_prefix('[').and_then(|k| k.strip_suffix(']')) {
        let list = value.strip_prefix('(').and_then(|v| v.strip_suffix(')')).map(cut);
        return list.is_some_and(|l| !l.is_empty() && l.iter().all(|v| holds(v, kind, all)));
    }
    match kind {
        "S" => value.len() >= 2 && value.starts_with('\'') && value.ends_with('\''),
        "I" => value.parse::<i64>().is_ok(),
        "R" => value.contains('.') && value.parse::<f64>().is_ok(),
        "L" => matches!(value, ".T." | ".F."),
        "E" => value.len() > 2 && value.starts_with('.') && value.ends_with('.'),
        "M" => value.contains("_MEASURE("),
        "*" => value == "*",
        names => {
            let of = all.get(value).map_or(&[][..], |records| records);
            names.split('|').any(|name| of.iter().any(|(found, _)| found == name))
        }
    }
}

/// The violations of the schema.
fn faults(file: &str) -> Vec<String> {
    let known: HashMap<&str, &str> = ATTRIBUTES.iter().copied().collect();
    let data = file.split_once("DATA;\n").unwrap().1.split_once("ENDSEC;").unwrap().0;
    let statements = data.split_terminator(";\n").map(|s| s.split_once('=').unwrap());
    let all: HashMap<String, Records> =
        statements.map(|(id, body)| (id.to_owned(), records(body))).collect();
    let mut faults = Vec::new();
    for (id, records) in &all {
        // The records of a complex instance are in alphabetical order.
        if !records.is_sorted_by_key(|(name, _)| name) {
            faults.push(format!("{id}: {records:?}"));
        }
        for (name, values) in records {
            let kinds = known.get(name.as_str()).map(|k| k.split_whitespace().collect::<Vec<_>>());
            let fits = kinds.is_some_and(|kinds| {
                let mut pairs = values.iter().zip(&kinds);
                kinds.len() == values.len() && pairs.all(|(value, kind)| holds(value, kind, &all))
            });
            if !fits {
                faults.push(format!("{id}={name}{values:?}"));
            }
        }
    }
    faults
}

#[test]
fn entities_are_as_the_schemas_have_them() {
    for schema in [Schema::Ap203, Schema::Ap214, Schema::Ap242] {
        for brep in [model::one_face("a'(,;"), model::two_faces("Größe"), model::inverted("")] {
            assert_eq!(faults(&step_file(&brep, schema)), Vec::<String>::new(), "{schema:?}");
        }
    }
}

#[test]
fn colours_are_as_the_schemas_have_them() {
    for schema in [Schema::Ap203, Schema::Ap214, Schema::Ap242] {
        let colour = Some([255, 51, 0]);
        let options = step::Options { schema, colour, ..Default::default() };
        let mut out = Vec::new();
        step::write(&model::one_face("part"), &options, &mut out).unwrap();
        let file = String::from_utf8(out).unwrap();
        assert_eq!(faults(&file), Vec::<String>::new(), "{schema:?}");
        // AP203 does not have these entities.
        assert_eq!(file.contains("COLOUR_RGB('',1.,0.2,0.)"), schema != Schema::Ap203);
    }
}

#[test]
fn faults_are_found() {
    let good = step_file(&model::one_face("part"), Schema::Ap242);
    for (from, to) in [
        ("PRODUCT_CONTEXT('',#1,'mechanical')", "PRODUCT_CONTEXT('',#1)"),
        ("PRODUCT_CONTEXT('',#1,", "PRODUCT_CONTEXT('',#2,"),
        ("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT('MILLI',.METRE.)"),
        ("ORIENTED_EDGE('',*,*,", "ORIENTED_EDGE('',$,*,"),
        ("(0.,0.,0.)", "(0,0.,0.)"),
        ("VERTEX_POINT(", "POINT("),
    ] {
        assert!(good.contains(from), "{from}");
        assert!(!faults(&good.replacen(from, to, 1)).is_empty(), "{to}");
    }
}
