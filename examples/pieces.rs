//! Converts every piece of a scan to its own file. The scan is read once. If a piece cannot be
//! converted, the example prints the error and continues with the next one.
//!
//! cargo run --release --example pieces -- SCAN FOLDER

use std::error::Error;
use std::path::Path;

use formats::LengthUnit;
use scan2step::mesh::{self, Choice, Components, Outer};
use scan2step::{Options, convert};

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
        match convert(&pieces, &options, &mut |_| Ok(())) {
            Ok(conversion) => {
                conversion.write(Path::new(folder).join(format!("piece-{number}.step")))?;
                for body in conversion.bodies() {
                    println!("piece {number}: rms {:.4} mm", body.deviation.rms);
                }
            }
            Err(e) => println!("piece {number}: {e}; {}", e.help()),
        }
    }
    Ok(())
}
