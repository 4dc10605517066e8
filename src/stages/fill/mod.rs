//! Hole filling by an advancing front (Tekumalla & Cohen 2005, section 3.2).
//!
//! A [`Disk`] with holes goes in, and a [`Patch`] without holes comes out. Each hole is
//! triangulated by a front that advances from its rim (`front`), or else by the
//! triangulation of least area (`least_area`). The new vertices are then placed on a smoothing
//! spline through the measured points around the hole (`shape`, `smoothing_spline`). Several
//! strategies are tried in turn until a fill has no fault (`strategies`, `faults`).
//!
//! Each hole is filled by itself from the measured points around it, so the order of the holes
//! does not matter, unless two fills intersect (`intersections`).

mod band;
mod box_grid;
mod charted;
mod faults;
mod front;
mod intersections;
mod least_area;
mod numbering;
mod rigid_layout;
mod rim_outlines;
mod roll;
mod shape;
mod smoothing_spline;
mod strategies;

use band::MeasuredPoints;
pub use faults::Faults;
use rayon::prelude::*;
use strategies::ClosedHole;

use crate::error::{Error, Result, of};
use crate::geometry::{FEW, Point, VertexId};
use crate::mesh::{Disk, FaceOrigin, Mesh, Patch, boundary};
use crate::progress::{self, Progress};
use crate::rules;

/// Options of the filling.
#[derive(Debug, Clone)]
pub struct Options {
    /// The angle of the hole, in radians, below which a corner of the front is closed by one
    /// triangle: φ in the paper, by default 5π/9. Smaller angles give more and narrower
    /// triangles. Larger ones give fewer and wider triangles, which follow the surface less
    /// well.
    pub ear_angle: f64,
    /// The support radius h of the smoothing, in mm; by default 0, for a mesh that was not
    /// smoothed. The MLS approximations of the front have at least this support, but no more
    /// than four edge lengths. With too small a value the front follows the noise; with a
    /// larger one it needs more time and follows small features less.
    pub support: f64,
    /// The standard deviation of the noise of the measured points, in mm; by default 0. Measured
    /// points that smoothing has moved farther than noise may be count as outliers, and
    /// their smoothed positions are used. With too small a value all are used smoothed, and a
    /// fill takes some noise for shape; with too large a value outliers bend it.
    pub noise: f64,
}

impl Default for Options {
    fn default() -> Self {
        Options { ear_angle: 100f64.to_radians(), support: 0.0, noise: 0.0 }
    }
}

impl Options {
    pub(crate) fn check(&self) -> Result<()> {
        rules::angle(self.ear_angle).map_err(of("ear_angle"))?;
        rules::extent(self.support).map_err(of("support"))?;
        rules::extent(self.noise).map_err(of("noise"))
    }
}

/// How a hole was triangulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Strategy {
    /// The advancing front.
    Front,
    /// The advancing front, which also had to close corners wider than φ.
    WideEars,
    /// An advancing front that was guided by the smoothing spline through the points around the
    /// hole.
    GuidedFront,
    /// The triangulation of least area.
    LeastArea,
}

/// A filled hole.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Hole {
    /// The number of vertices of its rim.
    pub rim_vertices: usize,
    /// The length of its rim, in mm.
    pub rim_length: f64,
    /// The number of islands in it.
    pub islands: usize,
    /// The number of vertices that were added.
    pub added_vertices: usize,
    /// The number of triangles that were added.
    pub added_triangles: usize,
    /// How it was triangulated.
    pub strategy: Strategy,
    /// The faults that remain.
    pub faults: Faults,
}

/// The filled holes.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Report {
    /// The holes, in the order of the holes of the disk.
    pub holes: Vec<Hole>,
}

impl Report {
    /// The report with all lengths multiplied by `factor`.
    pub(crate) fn scaled(mut self, factor: f64) -> Self {
        self.holes.iter_mut().for_each(|hole| hole.rim_length *= factor);
        self
    }
}

/// The width of a grid cell in mean edge lengths. It changes the time only: smaller cells hold an edge
/// several times, larger ones give more edges to look at.
const CELL: f64 = 3.0;

/// Fills all holes of a disk. `measured` are the points of its mesh before smoothing.
///
/// # Errors
/// [`Error::Fill`]: a hole cannot be filled. [`Error::Option`]: an option is out of range.
/// [`Error::Input`]: the number of measured points is not that of the points of the disk.
pub fn fill(disk: Disk, measured: &[Point], options: &Options) -> Result<(Patch, Report)> {
    fill_with(disk, measured, options, &mut progress::ignore)
}

