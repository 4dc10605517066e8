//! scan2step turns what a 3D scanner delivers into what CAD works with: a
//! noisy triangle mesh with holes becomes one trimmed tensor-product B-spline
//! face, smooth where the object is smooth, with every region that the scanner
//! missed cut out by a trim loop. What it saw in the middle of such a region, an
//! island, becomes a face on the same surface.
//!
//! [`convert`] is the whole program: whoever reads it has read how the stages
//! follow each other. The method is that of L. S. Tekumalla and E. Cohen,
//! "Reverse Engineering Point Clouds to Obtain Tensor Product B-Spline
//! Surfaces by Blending Local Fits" (2005), cited here by section. Lengths are
//! millimetres throughout, whatever the unit of the scan's numbers is.
//!
//! ```no_run
//! # fn main() -> scan2step::Result<()> {
//! use scan2step::{Options, convert_file};
//!
//! // The numbers of glTF are metres; the tolerance, the face and what is said of it, mm.
//! let options = Options::builder().name("door").tolerance(0.25).build()?;
//! let conversion = convert_file("door.glb", "door.step", &options)?;
//! println!("at most {:.3} mm off", conversion.fit_deviation.max);
//! # Ok(())
//! # }
//! ```
//!
//! Or step by step, with a mesh of one's own:
//!
//! ```
//! use scan2step::formats::{LengthUnit, Soup, step};
//! use scan2step::{Options, convert};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A sheet of 0.4 × 0.3 m, bent by 5 mm.
//! let mut soup = Soup { unit: Some(LengthUnit::Metre), ..Soup::default() };
//! for k in 0..41 * 31 {
//!     let (x, y) = (0.01 * f64::from(k % 41), 0.01 * f64::from(k / 41));
//!     soup.points.push([x, y, 0.005 * (10.0 * x).sin()]);
//! }
//! for a in (0..41 * 30).filter(|a| a % 41 < 40) {
//!     soup.polygons.push([a, a + 1, a + 42, a + 41]);
//! }
//! let options = Options::builder().name("sheet").tolerance(0.25).build()?;
//! let conversion = convert(&soup, &options, &mut |_| Ok(()))?;
//! assert!(conversion.tolerance_met(0.0));
//! let width = conversion.surface.net.iter().map(|p| p.x).fold(0.0, f64::max);
//! assert!((width - 400.0).abs() < 0.25, "the face is in mm: {width}");
//!
//! let mut file = Vec::new();
//! step::write(&conversion.brep, &step::Options::default(), &mut file)?;
//! # assert!(file.starts_with(b"ISO-10303-21;"));
//! # Ok(())
//! # }
//! ```
//!
//! # Stage by stage
//!
//! Each stage is a function with options and a report of its own, to be called with
//! one's own mesh, between others, or alone; `examples/stages.rs` calls all of them. Those
//! that take long have a second one, `smooth_with` and the like, that tells a [`Progress`]
//! how far it has come.
//!
//! | stage | function | from | makes |
//! | --- | --- | --- | --- |
//! | mesh | [`mesh::from_soup`], [`mesh::Components`] | polygons | a disk with holes |
//! | smooth | [`smooth::smooth`] | a disk with holes | the same, smoothed |
//! | fill | [`fill::fill`] | that | a disk |
//! | thin | [`thin::thin`] | that | a disk with fewer vertices, if the scan is dense for its noise |
//! | parameterize | [`parameterize::parameterize`] | that | parameters in [0, 1]² |
//! | knots, fit | [`adapt::fit`]; [`knots::place`], [`fit::fit`] | these | a surface |
//! | trim | [`cut::rims`], [`trim::trim`] | both | trim loops |
//! | brep | [`cut::faces`], [`brep::build`] | these | what `formats` writes |
//!
//! [`convert_scan`] is what the program does with a scan of any shape: faces, solids or shells.
//! [`convert_components`] converts several components of a scan, and [`joined`] puts their faces
//! into one B-rep. [`report::Report`] has the figures of conversions, [`Memory`] estimates the
//! memory that one takes before it begins.
//!
//! [`deviation::TrimmedFace`] tells how far points are from the face; [`check::check`] how far
//! a CAD file is from a scan.
//!
//! # Threads
//!
//! The loops of a conversion are shared by threads that end with it, or by those of the
//! caller's pool ([`threads`]). Nothing is set for the whole process.
//!
//! # Features
//!
//! | feature | what it adds | packages |
//! | --- | --- | --- |
//! | `cli` (default) | the program; it implies the others | clap, indicatif and others |
//! | `serde` | `serde::Serialize` for the types of [`report`] | serde |
//! | `json` | reports as JSON text | serde, serde_json |
//! | `picture` | the module `picture`, and the picture of a report | ab_glyph, dejavu, png |
//! | `html` | the page of a report | those of `json` and `picture`, minijinja, base64 |
//!
//! A library leaves out the program: `default-features = false`.
//!
//! # Errors and versions
//!
//! What can be wrong with a scan or an option is an [`Error`], and [`Error::help`] says
//! what to do. What stages hand on (`Disk`, `Patch`, `Parameterized`, `Surface`) is
//! taken to be as they made it: whoever changes it by hand keeps what its
//! documentation promises. Errors, reports and [`Stage`] may grow in any version. Options
//! of stages get new fields with a new minor version, before 1.0; write
//! `..Default::default()`.

#![deny(missing_docs)]
// What a caller hands in is answered with an error.
#![deny(clippy::expect_used, clippy::panic, clippy::unreachable, clippy::unwrap_used)]

pub mod adapt;
pub mod brep;
pub mod check;
mod cholesky;
pub mod cloud;
mod convert;
pub mod crop;
pub mod deviation;
pub mod error;
pub mod fill;
pub mod fit;
pub mod geometry;
pub mod knots;
pub mod layout;
mod least_squares;
pub mod mesh;
pub mod net;
mod noise;
pub mod parameterize;
pub mod patches;
#[cfg(feature = "picture")]
pub mod picture;
mod progress;
mod random;
pub mod refine;
pub mod report;
pub mod rules;
mod sets;
pub mod smooth;
pub mod spline;
mod statistics;
pub mod thin;
pub mod threads;
pub mod trim;
pub mod words;

pub use adapt::{Adapted, KnotOptions};
pub use convert::{
    BodyConversion, BodyEstimate, Builder, Conversion, Converted, Cut, InputReport, Inspection,
    Measured, Memory, Missed, Observer, Options, PieceReport, ScanConversion, ScanObserver,
    ScanPlace, Seams, Stage, TargetShape, cloud_components, convert, convert_body, convert_cloud,
    convert_component, convert_components, convert_file, convert_scan, cut, inspect, joined,
    joined_bodies, measured, mesh_components, shape, voids,
};
pub use error::{Error, Result};
pub use progress::Progress;
// What this library's own items take and give; no second version of them gets in.
pub use {formats, nalgebra};
