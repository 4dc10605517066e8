//! `inspect` of a file with several parts: the parts, and the tree of their places.

use formats::scene::{NodeContent, NodeId};
use formats::{Scene, SceneContent};
use scan2step::InspectedPart;
use scan2step::mesh::Choice;
use scan2step::report::{AssemblyInspection, AssemblySource};
use scan2step::words::{box_extents, plural};

use super::args::Inspect;
use super::assembly::Y_UP;
use super::input::{self, ReadScan};
use super::paragraphs::wrapped;
use super::{Failure, assembly, inspect, messages};

/// The text of `inspect` about a file with several parts. `None` if the file is no assembly, or if a component of all
/// meshes together is named.
pub(crate) fn inspected(args: &Inspect, content: &SceneContent) -> Result<Option<String>, Failure> {
    let SceneContent::Scene(scene) = content else { return Ok(None) };
    let names_component = args.component != Choice::Largest || args.piece.outer.is_some();
    let split = scene.split_groups();
    let count = split.as_ref().unwrap_or(scene).place_count();
    if count < 2 || names_component || args.piece.cloud.remesh {
        return Ok(None);
    }
    let options = ReadScan::options(&args.piece)?;
    let stopped = |e| input::stopped(&args.piece.scan.name, &e);
    let scene = split.unwrap_or_else(|| scene.clone());
    let Ok(parts) = assembly::parts_of(scene, &options, false).map_err(stopped)? else {
        return Ok(None);
    };
    let (scene, parts) = parts.inspect(&options).map_err(stopped)?;
    let scene = &scene;
    let file = args.piece.scan.name.display().to_string();
    let figures = AssemblyInspection::of(scene, &parts, &file, &options);
    Ok(Some(if args.look.json { figures.to_json() } else { as_text(scene, &parts, &figures) }))
}

/// The most places of the tree that are listed.
const LISTED: usize = 40;

fn as_text(scene: &Scene, parts: &[InspectedPart], figures: &AssemblyInspection) -> String {
    let AssemblySource { file, units, units_assumed, file_vertices, file_triangles, notes, .. } =
        &figures.input;
    let assumed = if *units_assumed { " (assumed; --units to change)" } else { "" };
    let [parts_count, places] = [plural(parts.len(), "part"), plural(scene.place_count(), "place")];
    let mut lines = vec![
        file.clone(),
        format!("  file        {}", messages::mesh([*file_vertices, *file_triangles])),
        format!("  units       {units}{assumed}"),
        format!("  parts       {parts_count} in {places} (--parts to choose)"),
    ];
    lines.extend(scene.is_y_up.then(|| format!("  axes        {Y_UP}")));
    lines.extend(notes.iter().map(|note| format!("  note        {note}")));
    for (number, part) in parts.iter().enumerate() {
        let places = plural(part.part.places.len(), "place");
        let what = match &part.found {
            Ok(found) => {
                let triangles = plural(found.input.triangles, "triangle");
                let size = box_extents(found.input.bounds);
                format!("{triangles}, {size}, becomes {}", inspect::target(found))
            }
            Err(e) => format!("cannot be converted: {e}"),
        };
        lines.push(format!("  --parts {number:<3} {}, in {places}: {what}", part.part.name));
    }
    let mut levels = Vec::new();
    for (number, node) in scene.nodes().iter().enumerate() {
        levels.push(node.parent.map_or(0, |NodeId(parent)| levels[parent] + 1));
        if number < LISTED {
            let indent = "  ".repeat(levels[number]);
            let name = scene.name(NodeId(number)).unwrap_or("without a name");
            let part = match node.content {
                NodeContent::Group => String::new(),
                NodeContent::Form(form) => {
                    let part = parts.iter().position(|part| part.part.form == form);
                    part.map_or(String::new(), |part| format!(" (part {part})"))
                }
            };
            lines.push(format!(
                "  {}{indent}{name}{part}",
                if number == 0 { "tree        " } else { "            " }
            ));
        }
    }
    if scene.nodes().len() > LISTED {
        lines.push(format!("              and {} more", scene.nodes().len() - LISTED));
    }
    lines.iter().map(|line| wrapped(line, inspect::INDENT) + "\n").collect()
}