/// The same as [`fill`], with reports of progress.
///
/// # Errors
/// Those of [`fill`], and the errors of `progress`.
pub fn fill_with(
    disk: Disk,
    measured: &[Point],
    options: &Options,
    progress: &mut Progress,
) -> Result<(Patch, Report)> {
    options.check()?;
    if measured.len() != disk.mesh.points.len() {
        return Err(Error::Input("there are not as many measured points as the disk has"));
    }
    let islands = |hole: usize| disk.islands.iter().filter(move |island| island.hole == hole);
    let fill = |around: &front::Surroundings, measured: &[Point], hole: usize| {
        let rims: Vec<&[VertexId]> = std::iter::once(disk.holes[hole].as_slice())
            .chain(islands(hole).map(|island| island.rim.as_slice()))
            .collect();
        let measured = MeasuredPoints { points: measured, noise: options.noise };
        strategies::close(around, &measured, &rims, options)
            .ok_or_else(|| Error::Fill { hole, at: disk.mesh.point(rims[0][0]) })
    };
    let fills = front::Surroundings::with(&disk.mesh, |around| {
        let count = disk.holes.len();
        let mut fills: Vec<ClosedHole> = Vec::with_capacity(count);
        loop {
            let filled = fills.len() as f64 / count.max(1) as f64;
            // Measuring what is around the holes takes about half of the time.
            progress::step(progress, 1, 2)(filled)?;
            let some = fills.len()..count.min(fills.len() + FEW);
            let closed: Result<Vec<_>> =
                some.into_par_iter().map(|hole| fill(around, measured, hole)).collect();
            fills.extend(closed?);
            if fills.len() == count {
                break;
            }
        }
        intersections::separate(around, measured, &mut fills, |mesh, measured, holes| {
            front::Surroundings::with(mesh, |around| {
                holes.par_iter().map(|&hole| fill(around, measured, hole)).collect()
            })
        });
        Ok::<_, Error>(fills)
    })?;
    let Disk { mesh, outer, holes: rims, islands, .. } = disk;
    let mut whole = PatchBuilder::new(mesh);
    let mut report = Report::default();
    for (number, (closed, rim)) in fills.into_iter().zip(&rims).enumerate() {
        let fill = closed.fill;
        report.holes.push(Hole {
            rim_vertices: rim.len(),
            rim_length: boundary::length(&whole.mesh, rim),
            islands: islands.iter().filter(|island| island.hole == number).count(),
            added_vertices: fill.points.len(),
            added_triangles: fill.triangles.len(),
            strategy: closed.strategy,
            faults: closed.faults,
        });
        whole.add(fill.points, &fill.triangles, FaceOrigin::Hole(number as u32));
    }
    let PatchBuilder { mesh, measured, origin } = whole;
    let patch = Patch {
        mesh,
        measured,
        origin,
        outer,
        measured_outer: None,
        rims,
        islands,
        stand_ins: None,
        point_counts: None,
    };
    debug_assert!(patch.outer.is_empty() || patch.is_disk(), "filling leaves a disk");
    Ok((patch, report))
}

/// Fills all holes of the body of a shell. The fills are cut out later, and only serve to make the
/// surface end smoothly beyond the rims. So a rim like the outer boundary of a sheet is rolled to the
/// back of the sheet before it is filled.
///
/// # Errors
/// Those of [`fill_with`].
pub fn fill_of_shell(
    disk: Disk,
    measured: &[Point],
    options: &Options,
    progress: &mut Progress,
) -> Result<(Patch, Report)> {
    let count = disk.mesh.points.len();
    if measured.len() != count {
        return Err(Error::Input("there are not as many measured points as the disk has"));
    }
    let own = disk.mesh.triangles.len();
    let rims = disk.holes.clone();
    let roll::Rolled { disk, triangles } = roll::rolled(disk);
    let measured: Vec<Point> = measured.iter().chain(&disk.mesh.points[count..]).copied().collect();
    let (mut patch, mut report) = fill_with(disk, &measured, options, progress)?;
    let mut next = own;
    for (number, rolled) in triangles.into_iter().enumerate() {
        patch.origin[next..next + rolled].fill(FaceOrigin::Hole(number as u32));
        next += rolled;
        report.holes[number].added_triangles += rolled;
        report.holes[number].rim_length = boundary::length(&patch.mesh, &rims[number]);
    }
    patch.measured = count;
    patch.rims = rims;
    Ok((patch, report))
}

/// The measured mesh with the fills that have been added.
struct PatchBuilder {
    mesh: Mesh,
    measured: usize,
    origin: Vec<FaceOrigin>,
}

impl PatchBuilder {
    fn new(mesh: Mesh) -> Self {
        let origin = vec![FaceOrigin::Measured; mesh.triangles.len()];
        PatchBuilder { measured: mesh.points.len(), mesh, origin }
    }

    /// Adds the points and triangles of a fill. The numbers of its new vertices follow those of
    /// the measured ones.
    fn add(&mut self, points: Vec<Point>, triangles: &[[VertexId; 3]], origin: FaceOrigin) {
        let shift = (self.mesh.points.len() - self.measured) as u32;
        let number =
            |v: VertexId| VertexId(v.0 + if v.index() < self.measured { 0 } else { shift });
        self.mesh.points.extend(points);
        self.mesh.triangles.extend(triangles.iter().map(|t| t.map(number)));
        self.origin.resize(self.mesh.triangles.len(), origin);
    }
}
