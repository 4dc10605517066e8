//! `scan2step inspect`: what a scan is.

use scan2step::primitives::PrimitiveKind;
use scan2step::report::{CloudFigures, InspectionFigures, ScanFigures, likely_unit};
use scan2step::words::{box_extents, extents, grouped, mm, plural, repair, tolerance_reason};
use scan2step::{ExactEstimate, Inspection, PieceReport, TargetShape};

use super::args::Inspect;
use super::input::{self, ReadScan};
use super::paragraphs::wrapped;
use super::spelling::spelled;
use super::{Failure, Outcome, cylinders, inspect_parts, messages, streams};

/// Reads and repairs a scan, and prints what it is.
pub(crate) fn run(args: &Inspect) -> Result<Outcome, Failure> {
    let content = input::read_content(&args.piece)?;
    if let Some(text) = inspect_parts::inspected(args, &content)? {
        streams::print(text.as_bytes())?;
        return Ok(Outcome::Done);
    }
    let scan = ReadScan::of(&args.piece, content)?;
    let outer = scan.outer(&args.piece)?;
    let options = ReadScan::options(&args.piece)?;
    let (scan, components) = scan.components(&options, &mut |_| Ok(()))?;
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

/// The column at which texts begin.
pub(super) const INDENT: usize = 14;

fn as_text(scan: &ReadScan, found: &Inspection) -> String {
    let input = &found.input;
    let source = &scan.source;
    let assumed = if source.unit_assumed { " (assumed; --units to change)" } else { "" };
    let mut lines = vec![
        format!("{}", scan.path.display()),
        format!("  file        {}", messages::counts(source)),
        format!("  units       {}{assumed}", source.unit.symbol()),
    ];
    lines.extend(source.cloud.iter().flat_map(scans));
    if source.origin_mm != [0.0; 3] {
        let [x, y, z] = source.origin_mm;
        lines.push(format!("  origin      ({x:.3}, {y:.3}, {z:.3}) mm"));
    }
    lines.extend(source.cloud.iter().flat_map(meshed));
    lines.extend(
        likely_unit(source, found.input.bounds).map(|hint| format!("  hint        {hint}")),
    );
    let which = match input.components {
        1 => "the only one".to_owned(),
        count => {
            format!("number {} of {}, where 0 is the largest", input.component, grouped(count))
        }
    };
    lines.extend([
        format!("  component   {which}: {}", messages::mesh([input.vertices, input.triangles])),
        format!("  size        {}", box_extents(found.input.bounds)),
        format!("  surface     {}", kind(found)),
        format!("  becomes     {}", target(found)),
    ]);
    let radii = found.exact.iter().map(|exact| &exact.radii).filter(|radii| !radii.is_empty());
    lines.extend(radii.map(|radii| format!("  cylinders   radius {}", cylinders::radii(radii))));
    lines.extend(choices(found));
    lines.extend(loops(found));
    if input.islands > 0 {
        let triangles = plural(input.island_triangles, "triangle");
        lines.push(format!("  islands     {} in its holes, {triangles}", input.islands));
    }
    lines.push(format!("  noise       {}", mm(found.noise)));
    lines.extend(found.pieces.iter().enumerate().map(piece));
    lines.extend(scan.notes.iter().map(|note| format!("  note        {note}")));
    for (kind, count) in &input.repairs {
        lines.push(format!("  repaired    {}", repair(kind, *count)));
    }
    let cut = input.handles.iter().map(|handle| ("cut", handle));
    let kept = found.body.iter().flat_map(|body| &body.handles).map(|handle| ("kept", handle));
    for (what, handle) in cut.take(LISTED).chain(kept.take(LISTED)) {
        let (at, length) = (handle.at, mm(handle.length));
        let place = format!("({:.3}, {:.3}, {:.3})", at.x, at.y, at.z);
        lines.push(format!("  handle      {what}, about {length} around, near {place}"));
    }
    lines.iter().map(|line| wrapped(line, INDENT) + "\n").collect()
}

/// The tolerance and the outline that a conversion chooses if nobody names them.
fn choices(found: &Inspection) -> Vec<String> {
    if found.shape.is_none() || found.exact.is_some() {
        return Vec::new();
    }
    let why = tolerance_reason(found.tolerance, found.noise);
    let mut lines =
        vec![format!("  tolerance   about {}, {why} (--tolerance to change)", mm(found.tolerance))];
    lines.extend(found.is_ragged.map(|is_ragged| {
        let outline = if is_ragged {
            "likely a trim loop, as the outer boundary is ragged (--outline to change)"
        } else {
            "the four sides of the face, unless they stretch it too much (--outline to change)"
        };
        format!("  outline     {outline}")
    }));
    lines
}

/// A line for each scan of a cloud.
fn scans(cloud: &CloudFigures) -> Vec<String> {
    let place = |[x, y, z]: [f64; 3]| format!("({x:.3}, {y:.3}, {z:.3})");
    let scan = |(number, scan): (usize, &ScanFigures)| {
        let grid = scan.grid.map(|[rows, columns]| format!("grid of {rows} × {columns}"));
        let seen = scan.viewpoint_mm.map(|at| format!("seen from {}", place(at)));
        let extent = scan.bounds_mm.map(box_extents);
        let parts = [Some(plural(scan.points, "point")), extent, grid, seen];
        format!("  scan {number:<7}{}", parts.into_iter().flatten().collect::<Vec<_>>().join(", "))
    };
    cloud.scans.iter().enumerate().map(scan).collect()
}

/// What was found when the mesh of a cloud was made.
fn meshed(cloud: &CloudFigures) -> Option<String> {
    cloud.mesh.as_ref().map(|mesh| {
        let [outliers, duplicates] =
            [plural(mesh.outliers, "outlier"), plural(mesh.duplicates, "duplicate")];
        let made =
            if mesh.mesher == "grid" { "along the scan's grid" } else { "from the points alone" };
        let [spacing, noise] = [mesh.spacing_mm, mesh.noise_mm].map(mm);
        format!(
            "  points      {spacing} apart, noise {noise}, {outliers}, {duplicates}, meshed {made}"
        )
    })
}

/// A line for one of several components, by whose number `--component` takes it.
fn piece((number, piece): (usize, &PieceReport)) -> String {
    let topology = &piece.topology;
    let loops = plural(topology.loops, "boundary loop");
    let sides = if topology.orientable { "" } else { ", one-sided" };
    format!(
        "  --component {number:<3} {}, {}, {loops}, genus {}{sides}",
        plural(piece.triangles, "triangle"),
        extents(piece.size),
        topology.genus()
    )
}

/// What the surface is.
fn kind(found: &Inspection) -> String {
    let topology = &found.topology;
    match found.loops.len() {
        _ if !topology.orientable => "one-sided".into(),
        1 if topology.is_disk() => "a disk without holes".into(),
        loops if topology.is_disk() => format!("a disk with {}", plural(loops - 1, "hole")),
        0 => format!("closed, genus {}", topology.genus()),
        loops => format!("genus {}, {}", topology.genus(), plural(loops, "boundary loop")),
    }
}

/// What a conversion makes of it.
pub(super) fn target(found: &Inspection) -> String {
    if let Some(exact) = &found.exact {
        return exact_target(exact);
    }
    let faces = found
        .body
        .as_ref()
        .map_or("several faces".into(), |body| format!("about {}", plural(body.faces, "face")));
    let why = found.reason;
    match (found.shape, found.topology.check_disk()) {
        (Some(TargetShape::Solid), _) if found.loops.is_empty() => {
            format!("a solid of {faces}, {why}")
        }
        (Some(TargetShape::Solid), _) => {
            format!("a solid of {faces} with its gaps filled, {why} (--shape to change)")
        }
        (Some(TargetShape::Shell), _) => format!("a shell of {faces}, {why} (--shape to change)"),
        (_, Ok(())) => format!("a face, {why} (--shape to change)"),
        (_, Err(e)) => format!("nothing: {e}; {}", spelled(&e.help())),
    }
}

/// What a conversion makes of a part.
fn exact_target(exact: &ExactEstimate) -> String {
    let count = |kind: &PrimitiveKind| exact.kinds.iter().filter(|&of| of == kind).count();
    let counts = PrimitiveKind::ALL.iter().map(|kind| (kind.name(), count(kind)));
    let all = plural(exact.kinds.len() + exact.facets, "face");
    let kinds = messages::kinds(counts.chain([("facet", exact.facets)]));
    let shape = exact.shape.map_or("body", TargetShape::word);
    match exact.noise {
        Some(noise) => format!(
            "a {shape} of {all}: {kinds} on {:.0} % of the area, as noise of {} explains how far its vertices are off them; others join them",
            100.0 * exact.explained,
            mm(noise)
        ),
        None => {
            let near = messages::within_rounding(exact.rounding_factor);
            format!("a {shape} of {all}: {kinds}, as its vertices lie on them {near}")
        }
    }
}

/// The number of holes, and of handles, that have a line of their own, so that the text fits on a screen.
const LISTED: usize = 12;

/// A line for the outer loop and for each of the longest holes.
fn loops(found: &Inspection) -> Vec<String> {
    let (outer, mut holes): (Vec<_>, Vec<_>) =
        found.loops.iter().enumerate().partition(|(i, _)| found.outer == Some(*i));
    holes.sort_by(|x, y| y.1.0.total_cmp(&x.1.0));
    let line = |what: &str, (length, vertices): &(f64, usize)| {
        format!("  {what:<11} {}, {}", mm(*length), plural(*vertices, "vertex"))
    };
    let mut lines: Vec<String> = outer.iter().map(|(_, l)| line("outer loop", l)).collect();
    lines.extend(holes.iter().take(LISTED).map(|(_, l)| line("hole", l)));
    if holes.len() > LISTED {
        lines.push(format!("  and {}", plural(holes.len() - LISTED, "shorter hole")));
    }
    lines
}
