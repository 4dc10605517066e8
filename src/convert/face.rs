//! The way from a scan to one face: mesh → thin and smooth → fill → parameterize →
//! knots and fit → trim → brep → deviation. Whoever reads [`face`] has read what the program does.
//!
//! The stages work in the lengths of the scan's mesh: its own numbers by a power of two
//! ([`Components::mm`]). `options` come in these, and so does what `watch` is shown up to
//! the fit. What comes out is in mm.

use rayon::prelude::*;

use super::conversion::{Body, BodyFit, Missed, SurfaceFit};
use super::smoothed::{Dense, Smoothed, smoothed};
use super::stage::{Observer, Stage, within};
use super::{Options, TargetShape, cut, input};
use crate::error::Result;
use crate::geometry::{Point, Uv};
use crate::mesh::{Components, Parameterized, Patch};
use crate::spline::Surface;
use crate::stages::adapt::Goal;
use crate::stages::{adapt, brep, fill, parameterize, trim};
use crate::{deviation, spline};

/// Converts one component of a scan to one face.
pub(super) fn face(scan: &Components, options: &Options, watch: &mut Observer) -> Result<Body> {
    let mm = scan.mm();
    let (mut measured, input) = input::disk(scan, options)?;
    watch(Stage::Mesh(&measured))?;

    let rough = scan.at_measured_places(&measured);
    // A tolerance that the user names is held at every point.
    let dense = if options.tolerance.is_some() { Dense::Every } else { Dense::Thinned };
    let found = smoothed(&rough, &options.smooth, dense, options.bound.as_ref(), watch)?;
    let Smoothed { disk, measured: means, stand_ins, noise, thin, smooth } = found;
    watch(Stage::Smooth(&disk))?;
    // Vertices that stand for several points have less noise than these.
    let noise = scan.raw_points().map_or(noise, |raw| raw.noise().max(noise));
    let goal = Goal::of(options, &measured.mesh, noise, smooth.is_noisy);
    // Points without noise can be followed as far as anybody asks for.
    let worth = Goal::of_scan(&measured.mesh, noise, smooth.is_noisy).noise();
    let worth = if smooth.is_noisy { worth } else { 0.0 };
    let tolerance = options.tolerance.unwrap_or(goal.tolerance);

    let fill_options =
        fill::Options { support: smooth.h, noise: smooth.noise, ..options.fill.clone() };
    let smoothed_points = disk.mesh.points.clone();
    let (patch, fill) = fill::fill_with(disk, &means, &fill_options, &mut within("fill", watch))?;
    drop(means);
    drop(rough);
    measured.mesh.triangles = Vec::new();
    let point_counts = scan.point_counts(&measured.mesh.points, stand_ins.as_ref());
    let patch = Patch { stand_ins, point_counts, ..patch };
    watch(Stage::Fill(&patch))?;

    let (mut map, parameterize) = parameterize::parameterize_with(
        patch,
        &options.parameterize,
        &mut within("parameterize", watch),
    )?;
    let largest_net = options.knots.largest_net_for(&goal, map.patch.measured);
    let crushed = parameterize::compressed_region(&map, tolerance, largest_net);
    watch(Stage::Parameterize(&map, crushed))?;

    let (surface, fit) =
        adapt::fit_with(&mut map, &options.adapt(noise, worth), &goal, &mut within("fit", watch))?;
    let surface = surface.rounded(measured.mesh.diagonal());
    watch(Stage::Fit(&surface))?;

    let trimmed: Vec<bool> = fill.holes.iter().map(|h| options.cut.cuts(h.rim_length)).collect();
    let rims = cut::rims(&map, &trimmed);
    let trim_options = options.trim(tolerance, rims.iter().map(|rim| rim.points.as_slice()));
    let arcs = trim::arcs(&surface, &rims, &trim_options)?;
    let rim_tolerance = trim_options.largest_rim(&surface, &rims);
    // How near edges must be to the surface is a matter of millimetres.
    let placed = surface.clone().scaled(mm);
    let rims: Vec<trim::Rim> = rims.into_iter().map(|rim| rim.scaled(mm)).collect();
    let (loops, trim) = trim::trace(&placed, &rims, arcs);
    let natural = !cut::has_outline(&loops);
    let outer = natural.then(|| outer_boundary(&surface, &map));
    watch(Stage::Trim(&placed, &loops))?;

    let faces = cut::faces(&loops);
    let brep = brep::build(&placed, &faces, &options.name, trim::edge_accuracy(&placed))?;
    watch(Stage::Brep)?;

    let face =
        deviation::TrimmedFace::new(&surface, loops.iter().map(|l| l.pcurves.as_slice()), natural);
    let (fit_deviation, places) =
        face.deviation_and_places(&smoothed_points, &map.uv[..map.patch.measured]);
    let raw = scan.measured_points(&measured.mesh.points);
    let starts = map.patch.of_scan(&places);
    let deviation = face.deviation(&raw.points, &raw.of_vertices(&starts));
    let of_vertices = || face.deviation(&measured.mesh.points, &starts).scaled(mm);
    let vertex_deviation = raw.vertex_of.as_ref().map(|_| of_vertices());
    let excused = if trim_options.keeps_vertices { 0.0 } else { rim_tolerance };
    let missed = missed(&face, (&smoothed_points, &places), &fit_deviation, (tolerance, excused));
    let seen = map.measured_triangles();
    let between = deviation::SurfaceOverMesh::new(&map.patch.mesh, &seen, &map.uv, &surface);
    let face_to_scan = between.report(tolerance, |at| face.contains(at));
    watch(Stage::Deviation)?;

    Ok(Body {
        brep,
        shape: TargetShape::Face,
        input,
        smooth: smooth.scaled(mm),
        fill: fill.scaled(mm),
        trimmed,
        tolerance: mm * tolerance,
        tolerance_named: goal.named,
        spared: goal.outliers,
        noise: mm * noise,
        missed: missed.scaled(mm),
        face_to_scan: face_to_scan.scaled(mm),
        fit_deviation: fit_deviation.scaled(mm),
        deviation: deviation.scaled(mm),
        vertex_deviation,
        origin: [0.0; 3],
        placement: None,
        hints: Vec::new(),
        stand_ins: map.patch.stand_ins,
        vertices: raw.map,
        fit: BodyFit::Face(Box::new(SurfaceFit {
            surface: placed,
            loops,
            thin: thin.scaled(mm),
            parameterize,
            crushed: crushed.map(|crushed| crushed.scaled(mm)),
            adapted: fit.scaled(mm),
            outer: outer.map(|(control, off)| (control, mm * off)),
            trim,
            rim_tolerance: mm * rim_tolerance,
        })),
    })
}

