//! A trimmed face, and the distances of points from it.

use std::fmt;
use std::sync::Arc;

use rayon::prelude::*;

use super::Deviation;
use super::slab_polygon::SlabPolygon;
use crate::geometry::{Point, Uv, bounds};
use crate::spline::chords::chords;
use crate::spline::nearest::{Foot, NearestPlace, NearestSearch};
use crate::spline::{ACCURACY, Curve, EdgeTree, Jet, ParametricSurface, Surface};

/// A surface in a form that is faster to evaluate, if there is one ([`ParametricSurface::fast_form`]).
pub(crate) type FastForm = Option<Arc<dyn ParametricSurface>>;

/// A surface with the loops that trim it. Loops may be nested: holes in the face, islands in the
/// holes, and so on.
pub struct TrimmedFace<'a, S> {
    surface: &'a S,
    /// The same surface in a form that is faster to evaluate, if there is one.
    fast_form: FastForm,
    trim: Trim,
    search: NearestSearch,
}

impl<S: fmt::Debug> fmt::Debug for TrimmedFace<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("TrimmedFace")
            .field("surface", &self.surface)
            .field("trim", &self.trim)
            .finish()
    }
}

/// The trimming loops of a face.
#[derive(Debug)]
struct Trim {
    outlines: Vec<SlabPolygon>,
    /// The periods of the surface.
    periods: [Option<f64>; 2],
    /// Whether a place that no loop surrounds is on the face.
    natural: bool,
    /// The sides of the polygons in space. `sides` has them in the parameter plane, in the same
    /// order.
    edges: EdgeTree,
    sides: Vec<[Uv; 2]>,
}

/// A corner of a polygon: its parameter point and its position in space.
type PolygonCorner = (Uv, Point);

/// A closed polygon that trims a face.
#[derive(Debug, Default)]
pub(crate) struct TrimRing {
    /// Its corners. The first one is not repeated at the end.
    pub corners: Vec<PolygonCorner>,
    /// The corners at which sides begin that are no edges, but lines across the face.
    pub across: Vec<usize>,
}

impl<'a> TrimmedFace<'a, Surface> {
    /// The face that the given loops trim. A face that is `natural` ends where the surface ends;
    /// only the loops of holes and islands are then given. Otherwise the outer loop is given as
    /// well.
    pub fn new<'b>(
        surface: &'a Surface,
        loops: impl Iterator<Item = &'b [Curve<2>]>,
        natural: bool,
    ) -> Self {
        let loops: Vec<&[Curve<2>]> = loops.collect();
        let fast_form = surface.fast_form();
        let breaks = loops.iter().copied().flatten().flat_map(|arc| {
            arc.knots.breaks().into_iter().map(|t| surface.point(Uv::from(arc.point(t))))
        });
        let [low, high] = match natural {
            true => bounds(surface.net.iter().map(|&p| Point::from(p))),
            false => bounds(breaks),
        };
        let chord = ACCURACY * (high - low).norm();
        let rings = loops
            .par_iter()
            .map(|arcs| loop_polygon(evaluated(surface, &fast_form), arcs, chord))
            .map(|corners| TrimRing { corners, across: Vec::new() })
            .collect();
        TrimmedFace::with(surface, fast_form, (rings, natural), [None; 2])
    }

    /// The deviation of points from the face, and the side of the face that each point is on.
    /// `starts` are parameter points near their foot points.
    pub fn deviation(&self, points: &[Point], starts: &[Uv]) -> Deviation {
        self.deviation_and_places(points, starts).0
    }

    /// The deviation of points from the face, as [`TrimmedFace::deviation`] has it, and the parameter
    /// points of the nearest places.
    pub(crate) fn deviation_and_places(
        &self,
        points: &[Point],
        starts: &[Uv],
    ) -> (Deviation, Vec<Uv>) {
        let each = points.par_iter().zip(starts).map(|(&p, &start)| {
            let (best, foot) = self.nearest_and_foot(p, start);
            let is_above = match foot.at == best.at {
                true => is_before(&foot.jet, p),
                false => self.is_above(p, best.at),
            };
            (best.at, (best.distance, is_above))
        });
        let (places, (distances, above)): (Vec<Uv>, (Vec<f64>, Vec<bool>)) = each.unzip();
        (Deviation::of(points, distances).with_sides(above), places)
    }

    /// Whether a point is on the side of the surface's normal at `at`, or on the surface.
    pub(super) fn is_above(&self, p: Point, at: Uv) -> bool {
        is_before(&self.surface.jet(at), p)
    }
}

impl<'a, S: ParametricSurface> TrimmedFace<'a, S> {
    /// The face that closed polygons trim. A place is on the face depending on whether an odd or an
    /// even number of polygons contains it. Without polygons the face is the whole surface. Faces on one
    /// surface may share its fast form. Polygons repeat themselves after the periods of the surface, if it has some.
    pub(crate) fn with(
        surface: &'a S,
        fast_form: FastForm,
        (rings, natural): (Vec<TrimRing>, bool),
        periods: [Option<f64>; 2],
    ) -> Self {
        let trim = Trim::new(&rings, natural, periods);
        let search =
            NearestSearch::new(evaluated(surface, &fast_form), |low, high| trim.leaves(low, high));
        TrimmedFace { surface, fast_form, trim, search }
    }

