//! The places of a network that are nearest to points and face their way.

use rayon::prelude::*;

use crate::geometry::{Point, Uv, Vector};
use crate::mesh::FacingPlaces;
use crate::spline::{Network, SAMPLES_PER_SPAN, foot_point};

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
    samples: FacingPlaces<NetworkPlace>,
}

impl<'a> NetworkPlaces<'a> {
    /// Builds the structure.
    pub(super) fn new(network: &'a Network) -> Self {
        let of_face = |(face, surface): (usize, &crate::spline::Surface)| {
            let sample = |at: Uv| {
                let jet = surface.jet(at);
                (NetworkPlace { face, at }, jet.s, jet.su.cross(&jet.sv))
            };
            surface.middles(SAMPLES_PER_SPAN).into_iter().map(sample).collect::<Vec<_>>()
        };
        let all = network.surfaces.par_iter().enumerate().map(of_face).flatten_iter().collect();
        NetworkPlaces { network, samples: FacingPlaces::new(all) }
    }

    /// The place nearest to `p` whose normal does not point against `normal`. `None` if none of the
    /// nearest samples faces that way.
    pub(crate) fn nearest(&self, p: Point, normal: Vector) -> Option<NetworkPlace> {
        // One start on each surface is enough, and the nearest comes first.
        let mut starts: Vec<NetworkPlace> = Vec::new();
        for place in self.samples.facing(p, normal) {
            if starts.iter().all(|start| start.face != place.face) {
                starts.push(place);
            }
        }
        let feet = starts.into_iter().map(|start| {
            let (at, distance) = foot_point(&self.network.surfaces[start.face], p, start.at);
            (distance, NetworkPlace { face: start.face, at })
        });
        feet.min_by(|a, b| a.0.total_cmp(&b.0)).map(|foot| foot.1)
    }

    /// The surface of the nearest sample, whichever way it faces.
    pub(crate) fn nearest_surface(&self, p: Point) -> usize {
        self.samples.nearest(p).map_or(0, |place| place.face)
    }
}
