//! Selects the corners and computes a first map, on a coarse version of the patch.

use super::rectangle::Rectangle;
use super::rectangle_map::{ConvexWeight, RectangleMap, triangles, without_scaffold};
use super::stretch;
use super::weights::Weights;
use crate::mesh::one_rings::{HalfEdgeCollapse, OneRings};
use crate::mesh::progressive_mesh::{Collapsing, ProgressiveMesh, shape_loss};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::geometry::{NONE, Point, Uv};
use crate::progress;

/// A coarse version of the patch with renumbered vertices.
pub(crate) struct Coarse {
    points: Vec<Point>,
    rings: OneRings,
    outer: Vec<u32>,
    weights: Weights,
    convex_weight: ConvexWeight,
}

/// A map of the coarse version.
pub(crate) struct CoarseLayout {
    /// The position of its corners in the list of corner sets.
    pub set: usize,
    /// The width and the height of the rectangle, in mm.
    pub size: [f64; 2],
    /// The positions of the remaining vertices in the rectangle, in their order.
    pub at: Vec<Uv>,
    /// The L² stretch without the scaffold.
    pub stretch: f64,
    /// The weight of the convex energy term with which the map was made.
    pub convex_weight: ConvexWeight,
    /// The share of its area with a ratio of stretches above [`STRONG_STRETCH`].
    stretched_share: f64,
}

/// A triangle is strongly stretched if the map stretches it by this factor more in one direction
/// than in the other.
const STRONG_STRETCH: f64 = 6.0;

/// If strongly stretched triangles cover more than this share of the map, it is recomputed with a
/// larger weight of the convex term. On finer meshes such triangles would take ever more of the
/// area.
const MAX_STRETCHED_SHARE: f64 = 0.1;

/// The map with the least stretch among those with one of the corner `sets`, on the coarsest mesh
/// of a hierarchy. It is recomputed with a larger weight of the convex term if strongly stretched
/// triangles cover much of it. `outer` is the boundary of the finest mesh.
pub(crate) fn least_stretched(
    points: &[Point],
    outer: &[u32],
    hierarchy: &ProgressiveMesh,
    weights: &Weights,
    sets: &[[u32; 4]],
) -> Result<CoarseLayout> {
    let (rings, number) = hierarchy.rings.renumbered(&hierarchy.remaining);
    let outer = outer.iter().map(|&v| number[v as usize]).filter(|&v| v != NONE);
    let mut coarse = Coarse {
        points: hierarchy.remaining.iter().map(|&v| points[v as usize]).collect(),
        rings,
        outer: outer.collect(),
        weights: weights.renumbered(&hierarchy.remaining),
        convex_weight: ConvexWeight::USUAL,
    };
    let sets: Vec<[u32; 4]> = sets.iter().map(|set| set.map(|v| number[v as usize])).collect();
    let usual = coarse.best(&sets)?;
    if usual.stretched_share <= MAX_STRETCHED_SHARE {
        return Ok(usual);
    }
    coarse.convex_weight = ConvexWeight::FIRM;
    coarse.best(&sets)
}

impl Coarse {
    /// The map with the least stretch.
    fn best(&self, sets: &[[u32; 4]]) -> Result<CoarseLayout> {
        let maps = sets.par_iter().enumerate().map(|(i, set)| self.map(i, set));
        let maps: Vec<Result<CoarseLayout>> = maps.collect();
        let least = |a: Result<CoarseLayout>, b: Result<CoarseLayout>| match (&a, &b) {
            (Ok(one), Ok(two)) if two.stretch.total_cmp(&one.stretch).is_lt() => b,
            (Err(_), Ok(_)) => b,
            _ => a,
        };
        // If no set of corners gives a map, the error of the first set is returned.
        maps.into_iter().reduce(least).unwrap_or(Err(Error::TooSmall(self.outer.len())))
    }

    /// The map with the given vertices as corners.
    fn map(&self, set: usize, corners: &[u32; 4]) -> Result<CoarseLayout> {
        let mut hierarchy = ProgressiveMesh::new(self.rings.clone());
        let mut kept = vec![false; self.points.len()];
        corners.iter().for_each(|&v| kept[v as usize] = true);
        let area = stretch::area(&self.points, triangles(&self.rings, &hierarchy.remaining));
        let mut weights = self.weights.clone();
        let lump = |collapse: &HalfEdgeCollapse| weights.lump(collapse);
        let loss = |rings: &OneRings, v| shape_loss(&self.points, rings, v);
        let collapsing = Collapsing { points: &self.points, kept: &kept, loss };
        hierarchy.coarsen(&collapsing, 0, lump, &mut progress::ignore)?;
        let remaining = |v: &u32| !hierarchy.rings.ring(*v).is_empty();
        let few: Vec<u32> = self.outer.iter().copied().filter(remaining).collect();
        let rectangle = Rectangle::new(&few, corners);
        let mut at = vec![Uv::origin(); self.points.len()];
        let size = rectangle.lay(&self.points, area, &mut at);
        let freedom = Rectangle::new(&self.outer, corners).freedom(at.len());
        let (points, weighed) = (&self.points, self.points.len());
        let convex_weight = self.convex_weight;
        let mut layout =
            RectangleMap { points, weights, weighed, freedom, size, at, convex_weight };
        layout.solve(&hierarchy)?;
        layout.refine(&mut hierarchy, &mut progress::ignore)?;
        let all =
            || without_scaffold(&layout.weights, triangles(&hierarchy.rings, &hierarchy.remaining));
        let stretch = stretch::of(&self.points, &layout.at, all());
        let stretched_share = stretch::drawn_out(&self.points, &layout.at, all(), STRONG_STRETCH);
        Ok(CoarseLayout {
            set,
            size: layout.size,
            at: layout.at,
            stretch,
            convex_weight,
            stretched_share,
        })
    }
}
