//! Hole filling by an advancing front (Tekumalla & Cohen 2005, section 3.2).
//!
//! Each hole is filled by itself from the measured points around it, so holes
//! do not depend on each other's order.

mod front;
mod membrane;
mod plane;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::mesh::boundary::Loop;
use crate::mesh::mls::Cloud;
use crate::mesh::{Disk, FaceOrigin, Patch, Rings, boundary};

/// How to fill.
#[derive(Debug, Clone)]
pub struct Options {
    /// Ears of the front with a smaller angle than this are closed, in
    /// radians. The paper's φ: 5π/9.
    pub ear_angle: f64,
    /// The support h of the MLS approximations at the least, in mm; a rim with
    /// longer edges takes 2.5 of its mean edge.
    pub support: f64,
}

impl Default for Options {
    fn default() -> Self {
        Options { ear_angle: 5.0 * std::f64::consts::PI / 9.0, support: 0.0 }
    }
}

/// How a hole was closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// By the front alone.
    Front,
    /// The front came to a halt, and ears wider than φ were closed for it.
    WideEars,
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

/// Fills all holes of a disk.
pub fn fill(disk: Disk, options: &Options) -> Result<(Patch, Report)> {
    let cloud = Cloud::of(&disk.mesh);
    let rings = Rings::new(&disk.mesh);
    let fill = |(hole, rim): (usize, &Loop)| {
        front::fill_hole(&disk.mesh, &rings, &cloud, rim, options)
            .ok_or_else(|| Error::Fill { hole, at: disk.mesh.point(rim[0]) })
    };
    let fills: Vec<front::Fill> =
        disk.holes.par_iter().enumerate().map(fill).collect::<Result<_>>()?;
    let measured = disk.mesh.points.len();
    let mut mesh = disk.mesh;
    let mut origin = vec![FaceOrigin::Measured; mesh.triangles.len()];
    let mut report = Report::default();
    for (number, (fill, rim)) in fills.into_iter().zip(&disk.holes).enumerate() {
        report.holes.push(Hole {
            rim_vertices: rim.len(),
            rim_length: boundary::length(&mesh, rim),
            added_vertices: fill.points.len(),
            added_triangles: fill.triangles.len(),
            method: fill.method,
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
    let patch = Patch { mesh, measured, origin, outer: disk.outer, rims: disk.holes };
    debug_assert!(patch.is_disk(), "filling leaves a disk");
    Ok((patch, report))
}
