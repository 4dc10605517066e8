//! Comparison of the faces of a CAD file with a scan.
//!
//! The input is a CAD model and a mesh. The output is the distances in both directions: from every
//! point of the scan to the faces, and from samples of the trimmed faces to the scan. The second
//! direction shows holes that were not trimmed away. Edges are followed by chords, and nearest
//! points are found by foot points on the surfaces.

mod curve;
mod loops;
mod samples;
mod surface;

use formats::cad::{CadFace, CadModel};
use rayon::prelude::*;

use crate::deviation::{Deviation, FaceTree, SAMPLED, TrimmedFace};
use crate::error::{Error, Result};
use crate::geometry::{Point, Uv, box_of, uv_bounds};
use crate::mesh::{Mesh, Triangles};
use crate::spline::ACCURACY;
use crate::threads;
use loops::{TracePoint, Tracer};
use samples::FaceSamples;
use surface::Domain;

/// The result of [`check`]. Lengths are in mm.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Report {
    /// The number of faces of the file.
    pub faces: usize,
    /// The number of loops that trim the faces.
    pub loops: usize,
    /// The area of the faces in mm².
    pub area: f64,
    /// The lowest and the highest coordinates of the samples of the faces.
    pub face_bounds: [[f64; 3]; 2],
    /// The lowest and the highest coordinates of the scan's points.
    pub scan_bounds: [[f64; 3]; 2],
    /// The largest distance of an edge's curve from the trace of its pcurve on the surface. If the
    /// two curves have no common parameter, values below `resolution` have no meaning.
    pub max_off_surface: f64,
    /// The largest distance of the chords from the edges that they approximate.
    pub resolution: f64,
    /// The distances of the scan's points from the faces.
    pub scan_to_face: Deviation,
    /// The distances of samples of the faces from the scan's triangles.
    pub face_to_scan: Deviation,
}

/// The largest gap between edges that should meet, or between curves that should coincide, as a
/// share of the scan's diagonal. Importers close gaps of this size.
const GAP: f64 = 1e-4;
/// The number of samples of the faces for every point of the scan.
const SAMPLES: f64 = 2.0;
/// The largest number of samples of all faces.
const MAX_SAMPLES: f64 = 4_000_000.0;

/// Measures the distances between the faces of a CAD file and a scan. `points` are the measured
/// points, if the scan's mesh was made of a cloud.
///
/// # Errors
/// [`Error::Cad`] if a face is invalid: an edge is off its surface, or a loop does not close.
pub fn check(model: &CadModel, scan: &Mesh, points: Option<&[Point]>) -> Result<Report> {
    threads::run(None, || measure(model, scan, points.unwrap_or(&scan.points)))?
}

fn measure(model: &CadModel, scan: &Mesh, measured: &[Point]) -> Result<Report> {
    let diagonal = scan.diagonal();
    let domains: Vec<Domain> = model.faces.iter().map(domain).collect();
    let (rings, off) = rings(model, &domains, diagonal)?;
    let parts: Vec<Domain> = domains.iter().zip(&rings).zip(&model.faces).map(bounded).collect();
    let faces = parts.iter().zip(rings).zip(&model.faces);
    let faces: Vec<TrimmedFace<Domain>> = faces
        .map(|((domain, rings), face)| TrimmedFace::of_rings(domain, rings, face.natural))
        .collect();
    let spacing = spacing(scan);
    let each = faces.par_iter().map(|face| FaceSamples::of(face, spacing, MAX_SAMPLES));
    let samples: Vec<FaceSamples> = each.collect();

    let tree = FaceTree::new(faces);
    let to_faces = measured.par_iter().map(|&p| tree.nearest(p).0).collect();
    let triangles = Triangles::new(scan);
    let points: Vec<Point> = samples.iter().flat_map(|s| s.points.iter().copied()).collect();
    let to_scan = points.par_iter().map(|&p| triangles.nearest(p).0).collect();
    Ok(Report {
        faces: model.faces.len(),
        loops: model.faces.iter().map(|f| f.loops.len()).sum(),
        area: samples.iter().map(|s| s.area).sum(),
        face_bounds: box_of(points.iter().copied()),
        scan_bounds: box_of(measured.iter().copied()),
        max_off_surface: off,
        resolution: ACCURACY * diagonal,
        scan_to_face: Deviation::of(measured, to_faces),
        face_to_scan: Deviation::of(&points, to_scan),
    })
}

/// The surface of a face. A face that its surface bounds goes once around it.
fn domain(face: &CadFace) -> Domain<'_> {
    let whole = Domain::whole(&face.surface);
    if face.natural { whole.once() } else { whole }
}

/// The polygons of every face's loops, and the largest distance of an edge from its surface.
fn rings(
    model: &CadModel,
    domains: &[Domain],
    diagonal: f64,
) -> Result<(Vec<Vec<Vec<TracePoint>>>, f64)> {
    let (mut rings, mut off) = (Vec::with_capacity(domains.len()), 0.0);
    for (face, domain) in model.faces.iter().zip(domains) {
        let cad = |what| Error::Cad { entity: face.entity.clone(), what };
        if face.natural && !domain.is_bounded() {
            return Err(cad("it has no bounds, and its surface has none, either".into()));
        }
        let mut tracer = Tracer {
            surface: domain,
            chord: ACCURACY * diagonal,
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

/// The part of a surface's domain that the loops of a face bound.
fn bounded<'a>(
    ((domain, rings), face): ((&Domain<'a>, &Vec<Vec<TracePoint>>), &CadFace),
) -> Domain<'a> {
    let endless = [f64::NEG_INFINITY, f64::INFINITY].map(|x| Uv::new(x, x));
    let corners: Vec<Uv> = rings.iter().flatten().map(|c| c.0).collect();
    domain.within(if face.natural { endless } else { uv_bounds(&corners) })
}

/// The distance between samples of the faces in mm, from the area and the number of points of the
/// scan.
fn spacing(scan: &Mesh) -> f64 {
    let count = (SAMPLES * scan.points.len() as f64).clamp(SAMPLED as f64, MAX_SAMPLES);
    (scan.area() / count).sqrt().max(f64::MIN_POSITIVE)
}
