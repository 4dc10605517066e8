//! The way from a noisy scan of a part to a solid of exact faces: mesh → regions → sharpen → seams → deviation. The surfaces of the
//! regions follow the noise only as far as their fits do, and the edges lie where surfaces meet.

use rayon::prelude::*;

use super::conversion::{Body, BodyFit, ExactFace, ExactFit, Missed};
use super::exact::Exact;
use super::input::{self, InputReport};
use super::stage::{Observer, Stage};
use super::{Options, TargetShape};
use crate::deviation::{Deviation, FaceToScan};
use crate::error::Result;
use crate::geometry::{NONE, Point};
use crate::mesh::{Choice, Components, Disk, Mesh, Triangles};
use crate::primitives::Primitive;
use crate::stages::regions::{self, Regions, ScanNoise};
use crate::stages::seams::{self, FacePatch};
use crate::stages::sharpen::{self, ScanSurface, Sharpened, sharpen};
use crate::stages::{fill, smooth};
use crate::statistics::outlying;

/// A scan is one of a part if at least this share of its area lies on exact surfaces.
const LEAST_SIGNIFICANT: f64 = 0.05;

/// The least share of the area on exact surfaces in a solid of exact faces. What is left stays triangles of the scan, which are only
/// bearable as an exception.
const LEAST_EXACT: f64 = 0.995;

/// Vertices that were moved onto their surfaces lie there to so many mm, far below what modelling kernels take for exact.
const PLACED: f64 = 1e-8;

/// Finding the faces of a scan with more vertices takes minutes: a smooth one of 50,000 vertices takes up to 24 s.
const MOST_VERTICES: usize = 100_000;

/// A component with its regions.
struct ScannedComponent {
    component: Choice,
    shape: TargetShape,
    mesh: Mesh,
    input: InputReport,
    noise: ScanNoise,
    regions: Regions,
}

/// Makes solids of the components, if all of them are closed and noisy and have exact surfaces of significance.
pub(super) fn scanned(
    scan: &Components,
    shapes: &[(Choice, TargetShape)],
    options: &Options,
    watch: &mut Observer,
) -> Result<Exact> {
    let is_closed = |of: &(Choice, TargetShape)| {
        matches!(of.1, TargetShape::Solid | TargetShape::Void) && scan.is_closed(of.0)
    };
    if shapes.is_empty() || !shapes.iter().all(is_closed) {
        return Ok(Exact::Unsuited);
    }
    let mut found = Vec::new();
    for &(component, shape) in shapes {
        let (body, input) = input::whole_body(scan, component, shape, options)?;
        if body.mesh.points.len() > MOST_VERTICES {
            return Ok(Exact::NotTried(format!(
                "faces of parts are looked for in scans of at most {MOST_VERTICES} vertices, so that edges may be rounded"
            )));
        }
        let noise = ScanNoise::of(&body.mesh);
        if !noise.is_visible {
            return Ok(Exact::Unsuited);
        }
        let regions = regions::find_scanned(&body.mesh, &noise);
        found.push(ScannedComponent { component, shape, mesh: body.mesh, input, noise, regions });
    }
    let area: f64 = found.iter().map(|one| one.mesh.area()).sum();
    let explained: f64 = found.iter().map(|one| one.regions.explained * one.mesh.area()).sum();
    if explained < LEAST_SIGNIFICANT * area {
        return Ok(Exact::Unsuited);
    }
    if explained < LEAST_EXACT * area {
        let share = 100.0 * (1.0 - explained / area);
        return Ok(Exact::Failed(format!(
            "{share:.0} % of the area is free-form, so that the edges beside it are rounded"
        )));
    }
    watch(Stage::Begin { shape: TargetShape::Solid, components: found.len(), why: None })?;
    let mut bodies = Vec::new();
    for (number, one) in found.into_iter().enumerate() {
        watch(Stage::Component(number))?;
        let component = one.component;
        match body(one, scan, options, watch) {
            Ok(Ok(body)) => {
                watch(Stage::Done(&body))?;
                bodies.push(body);
            }
            Ok(Err(why)) => return Ok(Exact::Failed(why)),
            Err(error) => return Err(error.of_component(component.number(), shapes.len())),
        }
    }
    Ok(Exact::Bodies(bodies))
}

