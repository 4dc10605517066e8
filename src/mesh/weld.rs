//! Merges vertices at the same place.

use std::hash::BuildHasher;

use foldhash::fast::FixedState;
use formats::Soup;
use hashbrown::HashTable;

use super::build::{Repairs, count};
use crate::geometry::{NONE, Point, ROUNDING, bounds};

/// Points with a coordinate beyond this, in mm, are treated like infinite ones. Products of larger
/// coordinates overflow.
const FARTHEST: f64 = 1e60;

/// Whether a point can be used, if its unit is `mm` millimetres long.
pub(super) fn is_usable(p: &[f64; 3], mm: f64) -> bool {
    // The comparison is false for NaN.
    p.iter().all(|x| (x * mm).abs() < FARTHEST)
}

/// The distinct places of a soup's points.
pub(super) struct Welded {
    /// The places in the pipeline's unit of length, without repetition, in the order of the file.
    pub(super) points: Vec<Point>,
    /// For each point of the soup the number of its place, or [`NONE`].
    pub(super) number: Vec<u32>,
}

/// Scales the points by a power of two and finds those that coincide. Points coincide if their
/// coordinates, rounded to a tiny share of the extent, are equal. Each place has the coordinates of its
/// first point. The unit of the soup is `mm` millimetres long.
pub(super) fn weld(soup: &Soup, mm: f64, factor: f64, repairs: &mut Repairs) -> Welded {
    let mut welded = Welded { points: Vec::new(), number: Vec::with_capacity(soup.points.len()) };
    let step = rounding(soup, mm) * factor;
    // Adding zero turns −0 into +0.
    let positive = |x: f64| x + 0.0;
    let rounded = |p: &Point| [p.x, p.y, p.z].map(|x| positive((x / step).round()));
    let hash = |p: &Point| FixedState::default().hash_one(rounded(p).map(f64::to_bits));
    // A surface has about half as many vertices as triangles.
    let places = soup.points.len().min(soup.polygons.len());
    let mut seen: HashTable<u32> = HashTable::with_capacity(places);
    let mut nowhere = 0;
    for p in &soup.points {
        if !is_usable(p, mm) {
            nowhere += 1;
            welded.number.push(NONE);
            continue;
        }
        let p = Point::from(p.map(|x| positive(x * factor)));
        let points = &mut welded.points;
        let same = |&i: &u32| rounded(&points[i as usize]) == rounded(&p);
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

/// The step to which coordinates are rounded, in relation to the largest extent.
fn rounding(soup: &Soup, mm: f64) -> f64 {
    let usable = soup.points.iter().filter(|p| is_usable(p, mm)).map(|p| Point::from(*p));
    let [low, high] = bounds(usable);
    (ROUNDING * (high - low).max()).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_that_differ_by_rounding_are_one() {
        let points = vec![[0.0, 1.0, 2.0], [-3e-17, 1.0, 2.0], [1e-6, 1.0, 2.0], [0.0, 1.0, 3.0]];
        let soup = Soup { points, ..Soup::default() };
        let mut repairs = Repairs::default();
        let welded = weld(&soup, 1.0, 1.0, &mut repairs);
        assert_eq!(welded.number, [0, 0, 1, 2]);
        assert_eq!(repairs.get("welded_vertices"), Some(&1));
    }
}