/// The smoothed points that miss the tolerance, but for those that a loop cuts off by no more
/// than `excused`.
fn missed(
    face: &deviation::TrimmedFace<Surface>,
    (points, starts): (&[Point], &[Uv]),
    deviation: &deviation::Deviation,
    (tolerance, excused): (f64, f64),
) -> Missed {
    let distances = &deviation.distances;
    let misses = |&i: &usize| {
        let (p, off) = (points[i], distances[i]);
        off > tolerance
            && (off > excused.hypot(tolerance) || {
                let (at, _) = face.nearest(p, Some(starts[i]));
                spline::foot_point(face.surface(), p, at).1 > tolerance
            })
    };
    let all: Vec<usize> = (0..distances.len()).into_par_iter().filter(misses).collect();
    let worst = all.iter().copied().max_by(|&i, &j| distances[i].total_cmp(&distances[j]));
    let worst = worst.map(|i| (distances[i], points[i].coords.into()));
    let (worst, worst_at) = worst.unwrap_or_default();
    Missed { points: all.len(), worst, worst_at }
}

fn outer_boundary(surface: &Surface, map: &Parameterized) -> (usize, f64) {
    let edges: Vec<_> = brep::outer_edges(surface).into_iter().map(|(edge, _, _)| edge).collect();
    let points: Vec<_> = map.patch.outer.iter().map(|&v| map.patch.mesh.point(v)).collect();
    let control = edges.iter().map(|e| e.control.len()).sum();
    (control, trim::distance_to_edges(&points, &edges))
}
