//! The way from a noisy scan of a part to a solid of exact faces: mesh → regions → sharpen → seams → deviation. The surfaces of the
//! regions follow the noise only as far as their fits do, and the edges lie where surfaces meet.

use formats::scene::Placement;

use super::align::{self, Datum};
use super::conversion::{Body, ExactFace, FaceSize};
use super::exact::{self, Exact, ExactEstimate};
use super::exact_body::{ExactBody, each, turned};
use super::exact_distances::Distances;
use super::input::{self, InputReport};
use super::stage::{Observer, Stage};
use super::{Options, TargetShape};
use crate::error::Result;
use crate::geometry::NONE;
use crate::mesh::{Choice, Components, Disk, Mesh};
use crate::primitives::Primitive;
use crate::stages::regions::{self, Regions, ScanNoise};
use crate::stages::seams::{self, FacePatch, FacetForm};
use crate::stages::sharpen::{
    self, Riser, RoundSize, ScanSurface, Sharpened, Size, SizeKind, sharpen,
};
use crate::statistics::outlying;

/// A scan is one of a part if at least this share of its area lies on exact surfaces.
const LEAST_SIGNIFICANT: f64 = 0.05;

/// The least share of the area on exact surfaces in a solid of exact faces. What is left stays triangles of the scan. Real parts
/// have up to 7 % of them, nearly all in risers. A part with more is mostly free-form beside its exact faces.
const LEAST_EXACT: f64 = 0.9;

/// Vertices that were moved onto their surfaces lie there to so many mm, far below what modelling kernels take for exact.
const PLACED: f64 = 1e-8;

/// Finding the faces of a scan with more vertices takes minutes: a smooth one of 50,000 vertices takes up to 24 s.
const MOST_VERTICES: usize = 150_000;

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
        let bias = options.bias.unwrap_or(0.0) / scan.mm();
        let noise = ScanNoise::of(&body.mesh).with_bias(bias);
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
    let found = found.into_iter().map(|one| (one.component, one)).collect();
    let mut placement = None;
    each(found, watch, |one, watch| body(one, scan, options, &mut placement, watch))
}

