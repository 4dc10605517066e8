//! A network of four-sided surfaces that share their sides.

use rayon::prelude::*;

use super::{Curve, Surface};
use crate::geometry::{Point, Uv, Vector};

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

    /// The angles between the normals of the two surfaces at places along every track, in radians.
    /// There are `places` of them inside each span of a track, and they come track by track.
    pub fn seam_angles(&self, places: usize) -> Vec<f64> {
        let mut sides = vec![Vec::new(); self.tracks.len()];
        for (face, of_face) in self.sides.iter().enumerate() {
            for (k, side) in of_face.iter().enumerate() {
                sides[side.track].push((face, k, side.forward));
            }
        }
        let angles = |(track, uses): (&Track, &Vec<(usize, usize, bool)>)| {
            let [a, b] = uses[..] else { return Vec::new() };
            let knots = track.curve.knots.breaks();
            let inside = knots.windows(2).flat_map(|span| {
                let share = |i: usize| (i as f64 + 0.5) / places as f64;
                (0..places).map(move |i| span[0] + share(i) * (span[1] - span[0]))
            });
            inside.map(|t| self.side_normal(a, t).angle(&self.side_normal(b, t))).collect()
        };
        self.tracks.par_iter().zip(&sides).map(angles).flatten_iter().collect()
    }

    /// The normal of a surface at a parameter of the track along one of its sides.
    fn side_normal(&self, (face, k, forward): (usize, usize, bool), t: f64) -> Vector {
        let surface = &self.surfaces[face];
        let end = surface.u.range().1;
        let along = if forward { t } else { end - t };
        let at = match k {
            0 => Uv::new(along, 0.0),
            1 => Uv::new(end, along),
            2 => Uv::new(end - along, end),
            _ => Uv::new(0.0, end - along),
        };
        let jet = surface.jet(at);
        jet.su.cross(&jet.sv)
    }
}
