//! Vertices at the same place become one.

use std::hash::BuildHasher;

use foldhash::fast::FixedState;
use formats::Soup;
use hashbrown::HashTable;

use super::build::{Repairs, count};
use crate::geometry::Point;

/// The number in [`Welded::number`] of a point that is of no use.
pub(super) const NOWHERE: u32 = u32::MAX;

/// Coordinates beyond this, in mm, are as bad as infinite ones: their products
/// overflow.
const FARTHEST: f64 = 1e60;

/// Whether a point has a place, if its unit is so many `mm`.
pub(super) fn is_usable(p: &[f64; 3], mm: f64) -> bool {
    // NaN is no less than anything.
    p.iter().all(|x| (x * mm).abs() < FARTHEST)
}

/// The places of a soup's points.
pub(super) struct Welded {
    /// In the lengths of the pipeline, each once, in the order of the file.
    pub(super) points: Vec<Point>,
    /// For each point of the soup the number of its place, or [`NOWHERE`].
    pub(super) number: Vec<u32>,
}

/// Multiplies the points, whose unit is so many `mm`, by a power of two, and finds those
/// that coincide: bit for bit, but that −0 is 0.
pub(super) fn weld(soup: &Soup, mm: f64, factor: f64, repairs: &mut Repairs) -> Welded {
    let mut welded = Welded { points: Vec::new(), number: Vec::with_capacity(soup.points.len()) };
    let hash = |p: &Point| FixedState::default().hash_one([p.x, p.y, p.z].map(f64::to_bits));
    // A surface has half as many places as triangles.
    let places = soup.points.len().min(soup.polygons.len());
    let mut seen: HashTable<u32> = HashTable::with_capacity(places);
    let mut nowhere = 0;
    for p in &soup.points {
        if !is_usable(p, mm) {
            nowhere += 1;
            welded.number.push(NOWHERE);
            continue;
        }
        // Adding zero makes −0 and +0 the same place.
        let p = Point::from(p.map(|x| x * factor + 0.0));
        let points = &mut welded.points;
        let same = |&i: &u32| points[i as usize] == p;
        let entry = seen.entry(hash(&p), same, |&i| hash(&points[i as usize]));
        let number = *entry.or_insert(points.len() as u32).get();
        if number as usize == points.len() {
            points.push(p);
        }
        welded.number.push(number);
    }
    count(repairs, "non_finite_vertices", nowhere);
    let (all, places) = (soup.points.len(), welded.points.len());
    count(repairs, "welded_vertices", all - nowhere - places);
    welded
}
