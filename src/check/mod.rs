//! Comparison of the faces of a CAD file with a scan.
//!
//! The input is a CAD model and a mesh. The output is the distances in both directions: from every
//! point of the scan to the faces, and from samples of the trimmed faces to the scan. The second
//! direction shows holes that were not trimmed away. Edges are followed by chords, and nearest
//! points are found by foot points on the surfaces. A face that is at several places is prepared once.

mod around;
mod closure;
mod curve;
mod extent;
mod integrals;
mod jets;
mod locate;
mod loops;
mod samples;
mod surface;
mod trace;

use std::collections::HashMap;
use std::sync::Arc;

use formats::cad::{CadFace, CadModel, CadPlace, CadShell, CadSolid, CadSurface};
use rayon::prelude::*;

use crate::deviation::{Deviation, FacePlace, FaceTree, FastForm, SAMPLED, TrimRing, TrimmedFace};
use crate::error::{Error, Result};
use crate::geometry::{Point, bounds, box_of};
use crate::mesh::{Mesh, Triangles};
use crate::spline::{ACCURACY, ParametricSurface};
use crate::threads;
use closure::Closure;
use extent::extent;
use integrals::Integrals;
use loops::FaceOutline;
use samples::FaceSamples;
use surface::Domain;
use trace::Tracer;

/// The result of [`check`]. Lengths are in mm.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Report {
    /// The number of faces of the file. A face counts at each of its places.
    pub faces: usize,
    /// The number of loops that trim the faces.
    pub loops: usize,
    /// The area of the faces in mm².
    pub area: f64,
    /// The volume of the solids in mm³. `None` if the file has no solid.
    pub volume: Option<f64>,
    /// The lowest and the highest coordinates of the faces.
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

/// The largest gap between edges that should meet, or between an edge and its surface, as a share of the scan's
/// diagonal. Real parts have edges that are half as far off, and importers close gaps of this size.
const GAP: f64 = 1e-3;
/// The largest distance between an edge and the trace of its pcurve, as a share of the gap. Beyond it the edge counts
/// and not the pcurve.
const AGREED: f64 = 0.1;
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
    let closures = closures(model);
    let domains = || model.faces.iter().map(|face| domain(face, &closures));
    let domains: Vec<Domain> = domains().collect();
    let (outlines, off) = outlines(model, &domains, scan.diagonal())?;
    let parts: Vec<Domain> = (domains.iter().zip(&outlines))
        .map(|(domain, outline)| loops::bounded(domain, outline))
        .collect();
    let faces = trimmed(model, &parts, &outlines);
    let integrals = integrals(&faces, &outlines);
    let area = summed(model, |face| integrals[face].area, 2);
    let spacing = spacing(scan);
    // Faces that are much larger than the scan, perhaps in a wrong unit, have no more samples in all.
    let spacing = spacing.max((area / MAX_SAMPLES).sqrt());
    let each = faces.par_iter().map(|face| FaceSamples::of(face, spacing, MAX_SAMPLES));
    let samples: Vec<FaceSamples> = each.collect();
    let face_bounds = face_bounds(model, &faces, &samples, &outlines);

    let to_scan = face_to_scan(model, &samples, &outlines, scan);
    let numbers = model.faces.iter().enumerate();
    let places = numbers.flat_map(|(face, of_face)| {
        of_face.places.iter().map(move |place| FacePlace { face, place: Some(*place) })
    });
    let tree = FaceTree::placed(faces, places.collect());
    let to_faces = measured.par_iter().map(|&p| tree.nearest(p).0).collect();
    let counted = |of: &dyn Fn(&CadFace) -> usize| {
        model.faces.iter().map(|face| face.places.len() * of(face)).sum()
    };
    Ok(Report {
        faces: counted(&|_| 1),
        loops: counted(&|face| face.loops.len()),
        area,
        volume: volume(model, &integrals),
        face_bounds,
        scan_bounds: box_of(measured.iter().copied()),
        max_off_surface: off,
        resolution: ACCURACY * scan.diagonal(),
        scan_to_face: Deviation::of(measured, to_faces),
        face_to_scan: to_scan,
    })
}

