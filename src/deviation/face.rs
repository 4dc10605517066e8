//! A trimmed face, and how far from it points are.

use rayon::prelude::*;
use rstar::RTree;

use super::Deviation;
use super::outline::{Outline, Side};
use crate::geometry::{Point, Uv};
use crate::spline::{Curve, Patch, Surface, foot_point, for_many_looks};

/// A surface and the loops that trim it: holes cut out of it, islands left in
/// them, and so on.
#[derive(Debug)]
pub struct Face<'a, S> {
    surface: &'a S,
    outlines: Vec<Outline>,
    /// Whether the surface itself is the face where no loop runs around.
    natural: bool,
    rims: RTree<Side>,
}

/// Chords a knot span of a trim loop.
const CHORDS: usize = 16;

impl<'a> Face<'a, Surface> {
    /// The face that loops trim: those of holes and of islands and, unless the
    /// face is `natural` and goes as far as the surface, the outer one.
    pub fn new<'b>(
        surface: &'a Surface,
        loops: impl Iterator<Item = &'b [Curve<2>]>,
        natural: bool,
    ) -> Self {
        let chords = |arcs: &[Curve<2>]| chords(surface, arcs);
        Face::of_rings(surface, loops.map(chords).collect(), natural)
    }

    /// The deviation of points whose parameter points are given.
    pub fn deviation(&self, points: &[Point], starts: &[Uv]) -> Deviation {
        let each = points.par_iter().zip(starts);
        let surface = for_many_looks(self.surface);
        let distance =
            |(&p, &start): (&Point, &Uv)| self.off_foot(p, foot_point(&*surface, p, start));
        Deviation::of(points, each.map(distance).collect())
    }
}

impl<'a, S: Patch> Face<'a, S> {
    /// The face that closed polygons trim; each corner is given by its parameter
    /// point and its place on the surface. Between an odd number of them and an
    /// even one the face ends.
    pub fn of_rings(surface: &'a S, rings: Vec<Vec<(Uv, Point)>>, natural: bool) -> Self {
        let sides = rings.iter().flat_map(|ring| {
            let nexts = ring.iter().cycle().skip(1);
            ring.iter().zip(nexts).map(|(a, b)| Side { ends: [a.1, b.1] })
        });
        let rims = RTree::bulk_load(sides.collect());
        let outlines = rings.iter().map(|ring| Outline::new(ring.iter().map(|c| c.0))).collect();
        Face { surface, outlines, natural, rims }
    }

    /// The surface that is trimmed.
    pub fn surface(&self) -> &'a S {
        self.surface
    }

    /// Whether a parameter point of the surface's domain is on the face.
    pub fn contains(&self, at: Uv) -> bool {
        let around = self.outlines.iter().filter(|outline| outline.contains(at)).count();
        around.is_multiple_of(2) == self.natural
    }

    /// The distance of `p`, searched from the parameter point `start`: to its
    /// foot or, where that is not on the face, to the nearest loop.
    pub fn distance(&self, p: Point, start: Uv) -> f64 {
        self.off_foot(p, foot_point(self.surface, p, start))
    }

    fn off_foot(&self, p: Point, (at, distance): (Uv, f64)) -> f64 {
        if self.contains(at) {
            return distance;
        }
        let nearest = self.rims.nearest_neighbor(p.coords.into());
        nearest.map_or(distance, |side| side.distance(p))
    }
}

fn chords(surface: &Surface, arcs: &[Curve<2>]) -> Vec<(Uv, Point)> {
    let mut ring = Vec::new();
    for arc in arcs {
        for span in arc.knots.breaks().windows(2) {
            let at = |i: usize| span[0] + (span[1] - span[0]) * i as f64 / CHORDS as f64;
            let corner = |i: usize| Uv::from(arc.point(at(i)));
            ring.extend((0..CHORDS).map(corner).map(|uv| (uv, surface.point(uv))));
        }
    }
    ring
}
