//! The files at scan2step's two ends: readers of scans and writers of CAD.
//!
//! Readers deliver what a file says, and no more: a [`Soup`] of polygons with
//! its declared unit, unwelded and unrepaired, or a cloud of [`Points`]. Writers take a [`Brep`]: faces on
//! B-spline surfaces, trimmed by edges with a pcurve for every use, in shells and
//! solids. The crate knows nothing of what happens between the two.

#![deny(missing_docs)]
// Whatever a file says is answered with an error.
#![deny(clippy::expect_used, clippy::panic, clippy::unreachable, clippy::unwrap_used)]

pub mod brep;
pub mod cad;
mod damage;
mod error;
mod gltf;
pub mod iges;
mod limits;
mod number;
mod obj;
mod off;
mod ply;
pub mod points;
pub mod read;
pub mod soup;
mod source;
pub mod spline;
pub mod step;
mod stl;
mod time_stamp;
mod token;
mod unzip;

pub use brep::Brep;
pub use error::{Error, Place, Result};
pub use points::{Content, PointFormat, Points, read_content, read_points, read_points_from};
pub use read::{Format, read_scan, read_scan_from};
pub use soup::{LengthUnit, Soup};

/// The example of the README is a test, too.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
