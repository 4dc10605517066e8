//! Smoothing (Tekumalla & Cohen 2005, section 3.1). A disk goes in; a disk with the same topology
//! and smoothed vertices comes out, with a [`Report`].
//!
//! Every point is projected onto the MLS surface of its neighbourhood. Then every boundary loop is
//! projected onto its MLS curve, with its corners kept, and projected back onto the surface. Last,
//! triangles that these moves have folded are unfolded.

mod clusters;
mod corners;
mod crossvalidation;
mod curve;
mod examined;
mod levels;
mod line;
mod support;
mod surface;
mod uncross;
mod unfold;

use rayon::prelude::*;

use crate::error::{Result, of};
use crate::geometry::{Point, Vector, VertexId, in_lengths, length};
use crate::mesh::{Disk, Mesh, boundary};
use crate::progress::{self, Progress};
use crate::rules;
use crate::statistics::median;
use examined::Examined;
use surface::MlsSurface;

/// The options of smoothing.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The support h of the MLS weights, or the rule that finds it. The default is
    /// [`Support::Auto`].
    pub support: Support,
    /// The corners that boundary smoothing keeps. The default is [`Corners::Auto`].
    pub corners: Corners,
}

impl Options {
    pub(crate) fn check(&self) -> Result<()> {
        if let Support::Fixed(h) = self.support {
            rules::length(h).map_err(of("smooth"))?;
        }
        match &self.corners {
            Corners::At(points) => rules::points(points).map_err(of("boundary_corners")),
            Corners::Auto | Corners::None => Ok(()),
        }
    }
}

/// The support of the MLS weights θ(x) = exp(−x²/h²). A support that is too small leaves noise; one
/// that is too large flattens the shape.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Support {
    /// The support is found on the scan and follows its noise and curvature. Points are not moved
    /// where their residuals cannot be distinguished from shape.
    #[default]
    Auto,
    /// A fixed support h, in mm. [`smooth`] fails if it is so small or so large that most points
    /// have no fit.
    Fixed(f64),
    /// No smoothing.
    Off,
}

/// The corners that the smoothing of a boundary keeps. Other corners are rounded.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Corners {
    /// Corners are found by their turning angle.
    #[default]
    Auto,
    /// No corners: every loop is treated as smooth all around.
    None,
    /// The boundary vertices nearest to these points, which are in mm.
    At(Vec<Point>),
}

/// The results of smoothing. Lengths are in mm.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Report {
    /// The support. If it varies over the scan this is the median; 0 if smoothing is off.
    pub h: f64,
    /// The support at each vertex, or 0 where its residual may be shape, so that it did not move all the
    /// way. Empty if smoothing is off.
    pub supports: Vec<f64>,
    /// The standard deviation of the scan's noise along the normal; that of the rounding of its
    /// numbers if no other noise is visible.
    pub noise: f64,
    /// Whether noise beyond the rounding is visible. If not, points stay where they are.
    pub is_noisy: bool,
    /// The step of which all heights of the scan along one axis are multiples, if there is one. The noise is then at
    /// least that of the steps.
    pub height_step: Option<f64>,
    /// The number of outliers, which are left out of all fits.
    pub outliers: usize,
    /// The root mean square of the distances by which points were moved.
    pub moved_rms: f64,
    /// The largest distance by which a point was moved.
    pub moved_max: f64,
    /// The corners that were kept, over all loops.
    pub corners: Vec<VertexId>,
}

impl Options {
    /// The options with lengths expressed in units of `mm` millimetres.
    pub(crate) fn in_lengths(&self, mm: f64) -> Self {
        let support = match self.support {
            Support::Fixed(h) => Support::Fixed(length(h, mm)),
            other => other,
        };
        let corners = match &self.corners {
            Corners::At(at) => Corners::At(at.iter().map(|&p| in_lengths(p, mm)).collect()),
            other => other.clone(),
        };
        Options { support, corners }
    }
}

impl Report {
    /// The report with all lengths multiplied by a factor.
    pub fn scaled(self, factor: f64) -> Self {
        Report {
            h: factor * self.h,
            supports: self.supports.iter().map(|h| factor * h).collect(),
            noise: factor * self.noise,
            height_step: self.height_step.map(|step| factor * step),
            moved_rms: factor * self.moved_rms,
            moved_max: factor * self.moved_max,
            ..self
        }
    }
}

/// Smooths a disk. The topology does not change.
///
/// # Errors
/// - [`Error::Option`](crate::error::Error::Option) if the support is not a length or a corner is not a finite point.
/// - [`Error::Support`](crate::error::Error::Support) if the support is so small or so large that no surface can be fitted.
pub fn smooth(disk: &Disk, options: &Options) -> Result<(Disk, Report)> {
    smooth_with(disk, options, &mut progress::ignore)
}

