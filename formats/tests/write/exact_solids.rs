//! Checking and writing of solids with analytic surfaces.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use formats::Brep;
use formats::brep::{
    BrepCurve, BrepSurface, EdgeId, FaceId, Frame, ModelFault, PCurve, ShellId, VertexId,
};
use formats::iges::Form;
use formats::step::Schema;

use crate::exact::{self, all_exact};
use crate::{iges_file, step_file};

#[test]
fn they_are_sound_and_have_their_volume() {
    for (brep, volume) in all_exact() {
        assert_eq!(brep.check(), Ok(()), "{}", brep.name);
        let found: f64 = (0..brep.shells.len()).map(|shell| brep.volume(ShellId(shell))).sum();
        let off = (found - volume).abs() / volume;
        assert!(off < 1e-10, "{}: {found} of {volume}, {off:.1e}", brep.name);
    }
}

#[test]
fn areas_of_faces_are_known() {
    let areas = |(brep, _): (Brep, f64)| -> Vec<f64> {
        (0..brep.faces.len()).map(|face| brep.face_area(FaceId(face))).collect()
    };
    let cone = [PI * 5.0 * 13.0, PI * 25.0];
    let cap = 7.0 * (1.0 - 0.5_f64.sin());
    let flat = [TAU * 7.0 * (14.0 - cap), PI * (7.0 * 0.5_f64.cos()).powi(2)];
    let known = [
        (areas(exact::cone()), cone.to_vec()),
        (areas(exact::cylinder()), vec![TAU * 60.0, 25.0 * PI, 25.0 * PI]),
        (areas(exact::sphere()), vec![4.0 * PI * 49.0]),
        (areas(exact::flat_sphere()), flat.to_vec()),
        (areas(exact::torus()), vec![TAU * TAU * 30.0]),
        // The mean height of the cut is that of the axis.
        (areas(exact::oblique())[..1].to_vec(), vec![TAU * 60.0]),
    ];
    for (found, wanted) in known {
        assert_eq!(found.len(), wanted.len());
        for (found, wanted) in found.into_iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-12 * wanted, "{found} of {wanted}");
        }
    }
}

#[test]
fn a_moved_one_stays_sound() {
    for (brep, volume) in all_exact() {
        let moved = brep.translated([1e3, -2e3, 5e2]);
        assert_eq!(moved.check(), Ok(()), "{}", moved.name);
        let found: f64 = (0..moved.shells.len()).map(|shell| moved.volume(ShellId(shell))).sum();
        assert!((found - volume).abs() < 1e-9 * volume, "{}: {found} of {volume}", moved.name);
    }
}