    /// The untrimmed surface.
    pub fn surface(&self) -> &'a S {
        self.surface
    }

    /// The untrimmed surface in the form that is fastest to evaluate.
    pub(crate) fn evaluated(&self) -> &dyn ParametricSurface {
        evaluated(self.surface, &self.fast_form)
    }

    /// Whether a parameter point of the surface's domain is on the face.
    pub fn contains(&self, at: Uv) -> bool {
        self.trim.contains(at)
    }

    /// Whether the polygon with a number surrounds a parameter point.
    pub(crate) fn surrounds(&self, ring: usize, at: Uv) -> bool {
        self.trim.surrounds(ring, at)
    }

    /// The distance of `p` from the face in mm, as [`TrimmedFace::nearest`] computes it.
    pub fn distance(&self, p: Point, start: Uv) -> f64 {
        self.nearest(p, Some(start)).1
    }

    /// The parameter point of the point of the face nearest to `p`, and its distance in mm. The
    /// distance is exact to 1e-7 of the diagonal of the face, or of the distance if that is larger.
    /// A good `start` reduces the time to a fraction.
    ///
    /// The nearest point is a foot point on the face, or it lies on a trim curve. On a face that
    /// ends where the surface ends it may also lie at this end.
    pub fn nearest(&self, p: Point, start: Option<Uv>) -> (Uv, f64) {
        let start = start.unwrap_or_else(|| self.search.start(p));
        let (best, _) = self.nearest_and_foot(p, start);
        (best.at, best.distance)
    }

    /// The nearest place of the face, and the foot point from which it was found. They are often the same.
    fn nearest_and_foot(&self, p: Point, start: Uv) -> (NearestPlace, Foot) {
        let evaluated = evaluated(self.surface, &self.fast_form);
        let foot = Foot::find(evaluated, p, start);
        let own = NearestPlace { at: foot.at, distance: foot.distance };
        let is_on_face = self.contains(foot.at);
        let mut best = if is_on_face { own } else { self.trim.nearest(p).unwrap_or(own) };
        if !self.search.proves_nearest(p, &foot, best.distance) {
            let edge = if is_on_face { self.trim.nearer_than(best.distance, p) } else { None };
            best = edge.unwrap_or(best);
            best = self.search.improve(evaluated, p, best, &|at| self.contains(at));
        }
        (best, foot)
    }

    /// The corners of a box around the face. `None` if no cell of the surface is on the face.
    pub(crate) fn bounds(&self) -> Option<[Point; 2]> {
        self.search.bounds()
    }
}

impl Trim {
    fn new(rings: &[TrimRing], natural: bool, periods: [Option<f64>; 2]) -> Self {
        let sides = || rings.iter().flat_map(edges);
        let outlines =
            rings.par_iter().map(|ring| SlabPolygon::new(ring.corners.iter().map(|c| c.0)));
        Trim {
            outlines: outlines.collect(),
            periods,
            natural: natural || rings.is_empty(),
            edges: EdgeTree::of_sides(sides().map(|(a, b)| [a.1, b.1])),
            sides: sides().map(|(a, b)| [a.0, b.0]).collect(),
        }
    }

    fn contains(&self, at: Uv) -> bool {
        let around = (0..self.outlines.len()).filter(|&ring| self.surrounds(ring, at)).count();
        around.is_multiple_of(2) == self.natural
    }

    /// Whether a polygon surrounds a parameter point.
    fn surrounds(&self, ring: usize, at: Uv) -> bool {
        let outline = &self.outlines[ring];
        let images = outline.images(self.periods, at, at);
        images.filter(|shift| outline.contains(at + shift)).count() % 2 == 1
    }

    /// Whether a part of the rectangle from `low` to `high` may be on the face.
    fn leaves(&self, low: Uv, high: Uv) -> bool {
        let middle = nalgebra::center(&low, &high);
        let meets = |outline: &SlabPolygon| {
            let mut images = outline.images(self.periods, low, high);
            images.any(|shift| outline.meets(low + shift, high + shift))
        };
        self.outlines.iter().any(meets) || self.contains(middle)
    }

    /// The nearest point of the trim curves.
    fn nearest(&self, p: Point) -> Option<NearestPlace> {
        self.edges.nearest(p).map(|near| self.place(near))
    }

    /// The same if it is nearer than `reach`.
    fn nearer_than(&self, reach: f64, p: Point) -> Option<NearestPlace> {
        self.edges.nearer_than(reach, p).map(|near| self.place(near))
    }

    /// The place of a position along a side, which has this distance.
    fn place(&self, (side, share, distance): (usize, f64, f64)) -> NearestPlace {
        let [a, b] = self.sides[side];
        NearestPlace { at: a + share * (b - a), distance }
    }
}

/// Whether a point is on the side of the surface's normal, or on the surface.
fn is_before(jet: &Jet, p: Point) -> bool {
    (p - jet.s).dot(&jet.su.cross(&jet.sv)) >= 0.0
}

/// The sides of a ring that are edges.
fn edges(ring: &TrimRing) -> impl Iterator<Item = (&PolygonCorner, &PolygonCorner)> {
    let sides = ring.corners.iter().zip(ring.corners.iter().cycle().skip(1));
    let is_edge = |(i, side)| (!ring.across.contains(&i)).then_some(side);
    sides.enumerate().filter_map(is_edge)
}

/// The form of the surface that is evaluated.
fn evaluated<'a, S: ParametricSurface>(
    surface: &'a S,
    fast_form: &'a FastForm,
) -> &'a dyn ParametricSurface {
    fast_form.as_deref().unwrap_or(surface)
}

/// The polygon that approximates a loop.
fn loop_polygon(
    surface: &dyn ParametricSurface,
    arcs: &[Curve<2>],
    chord: f64,
) -> Vec<PolygonCorner> {
    let mut ring = Vec::new();
    for arc in arcs {
        let at = |t: f64| {
            let uv = Uv::from(arc.point(t));
            (uv, surface.point(uv))
        };
        ring.extend(chords(&arc.knots.breaks(), &at, |corner: &PolygonCorner| corner.1, chord));
        ring.pop();
    }
    ring
}
