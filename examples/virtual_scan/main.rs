//! Makes virtual scans with known true surfaces and measures the distance from them, for `benches/`
//! and to reproduce the figures of the documents.
//!
//! cargo run --release --example virtual_scan -- NAME OUT.ply
//! cargo run --release --example virtual_scan -- NAME samples OUT
//! cargo run --release --example virtual_scan -- NAME places OUT
//! cargo run --release --example virtual_scan -- NAME rms POINTS
//! cargo run --release --example virtual_scan -- NAME accuracy [cloud]
//!
//! The first command writes the scan in mm. `samples` writes its points with their true parameters:
//! five doubles for each point, u v x y z, as `examples/fit.rs` reads them. `places` writes 300 ×
//! 300 parameter points: three doubles for each, u v and whether the scan has a hole there. `rms`
//! reads points with three doubles each and prints their root mean square distance from the true
//! surface in mm. `accuracy` converts the scan and prints the distances of the output of every
//! stage as a row of a table. With `cloud` it converts the points without their triangles.

mod accuracy;
#[allow(dead_code)]
#[path = "../../tests/common/body.rs"]
mod body;
mod named;
#[path = "../../tests/common/virtual_scan.rs"]
#[allow(dead_code)]
mod virtual_scan;

use std::error::Error;
use std::fs::{self, File};
use std::io::{BufWriter, Write};

/// The number of points along a side at which surfaces are compared.
const PLACES: usize = 300;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let (&name, task) = args.split_first().ok_or("NAME OUT.ply")?;
    let unknown = || format!("{name} is none of {}", named::names());
    let scan = named::scan(name).ok_or_else(unknown)?;
    match *task {
        ["samples", out] => {
            let both = scan.uv.iter().zip(&scan.points);
            doubles(out, both.flat_map(|(uv, p)| uv.iter().chain(p).copied()))
        }
        ["places", out] => {
            let at = |i: usize| (i as f64 + 0.5) / PLACES as f64;
            let places = (0..PLACES * PLACES).map(|i| [at(i / PLACES), at(i % PLACES)]);
            let missed = |[u, v]: [f64; 2]| scan.holes.iter().any(|hole| hole.holds(u, v));
            doubles(out, places.flat_map(|at| [at[0], at[1], f64::from(u8::from(missed(at)))]))
        }
        ["rms", points] => {
            let points = read(points)?;
            println!("{}", scan.rms(points.into_iter()));
            Ok(())
        }
        ["accuracy"] | ["accuracy", "cloud"] => {
            println!("{}", accuracy::row(name, &scan, task.len() > 1)?);
            Ok(())
        }
        [out] => {
            let mut file = BufWriter::new(File::create(out)?);
            scan.write_ply(&mut file)?;
            Ok(file.flush()?)
        }
        _ => {
            Err("NAME OUT.ply | NAME samples|places OUT | NAME rms POINTS | NAME accuracy [cloud]"
                .into())
        }
    }
}

fn doubles(out: &str, numbers: impl Iterator<Item = f64>) -> Result<(), Box<dyn Error>> {
    let mut file = BufWriter::new(File::create(out)?);
    for x in numbers {
        file.write_all(&x.to_le_bytes())?;
    }
    Ok(file.flush()?)
}

fn read(file: &str) -> Result<Vec<[f64; 3]>, Box<dyn Error>> {
    let bytes = fs::read(file)?;
    let (points, rest) = bytes.as_chunks::<24>();
    if !rest.is_empty() {
        return Err(format!("{file}: not three doubles a point").into());
    }
    let number =
        |p: &[u8; 24], k: usize| f64::from_le_bytes(std::array::from_fn(|byte| p[8 * k + byte]));
    Ok(points.iter().map(|p| std::array::from_fn(|k| number(p, k))).collect())
}