/// Where each surface closes, by its address.
fn closures(model: &CadModel) -> HashMap<*const CadSurface, Closure> {
    let mut closures = HashMap::new();
    for surface in model.faces.iter().map(|face| &face.surface) {
        closures.entry(Arc::as_ptr(surface)).or_insert_with(|| Closure::of(surface));
    }
    closures
}

/// The surface of a face.
fn domain<'a>(face: &'a CadFace, closures: &'a HashMap<*const CadSurface, Closure>) -> Domain<'a> {
    Domain::whole(&face.surface, &closures[&Arc::as_ptr(&face.surface)])
}

/// The rings of every face, and the largest distance of an edge from its surface.
fn outlines(
    model: &CadModel,
    domains: &[Domain],
    diagonal: f64,
) -> Result<(Vec<FaceOutline>, f64)> {
    let of = |(face, surface): (&CadFace, &Domain)| {
        let cad = |what| Error::Cad { entity: face.entity.clone(), what };
        // A place that scales makes gaps wider.
        let widest = face.places.iter().map(CadPlace::scale).fold(1.0, f64::max);
        let mut tracer = Tracer {
            surface,
            chord: ACCURACY * diagonal / widest,
            gap: GAP * diagonal / widest,
            agreed: AGREED * GAP * diagonal / widest,
            off_surface: 0.0,
        };
        let outline = tracer.outline(face).map_err(cad)?;
        if outline.natural && !surface.once().is_bounded() {
            return Err(cad("it has no bounds, and its surface has none, either".into()));
        }
        Ok((outline, widest * tracer.off_surface))
    };
    let (mut outlines, mut off) = (Vec::with_capacity(model.faces.len()), 0.0);
    // The first fault in the order of the faces ends it, and few others are looked for in vain.
    for (faces, domains) in model.faces.chunks(AT_ONCE).zip(domains.chunks(AT_ONCE)) {
        let each: Vec<Result<(FaceOutline, f64)>> = faces.par_iter().zip(domains).map(of).collect();
        for found in each {
            let (outline, own) = found?;
            outlines.push(outline);
            off = f64::max(off, own);
        }
    }
    Ok((outlines, off))
}

/// The number of faces whose loops are converted at once.
const AT_ONCE: usize = 64;

/// The trimmed faces, each in its own coordinates.
fn trimmed<'a>(
    model: &CadModel,
    parts: &'a [Domain<'a>],
    outlines: &[FaceOutline],
) -> Vec<TrimmedFace<'a, Domain<'a>>> {
    let mut fast_forms = HashMap::new();
    let faces = parts.iter().zip(outlines).zip(&model.faces);
    faces
        .map(|((domain, outline), face)| {
            let shared = fast_forms.entry(Arc::as_ptr(&face.surface));
            let mut fast_form: FastForm = None;
            if domain.is_unwrapped() {
                fast_form.clone_from(shared.or_insert_with(|| domain.fast_form()));
            }
            let rings = outline.rings.iter().map(|ring| TrimRing {
                corners: ring.iter().map(|c| (c.at, c.point)).collect(),
                across: (0..ring.len()).filter(|&i| ring[i].is_across).collect(),
            });
            let trim = (rings.collect(), outline.natural);
            TrimmedFace::with(domain, fast_form, trim, domain.closure.periods)
        })
        .collect()
}

/// The area and the flux of each face in its own coordinates.
fn integrals(faces: &[TrimmedFace<Domain>], outlines: &[FaceOutline]) -> Vec<Integrals> {
    // A point of the model, because a distant one would increase rounding.
    let corner = outlines.iter().flat_map(|outline| outline.rings.iter().flatten()).next();
    let origin = corner.map_or(Point::origin(), |corner| corner.point);
    let each = faces.par_iter().zip(outlines).map(|(face, outline)| {
        let trim = (&outline.rings[..], outline.natural);
        Integrals::of(
            (face.surface(), face.evaluated()),
            trim,
            |ring, at| face.surrounds(ring, at),
            origin,
        )
    });
    each.collect()
}

