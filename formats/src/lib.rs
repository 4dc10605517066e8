//! Readers of scans, and readers and writers of CAD files.
//!
//! A reader of scans returns exactly what a file contains: a [`Scene`] of meshes in their places, or all of them as one
//! [`Soup`] of polygons with the unit that the file declares, or a cloud of [`Points`]. It does not weld or repair anything. A writer
//! takes a [`Brep`]: faces on B-spline surfaces, planes, cylinders, cones, spheres, tori and swept
//! curves, in shells and solids, trimmed by edges with a pcurve for every use. The crate does not
//! know how scan2step converts one into the other.

#![deny(missing_docs)]
// Whatever a file contains, the readers return an error and do not panic.
#![deny(clippy::expect_used, clippy::panic, clippy::unreachable, clippy::unwrap_used)]

pub mod assembly;
pub mod brep;
pub mod cad;
mod colour;
mod damage;
mod error;
mod far;
mod gltf;
pub mod iges;
mod limits;
mod number;
mod numbered;
mod obj;
mod off;
mod ply;
pub mod points;
pub mod read;
pub mod scene;
pub mod soup;
mod source;
pub mod spline;
pub mod step;
mod stl;
mod threemf;
mod time_stamp;
mod token;
mod unit_comment;
mod unzip;
pub mod words;

pub use assembly::Assembly;
pub use brep::Brep;
pub use error::{Error, Location, Result};
pub use points::{
    Content, PointFormat, Points, SceneContent, read_content, read_points, read_points_from,
};
pub use read::{Format, read_scan, read_scan_from, read_scene, read_scene_from};
pub use scene::Scene;
pub use soup::{LengthUnit, Soup};

/// The example of the README is also a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
