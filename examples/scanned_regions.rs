//! Finds the regions of a noisy scan and writes them as JSON: points, the region of each triangle, and the surfaces.
//!
//! ```sh
//! cargo run --release --example scanned_regions -- scan.ply regions.json
//! ```

use std::error::Error;
use std::path::Path;

use cpu_time::ProcessTime;
use scan2step::formats::read_scan;
use scan2step::mesh::from_soup;
use scan2step::primitives::Primitive;
use scan2step::stages::regions::{FaceRegion, ScanNoise, find_scanned};
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn Error>> {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let [from, to] = files.as_slice() else {
        return Err("usage: scanned_regions SCAN JSON".into());
    };
    let build = from_soup(&read_scan(Path::new(from))?, 1.0)?;
    let mesh = &build.mesh;
    let start = ProcessTime::now();
    let noise = ScanNoise::of(mesh);
    let measured = start.elapsed().as_secs_f64();
    let regions = find_scanned(mesh, &noise);
    let seconds = start.elapsed().as_secs_f64();
    let value = json!({
        "mm": build.mm,
        "deviation": noise.deviation,
        "correlation": noise.correlation,
        "seconds": [measured, seconds],
        "explained": regions.explained,
        "points": mesh.points.iter().map(|p| p.coords.as_slice().to_vec()).collect::<Vec<_>>(),
        "triangles": mesh.triangles.iter().map(|t| t.map(|v| v.0)).collect::<Vec<_>>(),
        "of_triangle": regions.of_triangle,
        "regions": regions.regions.iter().map(described).collect::<Vec<_>>(),
    });
    std::fs::write(to, value.to_string())?;
    println!(
        "{from}: {} vertices, σ {:.5}, {} regions, {:.1} % explained, {seconds:.2} s of CPU",
        mesh.points.len(),
        noise.deviation,
        regions.regions.len(),
        100.0 * regions.explained
    );
    Ok(())
}

fn described(region: &FaceRegion) -> Value {
    let list = |v: &[f64]| json!(v);
    let (origin, axis, size) = match region.surface {
        Primitive::Plane { origin, normal } => (origin, Some(normal), json!({})),
        Primitive::Cylinder { origin, axis, radius } => {
            (origin, Some(axis), json!({"radius": radius}))
        }
        Primitive::Cone { origin, axis, radius, angle } => {
            (origin, Some(axis), json!({"radius": radius, "angle": angle}))
        }
        Primitive::Sphere { centre, radius } => (centre, None, json!({"radius": radius})),
        Primitive::Torus { centre, axis, major, minor } => {
            (centre, Some(axis), json!({"radius": minor, "major": major}))
        }
    };
    json!({
        "kind": region.surface.kind().name(),
        "side": region.side,
        "origin": list(origin.coords.as_slice()),
        "axis": axis.map(|a| list(a.as_slice())),
        "size": size,
        "vertices": region.vertices,
        "variances": region.covariance.diagonal().as_slice().to_vec(),
    })
}
