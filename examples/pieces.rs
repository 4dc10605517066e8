//! Converts every piece of a scan to its own file. The scan is read once. If a piece cannot be
//! converted, the example prints the error and continues with the next one.
//!
//! cargo run --release --example pieces -- SCAN FOLDER

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use formats::{LengthUnit, step};
use scan2step::mesh::{self, Choice, Components, Outer};
use scan2step::{Options, convert_component};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [scan, folder] = args.as_slice() else { return Err("SCAN FOLDER".into()) };
    let soup = formats::read_scan(Path::new(scan))?;
    let unit = soup.unit.unwrap_or(LengthUnit::Millimetre);
    let pieces = Components::new(mesh::from_soup(&soup, unit.in_mm())?);
    // Dust, and islands in the holes of other components, are not separate pieces.
    for number in pieces.without_islands(Outer::Auto) {
        let piece = Choice::Number(number);
        let options =
            Options::builder().name(format!("piece {number}")).component(piece).build()?;
        match convert_component(&pieces, &options, &mut |_| Ok(())) {
            Ok(conversion) => {
                let path = Path::new(folder).join(format!("piece-{number}.step"));
                let mut file = BufWriter::new(File::create(&path)?);
                step::write(&conversion.brep, &step::Options::default(), &mut file)?;
                file.flush()?;
                println!("piece {number}: rms {:.4} mm", conversion.deviation.rms);
            }
            Err(e) => println!("piece {number}: {e}; {}", e.help()),
        }
    }
    Ok(())
}
