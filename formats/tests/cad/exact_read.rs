//! Reading of our own solids with analytic surfaces.

use formats::brep::BrepSurface;
use formats::cad::{CadSurface, CurveShape};

use crate::{exact, files, read};

fn length(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Whether a surface that was read is the one that was written. Extrusions and revolutions may have
/// other parameters.
fn is_same(found: &CadSurface, written: &BrepSurface) -> bool {
    let close = |a: f64, b: f64| (a - b).abs() < 1e-13 * (1.0 + b.abs());
    match (found, written) {
        (CadSurface::Plane { origin, .. }, BrepSurface::Plane { frame }) => {
            *origin == frame.origin()
        }
        (CadSurface::Cylinder { origin, x, .. }, BrepSurface::Cylinder { frame, radius }) => {
            *origin == frame.origin() && close(length(*x), *radius)
        }
        (
            CadSurface::Cone { origin, radius, slope, .. },
            BrepSurface::Cone { frame, radius: wanted, half_angle },
        ) => *origin == frame.origin() && radius == wanted && close(*slope, half_angle.tan()),
        (CadSurface::Sphere { origin, z, .. }, BrepSurface::Sphere { frame, radius }) => {
            *origin == frame.origin() && close(length(*z), *radius)
        }
        (
            CadSurface::Torus { major, minor, .. },
            BrepSurface::Torus { major: wide, minor: thin, .. },
        ) => (major, minor) == (wide, thin),
        (CadSurface::Extrusion { .. }, BrepSurface::Extrusion { .. }) => true,
        (CadSurface::Revolution { origin, .. }, BrepSurface::Revolution { origin: on, .. }) => {
            origin == on
        }
        _ => false,
    }
}

#[test]
fn surfaces_read_back() {
    for (brep, _) in exact::all_exact() {
        for file in files(&brep) {
            let model = read(&file).unwrap();
            assert_eq!(model.faces.len(), brep.faces.len(), "{}", brep.name);
            for (face, written) in model.faces.iter().zip(&brep.faces) {
                let written = &brep.surfaces[written.surface.0];
                assert!(is_same(&face.surface, written), "{} {}", brep.name, face.entity);
            }
        }
    }
}

#[test]
fn an_ellipse_reads_back() {
    let (brep, _) = exact::oblique();
    for file in files(&brep) {
        let model = read(&file).unwrap();
        let edges = model.faces.iter().flat_map(|face| face.loops.iter().flatten());
        let curves = edges.filter_map(|edge| edge.curve.as_ref());
        let radii = curves.filter_map(|curve| match curve.shape {
            CurveShape::Ellipse { x, y, .. } => Some([length(x), length(y)]),
            _ => None,
        });
        let [a, b] = [5.0 / 0.5_f64.cos(), 5.0];
        let is_ellipse = |[x, y]: &[f64; 2]| (x - a).abs() < 1e-12 && (y - b).abs() < 1e-12;
        assert_eq!(radii.filter(is_ellipse).count(), 2, "one on each face");
    }
}

/// A whole sphere has a vertex as its boundary in STEP.
#[test]
fn a_vertex_bounds_a_whole_sphere() {
    let (brep, _) = exact::hollow_box();
    let [step, ..] = files(&brep);
    let model = read(&step).unwrap();
    let whole: Vec<bool> = model.faces.iter().map(|face| face.natural).collect();
    assert_eq!(whole, [false, false, false, false, false, false, true]);
    assert_eq!((model.solids[0].outer, model.solids[0].voids.len()), (0, 1));
}

/// The angle of a cone is in the unit of the file.
#[test]
fn the_angle_of_a_cone_may_be_in_degrees() {
    let (brep, _) = exact::truncated_cone();
    let [step, ..] = files(&brep);
    let radians = "(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))";
    let degrees = "(CONVERSION_BASED_UNIT('DEGREE',#99001)NAMED_UNIT(#99003)PLANE_ANGLE_UNIT())";
    let units = format!(
        "#99001=PLANE_ANGLE_MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE(0.017453292519943295),#99002);\n\
         #99002={radians};\n#99003=DIMENSIONAL_EXPONENTS(0.,0.,0.,0.,0.,0.,0.);\nENDSEC;\nEND-ISO"
    );
    let turned = step.replacen(radians, degrees, 1).replace("ENDSEC;\nEND-ISO", &units);
    let turned = turned.replace(",5.,0.3)", &format!(",5.,{})", 0.3_f64.to_degrees()));
    let model = read(&turned).unwrap();
    let CadSurface::Cone { slope, .. } = *model.faces[0].surface else { panic!() };
    assert!((slope - 0.3_f64.tan()).abs() < 1e-14);
}
