//! Measures the distances between a CAD file of any program and a scan: from every point of the
//! scan to the trimmed faces, and from samples of the faces to the scan.
//!
//! cargo run --release --example deviation -- CAD SCAN

use std::error::Error;
use std::path::Path;

use formats::LengthUnit;
use scan2step::check::check;
use scan2step::mesh::{self, Choice, Components, Outer};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [cad, scan] = args.as_slice() else { return Err("CAD SCAN".into()) };
    let model = formats::cad::read_cad(Path::new(cad))?;
    let soup = formats::read_scan(Path::new(scan))?;
    let unit = soup.unit.unwrap_or(LengthUnit::Millimetre);
    let pieces = Components::new(mesh::from_soup(&soup, unit.in_mm())?);
    let measured = scan2step::measured(&pieces, &[Choice::Largest], Outer::Auto)?;

    let found = check(&model, &measured.mesh, measured.points.as_deref())?;
    println!("{} face, {} loops, {:.1} mm²", found.faces, found.loops, found.area);
    for (what, off) in
        [("scan to face", &found.scan_to_face), ("face to scan", &found.face_to_scan)]
    {
        let [x, y, z] = off.max_at;
        println!("{what}: rms {:.4} mm, most {:.4} mm near {x:.1} {y:.1} {z:.1}", off.rms, off.max);
    }
    Ok(())
}
