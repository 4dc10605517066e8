//! Solids that are built by hand: written, read back, and imported by OpenCASCADE and FreeCAD.

// The models are those of the writers' own tests.
#[path = "../../formats/tests/write/bodies.rs"]
mod bodies;
#[path = "../../formats/tests/write/exact.rs"]
mod exact;
#[allow(dead_code)]
#[path = "../../formats/tests/write/model.rs"]
mod model;

use crate::common::importers::{freecad_solid, opencascade_healed, opencascade_solid};
use crate::common::number;
use formats::Brep;
use formats::brep::{BrepSurface, Face, ShellId};
use formats::cad::read_cad;
use formats::{iges, step};
use scan2step::check::check;
use scan2step::geometry::{Point, VertexId};
use scan2step::mesh::Mesh;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Writes a model as STEP and as IGES.
fn files(folder: &Path, brep: &Brep) -> [PathBuf; 2] {
    let [step_path, iges_path] =
        ["step", "igs"].map(|end| folder.join("solid").with_extension(end));
    let mut out = File::create(&step_path).expect("a temporary file");
    step::write(brep, &step::Options::default(), &mut out).expect("it is sound");
    let mut out = File::create(&iges_path).expect("a temporary file");
    let options = iges::Options { form: iges::Form::Brep, ..Default::default() };
    iges::write(brep, &options, &mut out).expect("it is sound");
    [step_path, iges_path]
}

#[test]
fn opencascade_finds_them_valid_without_healing() {
    for (name, brep, volume) in bodies::all() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for path in files(folder.path(), &brep) {
            let found = opencascade_solid(&path);
            let counts = [
                ("solids", brep.solids.len()),
                ("shells", brep.shells.len()),
                ("faces", brep.faces.len()),
                ("edges", brep.edges.len()),
                ("vertices", brep.vertices.len()),
            ];
            for (part, count) in counts {
                assert_eq!(found[part], count, "{part} of {name} in {found}");
            }
            assert_eq!(found["valid"], true, "{name}: {found}");
            assert_eq!(found["uses"], serde_json::json!({ "2": brep.edges.len() }), "{name}");
            assert_eq!(found["argument_faults"], serde_json::json!([]), "{name}");
            let off = (number(&found, "/volume") - volume).abs();
            assert!(off < 1e-9 * volume, "{name}: {found} instead of {volume}");
        }
    }
}

#[test]
fn freecad_cuts_and_rounds_them() {
    for (name, brep, volume) in bodies::all() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let [path, _] = files(folder.path(), &brep);
        let Some(found) = freecad_solid(&path) else { return };
        assert_eq!(found["solids"], brep.solids.len(), "{name}: {found}");
        assert_eq!(found["valid"], true, "{name}: {found}");
        assert_eq!(found["check"], serde_json::Value::Null, "{name}: {found}");
        assert!((number(&found, "/volume") - volume).abs() < 1e-3 * volume, "{name}: {found}");
        assert_eq!(found["cut_valid"], true, "{name}: {found}");
        let (cut, rounded) = (number(&found, "/cut_volume"), number(&found, "/fillet_volume"));
        assert!(cut > 0.1 * volume && cut < 0.9 * volume, "{name}: {found}");
        assert!(rounded < cut && rounded > 0.9 * cut, "{name}: {found}");
    }
}

#[test]
fn our_own_readers_read_them_back() {
    for (name, brep, _) in bodies::all() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for path in files(folder.path(), &brep) {
            let model = read_cad(&path).expect("it is a file of ours");
            assert_eq!(model.faces.len(), brep.faces.len(), "{name}");
            assert!(model.shells.iter().all(|shell| shell.closed), "{name}");
            let shells: Vec<usize> = model.shells.iter().map(|shell| shell.faces.len()).collect();
            let written: Vec<usize> = brep.shells.iter().map(|shell| shell.faces.len()).collect();
            assert_eq!(shells, written, "{name}");
            let solids = model.solids.iter().map(|solid| (solid.outer, solid.voids.len()));
            let written = brep.solids.iter().map(|solid| (solid.outer.0, solid.voids.len()));
            assert!(solids.eq(written), "{name}");
        }
    }
}

