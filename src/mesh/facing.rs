//! Places on surfaces, searched by nearness and by the way they face.

use super::Neighbours;
use crate::geometry::{Point, Vector};

/// Places with their points and normals.
pub(crate) struct FacingPlaces<P> {
    places: Vec<(P, Vector)>,
    tree: Neighbours,
}

/// The numbers of nearest places among which those are chosen that face some way. On a thin wall half of
/// the first ones may belong to its other side. Only where none of them faces that way are more looked at.
const CANDIDATES: [usize; 2] = [16, 256];

impl<P: Copy> FacingPlaces<P> {
    /// Builds the search structure.
    pub(crate) fn new(samples: Vec<(P, Point, Vector)>) -> Self {
        let points: Vec<Point> = samples.iter().map(|sample| sample.1).collect();
        let places = samples.into_iter().map(|(place, _, normal)| (place, normal)).collect();
        FacingPlaces { places, tree: Neighbours::new(&points) }
    }

    /// Those of the places near `p` whose normals do not point against `normal`, the nearest first.
    pub(crate) fn facing(&self, p: Point, normal: Vector) -> Vec<P> {
        let mut found = Vec::new();
        let mut among = |count: usize| {
            self.tree.nearest_n(p, count, &mut found);
            let near = found.iter().map(|&(k, _)| &self.places[k as usize]);
            near.filter(|place| place.1.dot(&normal) > 0.0).map(|place| place.0).collect()
        };
        let first: Vec<P> = among(CANDIDATES[0]);
        if first.is_empty() { among(CANDIDATES[1]) } else { first }
    }

    /// The place nearest to `p`, whichever way it faces.
    pub(crate) fn nearest(&self, p: Point) -> Option<P> {
        let mut found = Vec::new();
        self.tree.nearest_n(p, 1, &mut found);
        found.first().map(|&(k, _)| self.places[k as usize].0)
    }
}