/// The surfaces of the regions, each once, and for each triangle its surface.
fn surfaces_of(regions: &Regions) -> (Vec<ScanSurface>, Vec<u32>) {
    let mut surfaces: Vec<ScanSurface> = Vec::new();
    let mut number = Vec::with_capacity(regions.regions.len());
    for region in &regions.regions {
        // Pieces of one surface keep it in common.
        let is_same = |of: &ScanSurface| of.surface == region.surface && of.side == region.side;
        let known = surfaces.iter().position(is_same);
        number.push(known.unwrap_or(surfaces.len()) as u32);
        if known.is_none() {
            surfaces.push(ScanSurface { surface: region.surface, side: region.side });
        }
    }
    let of = |&region: &u32| if region == NONE { NONE } else { number[region as usize] };
    (surfaces, regions.of_triangle.iter().map(of).collect())
}

/// The patches of a mesh in mm: one for each surface, and one for each triangle that has none.
fn patches_of(made: &Sharpened, mesh: &Mesh, mm: f64) -> Vec<FacePatch> {
    let patch = |of: &ScanSurface| FacePatch {
        surface: of.surface.scaled(mm),
        side: of.side,
        is_facet: false,
        triangles: Vec::new(),
    };
    let mut patches: Vec<FacePatch> = made.surfaces.iter().map(patch).collect();
    for (t, &region) in made.of_triangle.iter().enumerate() {
        if region != NONE {
            patches[region as usize].triangles.push(t as u32);
            continue;
        }
        let corners = mesh.triangles[t];
        let normal = mesh.area_vector(corners).try_normalize(0.0).unwrap_or_default();
        let surface = Primitive::Plane { origin: mesh.point(corners[0]), normal };
        patches.push(FacePatch { surface, side: 1.0, is_facet: true, triangles: vec![t as u32] });
    }
    patches.retain(|patch| !patch.triangles.is_empty());
    patches
}

/// Makes the body of one component, or says why there is no valid one.
fn body(
    found: ScannedComponent,
    scan: &Components,
    options: &Options,
    watch: &mut Observer,
) -> Result<std::result::Result<Body, String>> {
    let ScannedComponent { shape, mesh, input, noise, regions, .. } = found;
    let mm = scan.mm();
    // Vertices are found by their coordinates in the unit of the mesh.
    let vertices = scan.vertices_of(&mesh.points);
    let disk = Disk { mesh, outer: Vec::new(), holes: Vec::new(), islands: Vec::new() };
    let (surfaces, of_triangle) = surfaces_of(&regions);
    let how = sharpen::Options { noise: noise.deviation, correlation: noise.common() };
    let made = sharpen(&disk.mesh, &surfaces, &of_triangle, &how);
    let shown = Disk { mesh: disk.mesh.scaled(mm), ..disk };
    watch(Stage::Mesh(&shown))?;
    let measured = shown.mesh;
    watch(Stage::Regions(&regions))?;
    let mesh = made.mesh.clone().scaled(mm);
    let patches = patches_of(&made, &mesh, mm);
    let errors = vec![PLACED; mesh.points.len()];
    let wanted = seams::Options { name: options.name.clone(), least_exact: LEAST_EXACT };
    let (mut brep, report) = match seams::solid(&mesh, &errors, patches, &wanted) {
        Ok(made) => made,
        Err(why) => return Ok(Err(rounded(&why.to_string(), &made, mm))),
    };
    watch(Stage::Brep)?;
    let mut patches = report.patches;
    if shape == TargetShape::Void {
        brep = brep.reversed();
        patches.iter_mut().for_each(|patch| patch.side = -patch.side);
    }
    let distances = ScanDistances::of(&measured, &mesh, &patches);
    watch(Stage::Deviation)?;
    let noise = mm * noise.deviation;
    let limit = outlying(measured.points.len()) * noise;
    let tolerance = options.tolerance.unwrap_or(limit);
    let outside = distances.of_vertices.iter().map(|d| *d > 0.0).collect();
    let absolute = distances.of_vertices.iter().map(|d| d.abs()).collect();
    let deviation = Deviation::of(&measured.points, absolute).with_sides(outside);
    Ok(Ok(Body {
        input,
        smooth: smooth::Report { noise, is_noisy: true, ..smooth::Report::default() },
        fill: fill::Report::default(),
        trimmed: Vec::new(),
        tolerance,
        tolerance_named: options.tolerance.is_some(),
        spared: 0.0,
        noise,
        missed: Missed::beyond(&deviation, tolerance),
        fit_deviation: deviation.clone(),
        deviation,
        vertex_deviation: None,
        face_to_scan: distances.to_triangles,
        brep,
        origin: [0.0; 3],
        hints: Vec::new(),
        vertices,
        shape,
        fit: BodyFit::Exact(Box::new(ExactFit {
            faces: distances.of_faces,
            of_triangle: distances.of_triangle,
            mesh,
            mm,
            facets: report.facets,
            fallbacks: report.fallbacks,
            gaps: Vec::new(),
            snaps: Vec::new(),
            explained: distances.explained,
            rounding: 0.0,
            noise: Some(noise),
        })),
    }))
}

