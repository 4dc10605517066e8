//! A network of four-sided surfaces that share their sides.

use rayon::prelude::*;

use super::{Curve, Surface};
use crate::geometry::{Point, Quarter, Uv, Vector};

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
    pub(crate) fn scaled(mut self, factor: f64) -> Self {
        self.surfaces = self.surfaces.into_iter().map(|s| s.scaled(factor)).collect();
        self.corners.iter_mut().for_each(|p| *p *= factor);
        for track in &mut self.tracks {
            track.curve.control.iter_mut().for_each(|p| *p *= factor);
        }
        self
    }

    /// Places along every track, with the angles between the two surfaces. There are `places` of them inside
    /// each span of a track, and they come track by track.
    pub fn seams(&self, places: usize) -> Vec<SeamPlace> {
        let of_track = |(track, uses): (&Track, &Vec<SideUse>)| {
            let [a, b] = uses[..] else { return Vec::new() };
            let place = |t: f64| {
                let angle = self.side_normal(a, t).angle(&self.side_normal(b, t));
                SeamPlace { face: a.face, at: a.place(self.end(), t, 0.0), angle }
            };
            track.curve.knots.middles(places).into_iter().map(place).collect()
        };
        self.tracks.par_iter().zip(&self.uses()).map(of_track).flatten_iter().collect()
    }

    /// The corners at which other than four surfaces meet.
    pub fn irregular(&self) -> Vec<Point> {
        let mut count = vec![0; self.corners.len()];
        for (face, k) in (0..4 * self.sides.len()).map(|side| (side / 4, side % 4)) {
            count[self.corner(face, k)] += 1;
        }
        let corners = self.corners.iter().zip(count);
        corners.filter(|of| of.1 != 4).map(|of| *of.0).collect()
    }

    /// The surfaces on the two sides of each track.
    pub(crate) fn uses(&self) -> Vec<Vec<SideUse>> {
        let mut uses = vec![Vec::with_capacity(2); self.tracks.len()];
        for (face, sides) in self.sides.iter().enumerate() {
            for (k, side) in sides.iter().enumerate() {
                uses[side.track].push(SideUse { face, k, forward: side.forward });
            }
        }
        uses
    }

    /// The highest parameter of all surfaces and tracks. The lowest one is 0.
    pub fn end(&self) -> f64 {
        self.surfaces.first().map_or(0.0, |surface| surface.u.range().1)
    }

    /// The corner at which side `k` of a surface starts.
    pub(crate) fn corner(&self, face: usize, k: usize) -> usize {
        let side = self.sides[face][k];
        self.tracks[side.track].ends[usize::from(!side.forward)]
    }

    /// The normal of a surface at a parameter of the track along one of its sides.
    fn side_normal(&self, side: SideUse, t: f64) -> Vector {
        let jet = self.surfaces[side.face].jet(side.place(self.end(), t, 0.0));
        jet.su.cross(&jet.sv)
    }
}

/// A place on a seam between two surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeamPlace {
    /// One of the surfaces.
    pub face: usize,
    /// The place on it.
    pub at: Uv,
    /// The angle between the normals of the two surfaces, in radians.
    pub angle: f64,
}

/// A surface beside a track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SideUse {
    /// The surface.
    pub face: usize,
    /// The number of its side.
    pub k: usize,
    /// Whether the track runs counter-clockwise around the surface.
    pub forward: bool,
}

impl SideUse {
    /// The parameter point at parameter `t` of the track, and at `depth` from the side towards the
    /// inside. `end` is the highest parameter.
    pub(crate) fn place(&self, end: f64, t: f64, depth: f64) -> Uv {
        let along = if self.forward { t } else { end - t };
        Quarter(self.k).turned(end, [along, depth]).into()
    }

    /// The inverse of `place`: the parameter of the track, and the depth.
    pub(crate) fn along_and_depth(&self, end: f64, at: Uv) -> (f64, f64) {
        let [along, depth] = Quarter(self.k).turned_back(end, at.into());
        (if self.forward { along } else { end - along }, depth)
    }
}
