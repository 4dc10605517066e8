//! `scan2step check`: how far a CAD file is from a scan.

use std::io::stdin;

use formats::cad::{read_cad, read_cad_stream};
use scan2step::check;
use scan2step::report::{CheckFigures, DistanceFigures, MeasuredComponents};
use scan2step::words::{box_extents, grouped, mm, plain_mm, plural};

use super::args::{Check, ComponentChoice, Origin, cad_file};
use super::input::{self, ReadScan};
use super::paragraphs::wrapped;
use super::{Failure, Outcome, streams};

/// Reads the CAD file and the scan, measures them against each other, and prints the result.
pub(crate) fn run(args: &Check) -> Result<Outcome, Failure> {
    let is_cad = |path: &std::path::Path| cad_file(&path.to_string_lossy()).is_ok();
    let (cad, scan) = (&args.cad.name, &args.piece.scan.name);
    if is_cad(scan) && !is_cad(cad) && !args.cad.is_stdin {
        let (cad, scan) = (scan.display(), cad.display());
        let error = format!("{scan}: is the place of the CAD file");
        let help = format!("name the CAD file first: scan2step check {cad} {scan}");
        return Err(Failure { error, help });
    }
    let model = if args.cad.is_stdin { read_cad_stream(cad, stdin())? } else { read_cad(cad)? };
    let scan = ReadScan::read(&args.piece)?;
    let outer = scan.outer(&args.piece)?;
    let options = ReadScan::options(&args.piece)?;
    let (scan, components) = scan.components(&options, &mut |_| Ok(()))?;
    let chosen = args.component.of(&components, outer);
    let measured = scan2step::measured(&components, &chosen, outer);
    let measured = measured.map_err(|e| input::stopped(&scan.path, &e))?;
    let parts = MeasuredComponents {
        all: components.count(),
        measured: chosen.len(),
        left_out: measured.left_out,
    };
    drop(components);
    let measured = match args.piece.cloud.origin {
        Origin::Keep => measured.translated(scan.source.origin_mm),
        Origin::Local => measured,
    };
    let found = check::check(&model, &measured.mesh, measured.points.as_deref());
    let found = found.map_err(|e| input::stopped(&args.cad.name, &e))?;
    let cad = (args.cad.name.display().to_string(), &model);
    let scan = (&scan.source, parts);
    let figures = CheckFigures::of(&found, cad, scan, args.tolerance, args.outliers);
    let text = if args.look.json { figures.to_json() } else { as_text(args, &figures) };
    streams::print(text.as_bytes())?;
    if figures.tolerance_met != Some(false) {
        return Ok(Outcome::Done);
    }
    for (what, distances) in [
        ("points of the scan", &figures.scan_to_face),
        ("samples of the faces", &figures.face_to_scan),
    ] {
        if !distances.keeps(args.outliers) {
            streams::say(format_args!("tolerance not met: {}", beyond(args, what, distances)));
        }
    }
    Ok(Outcome::Missed)
}

fn beyond(args: &Check, what: &str, distances: &DistanceFigures) -> String {
    let [x, y, z] = distances.deviation.max_at;
    format!(
        "{} of {} {what} are farther than {}; the worst, {}, at ({x:.3}, {y:.3}, {z:.3})",
        grouped(distances.beyond.unwrap_or(0)),
        grouped(distances.points),
        mm(args.tolerance.unwrap_or(f64::INFINITY)),
        mm(distances.deviation.max_mm),
    )
}

/// The column at which texts begin.
const INDENT: usize = 16;

fn as_text(args: &Check, figures: &CheckFigures) -> String {
    let CheckFigures { cad, scan, .. } = figures;
    let assumed = if scan.units_assumed { " (assumed; --units to change)" } else { "" };
    let direction = |distances: &DistanceFigures, name: &str| {
        let d = &distances.deviation;
        let [x, y, z] = d.max_at;
        format!(
            "rms {}, p95 {}, max {} at ({x:.3}, {y:.3}, {z:.3}), {}",
            mm(d.rms_mm),
            mm(d.p95_mm),
            mm(d.max_mm),
            plural(distances.points, name)
        )
    };
    let name = if cad.name.is_empty() { String::new() } else { format!("{}: ", cad.name) };
    let mut lines = vec![
        format!("{} against {}", cad.file, scan.file),
        format!("  units         {}{assumed}", scan.units),
    ];
    if scan.left_out_triangles > 0 {
        let all = if args.component == ComponentChoice::All {
            ""
        } else {
            "; --component all takes every one"
        };
        lines.push(format!(
            "  components    {} of {}, without {} in the others{all}",
            scan.components_measured,
            scan.components,
            plural(scan.left_out_triangles, "triangle"),
        ));
    }
    lines.extend([
        format!(
            "  CAD           {name}{}, {}, {} mm²",
            plural(cad.faces, "face"),
            plural(cad.loops, "loop"),
            plain_mm(cad.area_mm2)
        ),
        format!("  CAD size      {}", box_extents(cad.bounds_mm)),
        format!("  scan size     {}", box_extents(scan.bounds_mm)),
        format!("  scan to face  {}", direction(&figures.scan_to_face, "point")),
        format!("  face to scan  {}", direction(&figures.face_to_scan, "sample")),
    ]);
    lines.extend(figures.hints.iter().map(|hint| format!("  hint          {hint}")));
    lines.iter().map(|line| wrapped(line, INDENT) + "\n").collect()
}
