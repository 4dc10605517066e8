//! The distances of the output of each stage from the true surface.

use std::error::Error;

use formats::Soup;
use scan2step::deviation::TrimmedFace;
use scan2step::geometry::{Point, Uv};
use scan2step::mesh::{Bound, Disk, Patch};
use scan2step::{Body, Options, Stage};

use crate::body::{OneFace, face_seen};

use crate::virtual_scan::VirtualScan;

/// The number of samples of the face along a side of its domain.
const SIDE: usize = 200;

/// The largest number of points of a mesh that are measured.
const MOST: usize = 50_000;

/// A row of a Markdown table: the scan, its number of points, the noise found; the root mean square
/// distances in mm to the true surface of the measured points, of the smoothed points, of the
/// points of fills, and of the trimmed face; the largest distance of the face; the tolerance and
/// the control net.
pub fn row(name: &str, scan: &VirtualScan, is_cloud: bool) -> Result<String, Box<dyn Error>> {
    let mut soup = Soup::default();
    soup.points.clone_from(&scan.points);
    scan.triangles.iter().for_each(|&t| soup.polygons.push(t));
    let (mut smoothed, mut filled) = (Vec::new(), Vec::new());
    let options = Options::builder().remesh(is_cloud).build()?;
    let conversion = face_seen(&soup, &options, &mut |stage| {
        match stage {
            Stage::Smooth(Disk { mesh, .. }) => smoothed.clone_from(&mesh.points),
            Stage::Fill(patch) => {
                let Patch { mesh, measured, .. } = patch;
                filled = mesh.points[*measured..].to_vec();
            }
            _ => {}
        }
        Ok(())
    })?;
    let distances = |points: &[Point]| {
        let step = points.len().div_ceil(MOST).max(1);
        scan.distances(points.iter().step_by(step).map(|&p| p.into()))
    };
    let measured: Vec<Point> = scan.points.iter().map(|&p| Point::from(p)).collect();
    let face = distances(&on_face(&conversion));
    let [m, n] = conversion.one().surface.shape();
    Ok(format!(
        "| {name} | {} | {:.4} | {:.4} | {:.4} | {:.4} | {:.4} | {:.4} | {:.4} | {m} × {n} |",
        scan.points.len(),
        conversion.noise,
        rms(&distances(&measured)),
        rms(&distances(&smoothed)),
        rms(&distances(&filled)),
        rms(&face),
        face.iter().copied().fold(0.0, f64::max),
        conversion.tolerance,
    ))
}

/// Points that are spread evenly over the domain of the trimmed face.
fn on_face(conversion: &Body) -> Vec<Point> {
    let surface = &conversion.one().surface;
    let natural = conversion.one().loops.iter().all(|l| l.of != Bound::Outer);
    let loops = conversion.one().loops.iter().map(|l| l.pcurves.as_slice());
    let face = TrimmedFace::new(surface, loops, natural);
    let ((u0, u1), (v0, v1)) = (surface.u.range(), surface.v.range());
    let along =
        |(from, to): (f64, f64), i: usize| from + (to - from) * (i as f64 + 0.5) / SIDE as f64;
    let places =
        (0..SIDE * SIDE).map(|i| Uv::new(along((u0, u1), i / SIDE), along((v0, v1), i % SIDE)));
    places.filter(|&at| face.contains(at)).map(|at| surface.point(at)).collect()
}

fn rms(distances: &[f64]) -> f64 {
    let squares: f64 = distances.iter().map(|d| d * d).sum();
    (squares / distances.len().max(1) as f64).sqrt()
}
