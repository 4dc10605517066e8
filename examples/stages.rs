//! Calls every stage by hand, as `scan2step::convert` does. Use this to look at the output of a
//! stage, to change it, or to insert another stage.
//!
//! cargo run --release --example stages
//!
//! The example makes a wavy sheet of 60 × 40 mm with noise and a round hole, and a STEP file of it
//! in memory. The bytes are the same as those of `convert`. It prints a line for each stage.

use std::error::Error;

use formats::{Brep, Soup, step};
use scan2step::deviation::TrimmedFace;
use scan2step::mesh::{self, Choice, Components, Outer};
use scan2step::stages::adapt::{self, Goal};
use scan2step::stages::{brep, fill, parameterize, smooth, trim};
use scan2step::{Options, convert, cut};

/// The standard deviation of the noise, and the tolerance, in mm.
const NOISE: f64 = 0.02;
const TOLERANCE: f64 = 3.0 * NOISE;

fn main() -> Result<(), Box<dyn Error>> {
    // Mesh: vertices at the same place become one, faults are repaired, and a component is chosen.
    // From here on, lengths are those of the scan times a power of two. One such unit is `mm`
    // millimetres.
    let pieces = Components::new(mesh::from_soup(&scan(), 1.0)?);
    let mm = pieces.mm();
    let mut repairs = pieces.repairs().clone();
    let measured = pieces.take(Choice::Largest)?.into_own_disk(Outer::Auto, &mut repairs)?;
    println!("mesh: {} vertices, {} hole", measured.mesh.points.len(), measured.holes.len());

    // Smoothing leaves nothing small, so that a dense scan has more vertices than needed. It is thinned before,
    // unless the user names a tolerance, which holds at every point: `smooth::examine` and its outlook tell what
    // `thin::thin` may remove, and `smoothed_part` smooths the vertices that stay. From two million vertices on,
    // `thin::average` comes before all of this.
    let (smoothed, smoothing) = smooth::smooth(&measured, &smooth::Options::default())?;
    println!("smooth: noise {:.3} mm, support {:.1} mm", mm * smoothing.noise, mm * smoothing.h);

    let how =
        fill::Options { support: smoothing.h, noise: smoothing.noise, ..fill::Options::default() };
    let (patch, filling) = fill::fill(smoothed, &measured.mesh.points, &how)?;
    println!("fill: {} triangles", filling.holes[0].added_triangles);

    let how = parameterize::Options::default();
    let (mut map, mapping) = parameterize::parameterize(patch, &how)?;
    println!("parameterize: stretch {:.2}", mapping.stretch.l2);

    // Knots and fit are repeated until the goal is reached. `knots::place` and `fit::fit` are the
    // single steps. Without a tolerance, use `Goal::of_scan`.
    let tolerance = TOLERANCE / mm;
    let goal = Goal::named(tolerance, 0.0);
    let (surface, fitting) = adapt::fit(&mut map, &adapt::Options::default(), &goal)?;
    let surface = surface.rounded(measured.mesh.diagonal());
    let [m, n] = surface.shape();
    println!("fit: {m} × {n} control points after {} fits", fitting.rounds);

    // The loops are found on the surface and traced on it in mm, because the accuracy of edges is a
    // number of mm.
    let cut_out = vec![true; filling.holes.len()];
    let rims = cut::rims(&map, &cut_out);
    let how =
        trim::Options::of_rims(rims.iter().map(|rim| rim.points.as_slice()), tolerance, goal.named);
    let arcs = trim::arcs(&surface, &rims, &how)?;
    let placed = surface.clone().scaled(mm);
    let rims: Vec<trim::Rim> = rims.into_iter().map(|rim| rim.scaled(mm)).collect();
    let (loops, _) = trim::trace(&placed, &rims, arcs);
    println!("trim: {} loop of {} edges", loops.len(), loops[0].edges.len());

    let faces = cut::faces(&loops);
    let brep = brep::build(&placed, &faces, "sheet", trim::edge_accuracy(&placed))?;
    let file = step_file(&brep)?;
    println!("write: {} bytes", file.len());

    let arcs = loops.iter().map(|l| l.pcurves.as_slice());
    let face = TrimmedFace::new(&surface, arcs, !cut::has_outline(&loops));
    // The deviations of the smoothed points, to which the goal applies, and of the measured points.
    let count = map.patch.measured;
    let smoothed = face.deviation(&map.patch.mesh.points[..count], &map.uv[..count]);
    let measured_off = face.deviation(&measured.mesh.points, &map.uv[..count]);
    let [smoothed_max, measured_max] = [smoothed.max, measured_off.max].map(|off| mm * off);
    println!("deviation: at most {smoothed_max:.4} mm, measured {measured_max:.4} mm");

    assert_eq!((measured.holes.len(), filling.holes.len(), loops.len()), (1, 1, 1));
    assert!((0.5..1.5).contains(&(mm * smoothing.noise / NOISE)), "the noise is found");
    assert!(smoothed_max <= TOLERANCE, "the goal is reached");
    let options = Options::builder().name("sheet").tolerance(TOLERANCE).build()?;
    let at_once = convert(&scan(), &options, &mut |_| Ok(()))?;
    assert!(file == step_file(&at_once.parts[0].brep)?, "`convert` makes the same bytes");
    Ok(())
}

fn step_file(brep: &Brep) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut file = Vec::new();
    step::write(brep, &step::Options::default(), &mut file)?;
    Ok(file)
}

/// The sheet as a soup of polygons. The polygons may be squares.
fn scan() -> Soup {
    let (columns, rows) = (61, 41);
    let mut soup = Soup::default();
    let mut noise = noise();
    for k in 0..columns * rows {
        let (x, y) = (f64::from(k % columns), f64::from(k / columns));
        let z = 2.0 * (0.12 * x).sin() * (0.1 * y).cos();
        soup.points.push([x, y, z + NOISE * noise()]);
    }
    for k in 0..(columns - 1) * (rows - 1) {
        let (i, j) = (k % (columns - 1), k / (columns - 1));
        let (x, y) = (f64::from(i) - 34.5, f64::from(j) - 18.5);
        if x.hypot(y) > 7.0 {
            let a = j * columns + i;
            soup.polygons.push([a, a + 1, a + columns + 1, a + columns]);
        }
    }
    soup
}

/// Deterministic noise with the standard deviation 1: the sum of twelve uniform random numbers.
fn noise() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    let mut even = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    move || (0..12).map(|_| even()).sum::<f64>() - 6.0
}
