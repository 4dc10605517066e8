//! Prints the scene of a file: its nodes with their names, places and meshes.
//!
//! `cargo run -p scan2step-formats --example scene -- FILE`

use std::path::Path;

use formats::scene::{FormId, NodeContent, NodeId};

fn main() {
    for file in std::env::args().skip(1) {
        match formats::read_scene(Path::new(&file)) {
            Ok(scene) => print(&file, &scene),
            Err(e) => println!("{e}\n  {}", e.help),
        }
    }
}

fn print(file: &str, scene: &formats::Scene) {
    let unit = scene.unit.map_or("no unit", |unit| unit.symbol());
    println!("{file}: {unit}, {} places", scene.place_count());
    for note in &scene.notes {
        println!("  note: {note}");
    }
    let mut depth = Vec::new();
    for node in scene.nodes() {
        depth.push(node.parent.map_or(0, |NodeId(parent)| depth[parent] + 1));
        let level = depth[depth.len() - 1];
        let what = match node.content {
            NodeContent::Group => format!("group {:?}", node.group_name),
            NodeContent::Form(FormId(form)) => {
                let form = &scene.forms()[form];
                let mesh = &scene.meshes()[form.mesh.0];
                let stretched = if form.stretch.is_some() { ", stretched" } else { "" };
                format!(
                    "{:?}: {} triangles, colour {:?}, {} colours, {} groups{stretched}",
                    mesh.name,
                    mesh.soup.polygons.triangle_count(),
                    mesh.colour,
                    mesh.colours.values().len(),
                    mesh.groups.values().len(),
                )
            }
        };
        let name = node.name.as_deref().unwrap_or("-");
        println!("  {}{name} at {:?}: {what}", "  ".repeat(level), node.placement.translation);
    }
}
