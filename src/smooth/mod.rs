//! Smoothing (Tekumalla & Cohen 2005, section 3.1): every point is projected
//! onto the MLS surface of its neighbourhood; then every boundary loop is
//! projected onto its MLS curve, corners kept, and laid back on the surface;
//! last, triangles that the moves have folded are turned back.

mod corners;
mod curve;
mod support;
mod surface;
mod uncross;
mod unfold;

use crate::geometry::{Point, Vector, VertexId};
use crate::mesh::mls::{Cloud, Scratch};
use crate::mesh::{Disk, Mesh, boundary};

/// How to smooth.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The support h of the weights, or how to find it.
    pub support: Support,
    /// Where the boundary keeps a corner.
    pub corners: Corners,
}

/// The support of the MLS weights θ(x) = exp(−x²/h²).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Support {
    /// Found by leave-one-out cross-validation on the scan.
    #[default]
    Auto,
    /// h in mm.
    Fixed(f64),
    /// No smoothing at all.
    Off,
}

/// The corners that the smoothing of a boundary keeps.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Corners {
    /// Found by their turning angle.
    #[default]
    Auto,
    /// None: every loop is smooth all around.
    None,
    /// The boundary vertices nearest to these points.
    At(Vec<Point>),
}

/// What smoothing did. Lengths are mm.
#[derive(Debug, Clone, Default)]
pub struct Report {
    /// The support; 0 with smoothing off.
    pub h: f64,
    /// Standard deviation of the scan's noise along the normal.
    pub noise: f64,
    /// Root mean square of how far the points were moved.
    pub moved_rms: f64,
    /// How far the farthest was moved.
    pub moved_max: f64,
    /// Corners kept, over all loops.
    pub corners: Vec<VertexId>,
}

/// The noise of a scan: the standard deviation of its points along the normal.
pub fn noise(mesh: &Mesh) -> f64 {
    support::choose(mesh, &Cloud::of(mesh), Support::Off).noise
}

/// Smooths a disk. Its topology stays as it is.
pub fn smooth(disk: &Disk, options: &Options) -> (Disk, Report) {
    let cloud = Cloud::of(&disk.mesh);
    let tried = support::choose(&disk.mesh, &cloud, options.support);
    let mut report = Report { noise: tried.noise, ..Report::default() };
    let mut out = disk.clone();
    if options.support == Support::Off {
        return (out, report);
    }
    report.h = tried.h;
    out.mesh.points = surface::project_all(&disk.mesh, &cloud, tried.h);
    let projected = out.mesh.points.clone();
    for ring in disk.loops() {
        let kept = match &options.corners {
            Corners::Auto => corners::find(&out.mesh, ring, 2.0 * tried.h),
            Corners::None => Vec::new(),
            Corners::At(points) => nearest_positions(disk, ring, points),
        };
        report.corners.extend(kept.iter().map(|&i| ring[i]));
        let line: Vec<Point> = ring.iter().map(|&v| out.mesh.point(v)).collect();
        let mut smooth = curve::smooth_loop(&line, &kept, tried.h);
        let normals: Vec<Vector> = ring.iter().map(|v| cloud.normal(v.index())).collect();
        uncross::uncross(&mut smooth, &line, &normals);
        lay_back(&cloud, ring, &smooth, tried.h, &mut out.mesh.points);
    }
    unfold::unfold(&mut out, &cloud, &projected, tried.h);
    let moves = out.mesh.points.iter().zip(&disk.mesh.points).map(|(p, q)| (p - q).norm());
    report.moved_max = moves.clone().fold(0.0, f64::max);
    let squares: f64 = moves.map(|m| m * m).sum();
    report.moved_rms = (squares / disk.mesh.points.len() as f64).sqrt();
    (out, report)
}

/// Puts the smoothed loop back onto the MLS surface, off which the curve's
/// projection may have moved it.
fn lay_back(cloud: &Cloud, ring: &[VertexId], smooth: &[Point], h: f64, points: &mut [Point]) {
    let mut scratch = Scratch::default();
    for (v, &p) in ring.iter().zip(smooth) {
        let foot = cloud.project(p, cloud.normal(v.index()), h, &mut scratch);
        points[v.index()] = foot.map_or(p, |f| f.point);
    }
}

/// The positions in `ring` of the user's corners: each goes to the loop that
/// has the vertex nearest to it.
fn nearest_positions(disk: &Disk, ring: &[VertexId], corners: &[Point]) -> Vec<usize> {
    let nearest_in = |ring: &[VertexId], p: &Point| {
        let distance = |v: &VertexId| (disk.mesh.point(*v) - p).norm_squared();
        (0..ring.len()).min_by(|&i, &j| distance(&ring[i]).total_cmp(&distance(&ring[j])))
    };
    let mut kept = Vec::new();
    for p in corners {
        let distance = |r: &boundary::Loop, i: usize| (disk.mesh.point(r[i]) - p).norm_squared();
        let on_each = disk.loops().filter_map(|r| nearest_in(r, p).map(|i| (r, i)));
        let best = on_each.min_by(|x, y| distance(x.0, x.1).total_cmp(&distance(y.0, y.1)));
        kept.extend(best.filter(|(r, _)| r.as_slice() == ring).map(|(_, i)| i));
    }
    kept.sort_unstable();
    kept.dedup();
    kept
}