/// Like [`smooth`], and reports progress to `progress`.
///
/// # Errors
/// Those of [`smooth`], and any error that `progress` returns.
pub fn smooth_with(
    disk: &Disk,
    options: &Options,
    progress: &mut Progress,
) -> Result<(Disk, Report)> {
    options.check()?;
    let examined = Examined::new(&disk.mesh);
    let mut report = Report {
        noise: examined.noise.deviation,
        is_noisy: examined.noise.is_visible,
        height_step: examined.noise.terraces.map(|terraces| terraces.step),
        outliers: examined.left_out.iter().filter(|out| **out).count(),
        ..Report::default()
    };
    let mut out = disk.clone();
    if options.support == Support::Auto && !examined.noise.is_visible {
        report.h = levels::shortest(&disk.mesh);
        report.supports = vec![0.0; disk.mesh.points.len()];
        let corners =
            disk.loops().map(|ring| (ring, kept_corners(disk, &out.mesh, ring, options, report.h)));
        report.corners =
            corners.flat_map(|(ring, kept)| kept.into_iter().map(|i| ring[i])).collect();
        return Ok((out, report));
    }
    let mut surface = match options.support {
        Support::Auto => examined.surface(&disk.mesh, &mut progress::step(progress, 0, 2))?,
        Support::Fixed(h) => examined.surface_of(&disk.mesh, h)?,
        Support::Off => return Ok((out, report)),
    };
    let onto = &mut progress::step(progress, 1, 2);
    let (mut projected, normals) = surface.feet(&disk.mesh, onto)?;
    if options.support == Support::Auto {
        surface.stays = examined.shape(&disk.mesh, &surface, (&projected, &normals));
        keep(&surface.stays, &disk.mesh.points, &mut projected);
    }
    report.h = median(&mut surface.supports().collect::<Vec<f64>>()).unwrap_or(0.0);
    report.supports = surface.smoothed_supports().collect();
    out.mesh.points.clone_from(&projected);
    let noise: Vec<f64> = (0..disk.mesh.points.len())
        .map(|v| if surface.stays[v] { 0.0 } else { examined.noise.at(VertexId::from(v)) })
        .collect();
    let rings: Vec<&boundary::Loop> = disk.loops().collect();
    // The loops share no vertices.
    let smoothed = rings.par_iter().map(|ring| {
        let kept = kept_corners(disk, &out.mesh, ring, options, report.h);
        let feet = smoothed_loop(ring, &kept, &projected, &normals, &noise, &surface);
        (kept, feet)
    });
    let smoothed: Vec<(Vec<usize>, Vec<Point>)> = smoothed.collect();
    for (ring, (kept, feet)) in rings.into_iter().zip(smoothed) {
        report.corners.extend(kept.into_iter().map(|i| ring[i]));
        ring.iter().zip(feet).for_each(|(v, foot)| out.mesh.points[v.index()] = foot);
    }
    let named = matches!(options.corners, Corners::At(_));
    let upright = unfold::UnfoldReference { projected, normals, corners: &report.corners, named };
    unfold::unfold(&mut out, &surface, upright);
    let pairs = out.mesh.points.par_iter().zip(&disk.mesh.points);
    let moved: Vec<f64> = pairs.map(|(p, q)| (p - q).norm()).collect();
    report.moved_max = moved.iter().copied().fold(0.0, f64::max);
    report.moved_rms = root_mean_square(moved.into_iter());
    Ok((out, report))
}

/// The positions in a loop of the corners that are kept, where `mesh` has the points of the loop on
/// the surface with support `h`.
fn kept_corners(
    disk: &Disk,
    mesh: &Mesh,
    ring: &boundary::Loop,
    options: &Options,
    h: f64,
) -> Vec<usize> {
    match &options.corners {
        Corners::Auto => corners::find(mesh, ring, 2.0 * h),
        Corners::None => Vec::new(),
        Corners::At(points) => nearest_positions(disk, ring, points),
    }
}

/// The points of a loop on a surface, smoothed along the loop.
fn smoothed_loop(
    ring: &boundary::Loop,
    corners: &[usize],
    points: &[Point],
    normals: &[Vector],
    noise: &[f64],
    surface: &MlsSurface,
) -> Vec<Point> {
    let line: Vec<Point> = ring.iter().map(|&v| points[v.index()]).collect();
    let normals: Vec<Vector> = ring.iter().map(|&v| normals[v.index()]).collect();
    let noise: Vec<f64> = ring.iter().map(|&v| noise[v.index()]).collect();
    let rim = curve::RimPoints { points: &line, normals: &normals, noise: &noise };
    let mut smooth = curve::smooth_loop(&rim, corners);
    uncross::uncross(&mut smooth, &line, &normals);
    // The projection onto the curve may have left the surface.
    let foot = |(&v, &p): (&VertexId, &Point)| surface.project(v, p).map_or(p, |foot| foot.point);
    ring.par_iter().zip(&smooth).map(foot).collect()
}

/// The number of vertices on each side of a corner or a crossing of a loop that are treated with it.
const BESIDE: usize = 4;

/// Puts the vertices that stay back to where they were measured.
fn keep(stays: &[bool], measured: &[Point], points: &mut [Point]) {
    for (v, p) in points.iter_mut().enumerate().filter(|(v, _)| stays[*v]) {
        *p = measured[v];
    }
}

fn root_mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len().max(1) as f64;
    (values.map(|x| x * x).sum::<f64>() / n).sqrt()
}

/// The positions in `ring` of the corners that the user gave. Each corner belongs to the loop that
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
