//! The parameters of points of a surface.
//!
//! The input is a surface and a point near it. The output is the parameter point of the nearest place, or of one
//! near it: in closed form on planes, cylinders, cones, spheres and tori, and by a descent on other surfaces.

use std::f64::consts::{FRAC_PI_4, PI};

use formats::cad::CadSurface;

use super::surface::Domain;
use crate::geometry::{Point, Uv, Vector};
use crate::spline::{ParametricSurface, foot_point};

impl Domain<'_> {
    /// The parameter point of a place near `p`. The search on surfaces without a closed form begins at `hint`. Of
    /// the images on periodic surfaces it is the one nearest to `hint`.
    pub(super) fn locate(&self, p: Point, hint: Option<Uv>, gap: f64) -> Uv {
        let found = match (closed_form(self.surface, p, self.closure.ranges[1]), hint) {
            (Some(at), _) => at,
            (None, Some(hint)) => {
                let (at, off) = foot_point(self, p, hint);
                if off <= gap { at } else { self.searched(p, gap) }
            }
            (None, None) => self.searched(p, gap),
        };
        hint.map_or(found, |hint| self.image(found, hint))
    }

    /// The image of a parameter point that is nearest to another one.
    pub(super) fn image(&self, at: Uv, near: Uv) -> Uv {
        let of = |axis: usize| match self.closure.periods[axis] {
            Some(period) => at[axis] + period * ((near[axis] - at[axis]) / period).round(),
            None => at[axis],
        };
        Uv::new(of(0), of(1))
    }

    /// The nearest of the feet of several descents. They begin at the nearest places of a grid that are not beside
    /// each other.
    fn searched(&self, p: Point, gap: f64) -> Uv {
        let axes = self.once().breaks().map(|breaks| samples(&breaks));
        let mut places = Vec::with_capacity(axes[0].len() * axes[1].len());
        for (i, &u) in axes[0].iter().enumerate() {
            for (j, &v) in axes[1].iter().enumerate() {
                places.push(((self.point(Uv::new(u, v)) - p).norm(), [i, j]));
            }
        }
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best = (Uv::origin(), f64::INFINITY);
        let mut tried: Vec<[usize; 2]> = Vec::with_capacity(STARTS);
        for (_, at) in places {
            if tried.iter().any(|other| (0..2).all(|k| other[k].abs_diff(at[k]) <= BESIDE)) {
                continue;
            }
            tried.push(at);
            let foot = foot_point(self, p, Uv::new(axes[0][at[0]], axes[1][at[1]]));
            if foot.1 < best.1 {
                best = foot;
            }
            if best.1 <= gap || tried.len() == STARTS {
                break;
            }
        }
        best.0
    }
}

/// Places of a grid are beside each other if they are so many steps apart in both directions. A descent from one of
/// them comes to the same foot.
const BESIDE: usize = 2;

/// The number of descents after which a search gives up.
const STARTS: usize = 16;

/// The number of places of a grid along an axis, at least.
const GRID: usize = 64;

/// Parameters that cover an axis. For an unbounded axis they cover the range of an angle.
fn samples(breaks: &[f64]) -> Vec<f64> {
    let (Some(&low), Some(&high)) = (breaks.first(), breaks.last()) else { return Vec::new() };
    if !low.is_finite() || !high.is_finite() {
        return (-4..=4).map(|i| f64::from(i) * FRAC_PI_4).collect();
    }
    let pieces = (GRID / breaks.len()).max(2);
    let piece = |w: &[f64], i: usize| w[0] + (w[1] - w[0]) * (i as f64 + 0.5) / pieces as f64;
    let all = breaks.windows(2).flat_map(|w| (0..pieces).map(move |i| piece(w, i)));
    let step = (pieces * breaks.len()).div_ceil(MOST_GRID);
    all.step_by(step).collect()
}

/// The number of places of a grid along an axis, at most. It keeps the time in bounds if a surface has very many knots.
const MOST_GRID: usize = 512;

/// The parameters of a point in closed form, if the surface has one.
fn closed_form(surface: &CadSurface, p: Point, range: (f64, f64)) -> Option<Uv> {
    // The coordinates along axes, as multiples of them.
    let within = |origin: &[f64; 3], axes: [&[f64; 3]; 3]| {
        let from = p.coords - Vector::from(*origin);
        axes.map(|axis| {
            let axis = Vector::from(*axis);
            from.dot(&axis) / axis.norm_squared()
        })
    };
    match surface {
        CadSurface::Plane { origin, x, y } => {
            let [u, v, _] = within(origin, [x, y, x]);
            Some(Uv::new(u, v))
        }
        CadSurface::Cylinder { origin, x, y, z } => {
            let [a, b, v] = within(origin, [x, y, z]);
            Some(Uv::new(b.atan2(a), v))
        }
        CadSurface::Cone { origin, x, y, z, radius, slope } => {
            let [a, b, v] = within(origin, [x, y, z]);
            // Beyond the apex, the surface is on the other side of the axis.
            let turn = if radius + v * slope < 0.0 { PI } else { 0.0 };
            Some(Uv::new(b.atan2(a) + turn, v))
        }
        CadSurface::Sphere { origin, x, y, z } => {
            let [a, b, c] = within(origin, [x, y, z]);
            Some(Uv::new(b.atan2(a), c.atan2(a.hypot(b))))
        }
        CadSurface::Torus { origin, x, y, z, major, minor } => {
            let [a, b, c] = within(origin, [x, y, z]);
            let (u, out) = (b.atan2(a), a.hypot(b));
            // The inner part of a torus that meets its axis is on the other side of it.
            let outer = (out - major).hypot(c) - minor;
            let inner = (-out - major).hypot(c) - minor;
            Some(if inner.abs() < outer.abs() {
                let v = c.atan2(-out - major);
                Uv::new(u + PI, if v < range.0 { v + 2.0 * PI } else { v })
            } else {
                Uv::new(u, c.atan2(out - major))
            })
        }
        CadSurface::Part { base, .. } => closed_form(base, p, range),
        _ => None,
    }
}
