//! The way from a clean mesh to a solid of exact faces: mesh → regions → seams → deviation. A mesh is clean if a CAD
//! program made it, so that its vertices lie on their surfaces within the rounding of the file.

use formats::Brep;
use formats::scene::Placement;

use super::align::{self, Datum};
use super::conversion::{Body, BodyFit};
use super::exact_body::{ExactBody, each, turned};
use super::exact_distances::Distances;
use super::input::{self, InputReport};
use super::stage::{Observer, Stage};
use super::{EdgeChoice, Options, TargetShape, exact_choice};
use crate::error::Result;
use crate::mesh::{Choice, Components, Mesh};
use crate::noise::Terraces;
use crate::primitives::{Primitive, PrimitiveKind};
use crate::stages::regions::{
    self, FaceRegion, FileRounding, FlatPairs, RegionOrigin, Regions, Tessellation, VertexErrors,
};
use crate::stages::seams::{self, ClosedGap, FacePatch, FacetForm, SolidFault};
use crate::words::plural;

/// What became of the try to find exact faces.
pub(super) enum Exact {
    /// The bodies that have them.
    Bodies(Vec<Body>),
    /// The mesh is not clean, or has no exact faces of significance.
    Unsuited,
    /// Why the faces that were found make no valid body.
    Failed(String),
    /// Why none were looked for.
    NotTried(String),
}

/// Whether exact faces are wanted of a scan.
pub(super) fn are_wanted(scan: &Components, options: &Options) -> bool {
    scan.raw_points().is_none() && options.spline_option().is_none()
}

/// A mesh with fewer triangles is looked at as a whole. So many triangles suffice to tell noise.
const SAMPLED: usize = 2000;

/// Whether a sample of a large component tells that it is noisy, so that no part of it needs to be taken for exact faces.
/// Of a small one the whole is looked at later, unless it is asked for now.
pub(super) fn is_noisy(scan: &Components, component: Choice, now: bool) -> Result<bool> {
    let mesh = match scan.sampled(component, SAMPLED) {
        Some(sample) => sample,
        None if now => scan.take_whole(component)?.own_mesh().clone(),
        None => return Ok(false),
    };
    let errors = FileRounding::errors_of(&mesh.points, scan.unit());
    Ok(!is_clean(scan, component, &Tessellation::new(&mesh, &errors.bounds)))
}

/// Whether the flat pairs of a mesh tell that it is clean. Where they tell nothing, an open mesh is a scan: of a grid whose
/// steps are taken for the rounding they tell nothing.
fn is_clean(scan: &Components, component: Choice, mesh: &Tessellation<'_>) -> bool {
    FlatPairs::of(mesh).is_clean().unwrap_or_else(|| scan.is_closed(component))
}

/// A component with its exact regions.
struct ExactComponent {
    component: Choice,
    shape: TargetShape,
    mesh: Mesh,
    input: InputReport,
    /// The bounds of the errors of the vertices.
    errors: Vec<f64>,
    /// The factor by which they are larger than the rounding of the file.
    factor: f64,
    regions: Regions,
}

impl ExactComponent {
    /// The same as a shell if it would be a face, but several faces were found.
    fn shell_of_several(self) -> Self {
        let is_several = self.shape == TargetShape::Face && self.regions.regions.len() > 1;
        let shape = if is_several { TargetShape::Shell } else { self.shape };
        ExactComponent { shape, ..self }
    }
}

