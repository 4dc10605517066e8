//! The way from a body to a solid or a shell: mesh → smooth → fill → layout → net → patches →
//! refine → trim → brep → deviation. A body is closed, or has gaps that are filled. A solid keeps its
//! fills, and of a shell they are cut out.

use super::conversion::{Body, BodyFit, Missed, NetworkFit, Seams};
use super::face_options::FaceOptions;
use super::faces::{Faces, SEAM_PLACES, faces};
use super::gaps::Gaps;
use super::smoothed::{Dense, Smoothed, smoothed};
use super::stage::{Observer, Stage, within};
use super::{Options, TargetShape, goal, input};
use crate::deviation::NetworkFaces;
use crate::error::{Error, Result};
use crate::geometry::ROUNDING;
use crate::mesh::{Components, Patch};
use crate::spline::Network;
use crate::stages::adapt::Goal;
use crate::stages::trim::EDGE_ACCURACY;
use crate::stages::{brep, fill, trim};

/// Converts one component of a scan to a solid, a void or a shell, in the lengths of its mesh.
pub(super) fn body(
    scan: &Components,
    shape: TargetShape,
    options: &Options,
    watch: &mut Observer,
) -> Result<Body> {
    let mm = scan.mm();
    let (mut measured, input) = input::body(scan, shape, options)?;
    watch(Stage::Mesh(&measured))?;
    let rough = scan.at_measured_places(&measured);
    // A layout of a thinned mesh has other blocks, and its faces were farther from the true surface of a body of a
    // million vertices. So each vertex stays, or each mean.
    let dense = if options.tolerance.is_some() { Dense::Every } else { Dense::Means };
    let found = smoothed(&rough, &options.smooth, dense, options.bound.as_ref(), watch)?;
    let Smoothed { disk, measured: means, stand_ins, noise, thin, smooth } = found;
    watch(Stage::Smooth(&disk))?;
    let noise = scan.raw_points().map_or(noise, |raw| raw.noise().max(noise));
    let goal = Goal::of(options, &measured.mesh, noise, smooth.is_noisy);
    let tolerance = options.tolerance.unwrap_or(goal.tolerance);
    let fill_options =
        fill::Options { support: smooth.h, noise: smooth.noise, ..options.fill.clone() };
    let (patch, fill) = if shape == TargetShape::Shell {
        fill::fill_of_shell(disk, &means, &fill_options, &mut within("fill", watch))?
    } else {
        fill::fill_with(disk, &means, &fill_options, &mut within("fill", watch))?
    };
    drop(means);
    drop(rough);
    if shape != TargetShape::Shell {
        let mesh = &patch.mesh;
        let thickness = 2.0 * mesh.signed_volume().abs() / mesh.area();
        if thickness <= smooth.noise.max(ROUNDING * mesh.diagonal()) {
            return Err(Error::Flat);
        }
    }
    let is_clean = !goal.named && !smooth.is_noisy;
    let facets = if is_clean { goal::of_facets(&measured.mesh) } else { 0.0 };
    measured.mesh.triangles = Vec::new();
    let point_counts = scan.point_counts(&measured.mesh.points, stand_ins.as_ref());
    let patch = Patch { stand_ins, point_counts, ..patch };
    watch(Stage::Fill(&patch))?;

    let face_options = FaceOptions {
        wanted: options.faces,
        knots: options.knots.clone(),
        tolerance: tolerance.max(facets),
        both_ways: goal.named,
        outliers: goal.outliers,
    };
    let mut gaps = Gaps::of(&patch, shape, tolerance, options);
    let Faces { network: own, cut, to_scan, layout, net, irregular, .. } =
        faces(&patch.even(), &mut gaps, &face_options, watch)?;
    let network = own.clone().scaled(mm);
    watch(Stage::Network(&network))?;
    let brep = match shape {
        TargetShape::Shell => {
            watch(Stage::NetworkTrim(&network, &cut))?;
            let accuracy = network.surfaces.iter().map(trim::edge_accuracy);
            brep::open(&network, &cut, &options.name, accuracy.fold(EDGE_ACCURACY, f64::max))?
        }
        TargetShape::Void => brep::void(&network, &options.name, EDGE_ACCURACY)?,
        _ => brep::closed(&network, &options.name, EDGE_ACCURACY)?,
    };
    watch(Stage::Brep)?;

    let smoothed = &patch.mesh.points[..patch.measured];
    let raw = scan.measured_points(&measured.mesh.points);
    let kept = NetworkFaces::new(&own, &cut);
    let (fit_deviation, places) = kept.deviation_and_places(smoothed, None);
    let starts = patch.of_scan(&places);
    let (deviation, _) = kept.deviation_and_places(&raw.points, Some(&raw.of_vertices(&starts)));
    let [fit_deviation, deviation] = [fit_deviation, deviation].map(|of| of.scaled(mm));
    watch(Stage::Deviation)?;
    Ok(Body {
        input,
        smooth: smooth.scaled(mm),
        trimmed: (0..fill.holes.len()).map(|hole| gaps.is_cut(hole)).collect(),
        fill: fill.scaled(mm),
        tolerance: mm * tolerance,
        tolerance_named: goal.named,
        spared: goal.outliers,
        noise: mm * noise,
        missed: Missed::beyond(&fit_deviation, mm * tolerance),
        fit_deviation,
        deviation,
        vertex_deviation: None,
        face_to_scan: to_scan.report().scaled(mm),
        brep,
        origin: [0.0; 3],
        placement: None,
        hints: Vec::new(),
        stand_ins: patch.stand_ins,
        vertices: raw.map,
        shape,
        fit: BodyFit::Network(Box::new(NetworkFit {
            seams: seams(&network),
            folds: to_scan.inverted.len(),
            thin: thin.scaled(mm),
            layout: layout.scaled(mm),
            net: net.scaled(mm),
            irregular,
            left_filled: gaps.left_filled.into_iter().map(|left| left.scaled(mm)).collect(),
            network,
            cut,
        })),
    })
}

fn seams(network: &Network) -> Seams {
    let places = network.seams(SEAM_PLACES).into_iter();
    let mut angles: Vec<f64> = places.map(|place| place.angle).collect();
    if angles.is_empty() {
        return Seams::default();
    }
    angles.sort_by(f64::total_cmp);
    let n = angles.len();
    let mean = angles.iter().sum::<f64>() / n as f64;
    let [p95, max] = [(n * 95).div_ceil(100), n].map(|k| angles[k - 1]);
    Seams { mean: mean.to_degrees(), p95: p95.to_degrees(), max: max.to_degrees() }
}
