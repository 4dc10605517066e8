//! The places of a network that are nearest to points and face their way.

use rayon::prelude::*;

use crate::geometry::{Point, Uv, Vector};
use crate::mesh::Neighbours;
use crate::spline::{Network, foot_point};

/// The number of samples of each span in u and in v, from which the search for a foot point starts.
const SAMPLES: usize = 3;

/// The numbers of nearest samples among which those are chosen that face the way of the point. On a
/// thin wall half of the first ones may belong to its other side. Only where none of them faces that
/// way are more looked at.
const CANDIDATES: [usize; 2] = [16, 256];

/// A place of a network.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NetworkPlace {
    /// The surface.
    pub face: usize,
    /// The parameter point.
    pub at: Uv,
}

/// A search structure over samples of a network.
pub(crate) struct NetworkPlaces<'a> {
    network: &'a Network,
    samples: Vec<(NetworkPlace, Vector)>,
    tree: Neighbours,
}

impl<'a> NetworkPlaces<'a> {
    /// Builds the structure.
    pub fn new(network: &'a Network) -> Self {
        let of_face = |(face, surface): (usize, &crate::spline::Surface)| {
            let sample = |at: Uv| {
                let jet = surface.jet(at);
                (NetworkPlace { face, at }, jet.su.cross(&jet.sv), jet.s)
            };
            surface.middles(SAMPLES).into_iter().map(sample).collect::<Vec<_>>()
        };
        let all: Vec<_> =
            network.surfaces.par_iter().enumerate().map(of_face).flatten_iter().collect();
        let points: Vec<Point> = all.iter().map(|sample| sample.2).collect();
        let samples = all.into_iter().map(|(place, normal, _)| (place, normal)).collect();
        NetworkPlaces { network, samples, tree: Neighbours::new(&points) }
    }

    /// The place nearest to `p` whose normal does not point against `normal`. `None` if none of the
    /// nearest samples faces that way.
    pub(crate) fn nearest(&self, p: Point, normal: Vector) -> Option<NetworkPlace> {
        CANDIDATES.into_iter().find_map(|count| self.nearest_among(count, p, normal))
    }

    /// The surface of the nearest sample, whichever way it faces.
    pub(crate) fn nearest_surface(&self, p: Point) -> usize {
        let mut found = Vec::new();
        self.tree.nearest_n(p, 1, &mut found);
        found.first().map_or(0, |&(k, _)| self.samples[k as usize].0.face)
    }

    fn nearest_among(&self, count: usize, p: Point, normal: Vector) -> Option<NetworkPlace> {
        let mut found = Vec::new();
        self.tree.nearest_n(p, count, &mut found);
        let samples = found.iter().map(|&(k, _)| &self.samples[k as usize]);
        let facing = samples.filter(|sample| sample.1.dot(&normal) > 0.0).map(|sample| sample.0);
        // One start on each surface is enough, and the nearest comes first.
        let mut starts: Vec<NetworkPlace> = Vec::new();
        for place in facing {
            if starts.iter().all(|start| start.face != place.face) {
                starts.push(place);
            }
        }
        let feet = starts.into_iter().map(|start| {
            let surface = &self.network.surfaces[start.face];
            let (at, _) = foot_point(surface, p, start.at);
            let distance = (surface.point(at) - p).norm();
            (distance, NetworkPlace { face: start.face, at })
        });
        feet.min_by(|a, b| a.0.total_cmp(&b.0)).map(|foot| foot.1)
    }
}
