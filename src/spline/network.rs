//! A network of four-sided surfaces that share their sides.

use super::{Curve, Surface};
use crate::geometry::Point;

/// Surfaces over squares whose sides are shared curves.
///
/// All surfaces and tracks have the same knot vector. The outer rows of a surface's control net are
/// the control points of its tracks, so both are the same polynomials.
#[derive(Debug, Clone, Default)]
pub struct Network {
    /// The surfaces, in mm. Their normals point outwards.
    pub surfaces: Vec<Surface>,
    /// The four sides of each surface, counter-clockwise from its corner at the low ends of u and v.
    pub sides: Vec<[Side; 4]>,
    /// The curves on which sides lie, in mm.
    pub tracks: Vec<Track>,
    /// The corners of the surfaces.
    pub corners: Vec<Point>,
}

/// A curve between two corners that two surfaces share.
#[derive(Debug, Clone)]
pub struct Track {
    /// The curve.
    pub curve: Curve<3>,
    /// The corners at its start and at its end, as positions in [`Network::corners`].
    pub ends: [usize; 2],
}

/// A side of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Side {
    /// The track, as a position in [`Network::tracks`].
    pub track: usize,
    /// Whether the track runs counter-clockwise around the surface.
    pub forward: bool,
}

impl Network {
    /// The network with all lengths multiplied by a factor.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.surfaces = self.surfaces.into_iter().map(|s| s.scaled(factor)).collect();
        self.corners.iter_mut().for_each(|p| *p *= factor);
        for track in &mut self.tracks {
            track.curve.control.iter_mut().for_each(|p| *p *= factor);
        }
        self
    }
}
