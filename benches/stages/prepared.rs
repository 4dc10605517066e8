//! The input of each stage: the output of the stages before it for a scan.

use std::error::Error;
use std::io::Cursor;

use formats::{Soup, step};
use scan2step::deviation::{Deviation, TrimmedFace};
use scan2step::mesh::{self, Bound, Components, Disk, Outer, Patch};
use scan2step::spline::{KnotVector, Samples};
use scan2step::stages::parameterize::Parameterized;
use scan2step::stages::{brep, fill, knots, trim};
use scan2step::{Body, Options, Stage};

use crate::body::{OneFace, face_seen};
use crate::named;

/// A converted scan and the inputs of its stages.
pub struct Prepared {
    /// The file of the scan.
    pub ply: Vec<u8>,
    pub soup: Soup,
    pub options: Options,
    pub measured: Disk,
    pub smoothed: Disk,
    pub fill: fill::Options,
    pub patch: Patch,
    map: Parameterized,
    pub samples: Samples,
    pub knots: knots::Options,
    pub rims: Vec<trim::Rim>,
    pub trim: trim::Options,
    pub conversion: Body,
}

impl Prepared {
    pub fn new(name: &str) -> Result<Prepared, Box<dyn Error>> {
        let scan = named::scan(name).ok_or("no such scan")?;
        let mut ply = Vec::new();
        scan.write_ply(&mut ply)?;
        drop(scan);
        let soup = read(ply.clone())?;
        let options = Options::default();
        let (mut measured, mut smoothed, mut patch, mut map) = (None, None, None, None);
        let conversion = face_seen(&soup, &options, &mut |stage| {
            match stage {
                Stage::Mesh(disk) => measured = Some(disk.clone()),
                Stage::Smooth(disk) => smoothed = Some(disk.clone()),
                Stage::Fill(filled) => patch = Some(filled.clone()),
                Stage::Parameterize(mapped, _) => map = Some(mapped.clone()),
                _ => {}
            }
            Ok(())
        })?;
        let map = map.ok_or("the scan was not mapped")?;
        Ok(Prepared {
            fill: fill_options(&conversion),
            samples: samples(&map),
            knots: knots::Options { kappa: conversion.tolerance, depth: 20 },
            rims: rims(&map),
            trim: trim::Options {
                tolerance: conversion.tolerance,
                rim: conversion.one().rim_tolerance,
                least_rim: conversion.one().rim_tolerance,
                keeps_vertices: false,
            },
            measured: measured.ok_or("the scan was not meshed")?,
            smoothed: smoothed.ok_or("the scan was not smoothed")?,
            patch: patch.ok_or("the scan was not filled")?,
            ply,
            soup,
            options,
            map,
            conversion,
        })
    }

    pub fn disk(&self) -> scan2step::Result<Disk> {
        let scan = Components::new(mesh::from_soup(&self.soup, 1.0)?);
        let mut repairs = scan.repairs().clone();
        scan.take(mesh::Choice::Largest)?.into_disk(Outer::Auto, &mut repairs)
    }

    /// The knots of the final fit.
    pub fn net(&self) -> [KnotVector; 2] {
        [self.conversion.one().surface.u.clone(), self.conversion.one().surface.v.clone()]
    }

    pub fn deviation(&self) -> Deviation {
        let loops = self.conversion.one().loops.iter().map(|l| l.pcurves.as_slice());
        let face = TrimmedFace::new(&self.conversion.one().surface, loops, true);
        let points = &self.measured.mesh.points;
        face.deviation(points, &self.map.uv[..points.len()])
    }

    /// The size of the STEP file in bytes.
    pub fn step(&self) -> Result<usize, Box<dyn Error>> {
        let inner = self.conversion.one().loops.iter().map(|l| (&l.pcurves[..], &l.edges[..]));
        let face = brep::FaceBounds { outer: None, inner: inner.collect() };
        let brep =
            brep::build(&self.conversion.one().surface, &[face], "scan", trim::EDGE_ACCURACY)?;
        let mut file = Vec::new();
        step::write(&brep, &step::Options::default(), &mut file)?;
        Ok(file.len())
    }
}

pub fn read(ply: Vec<u8>) -> formats::Result<Soup> {
    formats::read_scan_from("scan.ply".as_ref(), Cursor::new(ply), None)
}

fn fill_options(conversion: &Body) -> fill::Options {
    let smooth = &conversion.smooth;
    fill::Options { support: smooth.h, noise: smooth.noise, ..fill::Options::default() }
}

fn samples(map: &Parameterized) -> Samples {
    let mut samples = Samples::default();
    samples.points.clone_from(&map.patch.mesh.points);
    samples.uv.clone_from(&map.uv);
    samples.weights = vec![1.0; samples.points.len()];
    samples
}

/// The rims of the holes. These scans have no other rims, because their outer boundary is straight
/// enough for the sides.
fn rims(map: &Parameterized) -> Vec<trim::Rim> {
    let rim = |hole| {
        let rim = map.patch.loop_of(Bound::Hole(hole));
        trim::Rim {
            of: Bound::Hole(hole),
            within: None,
            points: rim.iter().map(|&v| map.patch.mesh.point(v)).collect(),
            uv: rim.iter().map(|v| map.uv[v.index()]).collect(),
        }
    };
    (0..map.patch.rims.len()).map(rim).collect()
}
