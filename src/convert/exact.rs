//! The way from a clean mesh to a solid of exact faces: mesh → regions → seams → deviation. A mesh is clean if a CAD
//! program made it, so that its vertices lie on their surfaces within the rounding of the file.

use super::conversion::{Body, BodyFit, ExactFace, ExactFit, Missed};
use super::input::{self, InputReport};
use super::stage::{Observer, Stage};
use super::{Options, TargetShape};
use crate::deviation::{Deviation, FaceToScan};
use crate::error::Result;
use crate::geometry::{Point, VertexId};
use crate::mesh::{Choice, Components, Mesh};
use crate::primitives::PrimitiveKind;
use crate::stages::regions::{self, FileRounding, FlatPairs, RegionOrigin, Regions, Tessellation};
use crate::stages::seams::{self, FacePatch};
use crate::stages::{fill, smooth};
use crate::words::plural;

/// What became of the try to find exact faces.
pub(super) enum Exact {
    /// The bodies that have them.
    Bodies(Vec<Body>),
    /// The mesh is not clean, or not closed, or has no exact faces of significance.
    Unsuited,
    /// Why the faces that were found make no valid solid.
    Failed(String),
}

/// Whether exact faces are wanted of a scan.
pub(super) fn are_wanted(scan: &Components, options: &Options) -> bool {
    scan.raw_points().is_none() && options.spline_option().is_none()
}

/// The closed components among those that the options choose, as solids. There are none if one that is named is
/// open, or the largest.
pub(super) fn closed(scan: &Components, options: &Options) -> Vec<(Choice, TargetShape)> {
    let solids =
        |of: Vec<Choice>| of.into_iter().map(|component| (component, TargetShape::Solid)).collect();
    match options.component {
        Choice::Auto if options.all_components || scan.is_closed(Choice::Auto) => {
            let all = (0..scan.count()).map(Choice::Number);
            let closed: Vec<Choice> = all.filter(|&component| scan.is_closed(component)).collect();
            let is_whole = closed.len() == scan.count() || !options.all_components;
            solids(if is_whole { closed } else { Vec::new() })
        }
        component if scan.is_closed(component) => solids(vec![component]),
        _ => Vec::new(),
    }
}

/// A component with its exact regions.
struct ExactComponent {
    component: Choice,
    shape: TargetShape,
    mesh: Mesh,
    input: InputReport,
    /// The bounds of the errors of the vertices.
    errors: Vec<f64>,
    regions: Regions,
}

/// Makes solids of the components that the options choose, if all of them are clean and closed.
pub(super) fn exact(
    scan: &Components,
    shapes: &[(Choice, TargetShape)],
    options: &Options,
    watch: &mut Observer,
) -> Result<Exact> {
    if shapes.is_empty() {
        return Ok(Exact::Unsuited);
    }
    let mut found = Vec::new();
    for &(component, shape) in shapes {
        match regions_of(scan, component, shape, options)? {
            Some(one) => found.push(one),
            None => return Ok(Exact::Unsuited),
        }
    }
    // A small piece may have no significant face of its own.
    let areas = found.iter().map(|one| one.mesh.area());
    let significant = found.iter().map(|one| one.regions.significant * one.mesh.area());
    if significant.sum::<f64>() <= regions::MOST_OF_IT * areas.sum::<f64>() {
        return Ok(Exact::Unsuited);
    }
    let shape = options.shape.unwrap_or(TargetShape::Solid);
    watch(Stage::Begin { shape, components: found.len(), why: None })?;
    let left_out = scan.sizes().iter().sum::<usize>()
        - found.iter().map(|one| one.input.triangles).sum::<usize>();
    let mut bodies = Vec::new();
    for (number, mut one) in found.into_iter().enumerate() {
        watch(Stage::Component(number))?;
        one.input.left_out = left_out;
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
    Ok(match options.shape {
        Some(TargetShape::Face) if bodies.iter().any(|body| body.brep.faces.len() > 1) => {
            Exact::Unsuited
        }
        _ => Exact::Bodies(bodies),
    })
}

/// The regions of a component, unless it is noisy.
fn regions_of(
    scan: &Components,
    component: Choice,
    shape: TargetShape,
    options: &Options,
) -> Result<Option<ExactComponent>> {
    let (body, input) = input::whole_body(scan, component, shape, options)?;
    let (mesh, unit) = (body.mesh, scan.unit());
    let errors = FileRounding::errors_of(&mesh.points, unit);
    let measured = Tessellation::new(&mesh, &errors);
    if FlatPairs::of(&measured).is_clean() == Some(false) {
        return Ok(None);
    }
    let options = regions::Options { unit: 1.0 / unit, keep_polygons: options.keep_polygons };
    let regions = regions::find(&measured, &options);
    Ok(Some(ExactComponent { component, shape, mesh, input, errors, regions }))
}

/// The exact faces that a conversion finds on a component.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct ExactEstimate {
    /// The kind of each face, those that are only facets left out.
    pub kinds: Vec<PrimitiveKind>,
    /// The number of flat faces that are only facets.
    pub facets: usize,
    /// The radii of the cylinders in mm, the widest first.
    pub radii: Vec<f64>,
}

