//! Checking and writing of solids.

use formats::Brep;
use formats::brep::{BrepCurve, EdgeId, Face, FaceId, ModelFault, PCurve, ShellId, VertexId};
use formats::spline::SplineCurve;

use crate::bodies::{add_box, all, cube, empty, hollow, torus, two_bodies};
use crate::model::bezier;

#[test]
fn they_are_sound_and_have_their_volume() {
    for (name, brep, volume) in all() {
        assert_eq!(brep.check(), Ok(()), "{name}");
        assert!(brep.uses().iter().all(|uses| uses.len() == 2), "{name}");
        let found: f64 = (0..brep.shells.len()).map(|shell| brep.volume(ShellId(shell))).sum();
        assert!((found - volume).abs() < 1e-8 * volume, "{name}: {found} of {volume}");
    }
}

#[test]
fn the_area_is_known() {
    use std::f64::consts::PI;
    let [large, small] = crate::bodies::RADII;
    let areas = [(torus(""), 4.0 * PI * PI * large * small), (cube(""), 2200.0)];
    for (brep, area) in areas {
        let found = brep.area(ShellId(0));
        assert!((found - area).abs() < 1e-7 * area, "{found} of {area}");
    }
}

/// Broken variants of a valid part, each with its error.
#[test]
fn broken_ones_are_refused() {
    type Break = fn(&mut Brep);
    type Is = fn(&ModelFault) -> bool;
    let variants: [(&str, Brep, Break, Is); 16] = [
        (
            "a face is left out",
            cube(""),
            |b| b.shells[0].faces.truncate(5),
            |f| matches!(f, ModelFault::Owners(..)),
        ),
        (
            "a face is not there",
            cube(""),
            |b| drop(b.faces.pop()),
            |f| matches!(f, ModelFault::Missing(..)),
        ),
        (
            "open, but closed by its word",
            cube(""),
            |b| {
                b.faces.pop();
                b.shells[0].faces.pop();
            },
            |f| matches!(f, ModelFault::Uses { uses: 1, .. }),
        ),
        (
            "a face in it twice",
            cube(""),
            |b| {
                let twice = b.faces[0].clone();
                let face = b.add_face(twice);
                b.shells[0].faces.push(face);
            },
            |f| matches!(f, ModelFault::Uses { uses: 3, .. }),
        ),
        (
            "a face looks inwards",
            cube(""),
            |b| turn(b, 0),
            |f| matches!(f, ModelFault::Turned { .. }),
        ),
        (
            "all faces look inwards",
            cube(""),
            |b| (0..6).for_each(|face| turn(b, face)),
            |f| matches!(f, ModelFault::InsideOut(..)),
        ),
        (
            "a loop without one of its edges",
            cube(""),
            |b| drop(b.faces[0].loops[0].pop()),
            |f| matches!(f, ModelFault::Open(_)),
        ),
        (
            "a vertex that is moved",
            torus(""),
            |b| b.vertices[0][2] += 1e-3,
            |f| matches!(f, ModelFault::Vertex(..)),
        ),
        (
            "a vertex that is no number",
            cube(""),
            |b| b.vertices[0][2] = f64::NAN,
            |f| matches!(f, ModelFault::NotFinite(_)),
        ),
        (
            "an edge off its surface",
            torus(""),
            |b| {
                let BrepCurve::Spline(arc) = &b.edges[0].curve else { return };
                let mut poles = arc.poles().to_vec();
                poles[2][2] += 1e-3;
                let weights = arc.weights().map(<[f64]>::to_vec);
                let arc = SplineCurve::new(3, bezier(3), poles, weights).unwrap();
                b.edges[0].curve = BrepCurve::Spline(arc);
            },
            |f| matches!(f, ModelFault::OffSurface(_, off) if *off > 1e-4),
        ),
        (
            "a pcurve over another range",
            cube(""),
            |b| {
                let [from, to] = b.faces[0].loops[0][0].pcurve.ends();
                b.faces[0].loops[0][0].pcurve = PCurve::line(from, to, (0.0, 2.0)).unwrap();
            },
            |f| matches!(f, ModelFault::Range(_)),
        ),
        (
            "a face with its loop turned round",
            cube(""),
            |b| b.faces[0].forward = false,
            |f| matches!(f, ModelFault::WrongWay(_)),
        ),
        (
            "two boxes that share a corner",
            two_bodies(""),
            |b| {
                let others = std::mem::take(&mut b.shells[1].faces);
                b.shells[0].faces.extend(others);
                b.shells.pop();
                b.solids.pop();
            },
            |f| matches!(f, ModelFault::Pieces(_)),
        ),
        (
            "two corners that are one vertex",
            cube(""),
            |b| {
                for edge in &mut b.edges {
                    edge.ends = edge.ends.map(|end| if end.0 == 7 { VertexId(0) } else { end });
                }
                b.uncertainty_mm = 100.0;
            },
            |f| matches!(f, ModelFault::Euler(_, 1)),
        ),
        (
            "a void outside",
            hollow(""),
            |b| {
                let void = add_box(b, [50.0; 3], [60.0; 3], true);
                b.solids[0].voids.push(void);
            },
            |f| matches!(f, ModelFault::Outside(..)),
        ),
        (
            "an open shell in a solid",
            cube(""),
            |b| b.shells[0].closed = false,
            |f| matches!(f, ModelFault::OpenShell(..)),
        ),
    ];
    for (name, mut brep, damage, is) in variants {
        assert_eq!(brep.check(), Ok(()), "{name}");
        damage(&mut brep);
        let fault = brep.check().expect_err(name);
        assert!(is(&fault), "{name}: {fault:?}");
        // Nothing is written of a broken part.
        let mut out = Vec::new();
        let error = formats::step::write(&brep, &Default::default(), &mut out).unwrap_err();
        assert_eq!((error.kind(), out.len()), (std::io::ErrorKind::InvalidInput, 0), "{name}");
        let error = formats::iges::write(&brep, &Default::default(), &mut out).unwrap_err();
        assert_eq!((error.to_string(), out.len()), (fault.to_string(), 0), "{name}");
    }
}

