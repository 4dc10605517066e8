//! Distances from points to curves in space, by an R-tree of chords.

use rstar::{AABB, PointDistance, RTree, RTreeObject};

use super::ACCURACY;
use super::Curve;
use super::chords::chords;
use crate::geometry::{Point, bounds, segment_distance};

/// Curves in space, indexed for queries of the distance from a point to the nearest curve.
///
/// The curves are replaced by chords within 1e-7 of the diagonal of their bounding box, so
/// distances have this error. A query takes logarithmic time.
#[derive(Debug)]
pub struct EdgeTree {
    sides: RTree<Side>,
}

impl EdgeTree {
    /// Builds the tree of some curves.
    pub fn new(edges: &[Curve<3>]) -> Self {
        let control = edges.iter().flat_map(|edge| edge.control.iter().map(|&p| Point::from(p)));
        let [low, high] = bounds(control);
        let chord = ACCURACY * (high - low).norm();
        let line = |edge: &Curve<3>| {
            let at = |t: f64| Point::from(edge.point(t));
            chords(&edge.knots.breaks(), &at, |p| *p, chord)
        };
        let lines: Vec<Vec<Point>> = edges.iter().map(line).collect();
        EdgeTree::of_sides(lines.iter().flat_map(|line| line.windows(2).map(|s| [s[0], s[1]])))
    }

    /// Builds the tree of line segments, each given by its start and its end.
    pub(crate) fn of_sides(sides: impl Iterator<Item = [Point; 2]>) -> Self {
        let sides = sides.enumerate().map(|(number, ends)| Side { ends, number });
        EdgeTree { sides: RTree::bulk_load(sides.collect()) }
    }

    /// The distance in mm from `p` to the nearest curve, or infinity if there is no curve.
    pub fn distance(&self, p: Point) -> f64 {
        self.nearest(p).map_or(f64::INFINITY, |near| near.2)
    }

    /// The number of the segment nearest to `p`, the position along it from 0 to 1, and the
    /// distance.
    pub(crate) fn nearest(&self, p: Point) -> Option<(usize, f64, f64)> {
        // `nearest_neighbor` of rstar prunes by bounds that rounding may turn against the nearest
        // segment.
        self.sides.nearest_neighbor_iter(p.coords.into()).next().map(|side| side.nearest(p))
    }

    /// The same if the distance is less than `reach`. This is much faster if no segment is so near.
    pub(crate) fn nearer_than(&self, reach: f64, p: Point) -> Option<(usize, f64, f64)> {
        let corner = |sign: f64| [0, 1, 2].map(|k| p[k] + sign * reach);
        let around = AABB::from_corners(corner(-1.0), corner(1.0));
        let near = self.sides.locate_in_envelope_intersecting(around);
        let near = near.map(|side| side.nearest(p)).filter(|near| near.2 < reach);
        near.min_by(|a, b| a.2.total_cmp(&b.2).then(a.0.cmp(&b.0)))
    }
}

/// A chord of a curve.
#[derive(Debug, Clone, Copy)]
struct Side {
    ends: [Point; 2],
    number: usize,
}

impl Side {
    /// Its number, the position along it that is nearest to `p`, and the distance.
    fn nearest(&self, p: Point) -> (usize, f64, f64) {
        let ([a, b], along) = (self.ends, self.ends[1] - self.ends[0]);
        let share = (p - a).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
        (self.number, share.clamp(0.0, 1.0), segment_distance(p, a, b))
    }

    fn distance(&self, p: Point) -> f64 {
        segment_distance(p, self.ends[0], self.ends[1])
    }
}

impl RTreeObject for Side {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        let [a, b] = self.ends.map(|end| end.coords.into());
        AABB::from_corners(a, b)
    }
}

impl PointDistance for Side {
    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        self.distance(Point::from(*point)).powi(2)
    }
}