/// The sum of a figure over all faces and their places, which scale it by a power of their scale.
fn summed(model: &CadModel, of: impl Fn(usize) -> f64, power: i32) -> f64 {
    let at_places = |face: &CadFace| face.places.iter().map(|p| p.scale().powi(power)).sum::<f64>();
    model.faces.iter().enumerate().map(|(n, face)| of(n) * at_places(face)).sum()
}

/// The volume of the solids.
fn volume(model: &CadModel, integrals: &[Integrals]) -> Option<f64> {
    let of_shell = |shell: usize| {
        let CadShell { faces, inverted, .. } = &model.shells[shell];
        let flux = faces.iter().zip(inverted).map(|(&n, inverted)| {
            let is_inverted = (model.faces[n].forward == Some(false)) != *inverted;
            if is_inverted { -integrals[n].flux } else { integrals[n].flux }
        });
        let places = faces.first().map(|&n| &model.faces[n].places);
        let scales = places.into_iter().flat_map(|places| places.iter().map(|p| p.scale().powi(3)));
        flux.sum::<f64>().abs() / 3.0 * scales.sum::<f64>()
    };
    let of_solid = |solid: &CadSolid| {
        of_shell(solid.outer) - solid.voids.iter().map(|&shell| of_shell(shell)).sum::<f64>()
    };
    (!model.solids.is_empty()).then(|| model.solids.iter().map(of_solid).sum())
}

/// The bounding box of all faces at all places.
fn face_bounds(
    model: &CadModel,
    faces: &[TrimmedFace<Domain>],
    samples: &[FaceSamples],
    outlines: &[FaceOutline],
) -> [[f64; 3]; 2] {
    let each = faces.par_iter().zip(samples).zip(outlines).zip(&model.faces);
    let corners = each.flat_map_iter(|(((face, samples), outline), of_face)| {
        let corners: Vec<Point> = outline.rings.iter().flatten().map(|c| c.point).collect();
        let places = of_face.places.iter();
        let all = places.filter_map(|place| extent(face, samples, &corners, place));
        all.flatten().collect::<Vec<_>>()
    });
    let corners: Vec<Point> = corners.collect();
    bounds(corners.into_iter()).map(|corner| corner.coords.into())
}

/// The distances of samples of the faces, at all their places, from the scan's triangles. The largest one is that of
/// their edges as well, as a face leaves a scan farthest there.
fn face_to_scan(
    model: &CadModel,
    samples: &[FaceSamples],
    outlines: &[FaceOutline],
    scan: &Mesh,
) -> Deviation {
    let triangles = Triangles::new(scan);
    let of = |points: Vec<&[Point]>| {
        let placed = points.into_iter().zip(&model.faces).flat_map(|(points, face)| {
            let at = move |place: &CadPlace| {
                let place = *place;
                points.iter().map(move |&p| Point::from(place.point(p.into())))
            };
            face.places.iter().flat_map(at)
        });
        let points: Vec<Point> = placed.collect();
        let to_scan = points.par_iter().map(|&p| triangles.nearest(p).0).collect();
        Deviation::of(&points, to_scan)
    };
    let mut inner = of(samples.iter().map(|face| &face.points[..]).collect());
    let corners = |face: &FaceOutline| face.rings.iter().flatten().map(|c| c.point).collect();
    let corners: Vec<Vec<Point>> = outlines.iter().map(corners).collect();
    let edges = of(corners.iter().map(Vec::as_slice).collect());
    if edges.max > inner.max {
        (inner.max, inner.max_at) = (edges.max, edges.max_at);
    }
    inner
}

/// The distance between samples of the faces in mm, from the area and the number of points of the
/// scan.
fn spacing(scan: &Mesh) -> f64 {
    let count = (SAMPLES * scan.points.len() as f64).clamp(SAMPLED as f64, MAX_SAMPLES);
    (scan.area() / count).sqrt().max(f64::MIN_POSITIVE)
}
