//! `scan2step inspect`: what a scan is.

use scan2step::Inspection;
use scan2step::report::InspectionFigures;
use scan2step::words::mm;

use super::args::Inspect;
use super::input::{self, Scan};
use super::spelling::spelled;
use super::{Failure, Outcome, streams};

/// Reads and repairs a scan, and prints what it is.
pub fn run(args: &Inspect) -> Result<Outcome, Failure> {
    let scan = Scan::read(&args.piece)?;
    let outer = scan.outer(&args.piece)?;
    let (scan, components) = scan.components()?;
    let found = scan2step::inspect(components, args.component, outer);
    let found = found.map_err(|e| input::stopped(&scan.path, &e))?;
    let text = if args.look.json {
        InspectionFigures::of(&found, &scan.source).to_json()
    } else {
        as_text(&scan, &found)
    };
    streams::print(text.as_bytes())?;
    Ok(Outcome::Done)
}

fn as_text(scan: &Scan, found: &Inspection) -> String {
    let input = &found.input;
    let [low, high] = found.bounds;
    let [x, y, z] = [0, 1, 2].map(|k| high[k] - low[k]);
    let source = &scan.source;
    let assumed = if source.unit_assumed { " (assumed; --units to change)" } else { "" };
    let mut lines = vec![
        format!("{}", scan.path.display()),
        format!("  file        {} vertices, {} triangles", source.vertices, source.triangles),
        format!("  units       {}{assumed}", source.unit.symbol()),
        format!(
            "  component   1 of {}: {} vertices, {} triangles, {x:.4} × {y:.4} × {z:.4} mm",
            input.components, input.vertices, input.triangles
        ),
        format!("  surface     {}", kind(found)),
    ];
    lines.extend(loops(found));
    if input.islands > 0 {
        let (count, triangles) = (input.islands, input.island_triangles);
        lines.push(format!("  islands     {count} in its holes, {triangles} triangles"));
    }
    lines.push(format!("  noise       {}", mm(found.noise)));
    for (kind, count) in &input.repairs {
        lines.push(format!("  repaired    {count} {}", kind.replace('_', " ")));
    }
    lines.join("\n") + "\n"
}

/// What the surface is, and whether it can become a face.
fn kind(found: &Inspection) -> String {
    match found.topology.check_disk() {
        Ok(()) if found.loops.len() == 1 => "a disk without holes".into(),
        Ok(()) => format!("a disk with {} holes", found.loops.len() - 1),
        Err(e) => format!("cannot become a face: {e}; {}", spelled(&e.help())),
    }
}

/// The number of holes that have a line of their own, so that the text fits on a screen.
const LISTED: usize = 12;

/// A line for the outer loop and for each of the longest holes.
fn loops(found: &Inspection) -> Vec<String> {
    let (outer, mut holes): (Vec<_>, Vec<_>) =
        found.loops.iter().enumerate().partition(|(i, _)| found.outer == Some(*i));
    holes.sort_by(|x, y| y.1.0.total_cmp(&x.1.0));
    let line = |what: &str, (length, vertices): &(f64, usize)| {
        format!("  {what:<11} {}, {vertices} vertices", mm(*length))
    };
    let mut lines: Vec<String> = outer.iter().map(|(_, l)| line("outer loop", l)).collect();
    lines.extend(holes.iter().take(LISTED).map(|(_, l)| line("hole", l)));
    if holes.len() > LISTED {
        lines.push(format!("  and {} shorter holes", holes.len() - LISTED));
    }
    lines
}
