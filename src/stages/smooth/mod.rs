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
use crate::mesh::{Disk, boundary};
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
    pub(crate) fn scaled(self, factor: f64) -> Self {
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
    let examined = examine(disk, options, &mut progress::step(progress, 0, 2))?;
    examined.smoothed(&mut progress::step(progress, 1, 2))
}

/// Measures the noise of a disk and finds the surface that its vertices sample. No vertex moves yet, so that only
/// some of them need to be smoothed ([`Examination::smoothed_part`]).
///
/// # Errors
/// Those of [`smooth`], and any error that `progress` returns.
pub fn examine<'a>(
    disk: &'a Disk,
    options: &'a Options,
    progress: &mut Progress,
) -> Result<Examination<'a>> {
    options.check()?;
    let examined = Examined::new(&disk.mesh);
    let mut report = Report {
        noise: examined.noise.deviation,
        is_noisy: examined.noise.is_visible,
        height_step: examined.noise.terraces.map(|terraces| terraces.step),
        outliers: examined.left_out.iter().filter(|out| **out).count(),
        ..Report::default()
    };
    let surface = match options.support {
        Support::Auto if !examined.noise.is_visible => {
            report.h = levels::shortest(&disk.mesh);
            report.supports = vec![0.0; disk.mesh.points.len()];
            None
        }
        Support::Auto => Some(examined.surface(&disk.mesh, progress)?),
        Support::Fixed(h) => Some(examined.surface_of(&disk.mesh, h)?),
        Support::Off => None,
    };
    if let Some(surface) = &surface {
        report.h = median(&mut surface.supports().collect::<Vec<f64>>()).unwrap_or(0.0);
    }
    Ok(Examination { disk, options, report, examined, surface })
}

/// A disk whose noise is known, and the surface that its vertices sample.
pub struct Examination<'a> {
    disk: &'a Disk,
    options: &'a Options,
    report: Report,
    examined: Examined,
    /// `None` if no vertex moves.
    surface: Option<MlsSurface>,
}

/// Where the vertices of a disk will be about, and how much of what is between them smoothing leaves.
#[derive(Debug)]
#[non_exhaustive]
pub struct Outlook {
    /// A place near the smoothed place of each vertex.
    pub places: Vec<Point>,
    /// The support at each vertex, or 0 where its residual may be shape.
    pub supports: Vec<f64>,
}

impl Examination<'_> {
    /// The standard deviation of the noise, as [`Report::noise`] has it.
    pub fn noise(&self) -> f64 {
        self.report.noise
    }

    /// Whether noise is visible, as [`Report::is_noisy`] says.
    pub fn is_noisy(&self) -> bool {
        self.report.is_noisy
    }

    /// Where the vertices will be about. `None` if they do not move.
    pub fn outlook(&self) -> Option<Outlook> {
        let (surface, mesh) = (self.surface.as_ref()?, &self.disk.mesh);
        let (mut places, offsets) = surface.places_nearby(mesh);
        let mut supports: Vec<f64> = surface.supports().collect();
        if self.options.support == Support::Auto {
            let stays = self.examined.shape(mesh, surface, &offsets);
            keep(&stays, &mesh.points, &mut places);
            let unmoved = supports.iter_mut().zip(stays).filter(|(_, stays)| *stays);
            unmoved.for_each(|(h, _)| *h = 0.0);
        }
        Some(Outlook { places, supports })
    }

    /// Smooths the disk. The topology does not change.
    ///
    /// # Errors
    /// Any error that `progress` returns.
    pub fn smoothed(self, progress: &mut Progress) -> Result<(Disk, Report)> {
        let Examination { disk, options, mut report, examined, surface } = self;
        let Some(mut surface) = surface else {
            if options.support == Support::Auto {
                report.corners = all_corners(disk, options, report.h);
            }
            return Ok((disk.clone(), report));
        };
        let (mut projected, normals) = surface.feet(&disk.mesh, progress)?;
        if options.support == Support::Auto {
            let offset = |v: usize| (projected[v] - disk.mesh.points[v]).dot(&normals[v]);
            let offsets: Vec<f64> = (0..projected.len()).into_par_iter().map(offset).collect();
            surface.stays = examined.shape(&disk.mesh, &surface, &offsets);
            keep(&surface.stays, &disk.mesh.points, &mut projected);
        }
        report.supports = surface.smoothed_supports().collect();
        let noise = |v: usize| examined.noise.at(VertexId::from(v));
        let noise: Vec<f64> = (0..disk.mesh.points.len()).map(noise).collect();
        Ok(placed(disk.clone(), options, report, (&surface, &noise), (projected, normals)))
    }

    /// Smooths a disk of some of the vertices: `left` has their numbers, in the order of the `part`. All vertices
    /// count for the surface. `outlook` is that of all vertices.
    ///
    /// # Errors
    /// Any error that `progress` returns.
    pub fn smoothed_part(
        self,
        part: Disk,
        left: &[u32],
        outlook: Outlook,
        progress: &mut Progress,
    ) -> Result<(Disk, Report)> {
        let Examination { options, mut report, examined, surface, .. } = self;
        let Some(mut surface) = surface else { return Ok((part, report)) };
        surface.stays = outlook.supports.iter().map(|h| *h == 0.0).collect();
        drop(outlook);
        let noise = left.iter().map(|&v| examined.noise.at(VertexId(v)));
        let noise: Vec<f64> = noise.collect();
        drop(examined);
        let surface = surface.of_vertices(left);
        let (mut projected, normals) = surface.feet(&part.mesh, progress)?;
        keep(&surface.stays, &part.mesh.points, &mut projected);
        report.supports = surface.smoothed_supports().collect();
        Ok(placed(part, options, report, (&surface, &noise), (projected, normals)))
    }

    /// The means of the points that each vertex of a part stands for, as they were measured: for each of the `count`
    /// vertices its place in the outlook, and the mean offset of these points from theirs. Errors are independent, and
    /// smaller than those of single points. Outliers do not count.
    pub fn means(&self, outlook: &Outlook, left: &[u32], vertex_of: &[u32]) -> Vec<Point> {
        let points = &self.disk.mesh.points;
        let mut sums = vec![(Vector::zeros(), 0.0); left.len()];
        for (v, &of) in vertex_of.iter().enumerate().filter(|(v, _)| !self.examined.left_out[*v]) {
            let sum = &mut sums[of as usize];
            sum.0 += points[v] - outlook.places[v];
            sum.1 += 1.0;
        }
        let mean = |(&v, (sum, count)): (&u32, (Vector, f64))| match count > 0.0 {
            true => outlook.places[v as usize] + sum / count,
            false => points[v as usize],
        };
        left.iter().zip(sums).map(mean).collect()
    }
}

