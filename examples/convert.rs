//! Converts a scan to a CAD file: the whole program in a few lines.
//!
//! cargo run --release --example convert -- SCAN OUT.step [TOLERANCE]
//!
//! It prints the distances of the scan's points from each body.

use std::error::Error;

use scan2step::{Options, convert_file};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [scan, out, rest @ ..] = args.as_slice() else {
        return Err("SCAN OUT.step [TOLERANCE]".into());
    };
    let tolerance: Option<f64> = rest.first().map(|mm| mm.parse()).transpose()?;

    // If the file does not declare its unit, set it here: `.unit(LengthUnit::Metre)`.
    let options = Options::builder().name(scan).tolerance(tolerance).build()?;
    for body in convert_file(scan, out, &options)?.bodies() {
        let (off, kept) = (&body.deviation, body.tolerance_met(0.0));
        println!("rms {:.4} mm, at most {:.4} mm, within tolerance: {kept}", off.rms, off.max);
    }
    Ok(())
}