/// The kinds of the faces' surfaces in the words of OpenCASCADE, in alphabetical order.
fn kinds(brep: &Brep) -> Vec<&'static str> {
    let kind = |face: &Face| match &brep.surfaces[face.surface.0] {
        BrepSurface::Plane { .. } => "Plane",
        BrepSurface::Cylinder { .. } => "CylindricalSurface",
        BrepSurface::Cone { .. } => "ConicalSurface",
        BrepSurface::Sphere { .. } => "SphericalSurface",
        BrepSurface::Torus { .. } => "ToroidalSurface",
        BrepSurface::Extrusion { .. } => "SurfaceOfLinearExtrusion",
        BrepSurface::Revolution { .. } => "SurfaceOfRevolution",
        _ => "BSplineSurface",
    };
    let mut kinds: Vec<_> = brep.faces.iter().map(kind).collect();
    kinds.sort_unstable();
    kinds
}

#[test]
fn opencascade_finds_exact_ones_valid_without_healing() {
    for (brep, volume) in exact::all_exact() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for path in files(folder.path(), &brep) {
            let found = opencascade_solid(&path);
            let name = format!("{} as {}: {found}", brep.name, path.display());
            let counts = [
                ("solids", brep.solids.len()),
                ("shells", brep.shells.len()),
                ("faces", brep.faces.len()),
            ];
            for (part, count) in counts {
                assert_eq!(found[part], count, "{part} of {name}");
            }
            assert_eq!(found["valid"], true, "{name}");
            assert_eq!(found["argument_faults"], serde_json::json!([]), "{name}");
            assert_eq!(found["surfaces"], serde_json::json!(kinds(&brep)), "{name}");
            let uses = found["uses"].as_object().expect("an object");
            assert!(uses.keys().eq(["2"]), "every edge is used twice: {name}");
            assert!(number(&found, "/tolerance") <= brep.uncertainty_mm, "{name}");
            let off = (number(&found, "/volume") - volume).abs();
            assert!(off < 1e-9 * volume, "{name} instead of {volume}");
        }
    }
}

/// Trimmed surfaces (144) share no edges, so importers have to heal them.
#[test]
fn opencascade_reads_exact_ones_as_trimmed_surfaces() {
    for (brep, _) in exact::all_exact() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("trimmed.igs");
        iges::write(&brep, &iges::Options::default(), &mut File::create(&path).expect("a file"))
            .expect("it is sound");
        let found = opencascade_healed(&path);
        assert_eq!(found["faces"], brep.faces.len(), "{}: {found}", brep.name);
        assert_eq!(found["valid"], true, "{}: {found}", brep.name);
        let area: f64 = (0..brep.shells.len()).map(|shell| brep.area(ShellId(shell))).sum();
        // OpenCASCADE integrates to 1e-5, but faces that end at a spline only to a thousandth.
        let is_spline =
            |edge: &formats::brep::Edge| matches!(edge.curve, formats::brep::BrepCurve::Spline(_));
        let bound = if brep.edges.iter().any(is_spline) { 1e-3 } else { 1e-5 };
        let off = number(&found, "/area") / area - 1.0;
        assert!(off.abs() < bound, "{}: {off:e} off {area}: {found}", brep.name);
    }
}

