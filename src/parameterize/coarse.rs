//! Corners, and a first map, on a coarse version of the patch.

use super::hierarchy::Hierarchy;
use super::layout::{Layout, Round, heavy, triangles};
use super::rectangle::Rectangle;
use super::stars::{Removal, Stars};
use super::stretch;
use super::weights::Weights;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::geometry::{Point, Uv};
use crate::progress;

/// A coarse version of the patch, its vertices numbered anew.
pub struct Coarse {
    points: Vec<Point>,
    stars: Stars,
    outer: Vec<u32>,
    weights: Weights,
    round: Round,
}

/// A map of the coarse version.
pub struct First {
    /// Which of the sets of corners it has.
    pub set: usize,
    /// Width and height of the rectangle, in mm.
    pub size: [f64; 2],
    /// The vertices' places in it, in the order of those left.
    pub at: Vec<Uv>,
    /// Its L² stretch, a skirt left out.
    pub stretch: f64,
    /// The share of the energy's convex term that it was made with.
    pub round: Round,
    /// The share of it that is stretched more than [`DRAWN`] one way.
    drawn: f64,
}

/// Triangles are drawn out if the map stretches them so many times as much one way as the
/// other.
const DRAWN: f64 = 6.0;

/// A map of more drawn-out triangles than this share of its area is made again, firmer:
/// in finer ones they would take ever more of it.
const MUCH: f64 = 0.1;

/// The map that stretches least of those whose corners are one of the `sets`,
/// on the mesh that is left in a hierarchy; a firmer one if that draws much of it out.
/// `outer` is its finest boundary.
pub fn least_stretched(
    points: &[Point],
    outer: &[u32],
    hierarchy: &Hierarchy,
    weights: &Weights,
    sets: &[[u32; 4]],
) -> Result<First> {
    let (stars, number) = hierarchy.stars.renumbered(&hierarchy.left);
    let outer = outer.iter().map(|&v| number[v as usize]).filter(|&v| v != u32::MAX);
    let mut coarse = Coarse {
        points: hierarchy.left.iter().map(|&v| points[v as usize]).collect(),
        stars,
        outer: outer.collect(),
        weights: weights.renumbered(&hierarchy.left),
        round: Round::USUAL,
    };
    let sets: Vec<[u32; 4]> = sets.iter().map(|set| set.map(|v| number[v as usize])).collect();
    let usual = coarse.best(&sets)?;
    if usual.drawn <= MUCH {
        return Ok(usual);
    }
    coarse.round = Round::FIRM;
    coarse.best(&sets)
}

impl Coarse {
    /// The map that stretches least.
    fn best(&self, sets: &[[u32; 4]]) -> Result<First> {
        let maps = sets.par_iter().enumerate().map(|(i, set)| self.map(i, set));
        let maps: Vec<Result<First>> = maps.collect();
        let least = |a: Result<First>, b: Result<First>| match (&a, &b) {
            (Ok(one), Ok(two)) if two.stretch.total_cmp(&one.stretch).is_lt() => b,
            (Err(_), Ok(_)) => b,
            _ => a,
        };
        // Where no set has a map, the first says why.
        maps.into_iter().reduce(least).unwrap_or(Err(Error::TooSmall(self.outer.len())))
    }

    /// The map with the given vertices as corners.
    fn map(&self, set: usize, corners: &[u32; 4]) -> Result<First> {
        let mut hierarchy = Hierarchy::new(self.stars.clone());
        let mut kept = vec![false; self.points.len()];
        corners.iter().for_each(|&v| kept[v as usize] = true);
        let area = stretch::area(&self.points, triangles(&self.stars, &hierarchy.left));
        let mut weights = self.weights.clone();
        let lump = |removal: &Removal| weights.lump(removal);
        hierarchy.coarsen(&self.points, &kept, 0, lump, &mut progress::ignore)?;
        let left = |v: &u32| !hierarchy.stars.ring(*v).is_empty();
        let few: Vec<u32> = self.outer.iter().copied().filter(left).collect();
        let rectangle = Rectangle::new(&few, corners);
        let mut at = vec![Uv::origin(); self.points.len()];
        let size = rectangle.lay(&self.points, area, &mut at);
        let freedom = Rectangle::new(&self.outer, corners).freedom(at.len());
        let (points, weighed) = (&self.points, self.points.len());
        let round = self.round;
        let mut layout = Layout { points, weights, weighed, freedom, size, at, round };
        layout.solve(&hierarchy)?;
        layout.refine(&mut hierarchy, &mut progress::ignore)?;
        let all = || heavy(&layout.weights, triangles(&hierarchy.stars, &hierarchy.left));
        let stretch = stretch::of(&self.points, &layout.at, all());
        let drawn = stretch::drawn_out(&self.points, &layout.at, all(), DRAWN);
        Ok(First { set, size: layout.size, at: layout.at, stretch, round, drawn })
    }
}
