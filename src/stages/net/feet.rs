//! The foot points of a scan's points on a subdivision surface.

use rayon::prelude::*;

use super::Net;
use crate::geometry::{Point, Uv, UvVector, Vector};
use crate::mesh::Neighbours;
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

/// The number of samples along a side of a quad from which the search for a foot point starts.
/// Newton's method converges from the nearest of them.
const SAMPLES: usize = 3;

/// The number of nearest samples among which one with the right normal is chosen. On the other side
/// of a thin wall all of them may face the wrong way.
const CANDIDATES: usize = 8;

/// The largest number of steps of Newton's method. Points near their foot points need two or three.
const STEPS: usize = 12;

/// A step below this share of a quad ends the search. The remaining error is its square.
const LAST_STEP: f64 = 1e-3;

/// The cosine of the largest angle between the normals of a point and of its foot point (60°). A
/// larger angle belongs to another sheet.
const AGREES: f64 = 0.5;

impl Feet {
    /// Searches the foot points from samples of the whole surface.
    pub fn new(net: &Net, points: &[Point], normals: &[Vector]) -> Self {
        let control = net.control();
        let place = |k: usize| {
            let (quad, sample) = (k / (SAMPLES * SAMPLES), k % (SAMPLES * SAMPLES));
            let at = |i: usize| (i as f64 + 0.5) / SAMPLES as f64;
            QuadPlace { quad, at: Uv::new(at(sample % SAMPLES), at(sample / SAMPLES)) }
        };
        let count = SAMPLES * SAMPLES * net.mesh.quads.len();
        let sample = |scratch: &mut Vec<[f64; 3]>, k: usize| {
            let [p, du, dv] = net.surface.jet(&control, place(k), scratch);
            (Point::from(p), du.cross(&dv))
        };
        let samples: Vec<(Point, Vector)> =
            (0..count).into_par_iter().map_init(Vec::new, sample).collect();
        let places: Vec<Point> = samples.iter().map(|s| s.0).collect();
        let tree = Neighbours::new(&places);
        let search = |(scratch, found): &mut (Vec<_>, Vec<_>), (p, n): (&Point, &Vector)| {
            tree.nearest_n(*p, CANDIDATES, found);
            let faces = |k: u32| samples[k as usize].1.dot(n) > 0.0;
            let start = found.iter().find(|&&(k, _)| faces(k))?;
            foot(net, &control, *p, *n, place(start.0 as usize), scratch)
        };
        let each = points.par_iter().zip(normals);
        Feet { feet: each.map_init(Default::default, search).collect() }
    }

    /// Searches the foot points from those on a surface before its control points moved.
    pub(crate) fn moved(&self, net: &Net, points: &[Point], normals: &[Vector]) -> Self {
        let control = net.control();
        let each = self.feet.par_iter().zip(points.par_iter().zip(normals));
        type Item<'a> = (&'a Option<QuadFoot>, (&'a Point, &'a Vector));
        let search = |scratch: &mut Vec<[f64; 3]>, (old, (p, n)): Item| {
            foot(net, &control, *p, *n, (*old)?.place, scratch)
        };
        Feet { feet: each.map_init(Vec::new, search).collect() }
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
    for _ in 0..STEPS {
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
        if step.amax() < LAST_STEP {
            break;
        }
        place = walked(net, place, step / step.amax().max(1.0));
    }
    best.filter(|&(_, cosine)| cosine > AGREES).map(|(foot, _)| foot)
}

/// The place that a step of at most one quad leads to. A step that leaves the quad ends in the quad
/// beside it.
fn walked(net: &Net, place: QuadPlace, step: UvVector) -> QuadPlace {
    let to = place.at + step;
    // How far the step leads beyond each side.
    let beyond = [-to.y, to.x - 1.0, to.y - 1.0, -to.x];
    let side = (0..4).max_by(|&i, &j| beyond[i].total_cmp(&beyond[j])).unwrap_or(0);
    let inside = |x: f64| x.clamp(0.0, 1.0);
    if beyond[side] <= 0.0 {
        return QuadPlace { quad: place.quad, at: to };
    }
    let along = inside([to.x, to.y, 1.0 - to.x, 1.0 - to.y][side]);
    let (quad, k) = net.surface.across(place.quad, side);
    let (s, depth) = (1.0 - along, inside(beyond[side]));
    let at = match k {
        0 => Uv::new(s, depth),
        1 => Uv::new(1.0 - depth, s),
        2 => Uv::new(1.0 - s, 1.0 - depth),
        _ => Uv::new(depth, 1.0 - s),
    };
    QuadPlace { quad, at }
}