/// The exact faces that a conversion finds on a closed component of a scan, if they are most of it.
pub(super) fn estimate(scan: &Components, component: Choice) -> Result<Option<ExactEstimate>> {
    let options = Options::default();
    if !scan.is_closed(component) || !exact::are_wanted(scan, &options) {
        return Ok(None);
    }
    let mesh = input::whole_body(scan, component, TargetShape::Solid, &options)?.0.mesh;
    let noise = ScanNoise::of(&mesh);
    if mesh.points.len() > MOST_VERTICES || !noise.is_visible {
        return Ok(None);
    }
    let regions = regions::find_scanned(&mesh, &noise);
    let estimate = ExactEstimate {
        shape: Some(TargetShape::Solid),
        noise: Some(scan.mm() * noise.deviation),
        ..ExactEstimate::of(&regions, scan.mm())
    };
    Ok((regions.explained >= LEAST_EXACT).then_some(estimate))
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

/// The same in mm.
fn in_mm(made: Sharpened, mm: f64) -> Sharpened {
    let surface = |of: ScanSurface| ScanSurface { surface: of.surface.scaled(mm), ..of };
    let size = |of: RoundSize| {
        let unit = if of.kind == SizeKind::Own(Size::HalfAngle) { 1.0 } else { mm };
        let [value, deviation, round] = [of.value, of.deviation, of.round].map(|x| unit * x);
        RoundSize { value, deviation, round, ..of }
    };
    let uncertainties = made.uncertainties.into_iter();
    Sharpened {
        mesh: made.mesh.scaled(mm),
        surfaces: made.surfaces.into_iter().map(surface).collect(),
        uncertainties: uncertainties.map(|of| of.map(|of| of.scaled(mm))).collect(),
        round_sizes: made.round_sizes.into_iter().map(size).collect(),
        risers: made.risers.into_iter().map(|of| Riser { place: of.place * mm, ..of }).collect(),
        ..made
    }
}

/// The surfaces that may be datums, in mm.
fn datums(made: &Sharpened) -> Vec<Datum> {
    let mut areas = vec![0.0; made.surfaces.len()];
    for (t, &surface) in made.of_triangle.iter().enumerate().filter(|of| *of.1 != NONE) {
        areas[surface as usize] += made.mesh.area_vector(made.mesh.triangles[t]).norm();
    }
    let datum =
        |(of, area): (&ScanSurface, f64)| Datum { surface: of.surface, side: of.side, area };
    made.surfaces.iter().zip(areas).map(datum).collect()
}

/// The patches of a mesh in mm: one for each surface, and one for each triangle that has none.
fn patches_of(made: &Sharpened) -> Vec<FacePatch> {
    let mesh = &made.mesh;
    let patch = |of: &ScanSurface| FacePatch {
        surface: of.surface,
        side: of.side,
        is_facet: false,
        form: FacetForm::Flat,
        triangles: Vec::new(),
    };
    let mut patches: Vec<FacePatch> = made.surfaces.iter().map(patch).collect();
    let mut last = None;
    for (t, &region) in made.of_triangle.iter().enumerate() {
        if region != NONE {
            patches[region as usize].triangles.push(t as u32);
            continue;
        }
        // The triangles of a facet follow each other.
        let facet = Some(made.facet_of[t]);
        if last == facet
            && let Some(patch) = patches.last_mut()
        {
            patch.form = FacetForm::Bent;
            patch.triangles.push(t as u32);
            continue;
        }
        last = facet;
        let corners = mesh.triangles[t];
        let normal = mesh.area_vector(corners).try_normalize(0.0).unwrap_or_default();
        let surface = Primitive::Plane { origin: mesh.point(corners[0]), normal };
        let triangles = vec![t as u32];
        patches.push(FacePatch {
            surface,
            side: 1.0,
            is_facet: true,
            form: FacetForm::Flat,
            triangles,
        });
    }
    patches.retain(|patch| !patch.triangles.is_empty());
    patches
}

/// Makes the body of one component, or says why there is no valid one.
fn body(
    found: ScannedComponent,
    scan: &Components,
    options: &Options,
    placement: &mut Option<Placement>,
    watch: &mut Observer,
) -> Result<std::result::Result<Body, String>> {
    let ScannedComponent { shape, mesh, input, noise, regions, .. } = found;
    let mm = scan.mm();
    // Vertices are found by their coordinates in the unit of the mesh.
    let vertices = scan.vertices_of(&mesh.points);
    let disk = Disk { mesh, outer: Vec::new(), holes: Vec::new(), islands: Vec::new() };
    let (surfaces, of_triangle) = surfaces_of(&regions);
    let how = sharpen::Options {
        noise: noise.deviation,
        correlation: noise.common(),
        bias: noise.bias,
        unit: 1.0 / scan.unit(),
        regularize: options.regularize,
    };
    let made = sharpen(&disk.mesh, &surfaces, &of_triangle, &how);
    let mut made = in_mm(made, mm);
    let mut shown = Disk { mesh: disk.mesh.scaled(mm), ..disk };
    if options.align {
        let by = align::common(placement, &datums(&made), &made.mesh)?;
        made.surfaces.iter_mut().for_each(|of| of.surface = align::moved(&of.surface, &by));
        made.mesh = align::moved_mesh(made.mesh, &by);
        made.risers.iter_mut().for_each(|of| of.place = align::moved_place(of.place, &by));
        shown.mesh = align::moved_mesh(shown.mesh, &by);
    }
    watch(Stage::Mesh(&shown))?;
    let measured = shown.mesh;
    watch(Stage::Regions(&regions))?;
    let patches = patches_of(&made);
    let mesh = made.mesh.clone();
    let errors = vec![PLACED; mesh.points.len()];
    let name = options.name.clone();
    let free_forms = seams::FreeForms::Near;
    let wanted = seams::Options { name, least_exact: LEAST_EXACT, free_forms };
    let (brep, mut report) = match seams::solid(&mesh, &errors, patches, &wanted) {
        Ok(made) => made,
        Err(why) => return Ok(Err(rounded(&why.to_string(), &made))),
    };
    watch(Stage::Brep)?;
    let brep = turned(shape, brep, &mut report.patches);
    let mut distances = Distances::of_scan(&measured, &mesh, &report.patches);
    let round_sizes = add_sizes(&mut distances.of_faces, &made);
    watch(Stage::Deviation)?;
    let noise = mm * noise.deviation;
    let made_body = ExactBody {
        input,
        shape,
        vertices,
        brep,
        mesh,
        mm,
        placement: *placement,
        report,
        gaps: Vec::new(),
        risers: made.risers,
        snaps: Vec::new(),
        round_sizes,
        deviation: distances.deviation(&measured.points),
        distances,
        tolerance: outlying(measured.points.len()) * noise,
        rounding: 0.0,
        rounding_factor: 1.0,
        noise: Some(noise),
    };
    Ok(Ok(made_body.finished(options)))
}

/// Gives faces the uncertainties of their surfaces, and returns the round sizes of faces.
fn add_sizes(faces: &mut [ExactFace], made: &Sharpened) -> Vec<FaceSize> {
    let mut of_surface: Vec<Vec<usize>> = vec![Vec::new(); made.surfaces.len()];
    for (number, face) in faces.iter_mut().enumerate().filter(|(_, face)| !face.is_facet) {
        let own = made.surfaces.iter().position(|of| of.surface == face.surface);
        let Some(own) = own else { continue };
        face.uncertainty = made.uncertainties[own];
        of_surface[own].push(number);
    }
    let size = |of: &RoundSize| {
        let first = &of_surface[of.surface];
        let faces = match of.kind {
            SizeKind::Own(_) => first.clone(),
            SizeKind::Distance(other) => vec![*first.first()?, *of_surface[other].first()?],
        };
        let &RoundSize { kind, value, deviation, round, is_taken, .. } = of;
        let size = FaceSize { kind, faces, value, deviation, round, is_taken };
        (!size.faces.is_empty()).then_some(size)
    };
    made.round_sizes.iter().filter_map(size).collect()
}

/// Why there is no solid of exact faces, with a place whose edges are rounded for that.
fn rounded(why: &str, made: &Sharpened) -> String {
    let place = made.risers.first().map(|riser| (riser.why, riser.place));
    match place {
        Some((apart, p)) => format!(
            "{why}; edges are rounded, the first one near ({:.3}, {:.3}, {:.3}), where {apart}",
            p.x, p.y, p.z
        ),
        None => format!("{why}; its edges are rounded"),
    }
}
