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
//! that take long have a second one, `smooth_with` and the like, that tells a [`Course`]
//! how far it has come.
//!
//! | stage | function | from | makes |
//! | --- | --- | --- | --- |
//! | mesh | [`mesh::from_soup`], [`mesh::Components`] | polygons | a disk with holes |
//! | smooth | [`smooth::smooth`] | a disk with holes | the same, smoothed |
//! | fill | [`fill::fill`] | that | a disk |
//! | parameterize | [`parameterize::parameterize`] | that | parameters in [0, 1]² |
//! | knots, fit | [`adapt::fit`]; [`knots::place`], [`fit::fit`] | these | a surface |
//! | trim | [`cut::rims`], [`trim::trim`] | both | trim loops |
//! | brep | [`cut::faces`], [`brep::build`] | these | what `formats` writes |
//!
//! [`deviation::Face`] tells how far points are from the face; [`check::check`] how far
//! a CAD file is from a scan.
//!
//! # Features
//!
//! `cli` (default) is the program; `picture`, which it implies, the module of that name.
//! A library does without: `default-features = false`.
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
mod course;
pub mod cut;
mod decimal;
pub mod deviation;
pub mod error;
mod file;
pub mod fill;
pub mod fit;
pub mod geometry;
mod hints;
mod input;
pub mod knots;
mod lengths;
pub mod mesh;
mod options;
pub mod parameterize;
#[cfg(feature = "picture")]
pub mod picture;
pub mod rules;
mod sets;
pub mod smooth;
pub mod spline;
pub mod trim;
pub mod words;

pub use adapt::{Adapted, KnotOptions};
pub use course::Course;
pub use cut::Cut;
pub use error::{Error, Result};
pub use file::convert_file;
pub use input::{InputReport, Inspection, Measured, inspect, measured};
pub use options::{Builder, Options};
// What this library's own items take and give; no second version of them gets in.
pub use {formats, nalgebra};

use formats::{Brep, Soup};
use mesh::{Components, Disk, Patch};
use parameterize::Parameterized;
use rayon::prelude::*;
use spline::Surface;

