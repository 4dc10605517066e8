//! `scan2step inspect`: what a scan is.

use scan2step::Inspection;
use scan2step::words::mm;
use serde_json::{Value, json};

use super::args::Inspect;
use super::input::{self, Scan};
use super::spelling::spelled;
use super::{Failure, Outcome, report, streams};

/// Reads, repairs, looks, prints.
pub fn run(args: &Inspect) -> Result<Outcome, Failure> {
    let scan = Scan::read(&args.piece)?;
    let outer = scan.outer(&args.piece)?;
    let (scan, components) = scan.components()?;
    let found = scan2step::inspect(components, args.component, outer);
    let found = found.map_err(|e| input::stopped(&scan.path, &e))?;
    let text = if args.look.json {
        format!("{:#}\n", as_json(&scan, &found))
    } else {
        as_text(&scan, &found)
    };
    streams::print(text.as_bytes())?;
    Ok(Outcome::Done)
}

fn as_json(scan: &Scan, found: &Inspection) -> Value {
    let mut object = report::input(&found.input, scan);
    let loops = found.loops.iter().enumerate().map(|(i, (length, vertices))| {
        json!({ "length_mm": length, "vertices": vertices, "outer": found.outer == Some(i) })
    });
    let genus = found.topology.genus();
    let more = json!({
        // A whole number where the surface has two sides.
        "genus": if genus.fract() == 0.0 { json!(genus as i64) } else { json!(genus) },
        "orientable": found.topology.orientable,
        "disk": found.topology.is_disk(),
        "loops": loops.collect::<Vec<_>>(),
        "bounds_mm": found.bounds,
        "left_out_triangles": found.input.left_out,
        "noise_mm": found.noise,
    });
    if let (Some(object), Value::Object(more)) = (object.as_object_mut(), more) {
        object.extend(more);
    }
    object
}

fn as_text(scan: &Scan, found: &Inspection) -> String {
    let input = &found.input;
    let [low, high] = found.bounds;
    let [x, y, z] = [0, 1, 2].map(|k| high[k] - low[k]);
    let assumed = if scan.unit_assumed { " (assumed; --units to change)" } else { "" };
    let mut lines = vec![
        format!("{}", scan.path.display()),
        format!("  file        {} vertices, {} triangles", scan.counts[0], scan.counts[1]),
        format!("  units       {}{assumed}", scan.unit.symbol()),
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

/// How many holes are listed one by one.
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