/// The exact faces of a component, if it is closed and clean and they are significant.
pub(super) fn estimate(scan: &Components, component: Choice) -> Result<Option<ExactEstimate>> {
    let options = Options::default();
    if !are_wanted(scan, &options) || !scan.is_closed(component) {
        return Ok(None);
    }
    let found = regions_of(scan, component, TargetShape::Solid, &options)?;
    Ok(found.filter(|found| found.regions.is_significant()).map(|found| {
        let regions = found.regions.regions.iter();
        let (facets, faces): (Vec<_>, Vec<_>) =
            regions.partition(|region| region.origin == RegionOrigin::Facet);
        let cylinders =
            faces.iter().filter(|region| region.surface.kind() == PrimitiveKind::Cylinder);
        let mut radii: Vec<f64> =
            cylinders.filter_map(|of| of.surface.radius()).map(|r| scan.mm() * r).collect();
        radii.sort_by(|a, b| b.total_cmp(a));
        let kinds = faces.into_iter().map(|region| region.surface.kind()).collect();
        ExactEstimate { kinds, facets: facets.len(), radii }
    }))
}

/// Says so if an option that only B-spline faces have keeps a component from exact faces.
pub(super) fn left_for_splines(scan: &Components, options: &Options) -> Result<Option<String>> {
    let Some(option) = options.spline_option().filter(|option| *option != "surfaces") else {
        return Ok(None);
    };
    let exact = estimate(scan, options.component)?;
    Ok(exact.map(|exact| {
        let faces = plural(exact.kinds.len() + exact.facets, "face");
        format!("the faces are B-splines, as only these have a --{option}; without it, this is an exact solid of {faces}")
    }))
}

/// Makes the body of one component, or says why there is no valid one.
fn body(
    found: ExactComponent,
    scan: &Components,
    options: &Options,
    watch: &mut Observer,
) -> Result<std::result::Result<Body, String>> {
    let ExactComponent { shape, mesh, input, errors, regions, .. } = found;
    let mm = scan.mm();
    // Vertices are found by their coordinates in the unit of the mesh.
    let vertices = scan.vertices_of(&mesh.points);
    let mesh = mesh.scaled(mm);
    let errors: Vec<f64> = errors.into_iter().map(|e| mm * e).collect();
    let disk =
        crate::mesh::Disk { mesh, outer: Vec::new(), holes: Vec::new(), islands: Vec::new() };
    watch(Stage::Mesh(&disk))?;
    let mesh = disk.mesh;
    watch(Stage::Regions(&regions))?;
    let patches = regions.regions.iter().map(|region| FacePatch {
        surface: region.surface.scaled(mm),
        side: region.side,
        is_facet: region.origin == RegionOrigin::Facet,
        triangles: region.triangles.clone(),
    });
    let named = seams::Options { name: options.name.clone() };
    let (mut brep, report) = match seams::solid(&mesh, &errors, patches.collect(), &named) {
        Ok(made) => made,
        Err(why) => return Ok(Err(why.to_string())),
    };
    watch(Stage::Brep)?;
    let shape = match options.shape {
        Some(TargetShape::Face) if brep.faces.len() == 1 => TargetShape::Face,
        Some(TargetShape::Shell) => TargetShape::Shell,
        _ => shape,
    };
    if shape != TargetShape::Solid {
        brep.solids.clear();
    }
    let mut patches = report.patches;
    if shape == TargetShape::Void {
        brep = brep.reversed();
        patches.iter_mut().for_each(|patch| patch.side = -patch.side);
    }
    let distances = Distances::of(&mesh, &patches);
    if regions.is_significant() && distances.explained <= regions::MOST_OF_IT {
        return Ok(Err(format!(
            "{:.0} % of its area would be facets, as {}",
            100.0 * (1.0 - distances.explained),
            report.fallbacks.first().map_or("no surface has their corners", |first| &first.why)
        )));
    }
    watch(Stage::Deviation)?;
    let rounding = errors.iter().copied().fold(0.0, f64::max);
    let tolerance = options.tolerance.unwrap_or(regions::MOST_ERRORS * rounding);
    // Half a step of each of three numbers is a bound, and steps are spread evenly.
    let noise = rounding / 3.0;
    let outside = distances.of_vertices.iter().map(|d| *d > 0.0).collect();
    let absolute = distances.of_vertices.iter().map(|d| d.abs()).collect();
    let deviation = Deviation::of(&mesh.points, absolute).with_sides(outside);
    Ok(Ok(Body {
        input,
        smooth: smooth::Report { noise, ..smooth::Report::default() },
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
            snaps: regions.snaps,
            explained: distances.explained,
            rounding,
        })),
    }))
}

