//! Hole filling by an advancing front (Tekumalla & Cohen 2005, section 3.2).
//!
//! Each hole is filled by itself from the measured points around it, so holes
//! do not depend on each other's order.

mod apart;
mod band;
mod blocks;
mod cells;
mod close;
mod develop;
mod fair;
mod faults;
mod front;
mod least_area;
mod outlines;
mod plane;
mod ring;
mod sheet;
mod smoothing_spline;

use band::Measured;
use close::Closed;
pub use faults::Faults;
use rayon::prelude::*;

use crate::error::{Error, Result, of};
use crate::geometry::{Point, VertexId};
use crate::mesh::{Disk, FaceOrigin, Mesh, Patch, boundary};
use crate::progress::{self, Progress};
use crate::rules;

/// How to fill.
#[derive(Debug, Clone)]
pub struct Options {
    /// Ears of the front with a smaller angle than this are closed, in
    /// radians. The paper's φ: 5π/9.
    pub ear_angle: f64,
    /// The support h of the MLS approximations at the least, in mm, but no more
    /// than four edges; two or three edges are taken where that is more.
    pub support: f64,
    /// The standard deviation of the measured points' noise, in mm.
    pub noise: f64,
}

impl Default for Options {
    fn default() -> Self {
        Options { ear_angle: 5.0 * std::f64::consts::PI / 9.0, support: 0.0, noise: 0.0 }
    }
}

impl Options {
    pub(crate) fn check(&self) -> Result<()> {
        rules::angle(self.ear_angle).map_err(of("ear_angle"))?;
        rules::extent(self.support).map_err(of("support"))?;
        rules::extent(self.noise).map_err(of("noise"))
    }
}

/// How a hole was closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// By the front alone.
    Front,
    /// The front came to a halt, and ears wider than φ were closed for it.
    WideEars,
    /// The front went astray, and was led over the surface that the points
    /// around the hole make likely.
    Led,
    /// Fronts could not close it without a fold or a cut; the triangulation of
    /// least area does, or does with fewer.
    LeastArea,
}

/// One filled hole.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Hole {
    /// Vertices of the rim.
    pub rim_vertices: usize,
    /// Length of the rim, in mm.
    pub rim_length: f64,
    /// Islands in it.
    pub islands: usize,
    /// Vertices added.
    pub added_vertices: usize,
    /// Triangles added.
    pub added_triangles: usize,
    /// How it was closed.
    pub method: Method,
    /// What is wrong with it nevertheless.
    pub faults: Faults,
}

/// What was filled, in the order of the disk's holes.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Report {
    /// The holes.
    pub holes: Vec<Hole>,
}

impl Report {
    /// The same with all lengths times a factor.
    pub(crate) fn scaled(mut self, factor: f64) -> Self {
        self.holes.iter_mut().for_each(|hole| hole.rim_length *= factor);
        self
    }
}

/// The share of its time after which what is around the holes is usually known.
const SURROUNDED: f64 = 0.5;

/// Holes that are filled before it is told how many are.
const AT_ONCE: usize = 32;

/// Fills all holes of a disk. `measured` are its points as the scanner gave them, before smoothing.
///
/// # Errors
/// [`Error::Fill`]: a hole that cannot be filled. [`Error::Option`]: an option that
/// cannot be. [`Error::Input`]: not as many measured points as the disk has.
pub fn fill(disk: Disk, measured: &[Point], options: &Options) -> Result<(Patch, Report)> {
    fill_with(disk, measured, options, &mut progress::ignore)
}

/// The same, telling how far it has come.
///
/// # Errors
/// Those of [`fill`], and what `progress` answers.
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
        let measured = Measured { points: measured, noise: options.noise };
        close::close(around, &measured, &rims, options)
            .ok_or_else(|| Error::Fill { hole, at: disk.mesh.point(rims[0][0]) })
    };
    let fills = front::Surroundings::with(&disk.mesh, |around| {
        let count = disk.holes.len();
        let mut fills: Vec<Closed> = Vec::with_capacity(count);
        loop {
            progress(SURROUNDED + (1.0 - SURROUNDED) * fills.len() as f64 / count.max(1) as f64)?;
            let some = fills.len()..count.min(fills.len() + AT_ONCE);
            let closed: Result<Vec<_>> =
                some.into_par_iter().map(|hole| fill(around, measured, hole)).collect();
            fills.extend(closed?);
            if fills.len() == count {
                break;
            }
        }
        apart::part(around, measured, &mut fills, |mesh, measured, holes| {
            front::Surroundings::with(mesh, |around| {
                holes.par_iter().map(|&hole| fill(around, measured, hole)).collect()
            })
        });
        Ok::<_, Error>(fills)
    })?;
    let Disk { mesh, outer, holes: rims, islands, .. } = disk;
    let mut whole = Whole::new(mesh);
    let mut report = Report::default();
    for (number, (closed, rim)) in fills.into_iter().zip(&rims).enumerate() {
        let fill = closed.fill;
        report.holes.push(Hole {
            rim_vertices: rim.len(),
            rim_length: boundary::length(&whole.mesh, rim),
            islands: islands.iter().filter(|island| island.hole == number).count(),
            added_vertices: fill.points.len(),
            added_triangles: fill.triangles.len(),
            method: closed.method,
            faults: closed.faults,
        });
        whole.add(fill.points, &fill.triangles, FaceOrigin::Hole(number as u32));
    }
    let Whole { mesh, measured, origin } = whole;
    let patch = Patch { mesh, measured, origin, outer, measured_outer: None, rims, islands };
    debug_assert!(patch.is_disk(), "filling leaves a disk");
    Ok((patch, report))
}

/// The measured mesh with the fills so far.
struct Whole {
    mesh: Mesh,
    measured: usize,
    origin: Vec<FaceOrigin>,
}

impl Whole {
    fn new(mesh: Mesh) -> Self {
        let origin = vec![FaceOrigin::Measured; mesh.triangles.len()];
        Whole { measured: mesh.points.len(), mesh, origin }
    }

    /// What number a vertex of the next fill has in the whole; fills number their points
    /// from the measured ones on.
    fn number(&self) -> impl Fn(VertexId) -> VertexId + use<> {
        let (measured, shift) = (self.measured, (self.mesh.points.len() - self.measured) as u32);
        move |v| VertexId(v.0 + if v.index() < measured { 0 } else { shift })
    }

    /// Adds a fill.
    fn add(&mut self, points: Vec<Point>, triangles: &[[VertexId; 3]], origin: FaceOrigin) {
        let number = self.number();
        self.mesh.points.extend(points);
        self.mesh.triangles.extend(triangles.iter().map(|t| t.map(&number)));
        self.origin.resize(self.mesh.triangles.len(), origin);
    }
}
