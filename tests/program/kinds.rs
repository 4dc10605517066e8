//! `check` on CAD files of other programs: each kind of surface, curve and placement as OpenCASCADE writes it, and the
//! real parts and assemblies beside the project.

use std::path::{Path, PathBuf};

use crate::common::importers::make_kinds;
use crate::common::{shared, unpacked};
use scan2step::check::{Report, check};
use scan2step::geometry::{Point, VertexId};
use scan2step::mesh::Mesh;
use serde_json::Value;

/// Files that say too little, so that they are refused, with the reason.
const REFUSED: [(&str, &str); 7] = [
    // A vertex bounds the surface of revolution of a circle that goes through the axis twice.
    ("lemon.step", "which part between the poles"),
    ("lemon.bare.step", "which part between the poles"),
    // Loops of trimmed surfaces may run either way, and these have no seam that would tell.
    ("ball_drilled.trimmed.igs", "on which side of"),
    ("ball_drilled_nurbs.trimmed.igs", "on which side of"),
    ("mirrored.trimmed.igs", "on which side of"),
    ("torus_drilled.trimmed.igs", "on which side of"),
    ("torus_tilted_cut.trimmed.igs", "on which side of"),
];

/// The largest difference of areas and volumes from those of OpenCASCADE, as a share.
const AREA: f64 = 1e-6;

/// The largest distance of points of a tessellation, and of the corners of bounding boxes, as a share of the
/// diagonal.
const DISTANCE: f64 = 1e-6;

/// A box as a mesh.
fn box_mesh(low: [f64; 3], high: [f64; 3]) -> Mesh {
    let corner = |k: usize| {
        let end = |axis: usize| if k >> axis & 1 == 0 { low[axis] } else { high[axis] };
        Point::new(end(0), end(1), end(2))
    };
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    let triangles = quads.into_iter().flat_map(halves).map(|t| t.map(VertexId)).collect();
    Mesh { points: (0..8).map(corner).collect(), triangles }
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// What is wrong with the figures of a file.
fn faults(found: &Report, truth: &Value, diagonal: f64) -> Vec<String> {
    let mut faults = Vec::new();
    let mut keep = |is: bool, what: String| {
        if !is {
            faults.push(what);
        }
    };
    let areas = numbers(&truth["areas"]);
    let off =
        areas.iter().map(|area| (found.area / area - 1.0).abs()).fold(f64::INFINITY, f64::min);
    keep(off < AREA, format!("area {} instead of {areas:?}", found.area));
    let volume = truth["volume"].as_f64().expect("a volume");
    // Trimmed surfaces of IGES are no solids.
    if let Some(own) = found.volume {
        keep((own / volume - 1.0).abs() < AREA, format!("volume {own} instead of {volume}"));
    }
    let (bounds, expected) = (found.face_bounds.concat(), numbers(&truth["box"]));
    let apart = bounds.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    keep(apart < DISTANCE * diagonal, format!("box {bounds:?} instead of {expected:?}"));
    let farthest = found.scan_to_face.max;
    let most = (DISTANCE * diagonal).max(found.max_off_surface);
    keep(farthest < most, format!("a vertex is {farthest} mm away"));
    faults
}

/// Measures a file against points of its shape.
fn measured(path: &Path, truth: &Value) -> Result<(Report, f64), String> {
    let ends = numbers(&truth["box"]);
    let corner = |k: usize| [ends[k], ends[k + 1], ends[k + 2]];
    let mesh = box_mesh(corner(0), corner(3));
    let points: Vec<Point> = (truth["points"].as_array().expect("points").iter())
        .map(|p| Point::from_slice(&numbers(p)))
        .collect();
    let model = formats::cad::read_cad(path).map_err(|e| e.to_string())?;
    let found = check(&model, &mesh, Some(&points)).map_err(|e| e.to_string())?;
    Ok((found, (Point::from(corner(3)) - Point::from(corner(0))).norm()))
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("a file").path()).collect();
    files.retain(|path| path.extension().is_some_and(|end| end == "step" || end == "igs"));
    files.sort();
    files
}

#[test]
fn every_kind_that_opencascade_writes_is_measured_as_it_measures_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    make_kinds(folder.path());
    let (mut wrong, mut refused, mut good) = (Vec::new(), 0, 0);
    for path in files(folder.path()) {
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        let kind = name.split('.').next().expect("a kind");
        let text = std::fs::read_to_string(folder.path().join(format!("{kind}.json")));
        let truth: Value = serde_json::from_str(&text.expect("a truth")).expect("JSON");
        let why = REFUSED.iter().find(|(file, _)| *file == name).map(|(_, why)| *why);
        match (measured(&path, &truth), why) {
            (Ok((found, diagonal)), None) => {
                good += 1;
                let faults = faults(&found, &truth, diagonal);
                wrong.extend(faults.into_iter().map(|fault| format!("{name}: {fault}")));
            }
            (Err(said), Some(why)) if said.contains(why) => refused += 1,
            (Err(said), _) => wrong.push(format!("{name}: {said}")),
            (Ok(_), Some(_)) => wrong.push(format!("{name} is no longer refused")),
        }
    }
    println!("{good} files measured, {refused} refused");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(good > 170 && refused == REFUSED.len(), "{good} and {refused}");
}

/// The truth has six digits, and the area of a part depends on how its edges are joined where they are off their
/// surfaces: a share of the area, and of the diagonal.
const LOOSE: f64 = 1e-4;

#[test]
fn real_parts_have_the_areas_of_their_truths() {
    let Some(parts) = shared("parts") else { return };
    let index = std::fs::read_to_string(parts.join("INDEX.tsv")).expect("an index");
    let mut lines = index.lines().map(|line| line.split('\t').collect::<Vec<_>>());
    let head = lines.next().expect("a head");
    let column = |name: &str| head.iter().position(|h| *h == name).expect("a column");
    let [name, area, volume, diagonal] = ["name", "area", "volume", "diag"].map(column);
    let (mut count, mut wrong) = (0, Vec::new());
    for line in lines {
        let packed = parts.join(format!("step/{}.step.gz", line[name]));
        let number = |at: usize| line[at].parse::<f64>().expect("a number");
        let reach = number(diagonal) / 3.0_f64.sqrt();
        let mesh = box_mesh([0.0; 3], [reach; 3]);
        let model = formats::cad::read_cad_from(&packed, &unpacked(&packed));
        let model = model.unwrap_or_else(|e| panic!("{e}"));
        match check(&model, &mesh, None) {
            Err(e) => wrong.push(format!("{}: {e}", line[name])),
            Ok(found) => {
                let (own, volumes) = (found.area / number(area), found.volume.unwrap_or(0.0));
                let off = (own - 1.0).abs().max((volumes / number(volume) - 1.0).abs());
                if off > LOOSE && found.max_off_surface < LOOSE * number(diagonal) {
                    wrong.push(format!("{}: {own}, {volumes}", line[name]));
                }
            }
        }
        count += 1;
    }
    // OpenCASCADE's own ways to integrate this part differ by as much.
    wrong.retain(|of| !of.starts_with("so_handle"));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(count >= 45, "{count}");
}
