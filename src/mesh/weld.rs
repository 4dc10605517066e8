//! Merges vertices at the same place.

use std::hash::BuildHasher;
use std::sync::atomic::{AtomicU32, Ordering};

use foldhash::fast::FixedState;
use formats::Soup;
use hashbrown::HashTable;
use rayon::prelude::*;

use super::build::{Repairs, count};
use super::edge_map::Buckets;
use crate::geometry::{NONE, Point, ROUNDING, bounds};

/// Points with a coordinate beyond this, in mm, are treated like infinite ones. Products of larger
/// coordinates overflow.
const FARTHEST: f64 = 1e60;

/// The number of points of which a table is made at a time.
const BUCKET: usize = 1 << 14;

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
    let step = rounding(soup, mm) * factor;
    // Adding zero turns −0 into +0.
    let positive = |x: f64| x + 0.0;
    let place = |p: &[f64; 3]| Point::from(p.map(|x| positive(x * factor)));
    let rounded = |p: &[f64; 3]| place(p).coords.map(|x| positive((x / step).round()));
    let hash = |p: &[f64; 3]| {
        let bits: [u64; 3] = rounded(p).map(f64::to_bits).into();
        FixedState::default().hash_one(bits)
    };
    let hashes: Vec<u64> = soup.points.par_iter().map(hash).collect();
    // Points at one place are in one bucket, whose table the cache of a core holds.
    let buckets = soup.points.len().div_ceil(BUCKET).max(1);
    let bucket = |i: u32| (hashes[i as usize] % buckets as u64) as u32;
    let by_hash = Buckets::new(buckets, soup.points.len(), bucket);
    // Each point is in one bucket, so no two threads write to the same entry.
    let first: Vec<AtomicU32> = soup.points.par_iter().map(|_| NONE.into()).collect();
    let find = |seen: &mut HashTable<u32>, bucket: usize| {
        seen.clear();
        for &i in by_hash.of(bucket) {
            let p = &soup.points[i as usize];
            if is_usable(p, mm) {
                let same = |&j: &u32| {
                    hashes[j as usize] == hashes[i as usize]
                        && rounded(&soup.points[j as usize]) == rounded(p)
                };
                let entry = seen.entry(hashes[i as usize], same, |&j| hashes[j as usize]);
                first[i as usize].store(*entry.or_insert(i).get(), Ordering::Relaxed);
            }
        }
    };
    (0..buckets).into_par_iter().for_each_init(HashTable::new, find);
    let mut welded = Welded { points: Vec::new(), number: Vec::with_capacity(soup.points.len()) };
    let mut nowhere = 0;
    for (i, (p, first)) in soup.points.iter().zip(first).enumerate() {
        let number = match first.into_inner() {
            NONE => {
                nowhere += 1;
                NONE
            }
            first if first as usize == i => {
                welded.points.push(place(p));
                welded.points.len() as u32 - 1
            }
            first => welded.number[first as usize],
        };
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
