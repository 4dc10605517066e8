//! Assemblies: products, places, names and colours.

use formats::Assembly;
use formats::assembly::{AssemblyFault, AssemblyGroup, AssemblyPart, Member, Product};
use formats::brep::FaceId;
use formats::scene::Placement;
use formats::step::{self, Options, Schema};

use crate::bodies::{cube, torus};
use crate::step_file;

fn at(x: f64) -> Placement {
    Placement { translation: [x, 0.0, 0.0], ..Placement::IDENTITY }
}

/// A quarter turn about z.
fn turned(x: f64) -> Placement {
    let axes = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    Placement { axes, translation: [x, 0.0, 5.0] }
}

fn member(name: &str, placement: Placement, product: Product) -> Member {
    Member { name: name.into(), placement, colour: None, product }
}

/// A pair of a cube and a torus, twice, and a cube.
fn pairs() -> Assembly {
    let part = |brep, colour| AssemblyPart { brep, colour, face_colours: Vec::new() };
    let mut box_part = part(cube("a');#1=B"), Some([255, 0, 0]));
    box_part.face_colours.push((FaceId(2), [0, 0, 255]));
    let pair =
        vec![member("box", at(0.0), Product::Part(0)), member("", turned(30.0), Product::Part(1))];
    let all = vec![
        member("left", at(0.0), Product::Group(0)),
        member("right", turned(100.0), Product::Group(0)),
        member("Gr\u{f6}\u{df}e", at(-50.0), Product::Part(0)),
    ];
    let group =
        |name: &str, members| AssemblyGroup { name: name.into(), members, ..Default::default() };
    Assembly {
        parts: vec![box_part, part(torus("ring"), None)],
        groups: vec![group("pair", pair), group("all", all)],
    }
}

pub fn file(schema: Schema) -> String {
    written(&pairs(), schema)
}

fn written(assembly: &Assembly, schema: Schema) -> String {
    let mut out = Vec::new();
    step::write_assembly(assembly, &Options { schema, ..Options::default() }, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

/// How often an entity is in a file.
fn count(file: &str, entity: &str) -> usize {
    file.matches(&format!("={entity}(")).count()
}

#[test]
fn each_product_is_there_once() {
    for schema in [Schema::Ap203, Schema::Ap214, Schema::Ap242] {
        let file = file(schema);
        for (entity, expected) in [
            ("APPLICATION_CONTEXT", 1),
            ("PRODUCT", 4),
            ("PRODUCT_DEFINITION", 4),
            ("PRODUCT_DEFINITION_SHAPE", 9),
            ("NEXT_ASSEMBLY_USAGE_OCCURRENCE", 5),
            ("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION", 5),
            ("ITEM_DEFINED_TRANSFORMATION", 5),
            ("MANIFOLD_SOLID_BREP", 2),
        ] {
            assert_eq!(count(&file, entity), expected, "{schema:?}: {entity}");
        }
        let colours = if schema == Schema::Ap203 { 0 } else { 2 };
        assert_eq!(count(&file, "STYLED_ITEM"), colours);
        assert!(file.contains(r"PRODUCT('a\X\27);#1=B','a\X\27);#1=B','',"));
        assert!(file.contains(r"NEXT_ASSEMBLY_USAGE_OCCURRENCE('5','Gr\X2\00F600DF\X0\e','',"));
        assert!(file.contains("DIRECTION('',(0.,1.,0.))"));
    }
}

#[test]
fn a_thousand_places_cost_little() {
    let mut bricks = Assembly { parts: vec![pairs().parts[0].clone()], groups: Vec::new() };
    let members = (0..1000).map(|i| member("brick", at(f64::from(i)), Product::Part(0)));
    bricks.groups.push(AssemblyGroup {
        name: "wall".into(),
        members: members.collect(),
        ..Default::default()
    });
    let alone = step_file(&bricks.parts[0].brep, Schema::Ap242);
    let file = written(&bricks, Schema::Ap242);
    assert_eq!(
        (count(&file, "MANIFOLD_SOLID_BREP"), count(&file, "NEXT_ASSEMBLY_USAGE_OCCURRENCE")),
        (1, 1000)
    );
    assert!(file.len() < 2 * alone.len() + 2000 * 1000, "{} bytes", file.len());
}

#[test]
fn faults_are_found() {
    type Break = fn(&mut Assembly);
    let variants: [(Break, AssemblyFault); 7] = [
        (|a| a.groups.clear(), AssemblyFault::Empty),
        (|a| a.groups[0].members.clear(), AssemblyFault::EmptyGroup(0)),
        (|a| drop(a.parts.pop()), AssemblyFault::Missing(0, Product::Part(1))),
        (
            |a| a.groups[0].members[0].product = Product::Group(0),
            AssemblyFault::Missing(0, Product::Group(0)),
        ),
        (
            |a| a.groups[1].members[2].placement.axes[0] = [2.0, 0.0, 0.0],
            AssemblyFault::Place(1, 2),
        ),
        (
            |a| a.groups[1].members[0].placement.axes[0] = [-1.0, 0.0, 0.0],
            AssemblyFault::Place(1, 0),
        ),
        (|a| a.parts[0].face_colours[0].0 = FaceId(9), AssemblyFault::Face(0, 9)),
    ];
    for (spoil, fault) in variants {
        let mut assembly = pairs();
        assert_eq!(assembly.check(), Ok(()));
        spoil(&mut assembly);
        assert_eq!(assembly.check(), Err(fault.clone()));
        let error = step::write_assembly(&assembly, &Options::default(), &mut Vec::new());
        assert_eq!(error.expect_err("a fault").to_string(), fault.to_string());
    }
}
