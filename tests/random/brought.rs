//! Random scans of the kinds that people bring: blocks whose rims were rounded apart, both sides of a plate as a cloud,
//! heights in steps, and tubes with a slit. What `inspect` says of each is known.

use std::fmt::Write;
use std::path::Path;

use proptest::prelude::*;
use serde_json::Value;

use crate::common::random::Random;
use crate::{common, runner, tell};

/// What `inspect` says of a file with a text.
fn inspected(name: &str, text: &str) -> Value {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path: &Path = &folder.path().join(name);
    std::fs::write(path, text).expect("the folder takes it");
    common::inspected(path)
}

fn number(found: &Value, key: &str) -> Result<f64, TestCaseError> {
    found
        .pointer(key)
        .and_then(Value::as_f64)
        .ok_or_else(|| TestCaseError::fail(format!("{key}: {found}")))
}

/// The height of a surface over unit squares.
fn height(x: f64, y: f64) -> f64 {
    3.0 * (0.21 * x).sin() * (0.17 * y).cos()
}

/// The faces of a grid of vertices whose first one has a number.
fn faces(text: &mut String, [m, n]: [usize; 2], first: usize) {
    for (i, j) in (1..m).flat_map(|i| (1..n).map(move |j| (i, j))) {
        let d = first + n * i + j;
        writeln!(text, "f {} {} {d} {}", d - n - 1, d - 1, d - n).expect("memory");
    }
}

#[test]
fn blocks_are_one_sheet() {
    // The numbers of blocks and of squares in each, the size of a square, by what share of it rims are apart, a seed.
    let cases = (2..4_usize, 1..4_usize, 4..9_usize, -1.0..2.0_f64, -9.0..-3.5_f64, any::<u32>());
    let held = runner(12).run(&cases, |(rows, columns, squares, size, apart, seed)| {
        let (size, apart) = (10f64.powf(size), 10f64.powf(apart));
        let mut random = Random(u64::from(seed) + 1);
        let mut text = String::new();
        let (side, mut first) = (squares + 1, 1);
        for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
            for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
                let (x, y) = ((squares * row + i) as f64, (squares * column + j) as f64);
                let [x, y, z] =
                    [x, y, height(x, y)].map(|e| size * (e + apart * (random.share() - 0.5)));
                writeln!(text, "v {x:.15} {y:.15} {z:.15}").expect("memory");
            }
            faces(&mut text, [side, side], first);
            first += side * side;
        }
        let found = inspected("blocks.obj", &text);
        let all = (squares * rows + 1) * (squares * columns + 1);
        prop_assert_eq!(&found["components"], 1, "{}", found);
        prop_assert_eq!(&found["boundary_loops"], 1, "{}", found);
        prop_assert_eq!(&found["vertices"], all, "{}", found);
        prop_assert_eq!(&found["repairs"]["joined_rim_vertices"], first - 1 - all, "{}", found);
        Ok(())
    });
    held.unwrap_or_else(tell);
}

#[test]
fn both_sides_of_a_plate_are_two_sheets() {
    // The thickness in spacings, the noise as a share of it, the spacing, a seed.
    let cases = (1.0..2.5_f64, 0.005..0.06_f64, -1.0..1.0_f64, any::<u32>());
    let held = runner(12).run(&cases, |(thickness, noise, spacing, seed)| {
        let spacing = 10f64.powf(spacing);
        let mut random = Random(u64::from(seed) + 1);
        let (length, width) = (60.0, 40.0);
        let mut text = String::new();
        for n in 0..4800 {
            let [x, y] = [length * random.share(), width * random.share()];
            let slope = 0.63 * (0.21 * x).cos();
            let long = f64::hypot(1.0, slope);
            let side = if n % 2 == 0 { 0.5 } else { -0.5 };
            // Twelve of these have the spread and nearly the shape of a normal error.
            let error = (0..12).map(|_| random.share()).sum::<f64>() - 6.0;
            let off = thickness * (side + noise * error);
            let [x, z] = [x - off * slope / long, 3.0 * (0.21 * x).sin() + off / long];
            let [x, y, z] = [x, y, z].map(|e| spacing * e);
            writeln!(text, "{x:.9} {y:.9} {z:.9}").expect("memory");
        }
        let found = inspected("plate.xyz", &text);
        let layers = number(&found, "/cloud/layers_mm")?;
        let [thickness, noise] = [thickness * spacing, noise * thickness * spacing];
        prop_assert!((layers / thickness - 1.0).abs() < 0.1, "{} of {}", layers, thickness);
        prop_assert_eq!(&found["components"], 2, "{}", found);
        let said = number(&found, "/cloud/noise_mm")?;
        prop_assert!(said < 2.0 * noise + 0.05 * thickness, "{} for {}: {}", said, noise, found);
        Ok(())
    });
    held.unwrap_or_else(tell);
}

#[test]
fn heights_in_steps_are_noise() {
    // The numbers of vertices, the step as a share of the edges, the size of a square.
    let cases = ([40..70_usize, 40..70_usize], 0.1..1.0_f64, -1.0..2.0_f64);
    let held = runner(12).run(&cases, |(size, step, edge)| {
        // Steps of files are round numbers.
        let edge = 10f64.powf(edge);
        let step = ((step * edge * 1e3).round() / 1e3).max(1e-3);
        let mut text = String::new();
        for (i, j) in (0..size[0]).flat_map(|i| (0..size[1]).map(move |j| (i, j))) {
            let z = step * (edge * (height(i as f64, j as f64) + 0.11 * j as f64) / step).round();
            writeln!(text, "v {:.6} {:.6} {z:.6}", edge * i as f64, edge * j as f64)
                .expect("memory");
        }
        faces(&mut text, size, 1);
        let found = inspected("steps.obj", &text);
        prop_assert!(found["exact"].is_null(), "{}", found);
        let noise = number(&found, "/noise_mm")?;
        prop_assert!(noise >= 0.99 * step / 12f64.sqrt(), "{} at steps of {}", noise, step);
        prop_assert!(noise < 2.0 * step, "{} at steps of {}", noise, step);
        Ok(())
    });
    held.unwrap_or_else(tell);
}

#[test]
fn tubes_with_a_slit_are_no_solids() {
    // The vertices around and along, the slit as a share of the turn, the radius in edges along, the noise in edges, a seed.
    let cases =
        (24..60_usize, 20..60_usize, 0.01..0.25_f64, -1.0..2.0_f64, 0.0..0.05_f64, any::<u32>());
    let held = runner(12).run(&cases, |(around, along, slit, radius, noise, seed)| {
        let radius = 10f64.powf(radius);
        let mut random = Random(u64::from(seed) + 1);
        let turn = std::f64::consts::TAU * (1.0 - slit);
        let edge = radius * turn / (around - 1) as f64;
        let mut text = String::new();
        for (i, j) in (0..around).flat_map(|i| (0..along).map(move |j| (i, j))) {
            let angle = turn * i as f64 / (around - 1) as f64;
            let r = radius + 2.0 * noise * edge * (random.share() - 0.5);
            let z = edge * j as f64;
            writeln!(text, "v {:.9} {:.9} {z:.9}", r * angle.cos(), r * angle.sin())
                .expect("memory");
        }
        faces(&mut text, [around, along], 1);
        let found = inspected("tube.obj", &text);
        prop_assert_ne!(&found["shape"], "solid", "{}", found);
        prop_assert_eq!(&found["boundary_loops"], 1, "{}", found);
        Ok(())
    });
    held.unwrap_or_else(tell);
}
