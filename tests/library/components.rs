//! Several components of a scan in one B-rep, and options that name places by the scan's file.

use crate::common::fixture;
use crate::common::{OneFace, body_of, face_of, face_seen};
use formats::{LengthUnit, Soup, step};
use scan2step::geometry::Point;
use scan2step::mesh::{self, Choice, Components, Outer};
use scan2step::{Error, Options, Part, ScanPlace, Stage, TargetShape, convert};

/// Square sheets of so many squares a side, each 100 mm from the last, in one scan.
fn sheets(sides: &[u32]) -> Soup {
    let mut soup = Soup::default();
    for (k, &n) in sides.iter().enumerate() {
        let first = soup.points.len() as u32;
        for at in 0..(n + 1) * (n + 1) {
            let (x, y) = (f64::from(at % (n + 1)), f64::from(at / (n + 1)));
            soup.points.push([x + 100.0 * k as f64, y, 0.1 * x.sin()]);
        }
        for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
            let a = first + j * (n + 1) + i;
            soup.polygons.push([a, a + 1, a + n + 2, a + n + 1]);
        }
    }
    soup
}

fn components(soup: &Soup) -> Components {
    Components::new(mesh::from_soup(soup, 1.0).expect("a mesh"))
}

#[test]
fn all_components_become_shells_of_one_model() {
    let soup = sheets(&[8, 10, 6]);
    let scan = components(&soup);
    let options = Options::builder().name("sheets").all_components(true).tolerance(0.05).build();
    let options = options.expect("sound options");
    let all = scan.all(options.outer());
    assert_eq!(all, [0, 1, 2].map(Choice::Number));
    let (mut number, mut done) = (None, Vec::new());
    let mut watch = |stage: Stage| {
        match stage {
            Stage::Component(begun) => number = Some(begun),
            Stage::Done(body) => done.push((number, body.input.vertices)),
            _ => {}
        }
        Ok(())
    };
    let conversion = convert(&scan, &options, &mut watch).expect("faces");
    // The largest one comes first.
    assert_eq!(done, [(Some(0), 121), (Some(1), 81), (Some(2), 49)]);
    let Part { brep, bodies: made, .. } = &conversion.parts[0];
    assert_eq!((brep.name.as_str(), brep.shells.len(), brep.faces.len()), ("sheets", 3, 3));
    assert!(brep.check().is_ok());
    let each: usize = made.iter().map(|c| c.brep.edges.len()).sum();
    assert_eq!(brep.edges.len(), each);
    let farthest = made.iter().map(|c| c.brep.uncertainty_mm).fold(0.0, f64::max);
    assert_eq!(brep.uncertainty_mm, farthest);
    let mut file = Vec::new();
    step::write(brep, &step::Options::default(), &mut file).expect("a file");
    let text = String::from_utf8(file).expect("STEP is text");
    assert_eq!(text.matches("=OPEN_SHELL(").count() + text.matches("= OPEN_SHELL(").count(), 3);
}

#[test]
fn one_component_that_fails_or_a_caller_stops_all() {
    let soup = sheets(&[8, 10]);
    let scan = components(&soup);
    let missing = Options::builder().component(Choice::Number(5)).build().expect("sound options");
    let made = convert(&scan, &missing, &mut |_| Ok(()));
    assert!(matches!(made, Err(Error::Component { asked: 5, count: 2 })));
    let mut seen = 0;
    let mut watch = |stage: Stage| {
        let Stage::Component(number) = stage else { return Ok(()) };
        seen = number;
        if number == 1 { Err(Error::Input("enough")) } else { Ok(()) }
    };
    let both = || Options::builder().all_components(true);
    let made = convert(&scan, &both().build().expect("sound options"), &mut watch);
    assert!(matches!(made, Err(Error::Input("enough"))));
    assert_eq!(seen, 1);
    let named = both().net([4, 4]).corners(Some([Point::origin(); 4])).build();
    let options = named.expect("the corners are places");
    let made = convert(&scan, &options, &mut |_| Ok(()));
    let error = made.expect_err("all corners are at one place");
    assert!(matches!(error, Error::Piece { component: 0, .. }), "{error}");
    assert!(error.to_string().starts_with("component 0: "), "{error}");
}

