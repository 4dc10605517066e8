//! The run in figures. Lengths are mm; `docs/report.schema.json` has every key.

use scan2step::deviation::{Deviation, FaceToScan};
use scan2step::{Conversion, InputReport, fill::Strategy, fit, mesh::Bound};
use serde_json::{Value, json};

use super::Context;
use crate::cli::input::Scan;
use crate::cli::progress::peak_rss_mb;

/// The report's object. It speaks of the first component; where there are
/// more, `components` has what differs for each.
pub fn report(conversions: &[Conversion], context: &Context) -> Value {
    let mut report = json!({
        "scan2step": env!("CARGO_PKG_VERSION"),
        "tolerance_named": context.tolerance_named,
        "outliers_pct": context.outliers_pct,
        "options": context.options,
        "hints": context.hints,
        "stages": context.progress.stages.iter().map(|s| json!({
            "name": s.name, "seconds": s.seconds, "peak_rss_mb": s.peak_rss_mb,
        })).collect::<Vec<_>>(),
        "outputs": context.outputs.iter().map(|(path, pending)| json!({
            "file": path.display().to_string(), "bytes": pending.bytes, "sha256": pending.sha256,
        })).collect::<Vec<_>>(),
        "seconds": context.progress.seconds(),
        "peak_rss_mb": peak_rss_mb(),
    });
    let each: Vec<Value> = conversions.iter().map(|c| of_component(c, context)).collect();
    if let (Some(report), Some(Value::Object(first))) = (report.as_object_mut(), each.first()) {
        report.extend(first.clone());
        if each.len() > 1 {
            report.insert("components".into(), each.into());
        }
    }
    report
}

fn of_component(c: &Conversion, context: &Context) -> Value {
    json!({
        "input": input(&c.input, context.scan),
        "noise_mm": c.smooth.noise,
        "tolerance_mm": c.tolerance,
        "tolerance_met": c.tolerance_met(context.outliers_pct / 100.0),
        "smooth": {
            "h_mm": c.smooth.h,
            "moved_rms_mm": c.smooth.moved_rms,
            "moved_max_mm": c.smooth.moved_max,
            "corners": c.smooth.corners.len(),
            "outliers": c.smooth.outliers,
        },
        "fill": { "holes": holes(c) },
        "parameterize": {
            "outline": match c.outer {
                Some(_) => "sides",
                None => "free",
            },
            "bays": c.parameterize.bays.count,
            "bay_triangles": c.parameterize.bays.added_triangles,
            "flipped": c.parameterize.flipped,
            "mended": c.parameterize.mended,
            "split_edges": c.parameterize.split_edges,
            "stretch_l2": c.parameterize.stretch.l2,
            "stretch_max": c.parameterize.stretch.max,
            "aspect": c.parameterize.stretch.aspect,
        },
        "fit": fit_report(c),
        "deviation": deviation(&c.deviation),
        "face_to_scan": face_to_scan(&c.face_to_scan),
        "rim_tolerance_mm": c.rim_tolerance,
        "trim": trim(c),
    })
}

/// The `input` object, of `convert` and of `inspect`.
pub fn input(input: &InputReport, scan: &Scan) -> Value {
    json!({
        "file": scan.path.display().to_string(),
        "units": scan.unit.symbol(),
        "units_assumed": scan.unit_assumed,
        "file_vertices": scan.counts[0],
        "file_triangles": scan.counts[1],
        "vertices": input.vertices,
        "triangles": input.triangles,
        "components": input.components,
        "islands": input.islands,
        "island_triangles": input.island_triangles,
        "boundary_loops": input.boundary_loops,
        "repairs": input.repairs,
    })
}

fn holes(c: &Conversion) -> Vec<Value> {
    let each = c.fill.holes.iter().zip(&c.trimmed);
    each.map(|(hole, trimmed)| {
        json!({
            "rim_vertices": hole.rim_vertices,
            "rim_length_mm": hole.rim_length,
            "islands": hole.islands,
            "added_vertices": hole.added_vertices,
            "added_triangles": hole.added_triangles,
            "trimmed": trimmed,
            "method": match hole.strategy {
                Strategy::Front => "front",
                Strategy::WideEars => "wide ears",
                Strategy::GuidedFront => "guided front",
                Strategy::LeastArea => "least area",
            },
            "folds": hole.faults.folds,
            "cuts": hole.faults.cuts,
        })
    })
    .collect()
}

fn fit_report(c: &Conversion) -> Value {
    let [m, n] = c.surface.shape();
    let d = &c.fit_deviation;
    let within = d.distances.len() - c.missed.points;
    json!({
        "method": match c.fit.fit.method {
            fit::Method::Blend => "blend",
            fit::Method::Refined => "refined",
            fit::Method::Global => "global",
        },
        "degree": [c.surface.u.degree(), c.surface.v.degree()],
        "net": [m, n],
        "knots_u": c.surface.u.knots().len(),
        "knots_v": c.surface.v.knots().len(),
        "rms_mm": d.rms,
        "p95_mm": d.p95,
        "p99_mm": d.p99,
        "max_mm": d.max,
        "max_at": d.max_at,
        "within_pct": 100.0 * within as f64 / d.distances.len().max(1) as f64,
        "mean_parametric_mm": c.fit.mean_error,
        "kappa_mm": c.fit.kappa,
        "rounds": c.fit.rounds,
        "steps": c.fit.fit.steps,
        "folds": c.fit.folds.map(|folds| folds.inverted),
        "places": c.fit.folds.map(|folds| folds.samples),
    })
}

/// A deviation, of `convert` and of `check`.
pub fn deviation(d: &Deviation) -> Value {
    json!({
        "rms_mm": d.rms, "p95_mm": d.p95, "p99_mm": d.p99, "max_mm": d.max, "max_at": d.max_at,
    })
}

fn face_to_scan(d: &FaceToScan) -> Value {
    json!({
        "rms_mm": d.rms, "p95_mm": d.p95, "max_mm": d.max, "max_at": d.max_at,
        "chord_error_mm": d.chord_error, "triangles": d.triangles, "beyond": d.beyond,
    })
}

fn trim(c: &Conversion) -> Vec<Value> {
    let sides = c.outer.map(|(control_points, max_from_rim)| {
        json!({
            "loop": 0, "outer": true, "control_points": control_points,
            "max_off_surface_mm": 0.0, "max_from_rim_mm": max_from_rim,
        })
    });
    let first = usize::from(sides.is_some());
    // An island is a face of its own, with an outer loop.
    let others = c.trim.iter().enumerate().map(|(i, l)| {
        json!({
            "loop": first + i, "outer": !matches!(l.of, Bound::Hole(_)),
            "hole": l.of.hole(), "island": l.of.island(),
            "control_points": l.control_points, "max_off_surface_mm": l.max_off_surface,
            "max_from_rim_mm": l.max_from_rim,
        })
    });
    sides.into_iter().chain(others).collect()
}
