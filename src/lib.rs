//! scan2step turns what a 3D scanner delivers into what CAD works with. A noisy sheet with holes becomes one
//! trimmed B-spline face, with every region that the scanner missed cut out by a trim loop. A closed scan, or
//! one with small gaps, becomes a watertight solid of several faces, and a sheet that one face does not hold a
//! shell. Clouds of points become the same as meshes do. The result is written as STEP or IGES.
//!
#![doc = include_str!("../docs/front-picture.md")]
//! ```no_run
//! # fn main() -> scan2step::Result<()> {
//! use scan2step::{Options, Scan, convert};
//!
//! // The numbers of glTF are metres. The tolerance, and what is said of the result, are mm.
//! let options = Options::builder().name("door").tolerance(0.25).build()?;
//! let conversion = convert(Scan::read("door.glb")?, &options, &mut |_| Ok(()))?;
//! for body in conversion.bodies() {
//!     let (shape, off) = (body.shape.word(), body.fit_deviation.max);
//!     println!("a {shape} of {} faces, at most {off:.3} mm off", body.brep.faces.len());
//! }
//! conversion.write("door.step")?;
//! # Ok(())
//! # }
//! ```
//!
//! [`convert_file`] does these three steps in one call. [`convert`] takes meshes and clouds of one's own, too:
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
//! let part = &conversion.parts[0];
//! assert!(part.bodies[0].tolerance_met(0.0));
//! let width = part.bodies[0].surfaces()[0].net.iter().map(|p| p.x).fold(0.0, f64::max);
//! assert!((width - 400.0).abs() < 0.25, "the face is in mm: {width}");
//!
//! let mut file = Vec::new();
//! step::write(&part.brep, &step::Options::default(), &mut file)?;
//! # assert!(file.starts_with(b"ISO-10303-21;"));
//! # Ok(())
//! # }
//! ```
//!
//! A [`Conversion`] has parts, a [`Part`] has bodies, and a [`Body`] is one face, a shell, a solid or a void in
//! it. The method for single faces is that of L. S. Tekumalla and E. Cohen, "Reverse Engineering Point Clouds to
//! Obtain Tensor Product B-Spline Surfaces by Blending Local Fits" (2005), cited here by section. Lengths are
//! millimetres throughout, whatever the unit of the scan's numbers is.
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
//! | cloud | [`triangulate`](stages::cloud::triangulate) | points | polygons |
//! | mesh | [`mesh::from_soup`], [`mesh::Components`] | polygons | a disk with holes, or a body |
//! | thin | [`thin`](stages::thin::thin) | that | the same with fewer vertices, if the scan is dense for its noise |
//! | smooth | [`smooth`](stages::smooth::smooth) | that | the same, smoothed |
//! | fill | [`fill`](stages::fill::fill) | that | a disk, or a closed body |
//! | parameterize | [`parameterize`](stages::parameterize::parameterize) | that | parameters in [0, 1]² |
//! | knots, fit | [`fit`](stages::adapt::fit); [`place`](stages::knots::place), [`fit`](stages::fit::fit) | these | a surface |
//! | layout | [`layout`](stages::layout::layout) | a closed body | blocks of quads |
//! | net | [`fit`](stages::net::fit) | these | a subdivision surface |
//! | patches | [`extract`](stages::patches::extract) | that | a network of surfaces |
//! | refine | [`refine`](stages::refine::refine) | that | the same with more knots where they are needed |
//! | trim | [`cut::rims`], [`trim`](stages::trim::trim), [`network`](stages::trim::network::cut) | surfaces | trim loops |
//! | brep | [`cut::faces`], [`build`](stages::brep::build) | these | what `formats` writes |
//!
//! [`report::Report`] has the figures of a conversion. [`Memory`] estimates the memory that one takes before it
//! begins.
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

#![deny(missing_docs, unreachable_pub)]
// What a caller hands in is answered with an error.
#![deny(clippy::expect_used, clippy::panic, clippy::unreachable, clippy::unwrap_used)]

pub mod check;
mod convert;
pub mod deviation;
pub mod error;
pub mod geometry;
pub mod mesh;
mod noise;
pub mod primitives;
mod progress;
pub mod report;
pub mod rules;
mod solve;
pub mod spline;
pub mod stages;
mod statistics;
pub mod threads;
pub mod words;

pub use convert::{
    AssemblyConversion, Body, BodyEstimate, BodyFit, Builder, Conversion, ConvertedPart, Cut,
    EdgeChoice, ExactEstimate, ExactFace, ExactFit, FaceSize, InputReport, InspectedPart,
    Inspection, LeftFilled, MeansOf, Measured, MeasuredPlace, MeasuredScene, Memory, Missed,
    NetworkFit, Observer, Options, Part, PartColours, PartObserver, PieceReport, Scan, ScanPlace,
    ScenePart, SceneParts, Seams, Stage, SurfaceChoice, SurfaceFit, TargetShape, cloud_components,
    convert, convert_file, convert_scene, cropped, cut, inspect, is_same_file, measured,
    mesh_components, shape, voids,
};
pub use error::{Error, Result};
pub use progress::Progress;
pub use stages::adapt::{Adapted, KnotOptions};
// What this library's own items take and give; no second version of them gets in.
pub use {formats, nalgebra};