#[test]
fn corners_by_vertices_are_corners_by_their_points() {
    let soup = sheets(&[20]);
    let vertices = [0, 20, 440, 420];
    let step = |options: Options| {
        let made = face_of(&soup, &options).expect("a face");
        let mut file = Vec::new();
        step::write(&made.brep, &step::Options::default(), &mut file).expect("a file");
        (file, made)
    };
    let build = || Options::builder().unit_mm(2.5).tolerance(0.05);
    let places = vertices.map(ScanPlace::Vertex).to_vec();
    let (by_vertices, made) = step(build().corner_places(places).build().expect("options"));
    let points = vertices.map(|v: usize| soup.points[v]);
    let places = points.map(ScanPlace::Point).to_vec();
    let (by_places, _) = step(build().corner_places(places).build().expect("options"));
    let in_mm = points.map(|p| Point::from(p.map(|x| 2.5 * x)));
    let (by_points, _) = step(build().corners(in_mm).build().expect("options"));
    assert!(by_vertices == by_places && by_vertices == by_points);
    // The first corner is the surface's at (0, 0).
    let corner = Point::from(made.one().surface.control(0, 0));
    assert!((corner - in_mm[0]).norm() < 0.1, "{corner}");
    // Others make another surface.
    let others = [440, 420, 0, 20].map(ScanPlace::Vertex).to_vec();
    let (turned, made) = step(build().corner_places(others).build().expect("options"));
    assert!(turned != by_vertices);
    let corner = Point::from(made.one().surface.control(0, 0));
    assert!((corner - in_mm[2]).norm() < 0.1, "{corner}");
}

#[test]
fn the_loop_with_the_named_corners_is_the_outer_one() {
    let soup = formats::read_scan(&fixture("rolled_sheet.obj")).expect("a scan");
    let scan = components(&soup);
    let piece = scan.take(Choice::Largest).expect("a piece");
    let rings = piece.loops();
    assert_eq!(rings.len(), 2);
    let mesh = piece.mesh();
    for (k, ring) in rings.iter().enumerate() {
        let corners = [0, 1, 2, 3].map(|q| mesh.point(ring[q * ring.len() / 4]));
        let options = Options::builder().corners(corners).build().expect("options");
        assert_eq!(piece.outer(options.outer(), &rings), k);
    }
}

#[test]
fn places_are_looked_up_in_the_soup() {
    let soup = sheets(&[8]);
    let named = Options::builder().outer_place(ScanPlace::Vertex(81)).build().expect("options");
    let made = face_of(&soup, &named);
    let Err(Error::Vertex { asked: 81, count: 81 }) = made else { panic!("{made:?}") };
    let named = Options::builder().outer_place(ScanPlace::Vertex(80)).build().expect("options");
    let scan = components(&soup);
    let made = convert(&scan, &named, &mut |_| Ok(()));
    assert!(matches!(made, Err(Error::Input(_))), "a component has no soup");
    let resolved = named.resolved(&soup).expect("the vertex is there");
    assert_eq!(resolved.outer(), Outer::Near(soup.points[80].into()));
    assert!(convert(&scan, &resolved, &mut |_| Ok(())).is_ok());
    let three = vec![ScanPlace::Vertex(0); 3];
    let options = Options::builder().corner_places(three).build();
    assert!(matches!(options, Err(Error::Corners(_))));
}

#[test]
fn a_body_keeps_what_the_options_name() {
    let ring = fixture("ring.obj");
    let soup = formats::read_scan(&ring).expect("a mesh");
    // A length that is not the same any more once it is divided and multiplied by the unit.
    let inch = LengthUnit::Inch.in_mm();
    let tolerance = (20..).map(f64::from).find(|mm| mm / inch * inch != *mm).expect("a length");
    let named = Options::builder().unit(LengthUnit::Inch).tolerance(tolerance);
    let solid = |options: &Options| {
        let scan = scan2step::mesh_components(&soup, options).expect("a mesh");
        body_of(&scan, TargetShape::Solid, options, &mut |_| Ok(()))
    };
    let made = solid(&named.clone().build().expect("options")).expect("a solid");
    assert_eq!(made.tolerance, tolerance);
    let corners = vec![ScanPlace::Vertex(0)];
    let options = named.boundary_corner_places(corners).build().expect("options");
    assert!(matches!(solid(&options), Err(Error::Input(_))), "a component has no soup");
    assert!(solid(&options.resolved(&soup).expect("the vertex is there")).is_ok());
    let void = Options::builder().shape(TargetShape::Void).build();
    assert!(matches!(void, Err(Error::Option { option: "shape", .. })), "{void:?}");
}

#[test]
fn a_scan_that_may_need_too_much_memory_is_refused_before_the_work() {
    let soup = sheets(&[8]);
    let options = Options::builder().max_memory(25_000_000_u64).build().expect("options");
    let mut seen = 0;
    let made = face_seen(&soup, &options, &mut |_| {
        seen += 1;
        Ok(())
    });
    let Err(Error::MaxMemory { allowed, vertices, triangles, .. }) = made else {
        panic!("{made:?}")
    };
    assert_eq!((allowed, vertices, triangles, seen), (25_000_000, 81, 128, 0));
    let options = Options::builder().max_memory(1_000_000_000_u64).build().expect("options");
    assert!(face_of(&soup, &options).is_ok());
}