#[test]
fn freecad_cuts_and_rounds_exact_ones() {
    let several = [exact::plate(), exact::cone(), exact::flat_sphere(), exact::crossed()];
    for (brep, volume) in several {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for path in files(folder.path(), &brep) {
            let Some(found) = freecad_solid(&path) else { return };
            assert_eq!(found["solids"], 1, "{}: {found}", brep.name);
            assert_eq!(found["valid"], true, "{}: {found}", brep.name);
            assert_eq!(found["check"], serde_json::Value::Null, "{}: {found}", brep.name);
            let off = (number(&found, "/volume") - volume).abs();
            assert!(off < 1e-6 * volume, "{}: {found}", brep.name);
            assert_eq!(found["cut_valid"], true, "{}: {found}", brep.name);
            let (cut, rounded) = (number(&found, "/cut_volume"), number(&found, "/fillet_volume"));
            assert!(cut > 0.1 * volume && cut < 0.9 * volume, "{}: {found}", brep.name);
            assert!(rounded < cut && rounded > 0.9 * cut, "{}: {found}", brep.name);
        }
    }
}

/// Points inside of a face: those of a grid of its parameters that its pcurves surround.
fn points_of(brep: &Brep, face: &Face) -> Vec<Point> {
    let side = |of_loop: &formats::brep::EdgeUse| {
        let (a, b) = of_loop.pcurve.range();
        let at = |i: usize| of_loop.pcurve.point(a + (b - a) * i as f64 / 200.0);
        let mut side: Vec<[f64; 2]> = (0..=200).map(at).collect();
        if !of_loop.forward {
            side.reverse();
        }
        side
    };
    // The first point of each loop is not repeated. Jumps at poles become sides.
    let outlines: Vec<Vec<[f64; 2]>> =
        face.loops.iter().map(|ring| ring.iter().flat_map(side).collect()).collect();
    let all = || outlines.iter().flatten();
    let range = |k: usize| {
        let values = || all().map(move |p| p[k]);
        (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
    };
    let (us, vs) = (range(0), range(1));
    let inside = |[u, v]: [f64; 2]| {
        let crossings = outlines.iter().map(|outline| {
            let sides = outline.iter().zip(outline.iter().cycle().skip(1));
            let crossed = sides.filter(|(p, q)| {
                (p[1] > v) != (q[1] > v) && u < p[0] + (v - p[1]) / (q[1] - p[1]) * (q[0] - p[0])
            });
            crossed.count()
        });
        crossings.sum::<usize>() % 2 == 1
    };
    const STEPS: usize = 9;
    let at =
        |(from, to): (f64, f64), i: usize| from + (to - from) * (i as f64 + 0.5) / STEPS as f64;
    let grid = (0..STEPS * STEPS).map(|k| [at(us, k / STEPS), at(vs, k % STEPS)]);
    let surface = &brep.surfaces[face.surface.0];
    grid.filter(|place| inside(*place)).map(|[u, v]| surface.point(u, v).into()).collect()
}

#[test]
fn check_measures_exact_ones() {
    for (brep, _) in exact::all_exact() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut paths = files(folder.path(), &brep).to_vec();
        paths.push(folder.path().join("trimmed.igs"));
        let mut out = File::create(&paths[2]).expect("a temporary file");
        iges::write(&brep, &iges::Options::default(), &mut out).expect("it is sound");
        let points: Vec<Point> =
            brep.faces.iter().flat_map(|face| points_of(&brep, face)).collect();
        assert!(points.len() > 20, "{}", brep.name);
        let corner = |k: usize| VertexId::from(k);
        let triangles = (2..points.len()).map(|k| [corner(k - 2), corner(k - 1), corner(k)]);
        let scan = Mesh { triangles: triangles.collect(), points };
        for path in paths {
            let model = read_cad(&path).expect("it is a file of ours");
            let report = check(&model, &scan, None).expect("it is valid");
            let what = format!("{} as {}: {report:?}", brep.name, path.display());
            assert!(report.scan_to_face.max < 1e-6 * scan.diagonal(), "{what}");
            // Curves without a common parameter are compared by their chords.
            assert!(report.max_off_surface < 1e-6 + report.resolution, "{what}");
            let area: f64 = (0..brep.shells.len()).map(|shell| brep.area(ShellId(shell))).sum();
            assert!((report.area - area).abs() < 0.02 * area, "{what} instead of {area}");
        }
    }
}