/// Broken variants of a valid part, each with its error.
#[test]
fn broken_exact_ones_are_refused() {
    type Break = fn(&mut Brep);
    type Is = fn(&ModelFault) -> bool;
    let variants: [(&str, (Brep, f64), Break, Is); 8] = [
        (
            "a cylinder that is too wide",
            exact::cylinder(),
            |b| {
                let BrepSurface::Cylinder { radius, .. } = &mut b.surfaces[0] else { return };
                *radius += 1e-3;
            },
            |f| matches!(f, ModelFault::OffSurface(_, off) if (off - 1e-3).abs() < 1e-9),
        ),
        (
            "a radius that is no number",
            exact::sphere(),
            |b| b.surfaces[0] = BrepSurface::sphere(Frame::WORLD, f64::NAN),
            |f| matches!(f, ModelFault::Measures(..)),
        ),
        (
            "a torus without a circle",
            exact::torus(),
            |b| b.surfaces[0] = BrepSurface::torus(Frame::WORLD, 0.0, 3.0),
            |f| matches!(f, ModelFault::Measures(..)),
        ),
        (
            "a torus beyond where it cuts itself",
            exact::torus(),
            |b| b.surfaces[0] = BrepSurface::torus(Frame::WORLD, 3.0, 3.5),
            |f| matches!(f, ModelFault::Leaves(_)),
        ),
        (
            "a circle that begins elsewhere",
            exact::cylinder(),
            |b| {
                let frame = Frame::WORLD.at(b.vertices[0]);
                b.edges[0].curve = BrepCurve::circle(&frame, 5.0).unwrap();
            },
            |f| matches!(f, ModelFault::Vertex(..)),
        ),
        (
            "a ring without its seam",
            exact::cylinder(),
            |b| {
                let of_seam = |edge: EdgeId| edge == EdgeId(2);
                b.faces[0].loops[0].retain(|of_loop| !of_seam(of_loop.edge));
            },
            |f| matches!(f, ModelFault::Open(_) | ModelFault::OpenInPlane(_)),
        ),
        (
            "a sphere beyond its pole",
            exact::sphere(),
            |b| {
                for of_loop in &mut b.faces[0].loops[0] {
                    let [[u, _], _] = of_loop.pcurve.ends();
                    let range = of_loop.pcurve.range();
                    let ends = [[u, FRAC_PI_2], [u, 3.0 * FRAC_PI_2]];
                    of_loop.pcurve = PCurve::line(ends[0], ends[1], range).unwrap();
                }
            },
            |f| matches!(f, ModelFault::Leaves(_)),
        ),
        (
            "a seam between two other vertices",
            exact::cylinder(),
            |b| b.edges[2].ends = [VertexId(1), VertexId(0)],
            |f| matches!(f, ModelFault::Vertex(..)),
        ),
    ];
    for (name, (mut brep, _), damage, is) in variants {
        assert_eq!(brep.check(), Ok(()), "{name}");
        damage(&mut brep);
        let fault = brep.check().expect_err(name);
        assert!(is(&fault), "{name}: {fault:?}");
    }
}

#[test]
fn curves_with_wrong_measures_are_refused() {
    let frame = Frame::WORLD;
    assert!(BrepCurve::line([1.0; 3], [1.0; 3]).is_err());
    assert!(BrepCurve::circle(&frame, 0.0).is_err());
    assert!(BrepCurve::arc(&frame, 1.0, 7.0).is_err());
    assert!(BrepCurve::ellipse(&frame, [1.0, 2.0], (0.0, 1.0)).is_err());
    assert!(BrepCurve::ellipse(&frame, [2.0, 1.0], (-1.0, 1.0)).is_err());
    assert!(PCurve::line([0.0; 2], [f64::NAN, 1.0], (0.0, 1.0)).is_err());
    let clockwise = PCurve::on_plane(&frame.flipped(), &BrepCurve::circle(&frame, 1.0).unwrap());
    assert!(clockwise.is_err());
}

#[test]
fn a_reversed_curve_has_the_same_points() {
    let arc = BrepCurve::arc(&Frame::WORLD.at([1.0, 2.0, 3.0]), 4.0, 2.0).unwrap();
    let line = BrepCurve::line([1.0, 2.0, 3.0], [5.0, 5.0, 3.0]).unwrap();
    for curve in [arc, line] {
        let (start, end) = curve.range();
        let back = curve.reversed().unwrap();
        for share in [0.0, 0.3, 1.0] {
            let t = start + share * (end - start);
            let (p, q) = (curve.point(t), back.point(start + end - t));
            assert!((0..3).all(|k| (p[k] - q[k]).abs() < 1e-14), "{p:?} and {q:?}");
        }
    }
}