/// Why there is no solid of exact faces, with a place whose edges are rounded for that.
fn rounded(why: &str, made: &Sharpened, mm: f64) -> String {
    let place = made.lost.first().map(|lost| (lost.why, lost.place * mm));
    match place {
        Some((lost, p)) => format!(
            "{why}; edges are rounded, the first one near ({:.3}, {:.3}, {:.3}), where {lost}",
            p.x, p.y, p.z
        ),
        None => format!("{why}; its edges are rounded"),
    }
}

/// How far a scan is from exact faces.
struct ScanDistances {
    /// For each vertex of the scan the distance from the nearest face, positive outside.
    of_vertices: Vec<f64>,
    of_faces: Vec<ExactFace>,
    /// For each triangle of the exact mesh its face.
    of_triangle: Vec<u32>,
    to_triangles: FaceToScan,
    /// The share of the area that is not facets.
    explained: f64,
}

impl ScanDistances {
    /// Measures the vertices and the middles of the triangles of a scan. `mesh` has its vertices on the faces.
    fn of(scan: &Mesh, mesh: &Mesh, patches: &[FacePatch]) -> Self {
        let mut of_triangle = vec![0; mesh.triangles.len()];
        let (mut all, mut exact) = (0.0, 0.0);
        for (number, patch) in patches.iter().enumerate() {
            for &t in &patch.triangles {
                of_triangle[t as usize] = number as u32;
                let area = mesh.area_vector(mesh.triangles[t as usize]).norm();
                all += area;
                exact += if patch.is_facet { 0.0 } else { area };
            }
        }
        let triangles = Triangles::new(mesh);
        let face_at = |p: Point| of_triangle[triangles.nearest(p).1] as usize;
        let measure = |p: Point| {
            let (off, triangle) = triangles.nearest(p);
            let face = of_triangle[triangle] as usize;
            let distance = patches[face].side * patches[face].surface.distance(p).0;
            let foot = patches[face].surface.closest(p);
            let is_there = distance.abs() >= off || face_at(foot) == face;
            (face, if is_there { distance } else { off.copysign(distance) })
        };
        let found: Vec<(usize, f64)> = scan.points.par_iter().map(|&p| measure(p)).collect();
        let mut of_faces: Vec<ExactFace> = patches
            .iter()
            .map(|&FacePatch { surface, side, is_facet, .. }| ExactFace {
                surface,
                side,
                is_facet,
                rms: 0.0,
                max: 0.0,
                points: 0,
            })
            .collect();
        for &(face, distance) in &found {
            let of = &mut of_faces[face];
            of.rms += distance * distance;
            of.max = of.max.max(distance.abs());
            of.points += 1;
        }
        of_faces.iter_mut().for_each(|of| of.rms = (of.rms / of.points.max(1) as f64).sqrt());
        let middle = |&t: &[crate::geometry::VertexId; 3]| {
            let [a, b, c] = scan.corners(t).map(|p| p.coords);
            Point::from((a + b + c) / 3.0)
        };
        let middles: Vec<Point> = scan.triangles.iter().map(middle).collect();
        let offs: Vec<f64> = middles.par_iter().map(|&p| measure(p).1.abs()).collect();
        let back = Deviation::of(&middles, offs);
        let to_triangles = FaceToScan {
            rms: back.rms,
            p95: back.p95,
            max: back.max,
            max_at: back.max_at,
            chord_error: 0.0,
            beyond: 0,
            places: middles.len(),
        };
        ScanDistances {
            of_vertices: found.into_iter().map(|found| found.1).collect(),
            of_faces,
            of_triangle,
            to_triangles,
            explained: exact / f64::max(all, f64::MIN_POSITIVE),
        }
    }
}