/// The corners of all loops of a disk that does not move.
fn all_corners(disk: &Disk, options: &Options, h: f64) -> Vec<VertexId> {
    let of_ring = |ring: &boundary::Loop| {
        let kept = kept_corners((disk, &disk.mesh.points), ring, options, h);
        kept.into_iter().map(|i| ring[i]).collect::<Vec<_>>()
    };
    disk.loops().flat_map(of_ring).collect()
}

/// Puts the vertices of a disk at their projected places, with smoothed loops. `noise` has the standard deviation at
/// each vertex.
fn placed(
    disk: Disk,
    options: &Options,
    mut report: Report,
    (surface, noise): (&MlsSurface, &[f64]),
    (projected, normals): (Vec<Point>, Vec<Vector>),
) -> (Disk, Report) {
    let mut out = disk;
    let measured = std::mem::replace(&mut out.mesh.points, projected.clone());
    let noise: Vec<f64> =
        noise.iter().zip(&surface.stays).map(|(&n, stays)| if *stays { 0.0 } else { n }).collect();
    let rings: Vec<&boundary::Loop> = out.loops().collect();
    // The loops share no vertices.
    let smoothed = rings.par_iter().map(|ring| {
        let kept = kept_corners((&out, &measured), ring, options, report.h);
        let feet = smoothed_loop(ring, &kept, &projected, &normals, &noise, surface);
        let feet: Vec<(VertexId, Point)> = ring.iter().copied().zip(feet).collect();
        let kept: Vec<VertexId> = kept.into_iter().map(|i| ring[i]).collect();
        (kept, feet)
    });
    let smoothed: Vec<_> = smoothed.collect();
    for (kept, feet) in smoothed {
        report.corners.extend(kept);
        feet.into_iter().for_each(|(v, foot)| out.mesh.points[v.index()] = foot);
    }
    let named = matches!(options.corners, Corners::At(_));
    let upright = unfold::UnfoldReference { projected, normals, corners: &report.corners, named };
    unfold::unfold(&mut out, surface, upright);
    let pairs = out.mesh.points.par_iter().zip(&measured);
    let moved: Vec<f64> = pairs.map(|(p, q)| (p - q).norm()).collect();
    report.moved_max = moved.iter().copied().fold(0.0, f64::max);
    report.moved_rms = root_mean_square(moved.into_iter());
    (out, report)
}

/// The positions in a loop of the corners that are kept. `disk` has its points on the surface with support `h`, and
/// `measured` where they were measured.
fn kept_corners(
    (disk, measured): (&Disk, &[Point]),
    ring: &boundary::Loop,
    options: &Options,
    h: f64,
) -> Vec<usize> {
    match &options.corners {
        Corners::Auto => corners::find(&disk.mesh, ring, 2.0 * h),
        Corners::None => Vec::new(),
        Corners::At(points) => nearest_positions((disk, measured), ring, points),
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
fn nearest_positions(
    (disk, measured): (&Disk, &[Point]),
    ring: &[VertexId],
    corners: &[Point],
) -> Vec<usize> {
    let nearest_in = |ring: &[VertexId], p: &Point| {
        let distance = |v: &VertexId| (measured[v.index()] - p).norm_squared();
        (0..ring.len()).min_by(|&i, &j| distance(&ring[i]).total_cmp(&distance(&ring[j])))
    };
    let mut kept = Vec::new();
    for p in corners {
        let distance = |r: &boundary::Loop, i: usize| (measured[r[i].index()] - p).norm_squared();
        let on_each = disk.loops().filter_map(|r| nearest_in(r, p).map(|i| (r, i)));
        let best = on_each.min_by(|x, y| distance(x.0, x.1).total_cmp(&distance(y.0, y.1)));
        kept.extend(best.filter(|(r, _)| r.as_slice() == ring).map(|(_, i)| i));
    }
    kept.sort_unstable();
    kept.dedup();
    kept
}
