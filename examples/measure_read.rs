//! Measures reading a scan and making its mesh; `benches/peers/read.py` sets
//! the figures beside those of other programs.
//!
//! cargo run --release --example measure_read -- FILE [--mesh]
//!
//! Prints one line of JSON. Needs Linux: times are CPU seconds of all threads
//! and the peak is the process's, both from /proc.

use std::error::Error;
use std::fs;
use std::path::Path;

use scan2step::mesh::{self, Components, EdgeMap};
use serde_json::{Map, json};

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let Some(file) = args.next() else {
        // What the process costs without any work.
        println!("{}", json!({ "peak_rss_mb": rounded(peak_rss_mb()?) }));
        return Ok(());
    };
    let with_mesh = args.next().as_deref() == Some("--mesh");
    let mut steps = Steps { cpu_s: Map::new(), begun: cpu_s()? };

    let soup = formats::read_scan(Path::new(&file))?;
    steps.end("read")?;
    let (vertices, triangles) = (soup.points.len(), soup.polygons.len());
    if !with_mesh {
        let told = json!({ "task": "read", "vertices": vertices, "triangles": triangles });
        return steps.print(told);
    }

    let build = mesh::from_soup(&soup, 1.0)?;
    drop(soup);
    steps.end("mesh")?;
    let (vertices, triangles) = (build.mesh.points.len(), build.mesh.triangles.len());
    let loops = mesh::boundary::boundary_loops(&build.mesh, &EdgeMap::new(&build.mesh)).len();
    steps.end("loops")?;
    let components = Components::new(build);
    steps.end("components")?;
    steps.print(json!({
        "task": "mesh", "vertices": vertices, "triangles": triangles,
        "components": components.count(), "loops": loops, "manifold": true,
        "repairs": components.repairs(),
    }))
}

/// What each step took, in CPU seconds.
struct Steps {
    cpu_s: Map<String, serde_json::Value>,
    begun: f64,
}

impl Steps {
    fn end(&mut self, step: &str) -> Result<(), Box<dyn Error>> {
        let now = cpu_s()?;
        self.cpu_s.insert(step.into(), rounded(now - self.begun));
        self.begun = now;
        Ok(())
    }

    fn print(mut self, mut told: serde_json::Value) -> Result<(), Box<dyn Error>> {
        let total = self.cpu_s.values().filter_map(serde_json::Value::as_f64).sum();
        self.cpu_s.insert("total".into(), rounded(total));
        told["cpu_s"] = self.cpu_s.into();
        told["peak_rss_mb"] = rounded(peak_rss_mb()?);
        println!("{told}");
        Ok(())
    }
}

fn rounded(x: f64) -> serde_json::Value {
    json!((x * 1e3).round() / 1e3)
}

/// CPU seconds of all threads so far.
fn cpu_s() -> Result<f64, Box<dyn Error>> {
    let mut ns = 0.0;
    for task in fs::read_dir("/proc/self/task")? {
        let stat = fs::read_to_string(task?.path().join("schedstat"))?;
        ns += stat.split(' ').next().unwrap_or_default().parse::<f64>()?;
    }
    Ok(ns / 1e9)
}

/// The process's peak resident memory so far, in MB (10⁶ bytes).
fn peak_rss_mb() -> Result<f64, Box<dyn Error>> {
    let status = fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:")).ok_or("no VmHWM")?;
    Ok(line.trim().trim_end_matches("kB").trim().parse::<f64>()? * 1024.0 / 1e6)
}
