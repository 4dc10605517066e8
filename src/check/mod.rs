//! How far a CAD file's faces are from a scan, in both directions: every point
//! of the scan from the faces, and samples of the trimmed faces from the scan, so
//! that a hole that was not cut out shows.

mod curve;
mod loops;
mod samples;
mod surface;

use formats::cad::{CadFace, CadModel};
use rayon::prelude::*;

use crate::deviation::{Deviation, Face};
use crate::error::{Error, Result};
use crate::geometry::{Point, Uv, uv_bounds};
use crate::mesh::{Mesh, Triangles};
use crate::threads;
use loops::{Corner, Tracer};
use samples::Samples;
use surface::Domain;

/// What was found. Lengths are mm.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Report {
    /// How many faces the file has.
    pub faces: usize,
    /// How many loops trim them.
    pub loops: usize,
    /// Their area, in mm².
    pub area: f64,
    /// The farthest that an edge's curve is from its pcurve's trace on the
    /// surface. Where the two have no parameter in common less than `resolution`
    /// is not told from nothing.
    pub max_off_surface: f64,
    /// How near the chords are that stand for edges.
    pub resolution: f64,
    /// The scan's points, from the faces.
    pub scan_to_face: Deviation,
    /// Samples of the faces, from the scan's triangles.
    pub face_to_scan: Deviation,
}

/// Chords keep to edges within this share of the scan's diagonal.
const CHORD: f64 = 1e-7;
/// Edges that should meet, or curves that should be one, are within this share of
/// it; importers heal as much.
const GAP: f64 = 1e-4;
/// Samples of the faces, for every point of the scan, about.
const SAMPLES: f64 = 2.0;
/// At the least, and at the most.
const FEWEST: f64 = 20_000.0;
const MOST: f64 = 4_000_000.0;

/// Measures the faces of a CAD file against a scan.
///
/// # Errors
/// A face cannot be put together: an edge off its surface, a loop that does not
/// close.
pub fn check(model: &CadModel, scan: &Mesh) -> Result<Report> {
    threads::run(None, || measure(model, scan))?
}

fn measure(model: &CadModel, scan: &Mesh) -> Result<Report> {
    let diagonal = scan.diagonal();
    let domains: Vec<Domain> = model.faces.iter().map(|f| Domain::whole(&f.surface)).collect();
    let (rings, off) = rings(model, &domains, diagonal)?;
    let parts: Vec<Domain> = domains.iter().zip(&rings).zip(&model.faces).map(bounded).collect();
    let faces = parts.iter().zip(rings).zip(&model.faces);
    let faces: Vec<Face<Domain>> =
        faces.map(|((domain, rings), face)| Face::of_rings(domain, rings, face.natural)).collect();
    let spacing = spacing(scan);
    let each = faces.par_iter().map(|face| Samples::of(face, spacing, MOST));
    let samples: Vec<Samples> = each.collect();

    let to_faces = scan.points.par_iter().map(|&p| distance(&faces, p)).collect();
    let triangles = Triangles::new(scan);
    let points: Vec<Point> = samples.iter().flat_map(|s| s.points.iter().copied()).collect();
    let to_scan = points.par_iter().map(|&p| triangles.nearest(p).0).collect();
    Ok(Report {
        faces: model.faces.len(),
        loops: model.faces.iter().map(|f| f.loops.len()).sum(),
        area: samples.iter().map(|s| s.area).sum(),
        max_off_surface: off,
        resolution: CHORD * diagonal,
        scan_to_face: Deviation::of(&scan.points, to_faces),
        face_to_scan: Deviation::of(&points, to_scan),
    })
}

/// The polygons of every face's loops, and the farthest that an edge is off its
/// surface.
fn rings(
    model: &CadModel,
    domains: &[Domain],
    diagonal: f64,
) -> Result<(Vec<Vec<Vec<Corner>>>, f64)> {
    let (mut rings, mut off) = (Vec::with_capacity(domains.len()), 0.0);
    for (face, domain) in model.faces.iter().zip(domains) {
        let cad = |what| Error::Cad { entity: face.entity.clone(), what };
        if face.natural && !domain.is_bounded() {
            return Err(cad("it has no bounds, and its surface neither".into()));
        }
        let mut tracer = Tracer {
            surface: domain,
            chord: CHORD * diagonal,
            gap: GAP * diagonal,
            off_surface: off,
        };
        let polygons = face.loops.iter().map(|edges| tracer.polygon(edges));
        let polygons: std::result::Result<_, _> = polygons.collect();
        rings.push(polygons.map_err(cad)?);
        off = tracer.off_surface;
    }
    Ok((rings, off))
}

/// The part of a surface that a face's loops bound.
fn bounded<'a>(
    ((domain, rings), face): ((&Domain<'a>, &Vec<Vec<Corner>>), &CadFace),
) -> Domain<'a> {
    let endless = [f64::NEG_INFINITY, f64::INFINITY].map(|x| Uv::new(x, x));
    let corners: Vec<Uv> = rings.iter().flatten().map(|c| c.0).collect();
    domain.within(if face.natural { endless } else { uv_bounds(&corners) })
}

/// How far apart samples are, in mm: so that there are enough for the scan.
fn spacing(scan: &Mesh) -> f64 {
    let area: f64 = scan.triangles.iter().map(|t| 0.5 * scan.area_vector(*t).norm()).sum();
    let count = (SAMPLES * scan.points.len() as f64).clamp(FEWEST, MOST);
    (area / count).sqrt().max(f64::MIN_POSITIVE)
}

/// The distance of `p` from the nearest face.
fn distance(faces: &[Face<Domain>], p: Point) -> f64 {
    let mut order: Vec<(f64, &Face<Domain>)> = faces.iter().map(|f| (f.outside(p), f)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let nearer = |best: f64, (outside, face): (f64, &Face<Domain>)| {
        if outside < best { best.min(face.nearest(p, None).1) } else { best }
    };
    order.into_iter().fold(f64::INFINITY, nearer)
}
