//! `scan2step check`: how far a CAD file is from a scan.

use formats::cad::{CadModel, read_cad};
use scan2step::check::{self, Report};
use scan2step::deviation::Deviation;
use scan2step::words::mm;
use serde_json::{Value, json};

use super::args::{Check, Component};
use super::input::{self, Scan};
use super::{Failure, Outcome, plural, report, streams};

/// Reads both, measures, prints.
pub fn run(args: &Check) -> Result<Outcome, Failure> {
    let model = read_cad(&args.cad)?;
    let scan = Scan::read(&args.piece)?;
    let outer = scan.outer(&args.piece)?;
    let (scan, components) = scan.components()?;
    let chosen = args.component.of(&components, outer);
    let measured = scan2step::measured(&components, &chosen, outer);
    let measured = measured.map_err(|e| input::stopped(&scan.path, &e))?;
    let pieces =
        Pieces { chosen: chosen.len(), all: components.count(), left_out: measured.left_out };
    drop(components);
    let found = check::check(&model, &measured.mesh).map_err(|e| input::stopped(&args.cad, &e))?;
    let met = is_met(args, &found.scan_to_face) && is_met(args, &found.face_to_scan);
    let text = if args.look.json {
        format!("{:#}\n", as_json(args, &scan, &pieces, &model, &found, met))
    } else {
        as_text(args, &scan, &pieces, &model, &found)
    };
    streams::print(text.as_bytes())?;
    if met {
        return Ok(Outcome::Done);
    }
    for (what, deviation) in
        [("points of the scan", &found.scan_to_face), ("samples of the faces", &found.face_to_scan)]
    {
        if !is_met(args, deviation) {
            streams::say(format_args!("tolerance not met: {}", beyond(args, what, deviation)));
        }
    }
    Ok(Outcome::Missed)
}

/// Of the scan, what the faces are measured against.
struct Pieces {
    chosen: usize,
    all: usize,
    /// Triangles in the others.
    left_out: usize,
}

/// Whether all but the share that was named are within the tolerance.
fn is_met(args: &Check, deviation: &Deviation) -> bool {
    let most = args.outliers / 100.0 * deviation.distances.len() as f64;
    args.tolerance.is_none_or(|tolerance| deviation.beyond(tolerance) as f64 <= most)
}

fn beyond(args: &Check, what: &str, d: &Deviation) -> String {
    let tolerance = args.tolerance.unwrap_or(f64::INFINITY);
    let [x, y, z] = d.max_at;
    format!(
        "{} of {} {what} are farther than {}; the worst, {}, at ({x:.3}, {y:.3}, {z:.3})",
        d.beyond(tolerance),
        d.distances.len(),
        mm(tolerance),
        mm(d.max),
    )
}

fn as_json(
    args: &Check,
    scan: &Scan,
    pieces: &Pieces,
    model: &CadModel,
    found: &Report,
    met: bool,
) -> Value {
    let direction = |d: &Deviation| {
        let mut object = report::deviation(d);
        object["points"] = d.distances.len().into();
        if let Some(tolerance) = args.tolerance {
            object["beyond"] = d.beyond(tolerance).into();
        }
        object
    };
    json!({
        "scan2step": env!("CARGO_PKG_VERSION"),
        "cad": {
            "file": args.cad.display().to_string(),
            "name": model.name,
            "faces": found.faces,
            "loops": found.loops,
            "area_mm2": found.area,
            "max_off_surface_mm": found.max_off_surface,
            "resolution_mm": found.resolution,
        },
        "scan": {
            "file": scan.path.display().to_string(),
            "units": scan.unit.symbol(),
            "units_assumed": scan.unit_assumed,
            "components": pieces.all,
            "components_measured": pieces.chosen,
            "left_out_triangles": pieces.left_out,
        },
        "scan_to_face": direction(&found.scan_to_face),
        "face_to_scan": direction(&found.face_to_scan),
        "tolerance_mm": args.tolerance,
        "outliers_pct": args.outliers,
        "tolerance_met": met,
    })
}

fn as_text(args: &Check, scan: &Scan, pieces: &Pieces, model: &CadModel, found: &Report) -> String {
    let assumed = if scan.unit_assumed { " (assumed; --units to change)" } else { "" };
    let direction = |d: &Deviation| {
        let [x, y, z] = d.max_at;
        format!(
            "rms {}, p95 {}, max {} at ({x:.3}, {y:.3}, {z:.3}), {} points",
            mm(d.rms),
            mm(d.p95),
            mm(d.max),
            d.distances.len()
        )
    };
    let name = if model.name.is_empty() { String::new() } else { format!("{}: ", model.name) };
    let mut lines = vec![
        format!("{} against {}", args.cad.display(), scan.path.display()),
        format!("  units         {}{assumed}", scan.unit.symbol()),
    ];
    if pieces.left_out > 0 {
        let all =
            if args.component == Component::All { "" } else { "; --component all takes every one" };
        lines.push(format!(
            "  components    {} of {}, without {} in the others{all}",
            pieces.chosen,
            pieces.all,
            plural(pieces.left_out, "triangle"),
        ));
    }
    lines.extend([
        format!(
            "  CAD           {name}{}, {}, {:.4} mm²",
            plural(found.faces, "face"),
            plural(found.loops, "loop"),
            found.area
        ),
        format!("  scan to face  {}", direction(&found.scan_to_face)),
        format!("  face to scan  {}", direction(&found.face_to_scan)),
    ]);
    lines.join("\n") + "\n"
}