#[test]
fn step_has_its_surfaces_and_curves_by_name() {
    let count = |file: &str, entity: &str| file.matches(&format!("={entity}(")).count();
    type Named = ((Brep, f64), &'static [(&'static str, usize)]);
    let named: [Named; 8] = [
        (exact::exact_box(), &[("PLANE", 6), ("LINE", 12), ("SURFACE_CURVE", 12)]),
        // Top and bottom share the circle of their parameter planes.
        (exact::plate(), &[("CYLINDRICAL_SURFACE", 1), ("CIRCLE", 3), ("SEAM_CURVE", 1)]),
        (exact::cone(), &[("CONICAL_SURFACE", 1), ("SEAM_CURVE", 1)]),
        (exact::sphere(), &[("SPHERICAL_SURFACE", 1), ("VERTEX_LOOP", 1), ("EDGE_CURVE", 0)]),
        (exact::torus(), &[("TOROIDAL_SURFACE", 1), ("SEAM_CURVE", 2)]),
        (exact::oblique(), &[("ELLIPSE", 2)]),
        (exact::extrusion(), &[("SURFACE_OF_LINEAR_EXTRUSION", 1)]),
        (exact::revolution(), &[("SURFACE_OF_REVOLUTION", 1), ("AXIS1_PLACEMENT", 1)]),
    ];
    for ((brep, _), entities) in named {
        let file = step_file(&brep, Schema::Ap242);
        for (entity, wanted) in entities {
            let found = count(&file, entity);
            // There are also lines of the parameter planes, which are shared where they are the same.
            let enough = if *entity == "LINE" { found >= *wanted } else { found == *wanted };
            assert!(enough, "{}: {found} {entity}", brep.name);
        }
        let uses: usize = brep.uses().iter().map(Vec::len).sum();
        let whole_sphere = count(&file, "VERTEX_LOOP") * 2;
        assert_eq!(count(&file, "PCURVE"), uses - whole_sphere, "{}", brep.name);
        assert!(file.contains("FILE_DESCRIPTION(('Trimmed surfaces')"));
    }
}