/// How far the vertices and the triangles of a mesh are from the surfaces of their faces.
struct Distances {
    /// For each vertex the largest distance from one of its surfaces, positive outside.
    of_vertices: Vec<f64>,
    of_faces: Vec<ExactFace>,
    /// For each triangle its face.
    of_triangle: Vec<u32>,
    to_triangles: FaceToScan,
    /// The share of the area that is not facets.
    explained: f64,
}

impl Distances {
    fn of(mesh: &Mesh, patches: &[FacePatch]) -> Self {
        let mut of_vertices = vec![0.0f64; mesh.points.len()];
        let mut of_triangle = vec![0; mesh.triangles.len()];
        let mut of_faces = Vec::with_capacity(patches.len());
        let (mut all, mut exact) = (0.0, 0.0);
        let mut middles: Vec<(Point, f64)> = Vec::with_capacity(mesh.triangles.len());
        for (number, patch) in patches.iter().enumerate() {
            let corners = patch.triangles.iter().flat_map(|&t| mesh.triangles[t as usize]);
            let mut vertices: Vec<VertexId> = corners.collect();
            vertices.sort_unstable();
            vertices.dedup();
            let mut squares = 0.0;
            let mut max = 0.0f64;
            for &v in &vertices {
                let distance = patch.side * patch.surface.distance(mesh.point(v)).0;
                let known = &mut of_vertices[v.index()];
                if distance.abs() > known.abs() {
                    *known = distance;
                }
                squares += distance * distance;
                max = max.max(distance.abs());
            }
            for &t in &patch.triangles {
                of_triangle[t as usize] = number as u32;
                let area = mesh.area_vector(mesh.triangles[t as usize]).norm();
                all += area;
                exact += if patch.is_facet { 0.0 } else { area };
                let [a, b, c] = mesh.corners(mesh.triangles[t as usize]).map(|p| p.coords);
                let middle = Point::from((a + b + c) / 3.0);
                middles.push((middle, patch.surface.distance(middle).0.abs()));
            }
            let rms = (squares / vertices.len().max(1) as f64).sqrt();
            let FacePatch { surface, side, is_facet, .. } = *patch;
            of_faces.push(ExactFace { surface, side, is_facet, rms, max, points: vertices.len() });
        }
        let (points, distances): (Vec<Point>, Vec<f64>) = middles.into_iter().unzip();
        let found = Deviation::of(&points, distances);
        let to_triangles = FaceToScan {
            rms: found.rms,
            p95: found.p95,
            max: found.max,
            max_at: found.max_at,
            // The corners of the triangles lie on the surface, so that all of this is chord error.
            chord_error: found.max,
            beyond: 0,
            places: points.len(),
        };
        let explained = exact / f64::max(all, f64::MIN_POSITIVE);
        Distances { of_vertices, of_faces, of_triangle, to_triangles, explained }
    }
}
