//! Whatever comes in, out comes a face that is sound, or an error that says why not:
//! random scans of every kind of damage, at any size and place, with random options.
//!
//! The same cases every time, unless `PROPTEST_RNG_SEED` and `PROPTEST_CASES` name
//! others. What they once found is in `found.rs`.

mod choices;
#[cfg(feature = "cli")]
mod command;
#[path = "../common/mod.rs"]
mod common;
mod found;
mod judge;
mod loose;
mod places;
mod scan;
mod sheet;

use choices::Choices;
use formats::Soup;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestError, TestRunner};
use scan::Scan;
use scan2step::Options;

/// Random cases, always the same ones; `PROPTEST_CASES` and `PROPTEST_RNG_SEED` ask
/// for others.
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

/// Fails with the smallest case that was found.
fn tell<T: std::fmt::Debug>(found: TestError<T>) {
    match found {
        TestError::Fail(why, case) => panic!("{why}\n{case:?}"),
        TestError::Abort(why) => panic!("{why}"),
    }
}

/// Holds that every scan becomes a sound face or an error, and one that is `whole` no
/// error of a stage; and that no smaller share than `least` become faces.
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
        let became = judge::hung(format!("{scan:?}"), || judge::sound(&soup, &options, whole));
        faces.set(faces.get() + u32::from(became?));
        Ok(())
    });
    held.unwrap_or_else(tell);
    println!("{} of {} became faces", faces.get(), tried.get());
    let share = f64::from(faces.get()) / f64::from(tried.get());
    assert!(share > least, "{} of {}", faces.get(), tried.get());
}

#[test]
fn sheets_with_damage_of_every_kind() {
    let soup = |scan: &Scan| (scan.soup(), Options::default());
    // All 70 do.
    hold(70, 0.95, scan::damaged(), Scan::is_whole, soup);
}

#[test]
fn any_options_for_any_sheet() {
    let scans = (scan::damaged(), choices::any());
    let soup = |(scan, choices): &(Scan, _)| (scan.soup(), Choices::options(choices, scan));
    // Options may ask for what cannot be: 39 of 70 become faces.
    hold(70, 0.5, scans, |_| false, soup);
}

#[test]
fn meshes_of_a_few_triangles() {
    let scans = (scan::tiny(), choices::any());
    let soup = |(scan, choices): &(Scan, _)| (scan.soup(), Choices::options(choices, scan));
    // 141 of 250 do.
    hold(250, 0.5, scans, |_| false, soup);
}

#[test]
fn polygons_between_any_points() {
    let held = runner(250).run(&loose::polygons(), |soup| {
        judge::hung(format!("{soup:?}"), || judge::sound(&soup, &Options::default(), false))?;
        Ok(())
    });
    held.unwrap_or_else(tell);
}