#[test]
fn iges_has_its_surfaces_and_curves_by_number() {
    let count = |file: &str, number: u16| {
        let entry = format!("{number:8}");
        let is_entry = |line: &&str| line.as_bytes()[72] == b'D' && line.starts_with(&entry);
        file.lines().filter(is_entry).count() / 2
    };
    type Numbered = ((Brep, f64), &'static [(u16, usize)]);
    let numbered: [Numbered; 8] = [
        (exact::exact_box(), &[(190, 6), (110, 12 + 24)]),
        (exact::plate(), &[(190, 6), (192, 1), (100, 2 + 2)]),
        (exact::cone(), &[(194, 1)]),
        (exact::sphere(), &[(196, 1)]),
        (exact::torus(), &[(198, 1)]),
        (exact::oblique(), &[(104, 2)]),
        (exact::extrusion(), &[(122, 1)]),
        (exact::revolution(), &[(120, 1)]),
    ];
    for ((brep, _), entities) in numbered {
        let file = iges_file(&brep, Form::Brep);
        for (number, wanted) in entities {
            assert_eq!(count(&file, *number), *wanted, "{} {number}", brep.name);
        }
        assert_eq!(count(&file, 186), 1);
        assert!(file.starts_with("Trimmed surfaces in millimetres"));
    }
}

#[test]
fn a_box_is_small_and_files_are_always_the_same() {
    assert!(step_file(&exact::exact_box().0, Schema::Ap242).len() <= 16 << 10);
    for ((first, _), (second, _)) in all_exact().into_iter().zip(all_exact()) {
        let files = [&first, &second].map(|brep| {
            let iges = [Form::Brep, Form::Trimmed].map(|form| iges_file(brep, form));
            (step_file(brep, Schema::Ap242), iges)
        });
        assert_eq!(files[0], files[1], "{}", first.name);
    }
}

/// truck has planes and lines as such, but no circles.
#[test]
fn planes_and_lines_go_to_truck_and_back() {
    let (brep, volume) = exact::exact_box();
    let solid = brep.truck_solid(&brep.solids[0]).unwrap();
    assert!(solid.is_geometric_consistent());
    let mut back = crate::bodies::empty("back");
    back.add_truck_solid(&solid).unwrap();
    assert_eq!(back.check(), Ok(()));
    assert!((back.volume(ShellId(0)) - volume).abs() < 1e-9 * volume);
    assert!(back.surfaces.iter().all(|on| matches!(on, BrepSurface::Plane { .. })));
    assert!(back.edges.iter().all(|edge| matches!(edge.curve, BrepCurve::Line(_))));
    let (bracket, _) = exact::bracket();
    let refused = bracket.truck_solid(&bracket.solids[0]).unwrap_err();
    assert_eq!(refused.to_string(), "an edge on a circle or an ellipse");
}

#[test]
fn a_pole_at_a_corner_is_found() {
    let (polar, volume) = exact::octant(true);
    assert_eq!(polar.check(), Ok(()));
    assert!((polar.volume(ShellId(0)) - volume).abs() < 1e-12 * volume);
    let corners = polar.corner_poles();
    let faces: Vec<FaceId> = corners.iter().map(|corner| corner.0).collect();
    assert_eq!(faces, vec![FaceId(3)]);
    let [x, y, _] = polar.vertices[corners[0].1.0];
    assert!(x.hypot(y) < 1e-12, "the corner is on the axis");
    for (brep, _) in all_exact() {
        assert_eq!(brep.corner_poles(), vec![], "{}", brep.name);
    }
}

/// Pcurves end beside the vertices of loose models. Where there is no pole, that changes nothing about the order of a loop.
#[test]
fn gaps_between_pcurves_do_not_change_the_order_of_loops() {
    // The number and the direction of the edge of each use, in the order of the file.
    let order = |brep: &Brep| -> Vec<(Option<usize>, bool)> {
        let file = step_file(brep, Schema::Ap242);
        let edges = file.lines().filter(|line| line.contains("=EDGE_CURVE("));
        let edges: Vec<&str> = edges.filter_map(|line| line.split('=').next()).collect();
        let uses = file.lines().filter(|line| line.contains("=ORIENTED_EDGE("));
        let of = |line: &str| {
            let edge = line.split(',').nth(3);
            (edges.iter().position(|name| Some(*name) == edge), line.contains(".T."))
        };
        uses.map(of).collect()
    };
    let mut count = 0;
    for (mut brep, _) in [exact::elbow(), exact::cylinder(), exact::plate()] {
        brep.uncertainty_mm = 1e-6;
        let whole = order(&brep);
        assert!(whole.iter().all(|of| of.0.is_some()), "{}", brep.name);
        for (face, ring, n) in uses(&brep) {
            let of_loop = &brep.faces[face].loops[ring][n];
            let range = of_loop.pcurve.range();
            let PCurve::Line(_) = of_loop.pcurve else { continue };
            for end in 0..2 {
                let mut ends = of_loop.pcurve.ends();
                // The line gets a little shorter.
                let [from, to] = [ends[end], ends[1 - end]];
                let length = (to[0] - from[0]).hypot(to[1] - from[1]);
                ends[end] = [0, 1].map(|k| from[k] + 1e-8 * (to[k] - from[k]) / length);
                let mut loose = brep.clone();
                loose.faces[face].loops[ring][n].pcurve =
                    PCurve::line(ends[0], ends[1], range).unwrap();
                assert_eq!(order(&loose), whole, "{}: face {face}, use {n}", brep.name);
                assert_eq!(loose.corner_poles(), vec![], "{}: face {face}, use {n}", brep.name);
                count += 1;
            }
        }
    }
    assert!(count > 16, "{count} pcurves are lines");
}

/// The face, the loop and the place in it of each use of an edge.
fn uses(brep: &Brep) -> Vec<(usize, usize, usize)> {
    let faces = brep.faces.iter().enumerate();
    let loops = faces
        .flat_map(|(face, of)| of.loops.iter().enumerate().map(move |(k, ring)| (face, k, ring)));
    loops.flat_map(|(face, k, ring)| (0..ring.len()).map(move |n| (face, k, n))).collect()
}
