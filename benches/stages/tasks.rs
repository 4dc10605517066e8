//! The measured tasks.

use crate::body::OneFace;
use std::fmt::Display;
use std::hint::black_box;
use std::time::Duration;

use cpu_time::ProcessTime;
use criterion::{BatchSize, Bencher};
use scan2step::stages::{fill, fit, knots, parameterize, smooth, trim};
use scan2step::{Stage, convert};

use crate::cpu::CpuTime;
use crate::prepared::{Prepared, read};

/// Measures one stage of a scan.
pub type Task = fn(&mut Bencher<CpuTime>, &Prepared);

/// The stages in their order, and the whole conversion.
pub const TASKS: [(&str, Task); 12] = [
    ("read", |b, p| run(b, || p.ply.clone(), read)),
    ("mesh", |b, p| run(b, || (), |()| p.disk())),
    ("smooth", |b, p| {
        b.iter_with_large_drop(|| smooth::smooth(&p.measured, &smooth::Options::default()))
    }),
    ("fill", |b, p| {
        let points = &p.measured.mesh.points;
        run(b, || p.smoothed.clone(), |disk| fill::fill(disk, points, &p.fill));
    }),
    ("parameterize", |b, p| {
        let options = &parameterize::Options::default();
        run(b, || p.patch.clone(), |patch| parameterize::parameterize(patch, options));
    }),
    ("knots", |b, p| b.iter_with_large_drop(|| knots::place(&p.samples, &p.knots))),
    ("fit", |b, p| {
        run(b, || p.net(), |net| fit::fit(&p.samples, net, fit::Method::Refined));
    }),
    ("knots-and-fits", knots_and_fits),
    ("trim", |b, p| {
        run(b, || (), |()| trim::trim(&p.conversion.one().surface, &p.rims, &p.trim));
    }),
    ("deviation", |b, p| b.iter_with_large_drop(|| p.deviation())),
    ("brep-and-write", |b, p| run(b, || (), |()| p.step())),
    ("convert", |b, p| run(b, || (), |()| convert(&p.soup, &p.options, &mut |_| Ok(())))),
];

/// Measures a stage that may fail. A failure ends the run, because its time has no meaning. The
/// input is prepared and the output is dropped outside of the measurement.
fn run<I, O, E: Display>(
    bencher: &mut Bencher<CpuTime>,
    given: impl FnMut() -> I,
    mut stage: impl FnMut(I) -> Result<O, E>,
) {
    bencher.iter_batched(given, |input| ended(stage(input)), BatchSize::PerIteration);
}

/// All knots and fits of a whole run until the tolerance is satisfied: the time from the end of the
/// parameterization to the end of the last fit.
fn knots_and_fits(bencher: &mut Bencher<CpuTime>, prepared: &Prepared) {
    bencher.iter_custom(|count| {
        let mut total = Duration::ZERO;
        for _ in 0..count {
            let mut begun = ProcessTime::now();
            black_box(ended(convert(&prepared.soup, &prepared.options, &mut |stage| {
                match stage {
                    Stage::Parameterize(..) => begun = ProcessTime::now(),
                    Stage::Fit(_) => total += begun.elapsed(),
                    _ => {}
                }
                Ok(())
            })));
        }
        total
    });
}

/// Returns the result or ends the program.
pub fn ended<T, E: Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| {
        eprintln!("error: {error}");
        std::process::exit(1)
    })
}
