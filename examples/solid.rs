//! Models a solid with truck, writes it as a STEP and an IGES file, and converts it back to truck.
//!
//! cargo run --release --example solid -- OUT.step OUT.igs

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};

use formats::Brep;
use formats::brep::ShellId;
use formats::{iges, step};
use truck_modeling::{Face, ParametricSurface, Point3, Solid, Vector3, Wire, builder};

/// The corners of the profile of an angle section, in mm.
const PROFILE: [[f64; 2]; 6] =
    [[0.0, 0.0], [40.0, 0.0], [40.0, 5.0], [5.0, 5.0], [5.0, 30.0], [0.0, 30.0]];

/// A steel angle section with a length of 50 mm.
fn angle() -> Result<Solid, Box<dyn Error>> {
    let corners = PROFILE.map(|[x, y]| builder::vertex(Point3::new(x, y, 0.0)));
    let side = |k: usize| builder::line(&corners[k], &corners[(k + 1) % corners.len()]);
    let profile: Wire = (0..corners.len()).map(side).collect();
    let face: Face = builder::try_attach_plane(&[profile])?;
    Ok(builder::tsweep(&face, 50.0 * Vector3::unit_z()))
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [step_file, iges_file] = args.as_slice() else { return Err("OUT.step OUT.igs".into()) };
    let mut brep = Brep { name: "angle".into(), uncertainty_mm: 1e-7, ..Brep::default() };
    brep.add_truck_solid(&angle()?)?;
    brep.check()?;
    println!("{} faces, {:.3} mm³", brep.faces.len(), brep.volume(ShellId(0)));

    let mut file = BufWriter::new(File::create(step_file)?);
    step::write(&brep, &step::Options::default(), &mut file)?;
    file.flush()?;
    let mut file = BufWriter::new(File::create(iges_file)?);
    let options = iges::Options { form: iges::Form::Brep, ..iges::Options::default() };
    iges::write(&brep, &options, &mut file)?;
    file.flush()?;

    // truck evaluates the converted solid.
    let back = brep.truck_solid(&brep.solids[0])?;
    for face in back.face_iter() {
        let middle = face.surface().subs(0.0, 0.0);
        println!("a face through ({:.1}, {:.1}, {:.1})", middle.x, middle.y, middle.z);
    }
    Ok(())
}
