//! The noise along the normal against the true one.

use super::*;

#[test]
fn the_noise_along_the_normal_is_measured() {
    for noise in [0.01, 0.1, 0.5] {
        let cloud = relief([200, 200], noise, |x, y| Some(hills(x, y)));
        let ratio = mesh(&cloud).noise / noise;
        println!("noise {noise}: {ratio} of it measured");
        // The slopes of the hills take a few percent off what is along the ray.
        assert!((0.9..1.03).contains(&ratio), "noise {noise}: {ratio}");
    }
    // Displacements along a tilted plane are no noise.
    let mut random = Random(2);
    let plane = scan(100, 100, |(row, column)| {
        let x = column as f64 + 0.2 * random.normal();
        Some([x, row as f64 + 0.2 * random.normal(), 2.0 * x])
    });
    let noise = mesh(&plane).noise;
    assert!(noise < 1e-9, "{noise}");
}

#[test]
fn steps_are_no_noise() {
    let ratio = mesh(&plateau(6.0)).noise / 0.2;
    assert!((0.9..1.03).contains(&ratio), "{ratio}");
}

#[test]
fn flat_patches_of_a_scanner_with_coarse_steps_are_left_out() {
    // Steps of 0.5 in depth, on a slope with one step in ten units.
    let cloud = relief([200, 200], 0.0, |x, y| Some(0.5 * (0.1 * x + 0.02 * y).round()));
    let noise = mesh(&cloud).noise;
    println!("steps of 0.5: noise {noise}");
    // A uniform error within a step has a deviation of 0.29 steps.
    assert!((0.05..0.2).contains(&noise), "{noise}");
}