/// Makes bodies of the components that the options choose, if all of them are clean.
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
            Some(one) => found.push(one.shell_of_several()),
            None => return Ok(Exact::Unsuited),
        }
    }
    // A small piece may have no significant face of its own.
    let areas = found.iter().map(|one| one.mesh.area());
    let significant = found.iter().map(|one| one.regions.significant * one.mesh.area());
    if significant.sum::<f64>() <= regions::MOST_OF_IT * areas.sum::<f64>() {
        return Ok(Exact::Unsuited);
    }
    let shapes: Vec<_> = found.iter().map(|one| (one.component, one.shape)).collect();
    let has = |shape| shapes.iter().any(|of| of.1 == shape);
    let own = match (has(TargetShape::Shell), has(TargetShape::Face)) {
        (true, _) => TargetShape::Shell,
        (_, true) => TargetShape::Face,
        _ => TargetShape::Solid,
    };
    let shape = options.shape.unwrap_or(own);
    let why = exact_choice::why(scan, &shapes, options);
    watch(Stage::Begin { shape, components: found.len(), why })?;
    let left_out = scan.sizes().iter().sum::<usize>()
        - found.iter().map(|one| one.input.triangles).sum::<usize>();
    let found = found.into_iter().map(|mut one| {
        one.input.left_out = left_out;
        (one.component, one)
    });
    // What one of several components may lose is not known.
    let least_exact = if shapes.len() == 1 { regions::MOST_OF_IT } else { 0.0 };
    let mut placement = None;
    let of_one =
        |one, watch: &mut Observer| body(one, least_exact, scan, options, &mut placement, watch);
    let made = each(found.collect(), watch, of_one)?;
    Ok(match (&made, options.shape) {
        (Exact::Bodies(bodies), _)
            if bodies.len() > 1 && exact_share(bodies) <= regions::MOST_OF_IT =>
        {
            let facets = 100.0 * (1.0 - exact_share(bodies));
            Exact::Failed(format!("{facets:.0} % of their area would be facets"))
        }
        (Exact::Bodies(bodies), Some(TargetShape::Face))
            if bodies.iter().any(|body| body.brep.faces.len() > 1) =>
        {
            Exact::Unsuited
        }
        _ => made,
    })
}

/// The share of the area of several bodies that is on surfaces which were found.
fn exact_share(bodies: &[Body]) -> f64 {
    let of = |body: &Body| match &body.fit {
        BodyFit::Exact(fit) => [fit.mesh.area(), fit.explained * fit.mesh.area()],
        _ => [0.0; 2],
    };
    let areas: Vec<[f64; 2]> = bodies.iter().map(of).collect();
    let sum = |k: usize| areas.iter().map(|of| of[k]).sum::<f64>();
    sum(1) / sum(0)
}

/// The regions of a component, unless it is noisy.
fn regions_of(
    scan: &Components,
    component: Choice,
    shape: TargetShape,
    options: &Options,
) -> Result<Option<ExactComponent>> {
    let (body, input) = input::whole_body(scan, component, shape, options)?;
    let unit = scan.unit();
    let VertexErrors { bounds, is_single } = FileRounding::errors_of(&body.mesh.points, unit);
    let (mut mesh, mut errors) = joined(body.mesh, bounds);
    let mut factor = 1.0;
    if is_single {
        factor = regions::computed(&Tessellation::new(&mesh, &errors));
    }
    if factor > 1.0 {
        let larger = errors.iter().map(|error| factor * error);
        (mesh, errors) = joined(mesh, larger.collect());
    }
    let measured = Tessellation::new(&mesh, &errors);
    if !is_clean(scan, component, &measured) {
        return Ok(None);
    }
    let sharp = match options.edges {
        EdgeChoice::Degrees(degrees) => Some(degrees.to_radians()),
        EdgeChoice::Auto | EdgeChoice::Off => None,
    };
    let keep_polygons = options.keep_polygons;
    let options = regions::Options { unit: 1.0 / unit, keep_polygons, sharp };
    let regions = regions::find(&measured, &options);
    if regions.curved_share(&measured) < LEAST_CURVED && Terraces::of(&mesh).is_some() {
        return Ok(None);
    }
    Ok(Some(ExactComponent { component, shape, mesh, input, errors, factor, regions }))
}

