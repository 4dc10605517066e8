//! A surface that stands for a face whose kind is not known, with distances of points from it.

use super::foot::Foot;
use super::nearest::{NearestPlace, NearestSearch};
use super::{ParametricSurface, Surface};
use crate::geometry::{Point, Uv, Vector};

/// A surface with a search for the nearest places on it.
pub struct SplineSheet {
    surface: Surface,
    fast_form: Option<Box<dyn ParametricSurface>>,
    search: NearestSearch,
    within: f64,
    chord_error: f64,
}

impl std::fmt::Debug for SplineSheet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SplineSheet").field("surface", &self.surface).finish_non_exhaustive()
    }
}

impl SplineSheet {
    /// A surface that was fitted to the vertices of a mesh. All of them are within so many mm of it, and between them the
    /// mesh leaves the surface by about `chord_error` mm.
    pub fn new(surface: Surface, within: f64, chord_error: f64) -> Self {
        let fast_form = surface.fast_form();
        let search = NearestSearch::new(fast_form.as_deref().unwrap_or(&surface), |_, _| true);
        SplineSheet { surface, fast_form, search, within, chord_error }
    }

    /// The surface, in mm.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// The largest distance in mm of the points to which it was fitted.
    pub fn within(&self) -> f64 {
        self.within
    }

    /// How far a mesh through the points is from the surface, in mm: what it does not tell.
    pub fn chord_error(&self) -> f64 {
        self.chord_error
    }

    fn evaluated(&self) -> &dyn ParametricSurface {
        self.fast_form.as_deref().unwrap_or(&self.surface)
    }

    /// The parameters of the nearest place.
    pub(crate) fn nearest(&self, p: Point) -> Uv {
        let surface = self.evaluated();
        let foot = Foot::find(surface, p, self.search.start(p));
        if self.search.proves_nearest(p, &foot, foot.distance) {
            return foot.at;
        }
        let best = NearestPlace { at: foot.at, distance: foot.distance };
        self.search.improve(surface, p, best, &|_| true).at
    }

    /// The signed distance of a point from the tangent plane at the nearest place, and the unit normal there. The
    /// distance is positive on the side of the normal, which is that of the derivatives in u and in v.
    pub(crate) fn distance(&self, p: Point) -> (f64, Vector) {
        let jet = self.evaluated().jet(self.nearest(p));
        let normal = jet.su.cross(&jet.sv).try_normalize(0.0).unwrap_or_else(Vector::z);
        ((p - jet.s).dot(&normal), normal)
    }

    /// The nearest point.
    pub(crate) fn closest(&self, p: Point) -> Point {
        self.evaluated().jet(self.nearest(p)).s
    }

    /// The largest absolute curvature next to a point, in 1/mm.
    pub(crate) fn curvature(&self, p: Point) -> f64 {
        self.evaluated().jet(self.nearest(p)).largest_curvature()
    }
}
