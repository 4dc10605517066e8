//! Measures the stages up to the parameterization. `benches/peers/read.py`, `fill.py` and
//! `clouds.py` beside it, and `benches/smoothing.py` compare the figures with those of other programs and with the truth.
//!
//! cargo run --release --example measure -- FILE [--mesh | --cloud OUT.ply | --smooth OUT.ply |
//!     --fill OUT.ply | --map least-stretch | --map mean-value]
//!
//! The example prints one line of JSON. `--cloud` takes a cloud of points and writes its triangles,
//! with vertices relative to the origin of the cloud. `--smooth` writes the smoothed mesh, and its boundary loops
//! to `OUT.loops.json`. `--fill` writes the filled mesh, in which the measured triangles come
//! first. The example needs Linux: the CPU seconds of all threads and the peak memory of the
//! process are from /proc.

mod usage;

use std::error::Error;
use std::fs;
use std::io::{BufWriter, Write};
use std::path::Path;

use scan2step::geometry::{Point, VertexId};
use scan2step::mesh::{
    self, Choice, Components, Disk, EdgeMap, FaceOrigin, Mesh, Outer, Patch, Repairs,
};
use scan2step::stages::parameterize::{self, MapMethod};
use scan2step::stages::{cloud, fill, smooth};
use serde_json::{Map, json};
use usage::{cpu_s, peak_rss_mb};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let steps = Steps { cpu_s: Map::new(), begun: cpu_s()? };
    match args[..] {
        // The memory of the process before any work.
        [] => println!("{}", json!({ "peak_rss_mb": rounded(peak_rss_mb()?) })),
        [file] => read(file, steps)?,
        [file, "--mesh"] => mesh(file, steps)?,
        [file, "--cloud", out] => cloud(file, out, steps)?,
        [file, "--smooth", out] => smooth(file, out, steps)?,
        [file, "--fill", out] => fill(file, out, steps)?,
        [file, "--map", "least-stretch"] => map(file, MapMethod::LeastStretch, steps)?,
        [file, "--map", "mean-value"] => map(file, MapMethod::MeanValue, steps)?,
        _ => {
            return Err("FILE [--mesh | --cloud OUT.ply | --smooth OUT.ply | --fill OUT.ply | \
                        --map least-stretch | --map mean-value]"
                .into());
        }
    }
    Ok(())
}

fn read(file: &str, mut steps: Steps) -> Result<(), Box<dyn Error>> {
    let soup = formats::read_scan(Path::new(file))?;
    steps.end("read")?;
    let (vertices, triangles) = (soup.points.len(), soup.polygons.len());
    steps.print(json!({ "task": "read", "vertices": vertices, "triangles": triangles }))
}

fn mesh(file: &str, mut steps: Steps) -> Result<(), Box<dyn Error>> {
    let soup = formats::read_scan(Path::new(file))?;
    steps.end("read")?;
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

fn cloud(file: &str, out: &str, mut steps: Steps) -> Result<(), Box<dyn Error>> {
    let points = formats::read_points(Path::new(file))?;
    steps.end("read")?;
    let options = cloud::Options::default();
    let made = cloud::triangulate(&points, &options, &mut |_| Ok(()))?;
    steps.end("cloud")?;
    let triangles = made.soup.polygons.iter().map(|t| [t[0], t[1], t[2]].map(VertexId)).collect();
    let points = made.soup.points.iter().map(|&p| Point::from(p)).collect();
    write_ply(&Mesh { points, triangles }, out)?;
    let report = &made.report;
    steps.print(json!({
        "task": "cloud", "points": report.points, "vertices": report.vertices,
        "triangles": report.triangles, "outliers": report.outliers, "spacing": report.spacing,
        "noise": report.noise, "grid": format!("{:?}", report.grid),
    }))
}

fn smooth(file: &str, out: &str, mut steps: Steps) -> Result<(), Box<dyn Error>> {
    let (disk, repairs) = disk(file)?;
    steps.end("mesh")?;
    let (smoothed, report) = smooth::smooth(&disk, &smooth::Options::default())?;
    steps.end("smooth")?;
    write_ply(&smoothed.mesh, out)?;
    let loops: Vec<Vec<u32>> =
        smoothed.loops().map(|ring| ring.iter().map(|v| v.0).collect()).collect();
    fs::write(Path::new(out).with_extension("loops.json"), json!(loops).to_string())?;
    steps.print(json!({
        "task": "smooth", "vertices": disk.mesh.points.len(), "h_mm": report.h,
        "noise_mm": report.noise, "moved_rms_mm": report.moved_rms,
        "outliers": report.outliers, "repairs": repairs,
    }))
}

fn fill(file: &str, out: &str, mut steps: Steps) -> Result<(), Box<dyn Error>> {
    let (patch, report) = filled(file, &mut steps)?;
    write_ply(&patch.mesh, out)?;
    let triangles = patch.origin.iter().filter(|o| **o == FaceOrigin::Measured).count();
    steps.print(json!({
        "task": "fill", "vertices": patch.measured, "triangles": triangles,
        "holes": report.holes.len(),
    }))
}

fn map(file: &str, method: MapMethod, mut steps: Steps) -> Result<(), Box<dyn Error>> {
    let (patch, _) = filled(file, &mut steps)?;
    let before = rounded(peak_rss_mb()?);
    let vertices = patch.mesh.points.len();
    let options = parameterize::Options { method, ..parameterize::Options::default() };
    let (_, report) = parameterize::parameterize(patch, &options)?;
    steps.end("parameterize")?;
    steps.print(json!({
        "task": "map", "vertices": vertices, "stretch_l2": report.stretch.l2,
        "flipped": report.flipped, "mended": report.mended, "peak_rss_mb_before": before,
    }))
}

/// The smoothed scan with filled holes.
fn filled(file: &str, steps: &mut Steps) -> Result<(Patch, fill::Report), Box<dyn Error>> {
    let (disk, _) = disk(file)?;
    steps.end("mesh")?;
    let (smoothed, report) = smooth::smooth(&disk, &smooth::Options::default())?;
    steps.end("smooth")?;
    let mut options = fill::Options::default();
    (options.support, options.noise) = (report.h, report.noise);
    let filled = fill::fill(smoothed, &disk.mesh.points, &options)?;
    steps.end("fill")?;
    Ok(filled)
}

/// The largest component of a scan, and its repairs.
fn disk(file: &str) -> Result<(Disk, Repairs), Box<dyn Error>> {
    let soup = formats::read_scan(Path::new(file))?;
    let scan = Components::new(mesh::from_soup(&soup, 1.0)?);
    drop(soup);
    let mut repairs = scan.repairs().clone();
    let disk = scan.take(Choice::Largest)?.into_disk(Outer::Auto, &mut repairs)?;
    Ok((disk, repairs))
}

/// Writes a binary PLY file of doubles and ints.
fn write_ply(mesh: &Mesh, out: &str) -> Result<(), Box<dyn Error>> {
    let mut file = BufWriter::new(fs::File::create(out)?);
    let (points, triangles) = (&mesh.points, &mesh.triangles);
    write!(
        file,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\n\
         property double y\nproperty double z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        points.len(),
        triangles.len()
    )?;
    for x in points.iter().flat_map(|p| p.iter()) {
        file.write_all(&x.to_le_bytes())?;
    }
    for t in triangles {
        file.write_all(&[3])?;
        for v in t {
            file.write_all(&v.0.to_le_bytes())?;
        }
    }
    Ok(file.flush()?)
}

/// The CPU seconds of each step.
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
