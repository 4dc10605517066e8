//! Smoothing does not change clean meshes, however coarse, and still finds the noise of noisy ones.

#[path = "../common/tessellations.rs"]
mod tessellations;

use formats::Soup;
use scan2step::mesh::{self, Choice, Components, Disk, Outer, Repairs};
use scan2step::stages::smooth::{self, Options};
use tessellations::{KINDS, Kind, Random, SURFACES, Tessellation};

fn disk(points: Vec<[f64; 3]>, triangles: &[[u32; 3]]) -> Disk {
    let mut soup = Soup { points, ..Soup::default() };
    triangles.iter().for_each(|t| soup.polygons.push(*t));
    let scan = Components::new(mesh::from_soup(&soup, 1.0).expect("a sound mesh"));
    let largest = scan.take(Choice::Largest).expect("there is one");
    largest.into_disk(Outer::Auto, &mut Repairs::new()).expect("a disk")
}

/// Kinds of tessellations of a surface. The halving of edges does not end on the wavy sheet,
/// because the speed along its isolines is not constant.
fn kinds_of(name: &str) -> impl Iterator<Item = Kind> {
    let is_wavy = name == "wavy sheet";
    KINDS.into_iter().filter(move |kind| *kind != Kind::Adaptive || !is_wavy)
}

/// The largest number of vertices of a mesh, to limit the time.
const MOST: usize = 8_000;

/// Chord errors as shares of the scan's diagonal.
const CHORDS: [f64; 2] = [0.01, 0.001];

#[test]
fn smooth_surfaces_are_left_alone_however_they_are_tessellated() {
    let mut random = Random(1);
    let (mut worst, mut farthest, mut looked_at) = (Vec::new(), 0.0_f64, 0);
    for (name, truth) in SURFACES {
        let size = disk(
            Tessellation::grid(truth, [20, 20]).points(0.0, &mut random),
            &Tessellation::grid(truth, [20, 20]).triangles,
        )
        .mesh
        .diagonal();
        for kind in kinds_of(name) {
            for share in CHORDS {
                let chord = share * size;
                let mesh = Tessellation::new(truth, kind, chord, &mut random);
                // Cells that are twenty times as long as wide are very many on the finest mesh.
                if mesh.uv.len() > MOST {
                    continue;
                }
                looked_at += 1;
                let raw = disk(mesh.points(0.0, &mut random), &mesh.triangles);
                let (_, report) = smooth::smooth(&raw, &Options::default()).unwrap();
                let (moved, noise) = (report.moved_max / chord, report.noise / chord);
                println!(
                    "{name} {kind:?} {share}: {} vertices, moved {moved:.1e}, noise {noise:.1e} chords, {} outliers",
                    raw.mesh.points.len(),
                    report.outliers
                );
                farthest = moved.max(farthest);
                if moved > 0.05 || noise > 0.02 {
                    worst.push(format!("{name} {kind:?} {share}: moved {moved}, noise {noise}"));
                }
            }
        }
    }
    assert!(worst.is_empty(), "{worst:#?}");
    assert!(farthest < 0.05 && looked_at > 40, "{looked_at}: {farthest} chord errors");
}

#[test]
fn noise_is_found_on_every_kind_of_tessellation() {
    let mut random = Random(2);
    let (mut worst, mut looked_at) = (Vec::new(), 0);
    for (name, truth) in SURFACES {
        for kind in kinds_of(name) {
            // The mesh is fine enough for the shape to be small beside the noise.
            let mesh = Tessellation::new(truth, kind, 0.01, &mut random);
            // A few hundred vertices are not enough to find the noise. Very many need a long time
            // without more information.
            let is_enough = (1000..MOST).contains(&mesh.uv.len());
            for share in [1.0 / 3.0, 0.05].into_iter().filter(|_| is_enough) {
                let noise = share * mesh.edge();
                let raw = disk(mesh.points(noise, &mut random), &mesh.triangles);
                let (_, report) = smooth::smooth(&raw, &Options::default()).unwrap();
                let found = report.noise / noise;
                looked_at += 1;
                println!(
                    "{name} {kind:?} noise {share:.2} of {:.2} mm: {} vertices, found {found:.3}, moved {:.2} rms",
                    mesh.edge(),
                    raw.mesh.points.len(),
                    report.moved_rms / noise
                );
                if (found - 1.0).abs() > 0.15 {
                    worst.push(format!("{name} {kind:?} {share}: found {found}"));
                }
            }
        }
    }
    assert!(worst.is_empty() && looked_at > 20, "{looked_at}: {worst:#?}");
}