/// A stage that has just ended, with what it made, or one that goes on.
#[derive(Debug)]
#[non_exhaustive]
pub enum Stage<'a> {
    /// The cleaned mesh.
    Mesh(&'a Disk),
    /// The smoothed mesh.
    Smooth(&'a Disk),
    /// The mesh with its holes filled.
    Fill(&'a Patch),
    /// The filled mesh with parameters, and where it leaves too little room for
    /// the tolerance.
    Parameterize(&'a Parameterized, Option<parameterize::Crushed>),
    /// The fitted surface.
    Fit(&'a Surface),
    /// The loops: the outer one unless it is on the surface's sides, those of the
    /// holes and of the islands in them.
    Trim(&'a Surface, &'a [trim::TrimLoop]),
    /// The boundary representation.
    Brep,
    /// The deviation.
    Deviation,
    /// The stage of that name goes on, and has about so large a share of its time behind
    /// it: more than it was told of before.
    Within(&'static str, f64),
}

impl Stage<'_> {
    /// Its name, as reports and progress have it.
    pub fn name(&self) -> &'static str {
        match self {
            Stage::Mesh(_) => "mesh",
            Stage::Smooth(_) => "smooth",
            Stage::Fill(_) => "fill",
            Stage::Parameterize(..) => "parameterize",
            Stage::Fit(_) => "fit",
            Stage::Trim(..) => "trim",
            Stage::Brep => "brep",
            Stage::Deviation => "deviation",
            Stage::Within(name, _) => name,
        }
    }
}

/// A converted scan.
#[derive(Debug)]
#[non_exhaustive]
pub struct Conversion {
    /// What the writers take.
    pub brep: Brep,
    /// The fitted surface.
    pub surface: Surface,
    /// The loops: the outer one unless it is on the surface's sides, those of the
    /// holes cut out and of the islands in them.
    pub loops: Vec<trim::TrimLoop>,
    /// What came in.
    pub input: InputReport,
    /// What smoothing did.
    pub smooth: smooth::Report,
    /// What was filled.
    pub fill: fill::Report,
    /// Which of the filled holes were cut out.
    pub trimmed: Vec<bool>,
    /// How good the map is.
    pub parameterize: parameterize::Report,
    /// Where it leaves too little room for the tolerance.
    pub crushed: Option<parameterize::Crushed>,
    /// Knots and fit.
    pub fit: Adapted,
    /// The tolerance that holds, in mm.
    pub tolerance: f64,
    /// Whether the user named it.
    pub tolerance_named: bool,
    /// The share of points that may miss a tolerance that nobody named.
    pub spared: f64,
    /// The points that miss it.
    pub missed: Missed,
    /// How far the face is from the smoothed scan's triangles, fills left out.
    pub face_to_scan: deviation::FaceToScan,
    /// Deviation of the smoothed points from the trimmed face; the tolerance
    /// is held against it.
    pub fit_deviation: deviation::Deviation,
    /// Deviation of the points as they were measured.
    pub deviation: deviation::Deviation,
    /// The outer boundary on the surface's sides: control points of its edges,
    /// and the farthest, in mm, that a smoothed boundary vertex is from them.
    /// `None`: it is one of the loops.
    pub outer: Option<(usize, f64)>,
    /// How the loops turned out.
    pub trim: Vec<trim::LoopReport>,
    /// How far a loop may be from its rim, in mm.
    pub rim_tolerance: f64,
    /// What could be better, and what to do about it: a sentence each. Options have the
    /// names that they have on the command line.
    pub hints: Vec<String>,
}

impl Conversion {
    /// Whether the face keeps its tolerance. Where it is named, all but the share `outliers`
    /// of the smoothed points must be within it, and as many of the triangles, which the face
    /// may leave by their chord error besides. Where nobody named one, all but as many points
    /// as normal noise has beyond three standard deviations.
    pub fn tolerance_met(&self, outliers: f64) -> bool {
        let outliers = if self.tolerance_named { outliers } else { outliers.max(self.spared) };
        let keeps = |beyond: usize, all: usize| beyond as f64 <= outliers * all as f64;
        let back = &self.face_to_scan;
        keeps(self.missed.points, self.fit_deviation.distances.len())
            && (!self.tolerance_named || keeps(back.beyond, back.triangles))
    }
}

/// The smoothed points that miss the tolerance. A point that a trim loop cuts off is none of
/// them if it is no farther from the loop than a rim is known, and within the tolerance of
/// the surface.
#[derive(Debug, Clone, Copy, Default)]
#[non_exhaustive]
pub struct Missed {
    /// How many.
    pub points: usize,
    /// The distance of the farthest, in mm.
    pub worst: f64,
    /// Where it is.
    pub worst_at: [f64; 3],
}

impl Missed {
    fn scaled(self, factor: f64) -> Self {
        let worst_at = self.worst_at.map(|x| factor * x);
        Missed { worst: factor * self.worst, worst_at, ..self }
    }
}

/// A tolerance that nobody named is no less than this share of the scan's diagonal.
const LEAST_TOLERANCE: f64 = 1e-4;

/// The noise that a tolerance is at least made of. A scan without any tells its surface only as
/// well as flat triangles stand for it: their chord error takes the place of noise.
fn least_noise(mesh: &mesh::Mesh, noise: f64) -> f64 {
    let least = LEAST_TOLERANCE * mesh.diagonal() / adapt::TOLERANCE_OF_NOISE;
    if noise == 0.0 { least.max(mesh.mean_chord_error()) } else { least }
}

/// Converts one component of a scan. `watch` is shown what each stage made, and how far
/// long ones have come; an error of its own stops the conversion.
///
/// The work is shared by rayon's threads. On one of them (within `rayon::scope`) small
/// scans take a tenth less time, since no thread has to be woken for each loop.
///
/// # Errors
/// What stops a stage, or what `watch` answers.
pub fn convert(
    soup: &Soup,
    options: &Options,
    watch: &mut dyn FnMut(Stage) -> Result<()>,
) -> Result<Conversion> {
    let scan = Components::new(mesh::from_soup(soup, options.unit_of(soup))?);
    convert_component(&scan, options, watch)
}

/// Converts one component of a mesh: readers → **mesh → smooth → fill →
/// parameterize → knots → fit → trim → brep** → writers. Many of one mesh share it; its
/// unit is that which it was made with.
///
/// # Errors
/// Those of [`convert`], but for the mesh.
pub fn convert_component(
    scan: &Components,
    options: &Options,
    watch: &mut dyn FnMut(Stage) -> Result<()>,
) -> Result<Conversion> {
    // Sparse factorizations sum in an order that depends on the threads; the
    // same bytes on any number of them matter more.
    faer::set_global_parallelism(faer::Par::Seq);
    let mut shown = lengths::Shown::new(watch, scan.mm());
    let own = options.in_lengths(scan.mm());
    match pipeline(scan, &own, &mut |stage| shown.see(stage)) {
        Ok(conversion) => {
            let conversion = conversion.with_named(options);
            Ok(Conversion { hints: hints::of(&conversion, options), ..conversion })
        }
        Err(error) => Err(shown.in_mm(error).with_named(options)),
    }
}

/// The stages, in the lengths of the scan's mesh, as `options` are and what `watch` is shown
/// up to the fit. What comes out is in mm.
fn pipeline(
    scan: &Components,
    options: &Options,
    watch: &mut dyn FnMut(Stage) -> Result<()>,
) -> Result<Conversion> {
    let mm = scan.mm();
    let (measured, input) = input::disk(scan, options)?;
    watch(Stage::Mesh(&measured))?;

    let (smoothed, smooth) =
        smooth::smooth_with(&measured, &options.smooth, &mut within("smooth", watch))?;
    watch(Stage::Smooth(&smoothed))?;
    let goal = match options.tolerance {
        Some(tolerance) => adapt::Goal {
            tolerance: trim::Options::most_off(tolerance),
            named: true,
            outliers: options.outliers,
        },
        None => adapt::Goal::of_noise(smooth.noise.max(least_noise(&measured.mesh, smooth.noise))),
    };
    let tolerance = options.tolerance.unwrap_or(goal.tolerance);

    let fill_options =
        fill::Options { support: smooth.h, noise: smooth.noise, ..options.fill.clone() };
    let (patch, fill) = fill::fill_with(
        smoothed,
        &measured.mesh.points,
        &fill_options,
        &mut within("fill", watch),
    )?;
    watch(Stage::Fill(&patch))?;

    let (mut map, parameterize) = parameterize::parameterize_with(
        patch,
        &options.parameterize,
        &mut within("parameterize", watch),
    )?;
    let crushed = parameterize::crushed(&map, tolerance, options.knots.max_net);
    watch(Stage::Parameterize(&map, crushed))?;

    let measured_count = map.patch.measured;
    let (surface, fit) = adapt::fit_with(&mut map, options, &goal, &mut within("fit", watch))?;
    let mut surface = surface;
    decimal::surface(&mut surface, measured.mesh.diagonal());
    watch(Stage::Fit(&surface))?;

    let trimmed: Vec<bool> = fill.holes.iter().map(|h| options.cut.cuts(h.rim_length)).collect();
    let rims = cut::rims(&map, &trimmed);
    let trim_options = options.trim(tolerance, &rims);
    let arcs = trim::arcs(&surface, &rims, &trim_options)?;
    // How near edges must be to the surface is a matter of millimetres.
    let placed = surface.clone().scaled(mm);
    let rims: Vec<trim::Rim> = rims.into_iter().map(|rim| rim.scaled(mm)).collect();
    let (loops, trim) = trim::trace(&placed, &rims, arcs);
    let natural = !cut::has_outline(&loops);
    let outer = natural.then(|| outer_boundary(&surface, &map));
    watch(Stage::Trim(&placed, &loops))?;

    let faces = cut::faces(&loops);
    let brep = brep::build(&placed, &faces, &options.name, trim::edge_accuracy(&placed))?;
    watch(Stage::Brep)?;

    let face = deviation::Face::new(&surface, loops.iter().map(|l| l.pcurves.as_slice()), natural);
    let starts = &map.uv[..measured_count];
    let fit_deviation = face.deviation(&map.patch.mesh.points[..measured_count], starts);
    let deviation = face.deviation(&measured.mesh.points, starts);
    let excused = if trim_options.keeps_vertices { 0.0 } else { trim_options.rim };
    let missed = missed(&face, &map, &fit_deviation, tolerance, excused);
    let seen = map.measured_triangles();
    let between = deviation::Between::new(&map.patch.mesh, &seen, &map.uv, &surface);
    let face_to_scan = between.report(tolerance, |at| face.contains(at));
    watch(Stage::Deviation)?;

    Ok(Conversion {
        brep,
        surface: placed,
        loops,
        input,
        smooth: smooth.scaled(mm),
        fill: fill.scaled(mm),
        trimmed,
        parameterize,
        crushed: crushed.map(|crushed| crushed.scaled(mm)),
        fit: fit.scaled(mm),
        tolerance: mm * tolerance,
        tolerance_named: goal.named,
        spared: goal.outliers,
        missed: missed.scaled(mm),
        face_to_scan: face_to_scan.scaled(mm),
        fit_deviation: fit_deviation.scaled(mm),
        deviation: deviation.scaled(mm),
        outer: outer.map(|(control, off)| (control, mm * off)),
        trim,
        rim_tolerance: mm * trim_options.rim,
        hints: Vec::new(),
    })
}

/// The smoothed points that miss the tolerance, but for those that a loop cuts off by no more
/// than `excused`.
fn missed(
    face: &deviation::Face<Surface>,
    map: &Parameterized,
    deviation: &deviation::Deviation,
    tolerance: f64,
    excused: f64,
) -> Missed {
    let distances = &deviation.distances;
    let misses = |&i: &usize| {
        let (p, off) = (map.patch.mesh.points[i], distances[i]);
        off > tolerance
            && (off > excused.hypot(tolerance) || {
                let (at, _) = face.nearest(p, Some(map.uv[i]));
                spline::foot_point(face.surface(), p, at).1 > tolerance
            })
    };
    let all: Vec<usize> = (0..distances.len()).into_par_iter().filter(misses).collect();
    let worst = all.iter().copied().max_by(|&i, &j| distances[i].total_cmp(&distances[j]));
    let worst = worst.map(|i| (distances[i], map.patch.mesh.points[i].coords.into()));
    let (worst, worst_at) = worst.unwrap_or_default();
    Missed { points: all.len(), worst, worst_at }
}

/// What a stage comes farther by is told from this share on.
const STEP: f64 = 0.01;

/// Tells `watch` how far a stage has come: forwards only, and not at every step.
fn within<'a>(
    name: &'static str,
    watch: &'a mut dyn FnMut(Stage) -> Result<()>,
) -> impl FnMut(f64) -> Result<()> + 'a {
    let mut told = 0.0;
    move |share| {
        if share < told + STEP {
            return Ok(());
        }
        told = share.min(1.0);
        watch(Stage::Within(name, told))
    }
}

fn outer_boundary(surface: &Surface, map: &Parameterized) -> (usize, f64) {
    let edges: Vec<_> = brep::outer_edges(surface).into_iter().map(|(edge, _, _)| edge).collect();
    let points: Vec<_> = map.patch.outer.iter().map(|&v| map.patch.mesh.point(v)).collect();
    let control = edges.iter().map(|e| e.control.len()).sum();
    (control, trim::distance_to_edges(&points, &edges))
}
