//! Fits a net to points with given parameters. `benches/peers/fit.py` compares the figures with
//! those of other programs and with the truth.
//!
//! cargo run --release --example fit -- SAMPLES M N METHOD [OUT]
//!
//! SAMPLES has five doubles for each point: u v x y z. The example prints one line of JSON with the
//! CPU seconds of all threads, the wall-clock seconds, the steps, and the root mean square distance
//! at equal parameters. It writes the control net to OUT, with three doubles for each point. It
//! needs Linux for the CPU time.

mod usage;

use std::error::Error;
use std::fs;
use std::time::Instant;

use scan2step::geometry::{Point, Uv};
use scan2step::spline::{KnotVector, Samples};
use scan2step::stages::fit::{self, Method};
use serde_json::json;
use usage::cpu_s;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [file, m, n, method, rest @ ..] = &args[..] else {
        return Err("SAMPLES M N blend|refined|global [OUT]".into());
    };
    let method = match method.as_str() {
        "blend" => Method::Blend,
        "refined" => Method::Refined,
        "global" => Method::Global,
        other => return Err(format!("{other} is no method").into()),
    };
    let samples = read(file)?;
    let knots = [KnotVector::cubic(m.parse()?)?, KnotVector::cubic(n.parse()?)?];
    let (cpu, clock) = (cpu_s()?, Instant::now());
    let (surface, report) = fit::fit(&samples, knots, method)?;
    let (cpu, clock) = (cpu_s()? - cpu, clock.elapsed().as_secs_f64());
    let at = samples.uv.iter().zip(&samples.points);
    let distances: Vec<f64> = at.map(|(&at, p)| (surface.point(at) - p).norm()).collect();
    let count = distances.len() as f64;
    println!(
        "{}",
        json!({
            "cpu_s": cpu, "clock_s": clock, "steps": report.steps,
            "mean_mm": distances.iter().sum::<f64>() / count,
            "rms_mm": (distances.iter().map(|d| d * d).sum::<f64>() / count).sqrt(),
        })
    );
    if let [out] = rest {
        let bytes = surface.net.iter().flat_map(|p| [p.x, p.y, p.z]).flat_map(f64::to_le_bytes);
        fs::write(out, bytes.collect::<Vec<u8>>())?;
    }
    Ok(())
}

fn read(file: &str) -> Result<Samples, Box<dyn Error>> {
    let bytes = fs::read(file)?;
    let numbers =
        bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap_or_default()));
    let numbers: Vec<f64> = numbers.collect();
    let mut samples = Samples::default();
    for x in numbers.chunks_exact(5) {
        samples.uv.push(Uv::new(x[0], x[1]));
        samples.points.push(Point::new(x[2], x[3], x[4]));
        samples.weights.push(1.0);
    }
    Ok(samples)
}