/// The mesh without edges that are no longer than the errors of their ends.
fn joined(mesh: Mesh, errors: Vec<f64>) -> (Mesh, Vec<f64>) {
    match mesh.without_short_edges(&errors) {
        Some((joined, numbers)) => (joined, numbers.into_iter().map(|v| errors[v]).collect()),
        None => (mesh, errors),
    }
}

/// Heights in steps are planes and facets, and few of them look curved by chance. Curved faces with more than this share
/// of the area are a design, whose heights are round numbers.
const LEAST_CURVED: f64 = 0.05;

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
    /// What a conversion makes of them.
    pub shape: Option<TargetShape>,
    /// Within how many times the rounding of the file the vertices lie on them.
    pub rounding_factor: f64,
    /// The share of the area that they have.
    pub explained: f64,
    /// The standard deviation of the noise in mm that explains how far the vertices of a scan are off them. `None` for a clean mesh.
    pub noise: Option<f64>,
}

impl ExactEstimate {
    /// The faces of regions whose unit has so many mm.
    pub(super) fn of(regions: &Regions, mm: f64) -> Self {
        let (facets, faces): (Vec<_>, Vec<_>) =
            regions.regions.iter().partition(|region| region.origin == RegionOrigin::Facet);
        let cylinders =
            faces.iter().filter(|region| region.surface.kind() == PrimitiveKind::Cylinder);
        let mut radii: Vec<f64> =
            cylinders.filter_map(|of| of.surface.radius()).map(|r| mm * r).collect();
        radii.sort_by(|a, b| b.total_cmp(a));
        ExactEstimate {
            kinds: faces.into_iter().map(|region| region.surface.kind()).collect(),
            facets: facets.len(),
            radii,
            shape: None,
            rounding_factor: 1.0,
            explained: regions.explained,
            noise: None,
        }
    }
}

/// The exact faces of a component, if it is clean and they are significant.
pub(super) fn estimate(scan: &Components, component: Choice) -> Result<Option<ExactEstimate>> {
    if is_noisy(scan, component, false)? {
        return Ok(None);
    }
    let options = Options::default();
    let shape = exact_choice::shape(scan, component, None)?;
    let Some(shape) = shape.filter(|_| are_wanted(scan, &options)) else { return Ok(None) };
    let found = regions_of(scan, component, shape, &options)?;
    let found = found.map(ExactComponent::shell_of_several);
    Ok(found.filter(|found| found.regions.is_significant()).map(|found| ExactEstimate {
        shape: Some(found.shape),
        rounding_factor: found.factor,
        ..ExactEstimate::of(&found.regions, scan.mm())
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
        let shape = exact.shape.map_or("body", TargetShape::word);
        let why = match option {
            "edges" => "as --edges off leaves no sharp edges".into(),
            option => format!("as only these have a --{option}"),
        };
        format!("the faces are B-splines, {why}; without it, this is an exact {shape} of {faces}")
    }))
}

/// What the seams of a component make: its B-rep, and the mesh without its gaps.
struct Sewn {
    brep: Brep,
    report: seams::Report,
    mesh: Mesh,
    gaps: Vec<ClosedGap>,
}

/// Makes faces with edges of patches. The gaps of what becomes a solid are closed; the rims of a shell become free edges.
fn sewn(
    mesh: Mesh,
    errors: &[f64],
    patches: Vec<FacePatch>,
    shape: TargetShape,
    wanted: &seams::Options,
) -> std::result::Result<Sewn, SolidFault> {
    if matches!(shape, TargetShape::Shell | TargetShape::Face) {
        let (brep, report) = seams::open_shell(&mesh, errors, patches, wanted)?;
        return Ok(Sewn { brep, report, mesh, gaps: Vec::new() });
    }
    let closed = seams::close_gaps(&mesh, errors, patches)?;
    let (brep, report) = seams::solid(&closed.mesh, &closed.errors, closed.patches, wanted)?;
    Ok(Sewn { brep, report, mesh: closed.mesh, gaps: closed.gaps })
}

