//! `scan2step check`: how far a CAD file is from a scan.

use std::io::stdin;
use std::path::Path;

use formats::SceneContent;
use formats::cad::{CadModel, read_cad, read_cad_stream};
use formats::scene::Placement;
use scan2step::report::{
    CheckFigures, DistanceFigures, MeasuredComponents, ScanSource, placement_of_rows,
};
use scan2step::words::{box_extents, grouped, mm, plain_mm, plural};
use scan2step::{SceneParts, check};

use super::args::{Check, ComponentChoice, Origin, cad_file};
use super::input::{self, ReadScan};
use super::paragraphs::wrapped;
use super::{Failure, Outcome, assembly, streams};

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
    let placement = args.placement.as_deref().map(placement_of).transpose()?;
    let model = if args.cad.is_stdin { read_cad_stream(cad, stdin())? } else { read_cad(cad)? };
    let content = input::read_content(&args.piece)?;
    let content = match assembly_of(args, content)? {
        // Parts of several are not aligned.
        Ok(_) if placement.is_some() => return Err(no_placement(args)),
        Ok(parts) => return check_parts(args, &model, parts),
        Err(content) => content,
    };
    let scan = ReadScan::of(&args.piece, content)?;
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
    let measured = match (&placement, args.piece.cloud.origin) {
        (Some(by), _) => measured.translated(scan.source.origin_mm).placed(by),
        (None, Origin::Keep) => measured.translated(scan.source.origin_mm),
        (None, Origin::Local) => measured,
    };
    let found = check::check(&model, &measured.mesh, measured.points.as_deref());
    let found = found.map_err(|e| input::stopped(&args.cad.name, &e))?;
    let cad = (args.cad.name.display().to_string(), &model);
    let scan = (&scan.source, parts);
    let figures = CheckFigures::of(&found, cad, scan, args.tolerance, args.outliers);
    tell(args, &figures)
}

/// The placement in a report.
fn placement_of(report: &Path) -> Result<Placement, Failure> {
    let failure = |error: String| Failure {
        error: format!("{}: {error}", report.display()),
        help: "name the JSON file that `convert --align --report FILE.json` has written".into(),
    };
    let text =
        std::fs::read_to_string(report).map_err(|e| failure(format!("cannot be read: {e}")))?;
    let read: serde_json::Value =
        serde_json::from_str(&text).map_err(|e| failure(format!("is no JSON: {e}")))?;
    let rows: Option<[[f64; 4]; 3]> =
        serde_json::from_value(read["placement"].clone()).ok().flatten();
    rows.map(placement_of_rows).ok_or_else(|| failure("has no placement".into()))
}

/// The error of a placement of a file with several parts.
fn no_placement(args: &Check) -> Failure {
    Failure {
        error: format!(
            "{}: has several parts, which are not aligned",
            args.piece.scan.name.display()
        ),
        help: "leave out --placement".into(),
    }
}

/// The parts of the scan, if it is an assembly and no component of all meshes is named. Otherwise its content.
fn assembly_of(
    args: &Check,
    content: SceneContent,
) -> Result<Result<SceneParts, SceneContent>, Failure> {
    let names_component = args.component != ComponentChoice::Largest || args.piece.outer.is_some();
    let SceneContent::Scene(scene) = content else { return Ok(Err(content)) };
    let split = scene.split_groups();
    let count = split.as_ref().unwrap_or(&scene).place_count();
    if count < 2 || names_component || args.piece.cloud.remesh {
        return Ok(Err(SceneContent::Scene(scene)));
    }
    let options = ReadScan::options(&args.piece)?;
    let (whole, scene) = match split {
        Some(split) => (Some(scene), split),
        None => (None, scene),
    };
    let parts = assembly::parts_of(scene, &options, false);
    let parts = parts.map_err(|e| input::stopped(&args.piece.scan.name, &e))?;
    Ok(parts.map_err(|scene| SceneContent::Scene(whole.unwrap_or(scene))))
}

/// Measures all parts in their places.
fn check_parts(args: &Check, model: &CadModel, parts: SceneParts) -> Result<Outcome, Failure> {
    let stopped = |e| input::stopped(&args.piece.scan.name, &e);
    let options = ReadScan::options(&args.piece)?;
    let scene = parts.measured(&options).map_err(stopped)?;
    let found = check::check(model, &scene.mesh, None);
    let found = found.map_err(|e| input::stopped(&args.cad.name, &e))?;
    let soup = scene.scene.meshes().first().map(|mesh| mesh.soup.clone()).unwrap_or_default();
    let source = ScanSource::of(args.piece.scan.name.display().to_string(), &soup, &options);
    let of_scan =
        MeasuredComponents { all: scene.components, measured: scene.components, left_out: 0 };
    let cad = (args.cad.name.display().to_string(), model);
    let scan = (&source, of_scan);
    let figures = CheckFigures::of(&found, cad, scan, args.tolerance, args.outliers);
    tell(args, &figures.of_parts(&found, &scene))
}

/// Prints the figures, and says whether the tolerance is met.
fn tell(args: &Check, figures: &CheckFigures) -> Result<Outcome, Failure> {
    let text = if args.look.json { figures.to_json() } else { as_text(args, figures) };
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
    for part in figures.parts.iter().flatten() {
        let worst = part
            .places
            .iter()
            .max_by(|a, b| a.distances.deviation.max_mm.total_cmp(&b.distances.deviation.max_mm));
        if let Some(worst) = worst {
            let places = plural(part.places.len(), "place");
            let d = &worst.distances.deviation;
            lines.push(format!(
                "  part          {}, in {places}: rms {}, max {} in {}",
                part.name,
                mm(d.rms_mm),
                mm(d.max_mm),
                worst.path.join(" / ")
            ));
        }
    }
    lines.extend(figures.hints.iter().map(|hint| format!("  hint          {hint}")));
    lines.iter().map(|line| wrapped(line, INDENT) + "\n").collect()
}