fn turn(brep: &mut Brep, face: usize) {
    let face = &mut brep.faces[face];
    face.forward = !face.forward;
    for uses in &mut face.loops {
        uses.reverse();
        uses.iter_mut().for_each(|of_loop| of_loop.forward = !of_loop.forward);
    }
}

#[test]
fn step_names_solids_voids_and_shells() {
    let file = |brep: &Brep| crate::step_file(brep, formats::step::Schema::Ap242);
    let count = |file: &str, entity: &str| file.matches(&format!("={entity}(")).count();
    for (name, brep, _) in all() {
        let file = file(&brep);
        let voids: usize = brep.solids.iter().filter(|solid| !solid.voids.is_empty()).count();
        assert_eq!(count(&file, "BREP_WITH_VOIDS"), voids, "{name}");
        assert_eq!(count(&file, "MANIFOLD_SOLID_BREP"), brep.solids.len() - voids);
        assert_eq!(count(&file, "CLOSED_SHELL"), brep.shells.len());
        assert_eq!(count(&file, "ADVANCED_BREP_SHAPE_REPRESENTATION"), 1);
        assert_eq!(count(&file, "OPEN_SHELL"), 0);
        assert_eq!(count(&file, "EDGE_CURVE") * 2, count(&file, "ORIENTED_EDGE"));
    }
    let mut mixed = cube("mixed");
    mixed.append(crate::model::one_face(""));
    assert_eq!(mixed.check(), Ok(()));
    let file = file(&mixed);
    assert_eq!(count(&file, "SHAPE_REPRESENTATION"), 1);
    assert_eq!([count(&file, "OPEN_SHELL"), count(&file, "CLOSED_SHELL")], [1, 1]);
}

/// truck accepts our solids as closed and manifold, and the way back gives the same solids.
#[test]
fn they_go_to_truck_and_back() {
    for (name, brep, volume) in all() {
        let mut back = empty(name);
        for solid in &brep.solids {
            let solid = brep.truck_solid(solid).expect(name);
            assert!(solid.is_geometric_consistent(), "{name}");
            back.add_truck_solid(&solid).expect(name);
        }
        assert_eq!(back.check(), Ok(()), "{name}");
        let counts = |b: &Brep| [b.vertices.len(), b.edges.len(), b.faces.len(), b.shells.len()];
        assert_eq!(counts(&back), counts(&brep), "{name}");
        let found: f64 = (0..back.shells.len()).map(|shell| back.volume(ShellId(shell))).sum();
        assert!((found - volume).abs() < 1e-8 * volume, "{name}: {found} of {volume}");
    }
}

/// A solid that truck has built is converted. Its faces are planes.
#[test]
fn a_box_of_truck_is_taken_over() {
    use truck_modeling::{Point3, Vector3, builder};
    let corner = builder::vertex(Point3::new(1.0, 2.0, 3.0));
    let edge = builder::tsweep(&corner, 4.0 * Vector3::unit_x());
    let face = builder::tsweep(&edge, 5.0 * Vector3::unit_y());
    let solid = builder::tsweep(&face, 6.0 * Vector3::unit_z());
    let mut brep = empty("truck");
    brep.add_truck_solid(&solid).unwrap();
    assert_eq!(brep.check(), Ok(()));
    assert!((brep.volume(ShellId(0)) - 120.0).abs() < 1e-9);
}

#[test]
fn faces_on_one_surface_share_it() {
    let mut brep = crate::model::one_face("");
    // An island in the first hole: the same edges in the opposite direction.
    let mut island = brep.faces[0].loops[1].clone();
    island.reverse();
    island.iter_mut().for_each(|of_loop| of_loop.forward = !of_loop.forward);
    let surface = brep.faces[0].surface;
    brep.add_face(Face { surface, forward: true, loops: vec![island] });
    brep.shells[0].faces.push(FaceId(1));
    assert_eq!(brep.check(), Ok(()));
    let file = crate::step_file(&brep, formats::step::Schema::Ap242);
    assert_eq!(file.matches("=B_SPLINE_SURFACE_WITH_KNOTS(").count(), 1);
    assert_eq!(file.matches("=ADVANCED_FACE(").count(), 2);
    let file = crate::iges_file(&brep, formats::iges::Form::Trimmed);
    assert_eq!(file.lines().filter(|line| line.starts_with("     128 ")).count(), 2);
    let of_edges = brep.uses();
    assert_eq!(of_edges[EdgeId(4).0].len(), 2);
}
