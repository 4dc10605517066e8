//! A scan becomes a CAD file: the whole program in twenty lines.
//!
//! cargo run --release --example convert -- SCAN OUT.step [TOLERANCE]
//!
//! Prints how far the scan's points are from the face.

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use formats::{LengthUnit, step};
use scan2step::{Options, convert};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [scan, out, rest @ ..] = args.as_slice() else {
        return Err("SCAN OUT.step [TOLERANCE]".into());
    };
    let tolerance: Option<f64> = rest.first().map(|mm| mm.parse()).transpose()?;

    let soup = formats::read_scan(Path::new(scan))?;
    let unit = soup.unit.unwrap_or(LengthUnit::Millimetre);
    let options = Options::builder().name(scan).unit(unit).tolerance(tolerance).build()?;
    // The third argument is shown every stage as it ends, and may stop the work.
    let conversion = convert(&soup, &options, &mut |_| Ok(()))?;

    let mut file = BufWriter::new(File::create(out)?);
    step::write(&conversion.brep, &step::Options::default(), &mut file)?;
    file.flush()?;
    let (off, kept) = (&conversion.deviation, conversion.tolerance_met(0.0));
    println!("rms {:.4} mm, at most {:.4} mm, within tolerance: {kept}", off.rms, off.max);
    Ok(())
}