/// The surfaces of regions in mm that may be datums.
fn datums(regions: &Regions, mesh: &Mesh, mm: f64) -> Vec<Datum> {
    let faces = regions.regions.iter().filter(|region| region.origin != RegionOrigin::Facet);
    let datum = |region: &FaceRegion| Datum {
        surface: region.surface.scaled(mm),
        side: region.side,
        area: region
            .triangles
            .iter()
            .map(|&t| mesh.area_vector(mesh.triangles[t as usize]).norm())
            .sum(),
    };
    faces.map(datum).collect()
}

/// Puts the surfaces of regions, whose unit has so many mm, at their new place.
fn align_regions(regions: &mut Regions, by: &Placement, mm: f64) {
    let moved = |of: &mut Primitive| *of = align::moved(&of.scaled(mm), by).scaled(1.0 / mm);
    regions.regions.iter_mut().for_each(|region| moved(&mut region.surface));
    for snap in &mut regions.snaps {
        moved(&mut snap.before);
        moved(&mut snap.after);
    }
}

/// Makes the body of one component, or says why there is no valid one.
fn body(
    found: ExactComponent,
    least_exact: f64,
    scan: &Components,
    options: &Options,
    placement: &mut Option<Placement>,
    watch: &mut Observer,
) -> Result<std::result::Result<Body, String>> {
    let ExactComponent { shape, mesh, input, errors, factor, mut regions, .. } = found;
    let mm = scan.mm();
    // Vertices are found by their coordinates in the unit of the mesh.
    let vertices = scan.vertices_of(&mesh.points);
    let mut mesh = mesh.scaled(mm);
    if options.align {
        let by = align::common(placement, &datums(&regions, &mesh, mm), &mesh)?;
        align_regions(&mut regions, &by, mm);
        mesh = align::moved_mesh(mesh, &by);
    }
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
        form: FacetForm::Flat,
        triangles: region.triangles.clone(),
    });
    let measured = [mesh.points.len(), mesh.triangles.len()];
    let within = options.tolerance.unwrap_or(f64::INFINITY);
    let free_forms = seams::FreeForms::Through { turn: regions::MOST_TURN, within };
    let wanted = seams::Options { name: options.name.clone(), least_exact, free_forms };
    let sewn = sewn(mesh, &errors, patches.collect(), shape, &wanted);
    let Sewn { mut brep, mut report, mesh, gaps } = match sewn {
        Ok(sewn) => sewn,
        Err(why) => return Ok(Err(why.to_string())),
    };
    watch(Stage::Brep)?;
    let shape = match options.shape.unwrap_or(shape) {
        TargetShape::Face if brep.faces.len() == 1 => TargetShape::Face,
        TargetShape::Face if options.shape.is_none() => TargetShape::Shell,
        TargetShape::Shell => TargetShape::Shell,
        _ => shape,
    };
    if shape != TargetShape::Solid {
        brep.solids.clear();
    }
    let brep = turned(shape, brep, &mut report.patches);
    let distances = Distances::of(&mesh, measured, &report.patches);
    watch(Stage::Deviation)?;
    let passes = report.patches.iter().filter_map(|patch| Some(patch.free_form()?.passes()));
    let passes = passes.fold(0.0, f64::max);
    let rounding = errors.iter().copied().fold(0.0, f64::max);
    let made = ExactBody {
        input,
        shape,
        vertices,
        brep,
        deviation: distances.deviation(&mesh.points[..measured[0]]),
        mesh,
        mm,
        placement: *placement,
        report,
        gaps,
        risers: Vec::new(),
        snaps: regions.snaps,
        round_sizes: Vec::new(),
        distances,
        tolerance: passes.max(regions::MOST_ERRORS * rounding),
        rounding,
        rounding_factor: factor,
        noise: None,
    };
    Ok(Ok(made.finished(options)))
}
