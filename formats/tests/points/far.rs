//! Clouds far from zero keep every digit.

use crate::support::{cloud, places};

/// A fraction with many digits that a coordinate of this size can hold.
fn digits(i: u64) -> f64 {
    (i * 0x9e37_79b9 % 1_000_003) as f64 / 1_048_576.0
}

fn sheet(at: [f64; 3], extent: f64) -> Vec<[f64; 3]> {
    (0..200).map(|i| [0, 1, 2].map(|k| at[k] + extent * digits(3 * i + k as u64))).collect()
}

fn text(points: &[[f64; 3]]) -> String {
    points.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect()
}

#[test]
fn every_bit_comes_back() {
    for (at, extent) in [
        ([400_000.0, 5_800_000.0, 100.0], 1.0),
        ([400_000.0, 5_800_000.0, 100.0], 300.0),
        ([-400_000.0, -5_800_000.0, 0.0], 7.0),
        ([5.8e9, 0.0, -4e8], 1000.0),
        ([1e18, -1e18, 0.0], 1e3),
        ([-5e5, -5e5, -5e5], 1e6),
        ([0.0; 3], 1.0),
        ([0.0; 3], 1e300),
    ] {
        let points = sheet(at, extent);
        assert_eq!(places(&cloud("scan.xyz", text(&points))), points, "{at:?} {extent}");
    }
}

#[test]
fn the_origin_is_a_round_number_near_the_middle() {
    let far = cloud("scan.xyz", text(&sheet([400_000.25, 5_800_000.5, 0.0], 100.0)));
    // Taking the last one off would round.
    assert_eq!(far.origin, [400_000.0, 5_800_000.0, 0.0]);
    let greatest = far.positions.iter().flatten().fold(0.0, |a: f64, x| a.max(x.abs()));
    assert!(greatest <= 1000.0, "{greatest}");
}

/// A part that was moved by a survey's coordinates has the same positions to the last bit: the
/// digits of the file are taken off, not the numbers that the processor makes of them.
#[test]
fn decimals_are_the_same_anywhere() {
    let number = |i: u64| (i * 0x9e37_79b9 % 1_000_003) as i64 - 500_000;
    for (whole, digits) in [([400_000, 5_800_000, 100], 6), ([-4_000_000, 58_000_000, 0], 3)] {
        let power = 10i64.pow(digits);
        let text = |moved: [i64; 3]| {
            let coordinate = |i: u64, k: usize| {
                let number = number(3 * i + k as u64) + moved[k] * power;
                let sign = if number < 0 { "-" } else { "" };
                let (before, after) = (number.abs() / power, number.abs() % power);
                format!("{sign}{before}.{after:0width$}", width = digits as usize)
            };
            let line = |i| [0, 1, 2].map(|k| coordinate(i, k)).join(" ") + "\n";
            (0..200).map(line).collect::<String>()
        };
        let [near, far] = [[0; 3], whole].map(|moved| cloud("scan.xyz", text(moved)));
        assert_eq!((near.origin, far.origin), ([0.0; 3], whole.map(|x| x as f64)));
        assert_eq!(near.positions, far.positions);
    }
}

#[test]
fn a_cloud_near_zero_stays() {
    for (at, extent) in [([50.0, 20.0, 0.0], 1.0), ([1e5, 0.0, 0.0], 1e4)] {
        assert_eq!(cloud("scan.xyz", text(&sheet(at, extent))).origin, [0.0; 3]);
    }
}

#[test]
fn a_cloud_that_moved_is_the_same_but_for_its_origin() {
    // Eighths can be moved exactly.
    let near: Vec<[f64; 3]> =
        (0..100).map(|i| [i % 10, i / 10, i % 7].map(|n| f64::from(n) / 8.0)).collect();
    let far: Vec<[f64; 3]> =
        near.iter().map(|p| [p[0] + 4e5, p[1] + 5.8e6, p[2] + 100.0]).collect();
    let [near, far] = [near, far].map(|points| cloud("scan.xyz", text(&points)));
    for (a, b) in near.positions.iter().zip(&far.positions) {
        let moved = [0, 1, 2].map(|k| b[k] + far.origin[k] - [4e5, 5.8e6, 100.0][k]);
        assert_eq!(*a, moved);
    }
}
