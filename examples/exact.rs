//! Reads the mesh of a CAD export, and writes the STEP file of its exact solid. Prints what was made as a line of JSON.
//!
//! ```sh
//! cargo run --example exact -- part.stl part.step
//! ```

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use scan2step::formats::{read_scan, step};
use scan2step::geometry::Point;
use scan2step::mesh::from_soup;
use scan2step::primitives::PrimitiveKind;
use scan2step::stages::regions::{self, FileRounding, MOST_TURN, RegionOrigin, Tessellation};
use scan2step::stages::seams::{self, FacePatch, FacetForm, solid};
use serde_json::json;

fn main() -> Result<(), Box<dyn Error>> {
    let mut names = std::env::args().skip(1);
    let (Some(from), Some(to)) = (names.next(), names.next()) else {
        return Err("give a mesh and a STEP file".into());
    };
    let soup = read_scan(Path::new(&from))?;
    let build = from_soup(&soup, 1.0)?;
    let errors = FileRounding::of(&soup.points).errors(&soup, &build, 1.0 / build.mm);
    let options = regions::Options { unit: build.mm, ..Default::default() };
    let found = regions::find(&Tessellation::new(&build.mesh, &errors), &options);
    let patches = found.regions.iter().map(|region| FacePatch {
        surface: region.surface.scaled(build.mm),
        side: region.side,
        is_facet: region.origin == RegionOrigin::Facet,
        form: FacetForm::Flat,
        triangles: region.triangles.clone(),
    });
    let mut mesh = build.mesh.clone();
    mesh.points.iter_mut().for_each(|p: &mut Point| *p *= build.mm);
    let errors: Vec<f64> = errors.iter().map(|e| e * build.mm).collect();
    let free_forms = seams::FreeForms::Through { turn: MOST_TURN, within: f64::INFINITY };
    let options = seams::Options { name: "part".into(), free_forms, ..Default::default() };
    let (brep, report) = solid(&mesh, &errors, patches.collect(), &options)?;
    let kinds = report.kinds();
    let count = |kind: PrimitiveKind| kinds.iter().filter(|&&k| k == kind).count();
    let fallbacks = report.fallbacks.iter().map(|f| {
        let place: [f64; 3] = f.place.into();
        json!({"kind": f.kind.name(), "triangles": f.triangles, "place": place, "why": f.why})
    });
    let line = json!({
        "file": from,
        "faces": kinds.len(),
        "facets": report.facets,
        "plane": count(PrimitiveKind::Plane),
        "cylinder": count(PrimitiveKind::Cylinder),
        "cone": count(PrimitiveKind::Cone),
        "sphere": count(PrimitiveKind::Sphere),
        "torus": count(PrimitiveKind::Torus),
        "gap": report.gap,
        "fallbacks": fallbacks.collect::<Vec<_>>(),
    });
    println!("{line}");
    step::write(&brep, &step::Options::default(), &mut BufWriter::new(File::create(to)?))?;
    Ok(())
}
