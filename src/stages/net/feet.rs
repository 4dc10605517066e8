//! The foot points of a scan's points on a subdivision surface.

use rayon::prelude::*;

use super::Net;
use crate::geometry::{MOST_ROUNDS, NEGLIGIBLE, Point, Quarter, SAME_SIDE, Uv, UvVector, Vector};
use crate::mesh::FacingPlaces;
use crate::spline::SAMPLES_PER_SPAN;
use crate::spline::subdivision::QuadPlace;

/// The foot point of one point.
#[derive(Debug, Clone, Copy)]
pub(super) struct QuadFoot {
    /// Its place.
    pub place: QuadPlace,
    /// The distance of the point from the surface there, in mm.
    pub distance: f64,
}

/// The foot points of all points. A point has none if the normals at all near places disagree with
/// its own.
#[derive(Debug, Clone)]
pub(super) struct Feet {
    pub feet: Vec<Option<QuadFoot>>,
}

impl Feet {
    /// Searches the foot points from samples of the whole surface.
    pub(super) fn new(net: &Net, points: &[Point], normals: &[Vector]) -> Self {
        let control = net.control();
        let place = |k: usize| {
            let (quad, sample) = (
                k / (SAMPLES_PER_SPAN * SAMPLES_PER_SPAN),
                k % (SAMPLES_PER_SPAN * SAMPLES_PER_SPAN),
            );
            let at = |i: usize| (i as f64 + 0.5) / SAMPLES_PER_SPAN as f64;
            QuadPlace {
                quad,
                at: Uv::new(at(sample % SAMPLES_PER_SPAN), at(sample / SAMPLES_PER_SPAN)),
            }
        };
        let count = SAMPLES_PER_SPAN * SAMPLES_PER_SPAN * net.mesh.quads.len();
        let sample = |scratch: &mut Vec<[f64; 3]>, k: usize| {
            let [p, du, dv] = net.surface.jet(&control, place(k), scratch);
            (place(k), Point::from(p), du.cross(&dv))
        };
        let samples = (0..count).into_par_iter().map_init(Vec::new, sample).collect();
        let places = FacingPlaces::new(samples);
        let search = |scratch: &mut Vec<[f64; 3]>, (p, n): (&Point, &Vector)| {
            let start = *places.facing(*p, *n).first()?;
            foot(net, &control, *p, *n, start, scratch)
        };
        let each = points.par_iter().zip(normals);
        Feet { feet: each.map_init(Vec::new, search).collect() }
    }

    /// Searches the foot points from those on a surface before its control points moved. Points that had none
    /// are searched from samples.
    pub(crate) fn moved(&self, net: &Net, points: &[Point], normals: &[Vector]) -> Self {
        let control = net.control();
        let each = self.feet.par_iter().zip(points.par_iter().zip(normals));
        type Item<'a> = (&'a Option<QuadFoot>, (&'a Point, &'a Vector));
        let search = |scratch: &mut Vec<[f64; 3]>, (old, (p, n)): Item| {
            foot(net, &control, *p, *n, (*old)?.place, scratch)
        };
        let mut feet: Vec<_> = each.map_init(Vec::new, search).collect();
        let lost: Vec<usize> = (0..feet.len()).filter(|&i| self.feet[i].is_none()).collect();
        if !lost.is_empty() {
            let points: Vec<Point> = lost.iter().map(|&i| points[i]).collect();
            let normals: Vec<Vector> = lost.iter().map(|&i| normals[i]).collect();
            let found = Feet::new(net, &points, &normals).feet;
            lost.into_iter().zip(found).for_each(|(i, foot)| feet[i] = foot);
        }
        Feet { feet }
    }
}

/// Newton's method for the foot point, from quad to quad. The curvature of the surface is left out
/// of the matrix, as the points are near the surface.
fn foot(
    net: &Net,
    control: &[Vector],
    p: Point,
    normal: Vector,
    start: QuadPlace,
    scratch: &mut Vec<[f64; 3]>,
) -> Option<QuadFoot> {
    let mut place = start;
    let mut best: Option<(QuadFoot, f64)> = None;
    for _ in 0..MOST_ROUNDS {
        let [s, du, dv] = net.surface.jet(control, place, scratch);
        let r = p.coords - s;
        let distance = r.norm();
        if best.is_some_and(|(foot, _)| distance > foot.distance) {
            break;
        }
        let n = du.cross(&dv);
        let cosine = n.dot(&normal) / n.norm().max(f64::MIN_POSITIVE);
        best = Some((QuadFoot { place, distance }, cosine));
        let (a, b, c) = (du.norm_squared(), du.dot(&dv), dv.norm_squared());
        let determinant = a * c - b * b;
        if determinant <= f64::MIN_POSITIVE {
            break;
        }
        let (x, y) = (r.dot(&du), r.dot(&dv));
        let step = UvVector::new(c * x - b * y, a * y - b * x) / determinant;
        if step.amax() < NEGLIGIBLE {
            break;
        }
        place = walked(net, place, step / step.amax().max(1.0));
    }
    best.filter(|&(_, cosine)| cosine > SAME_SIDE).map(|(foot, _)| foot)
}

/// The place that a step of at most one quad leads to. A step that leaves the quad ends in the quad
/// beside it.
fn walked(net: &Net, place: QuadPlace, step: UvVector) -> QuadPlace {
    let to = place.at + step;
    // How far the step leads along each side and beyond it.
    let seen = [0, 1, 2, 3].map(|k| Quarter(k).turned_back(1.0, to.into()));
    let beyond = seen.map(|[_, depth]| -depth);
    let side = (0..4).max_by(|&i, &j| beyond[i].total_cmp(&beyond[j])).unwrap_or(0);
    let inside = |x: f64| x.clamp(0.0, 1.0);
    if beyond[side] <= 0.0 {
        return QuadPlace { quad: place.quad, at: to };
    }
    let along = inside(seen[side][0]);
    let (quad, k) = net.surface.across(place.quad, side);
    let (s, depth) = (1.0 - along, inside(beyond[side]));
    QuadPlace { quad, at: Quarter(k).turned(1.0, [s, depth]).into() }
}
