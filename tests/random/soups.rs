//! Random polygon soups, whose points may be anywhere or not finite.

use formats::Soup;
use proptest::prelude::*;

/// Soups of up to 40 polygons.
pub fn polygons() -> impl Strategy<Value = Soup> {
    let points = prop::collection::vec(prop::array::uniform3(coordinate()), 1..16);
    let polygons = prop::collection::vec(prop::collection::vec(0..16_u32, 0..6), 0..40);
    // Some polygons refer to points that do not exist.
    let beyond = prop::bool::weighted(0.05).prop_map(u32::from);
    (points, polygons, beyond).prop_map(|(points, polygons, beyond)| {
        let count = points.len() as u32 + beyond;
        let mut soup = Soup { points, ..Soup::default() };
        polygons.iter().for_each(|p| soup.polygons.push(p.iter().map(|k| k % count)));
        soup
    })
}

fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        12 => (0..4_u8).prop_map(f64::from),
        6 => -1.0..1.0,
        1 => prop::num::f64::ANY,
    ]
}
