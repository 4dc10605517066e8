//! Hole filling by an advancing front (Tekumalla & Cohen 2005, section 3.2).
//!
//! Each hole is filled by itself from the measured points around it, so holes
//! do not depend on each other's order.

mod band;
mod cholesky;
mod develop;
mod fair;
mod front;
mod membrane;
mod outlines;
mod plane;
mod ring;
mod sheet;
mod size;
mod smoothing_spline;

use band::Measured;
use fair::Seen;
use front::{Fill, SUPPORTS, Way};
use rayon::prelude::*;
use size::Sizes;

use crate::error::{Error, Result};
use crate::geometry::{Point, VertexId};
use crate::mesh::boundary::Loop;
use crate::mesh::mls::Cloud;
use crate::mesh::{Disk, FaceOrigin, Patch, Rings, boundary};

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
    /// The front could not close it; a membrane does.
    Membrane,
}

/// One filled hole.
#[derive(Debug, Clone)]
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
}

/// What was filled, in the order of the disk's holes.
#[derive(Debug, Clone, Default)]
pub struct Report {
    /// The holes.
    pub holes: Vec<Hole>,
}

/// Fills all holes of a disk. `measured` are its points as the scanner gave
/// them, before smoothing.
pub fn fill(disk: Disk, measured: &[Point], options: &Options) -> Result<(Patch, Report)> {
    let cloud = Cloud::of(&disk.mesh);
    let rings = Rings::new(&disk.mesh);
    let around = front::Surroundings { mesh: &disk.mesh, rings: &rings, cloud: &cloud };
    let measured = Measured { points: measured, noise: options.noise };
    let islands = |hole: usize| disk.islands.iter().filter(move |island| island.hole == hole);
    let fill = |(hole, rim): (usize, &Loop)| {
        let rims: Vec<&[VertexId]> = std::iter::once(rim.as_slice())
            .chain(islands(hole).map(|island| island.rim.as_slice()))
            .collect();
        close(&around, &measured, &rims, options)
            .ok_or_else(|| Error::Fill { hole, at: disk.mesh.point(rim[0]) })
    };
    let fills: Vec<(Fill, Method)> =
        disk.holes.par_iter().enumerate().map(fill).collect::<Result<_>>()?;
    let measured = disk.mesh.points.len();
    let mut mesh = disk.mesh;
    let mut origin = vec![FaceOrigin::Measured; mesh.triangles.len()];
    let mut report = Report::default();
    for (number, ((fill, method), rim)) in fills.into_iter().zip(&disk.holes).enumerate() {
        report.holes.push(Hole {
            rim_vertices: rim.len(),
            rim_length: boundary::length(&mesh, rim),
            islands: islands(number).count(),
            added_vertices: fill.points.len(),
            added_triangles: fill.triangles.len(),
            method,
        });
        let shift = (mesh.points.len() - measured) as u32;
        origin.extend(fill.triangles.iter().map(|_| FaceOrigin::Hole(number as u32)));
        mesh.triangles.extend(fill.triangles.iter().map(|t| {
            t.map(|mut v| {
                v.0 += if v.index() < measured { 0 } else { shift };
                v
            })
        }));
        mesh.points.extend(fill.points);
    }
    let Disk { outer, holes: rims, islands, .. } = disk;
    let patch = Patch { mesh, measured, origin, outer, rims, islands };
    debug_assert!(patch.is_disk(), "filling leaves a disk");
    Ok((patch, report))
}

/// Closes one hole. The front's fill is shaped by the points around it, as a
/// height if all of these can be seen from one side, or over a layout in the
/// plane. Where the front went astray, or overlaps itself, it is led over the
/// surface that the points make likely; what cannot be seen is left to a
/// membrane.
fn close(
    around: &front::Surroundings,
    measured: &Measured,
    rims: &[&[VertexId]],
    options: &Options,
) -> Option<(Fill, Method)> {
    let points = |rim: &&[VertexId]| rim.iter().map(|&v| around.mesh.point(v)).collect();
    let sizes = Sizes::new(&rims.iter().map(points).collect::<Vec<_>>());
    let hole = front::Hole { around, rims, sizes: &sizes };
    let built = SUPPORTS.iter().find_map(|&s| front::advance(hole, options, Way::Mls(s)));
    let method = |fill: Fill| {
        let method = if fill.wide_ears == 0 { Method::Front } else { Method::WideEars };
        (fill, method)
    };
    if let Some(fill) = built.as_ref().filter(|fill| fill.points.is_empty()) {
        return Some(method(fill.clone()));
    }
    let shaper = fair::Shaper::new(hole, measured);
    let over_plane = |seen: Seen| {
        let shaper = shaper.as_ref()?;
        let view = shaper.view(seen)?;
        let shaped = built.as_ref().and_then(|fill| shaper.over_plane(fill, &view));
        shaped.map(method).or_else(|| {
            let surface = |p: Point| view.under(p, 1e-3 * sizes.mean);
            let led = front::advance(hole, options, Way::Led(view.lead(&surface)))?;
            Some((shaper.over_plane(&led, &view)?, Method::Led))
        })
    };
    let developed = |fill: &Fill| shaper.as_ref()?.developed(fill);
    over_plane(Seen::All)
        .or_else(|| built.as_ref().and_then(developed).map(method))
        .or_else(|| over_plane(Seen::Part))
        .or_else(|| {
            let membrane = front::span(hole, options)?;
            Some((developed(&membrane).unwrap_or(membrane), Method::Membrane))
        })
}
