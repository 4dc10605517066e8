//! Reads a cloud of points. `benches/peers/points.py` compares the figures with those of other
//! programs.
//!
//! cargo run --release -p scan2step-formats --example points -- FILE
//!
//! The example prints one line of JSON: the number of points, the sum of the bits of all
//! coordinates, and the peak memory of the process in MB (10^6 bytes). It needs Linux.

use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args_os().nth(1).map(PathBuf::from).ok_or("FILE is missing")?;
    let cloud = formats::read_points(&file)?;
    let bits = (0..cloud.len()).flat_map(|i| cloud.absolute(i)).map(f64::to_bits);
    let sum = bits.fold(0, u64::wrapping_add);
    let status = std::fs::read_to_string("/proc/self/status")?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib: f64 = peak.and_then(|peak| peak.split_whitespace().next()).unwrap_or("0").parse()?;
    let peak_mb = kib * 1024.0 / 1e6;
    println!("{{\"points\": {}, \"sum\": {sum}, \"peak_rss_mb\": {peak_mb}}}", cloud.len());
    Ok(())
}
