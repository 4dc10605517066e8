//! Random scans with every kind of damage, of any size and at any place, with random options.
//!
//! Every scan must become a valid face or an error that says why it does not. The cases are the
//! same in every run, unless `PROPTEST_RNG_SEED` and `PROPTEST_CASES` ask for others. They are
//! few, so that nobody has to wait: `benches/random` tries more. `regressions.rs` has cases that
//! failed once.

#[cfg(feature = "cli")]
mod brought;
mod choices;
#[cfg(feature = "cli")]
mod command;
#[path = "../common/mod.rs"]
mod common;
mod oracle;
mod places;
mod regressions;
mod scan;
mod sheet;
mod soups;

use choices::Choices;
use formats::Soup;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestError, TestRunner};
use scan::Scan;
use scan2step::Options;

/// Random cases. They are the same in every run, unless `PROPTEST_CASES` and `PROPTEST_RNG_SEED`
/// ask for others.
fn runner(cases: u32) -> TestRunner {
    let mut config =
        Config { failure_persistence: None, max_shrink_iters: 300, ..Config::default() };
    if std::env::var_os("PROPTEST_CASES").is_none() {
        config.cases = cases;
    }
    if config.rng_seed == RngSeed::Random {
        config.rng_seed = RngSeed::Fixed(9);
    }
    TestRunner::new(config)
}

/// Fails with the smallest failing case.
fn tell<T: std::fmt::Debug>(found: TestError<T>) {
    match found {
        TestError::Fail(why, case) => panic!("{why}\n{case:?}"),
        TestError::Abort(why) => panic!("{why}"),
    }
}

/// Checks that every scan becomes a valid face or an error, and that no stage refuses a scan for
/// which `is_whole` holds. A share of more than `least` of the scans must become faces.
fn hold<T: std::fmt::Debug>(
    cases: u32,
    least: f64,
    scans: impl Strategy<Value = T>,
    is_whole: impl Fn(&T) -> bool,
    soup: impl Fn(&T) -> (Soup, Options),
) {
    let faces = std::cell::Cell::new(0);
    let tried = std::cell::Cell::new(0);
    let held = runner(cases).run(&scans, |scan| {
        tried.set(tried.get() + 1);
        let (soup, options) = soup(&scan);
        let whole = is_whole(&scan);
        let became =
            oracle::within_time(format!("{scan:?}"), || oracle::sound(&soup, &options, whole));
        faces.set(faces.get() + u32::from(became?));
        Ok(())
    });
    held.unwrap_or_else(tell);
    println!("{} of {} became faces", faces.get(), tried.get());
    let share = f64::from(faces.get()) / f64::from(tried.get());
    assert!(share > least, "{} of {}", faces.get(), tried.get());
}

fn splines() -> Options {
    choices::splines().build().expect("options")
}

#[test]
fn sheets_with_damage_of_every_kind() {
    let soup = |scan: &Scan| (scan.soup(), splines());
    // All scans become faces. So did 70 of 70.
    hold(20, 0.95, scan::damaged(), Scan::is_whole, soup);
}

#[test]
fn any_options_for_any_sheet() {
    let scans = (scan::damaged(), choices::any());
    let soup = |(scan, choices): &(Scan, _)| (scan.soup(), Choices::options(choices, scan));
    // Options may ask for the impossible. 42 of 70 scans become faces.
    hold(20, 0.5, scans, |_| false, soup);
}

#[test]
fn meshes_of_a_few_triangles() {
    let scans = (scan::tiny(), choices::any());
    let soup = |(scan, choices): &(Scan, _)| (scan.soup(), Choices::options(choices, scan));
    // 141 of 250 scans become faces.
    hold(70, 0.5, scans, |_| false, soup);
}

#[test]
fn polygons_between_any_points() {
    let held = runner(70).run(&soups::polygons(), |soup| {
        oracle::within_time(format!("{soup:?}"), || oracle::sound(&soup, &splines(), false))?;
        Ok(())
    });
    held.unwrap_or_else(tell);
}
