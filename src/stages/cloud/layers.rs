//! Layers: two sides of a thin wall, or scans that are not registered. Points of different layers are never
//! neighbours, however near they are.
//!
//! Where the file has normals, or the places of several scanners, points that face opposite ways are in different
//! layers. Without them, points are in two layers where they lie on two quadrics with nothing between, and where
//! that is so at most places.

use rayon::prelude::*;

use super::nearest_lists::NearestLists;
use super::two_layers::TwoLayers;
use crate::geometry::{Point, SAMPLE, Vector};
use crate::mesh::Neighbours;
use crate::statistics::median;

/// A place is looked at with so many times as many points as one layer asks for: the other layer has as many, and
/// may be as far away as the points reach.
pub(super) const AROUND: usize = 4;

/// Normals are those of a surface with two sides, and do not face any way, if this share of the points that face
/// the opposite way is on one side. Half of them is if normals have no side.
pub(super) const ONE_SIDE: f64 = 0.9;

/// How points are told from those of another layer.
enum Distinction {
    /// There is one layer.
    None,
    /// The direction that each point faces, or zero.
    Facing(Vec<Vector>),
    /// By their heights.
    Heights,
}

/// Points with their layers.
pub(super) struct Layers<'a> {
    points: &'a [Point],
    near: &'a Neighbours,
    distinction: Distinction,
    /// The distance of the layers; `None` if there is one.
    pub distance: Option<f64>,
}

/// Working memory of a search.
#[derive(Default)]
pub(super) struct LayerSearch {
    found: Vec<(u32, f64)>,
    places: Vec<Point>,
    /// The points that were found.
    pub list: Vec<u32>,
}

impl<'a> Layers<'a> {
    /// Looks for layers among the neighbourhoods of `count` points. `facing` has the direction in which each point
    /// faces, if that is known.
    pub(super) fn new(
        points: &'a [Point],
        near: &'a Neighbours,
        facing: Option<Vec<Vector>>,
        count: usize,
    ) -> Self {
        let mut layers = Layers { points, near, distinction: Distinction::None, distance: None };
        let by_facing = facing.as_ref().and_then(|facing| layers.between_opposite(facing, count));
        if by_facing.is_some() {
            layers.distinction = Distinction::Facing(facing.unwrap_or_default());
            layers.distance = by_facing;
            return layers;
        }
        layers.distance = layers.between_heights(count);
        if layers.distance.is_some() {
            layers.distinction = Distinction::Heights;
        }
        layers
    }

    /// Lists the `count` nearest points of the layer of point `i`, nearest first. Where it has fewer, some are there
    /// repeatedly.
    pub(super) fn list(&self, i: usize, count: usize, search: &mut LayerSearch) {
        let own = self.points[i];
        let LayerSearch { found, places, list } = search;
        let around = if self.distance.is_some() { AROUND } else { 1 };
        self.near.nearest_n(own, around * count + 1, found);
        let is_upper = match (&self.distinction, self.distance) {
            (Distinction::Heights, Some(distance)) => {
                let nearer = found.partition_point(|f| f.1 < distance.powi(2));
                let two = self.two_layers(own, found, places).map(|two| two.is_upper);
                if two.is_none() && nearer > count {
                    // What is nearer than the other layer is in this one.
                    found.truncate(nearer);
                }
                two
            }
            _ => None,
        };
        let is_own = |j: u32| j as usize == i;
        let at = found.iter().position(|f| is_own(f.0));
        let is_same = |k: usize| match (&self.distinction, &is_upper, at) {
            (Distinction::Facing(facing), ..) => facing[i].dot(&facing[found[k].0 as usize]) >= 0.0,
            (_, Some(is_upper), Some(at)) => is_upper[k] == is_upper[at],
            _ => true,
        };
        let others = || (0..found.len()).filter(|&k| !is_own(found[k].0));
        list.clear();
        list.extend(others().filter(|&k| is_same(k)).map(|k| found[k].0));
        if list.is_empty() {
            list.extend(others().map(|k| found[k].0));
        }
        let own_ones = list.len();
        for k in own_ones..count {
            list.push(list[k % own_ones]);
        }
        list.truncate(count);
    }

    fn two_layers(
        &self,
        own: Point,
        found: &[(u32, f64)],
        places: &mut Vec<Point>,
    ) -> Option<TwoLayers> {
        let radius = found.last()?.1.sqrt();
        places.clear();
        places.extend(found.iter().map(|&(j, _)| self.points[j as usize]));
        TwoLayers::new(own, radius, places)
    }

    /// The distance between points that face opposite ways, if they are on one side of each other: behind each
    /// other in a wall, before each other in a gap.
    fn between_opposite(&self, facing: &[Vector], count: usize) -> Option<f64> {
        let heights = |search: &mut LayerSearch, i: usize| {
            self.list(i, count, search);
            let opposite = |&&j: &&u32| facing[i].dot(&facing[j as usize]) < 0.0;
            let height = |&j: &u32| (self.points[j as usize] - self.points[i]).dot(&facing[i]);
            search.list.iter().filter(opposite).map(height).collect::<Vec<f64>>()
        };
        let numbers: Vec<usize> = self.sample().collect();
        let heights: Vec<Vec<f64>> =
            numbers.into_par_iter().map_init(LayerSearch::default, heights).collect();
        let mut heights: Vec<f64> = heights.into_iter().flatten().collect();
        let behind = heights.iter().filter(|&&h| h < 0.0).count() as f64 / heights.len() as f64;
        heights.iter_mut().for_each(|h| *h = h.abs());
        let distance = median(&mut heights)?;
        (behind >= ONE_SIDE || 1.0 - behind >= ONE_SIDE).then_some(distance)
    }

    /// The distance between the layers, if there are two at most places.
    fn between_heights(&self, count: usize) -> Option<f64> {
        let distance = |search: &mut LayerSearch, i: usize| {
            self.near.nearest_n(self.points[i], AROUND * count + 1, &mut search.found);
            let LayerSearch { found, places, .. } = search;
            self.two_layers(self.points[i], found, places).map(|layers| layers.distance)
        };
        let numbers: Vec<usize> = self.sample().collect();
        let looked_at = numbers.len();
        let found: Vec<Option<f64>> =
            numbers.into_par_iter().map_init(LayerSearch::default, distance).collect();
        let mut found: Vec<f64> = found.into_iter().flatten().collect();
        (2 * found.len() > looked_at).then(|| median(&mut found)).flatten()
    }

    /// Some of the points, evenly spaced.
    fn sample(&self) -> impl Iterator<Item = usize> + use<> {
        (0..self.points.len()).step_by(self.points.len().div_ceil(SAMPLE).max(1))
    }
}

/// Says whether two points are in one layer.
pub(super) type AreJoined<'a> = dyn Fn(usize, u32) -> bool + Sync + 'a;

/// Whether two points are in one layer: one is a neighbour of the other, or they have one in common.
pub(super) fn are_joined(lists: &NearestLists, i: u32, j: u32) -> bool {
    let (of_i, of_j) = (lists.of(i as usize), lists.of(j as usize));
    of_i.contains(&j) || of_j.contains(&i) || of_i.iter().any(|k| of_j.contains(k))
}
