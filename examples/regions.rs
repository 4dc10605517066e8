//! Prints the regions of CAD exports: kinds, radii, the triangles explained, and the seconds of CPU time, as a line of
//! JSON for each file. With `--faces` it lists all faces with their parameters, with `--details` also the mesh.
//!
//! ```sh
//! cargo run --example regions -- [--faces] part.stl other.obj
//! ```

use std::error::Error;
use std::path::Path;

use cpu_time::ThreadTime;
use scan2step::formats::read_scan;
use scan2step::mesh::from_soup;
use scan2step::primitives::{Primitive, PrimitiveKind};
use scan2step::stages::regions::{
    FaceRegion, FileRounding, FlatPairs, Options, RegionOrigin, Regions, Tessellation, find,
};
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn Error>> {
    let is_given = |flag: &str| std::env::args().any(|a| a == flag);
    let (details, faces) = (is_given("--details"), is_given("--faces"));
    for file in std::env::args().skip(1).filter(|a| !a.starts_with("--")) {
        println!("{}", line(Path::new(&file), details, faces)?);
    }
    Ok(())
}

fn line(file: &Path, details: bool, faces: bool) -> Result<Value, Box<dyn Error>> {
    let soup = read_scan(file)?;
    let build = from_soup(&soup, 1.0)?;
    let start = ThreadTime::now();
    let rounding = FileRounding::of(&soup.points);
    let errors = rounding.errors(&soup, &build, 1.0 / build.mm);
    let mesh = Tessellation::new(&build.mesh, &errors);
    let pairs = FlatPairs::of(&mesh);
    let prepared = start.elapsed().as_secs_f64();
    let regions = find(&mesh, &Options { unit: build.mm, ..Options::default() });
    let seconds = start.elapsed().as_secs_f64();
    let count = |kind: PrimitiveKind| {
        let is = |r: &&FaceRegion| r.origin != RegionOrigin::Facet && r.surface.kind() == kind;
        regions.regions.iter().filter(is).count()
    };
    let facets = regions.regions.iter().filter(|r| r.origin == RegionOrigin::Facet);
    let left: usize = facets.clone().map(|r| r.triangles.len()).sum();
    let mut value = json!({
        "file": file.display().to_string(),
        "triangles": regions.of_triangle.len(),
        "rounding": rounding.name(),
        "diagonal": build.mesh.diagonal() * build.mm,
        "pairs": [pairs.exact, pairs.near],
        "clean": pairs.is_clean(),
        "significant": regions.significant,
        "is_significant": regions.is_significant(),
        "plane": count(PrimitiveKind::Plane),
        "cylinder": count(PrimitiveKind::Cylinder),
        "cone": count(PrimitiveKind::Cone),
        "sphere": count(PrimitiveKind::Sphere),
        "torus": count(PrimitiveKind::Torus),
        "facets": facets.count(),
        "explained": regions.explained,
        "triangles_explained": 1.0 - left as f64 / regions.of_triangle.len() as f64,
        "snaps": regions.snaps.len(),
        "prisms": regions.prisms.iter().map(|p| json!([p.sides, p.radius * build.mm, p.is_round])).collect::<Vec<_>>(),
        "seconds": [prepared, seconds],
        "cylinders": cylinders(&regions, build.mm),
    });
    if faces {
        let area = |&t: &u32| build.mesh.area_vector(build.mesh.triangles[t as usize]).norm() / 2.0;
        let listed = regions.regions.iter().map(|r| {
            let area: f64 = r.triangles.iter().map(area).sum();
            face(r, area * build.mm * build.mm, build.mm)
        });
        value["faces"] = listed.collect();
    }
    if details {
        value["regions"] = regions.regions.iter().map(|r| described(r, build.mm)).collect();
        value["of_triangle"] = json!(regions.of_triangle);
        let scaled = |p: &scan2step::geometry::Point| (p.coords * build.mm).as_slice().to_vec();
        value["points"] = build.mesh.points.iter().map(scaled).collect::<Vec<_>>().into();
        let corners = |t: &[scan2step::geometry::VertexId; 3]| t.map(|v| v.0);
        value["mesh"] = json!(build.mesh.triangles.iter().map(corners).collect::<Vec<_>>());
        value["snapped"] =
            regions.snaps.iter().map(|s| format!("{s:?}")).collect::<Vec<_>>().into();
    }
    Ok(value)
}

fn cylinders(regions: &Regions, mm: f64) -> Value {
    let round = |r: &FaceRegion| match r.surface.scaled(mm) {
        Primitive::Cylinder { origin, axis, radius } if r.origin == RegionOrigin::Curved => {
            Some(json!([
                radius,
                origin.coords.as_slice(),
                axis.as_slice(),
                r.triangles.len(),
                r.side
            ]))
        }
        _ => None,
    };
    regions.regions.iter().filter_map(round).collect()
}

fn face(region: &FaceRegion, area: f64, mm: f64) -> Value {
    let surface = region.surface.scaled(mm);
    let list = |v: &[f64]| json!(v);
    let (origin, axis) = match surface {
        Primitive::Plane { origin, normal } => (origin, Some(normal)),
        Primitive::Cylinder { origin, axis, .. } | Primitive::Cone { origin, axis, .. } => {
            (origin, Some(axis))
        }
        Primitive::Sphere { centre, .. } => (centre, None),
        Primitive::Torus { centre, axis, .. } => (centre, Some(axis)),
    };
    let mut value = json!({
        "kind": surface.kind().name(),
        "origin_of": format!("{:?}", region.origin),
        "area": area,
        "triangles": region.triangles.len(),
        "origin": list(origin.coords.as_slice()),
        "axis": axis.map(|a| list(a.as_slice())),
        "side": region.side,
    });
    match surface {
        Primitive::Plane { .. } => {}
        Primitive::Cylinder { radius, .. } | Primitive::Sphere { radius, .. } => {
            value["radius"] = radius.into();
        }
        Primitive::Cone { axis, radius, angle, .. } => {
            value["radius"] = radius.into();
            value["angle"] = angle.into();
            value["apex"] = list((origin - radius / angle.tan() * axis).coords.as_slice());
        }
        Primitive::Torus { major, minor, .. } => {
            value["radius"] = minor.into();
            value["major"] = major.into();
        }
    }
    value
}

fn described(region: &FaceRegion, mm: f64) -> Value {
    json!({
        "origin": format!("{:?}", region.origin),
        "kind": region.surface.kind().name(),
        "surface": format!("{:?}", region.surface.scaled(mm)),
        "triangles": region.triangles.len(),
        "side": region.side,
    })
}
