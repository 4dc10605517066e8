//! The area of a face, and the volume of the cone from a point to it.
//!
//! The input is the rings of a face. Green's theorem converts the integrals over the face to integrals along its
//! rings: for a density g(u, v) and G(u, v) = ∫ g du, the integral of g over the inside of a ring is ∮ G dv. The
//! parameter plane is divided into cells in which the surface is smooth. G at a place is the sum over the whole
//! cells before it, which is kept for each row of cells, and an integral over a part of one cell. Between three
//! corners a ring is a parabola, which is the edge up to the fourth power of its length.

use std::f64::consts::FRAC_PI_4;

use formats::cad::{CadCurve, CadSurface, CurveShape};
use rayon::prelude::*;

use super::loops::{Ring, RingCorner, ring_bounds};
use super::surface::Domain;
use crate::geometry::{Point, Uv, uv_bounds};
use crate::spline::ParametricSurface;

/// The number of nodes of Gauss–Legendre quadrature along v and along rings. The integrals over u are also
/// interpolated between them.
const NODES: usize = 8;

/// The positive nodes over [−1, 1] and their weights. They are exact up to degree 15.
const GAUSS: [(f64, f64); NODES / 2] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// The nodes along u, which are exact up to degree 7.
const GAUSS_U: [(f64, f64); NODES / 4] = [
    (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_86),
];

/// The largest part of an angle that one cell spans. Over it the error of the quadrature of a cosine is 1e-10.
const ARC: f64 = FRAC_PI_4;

/// The number of cells along an axis, at least. The densities are no polynomials, even if the surface is one.
const FEWEST: usize = 8;

/// The number of parts of a span between two knots of a rational surface.
const PARTS: usize = 4;

/// The area of a part of a surface in mm², and its flux: three times the volume of the cone from a point to it.
/// The flux is positive if the normals Sᵤ × Sᵥ point away from the point.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Integrals {
    pub(super) area: f64,
    pub(super) flux: f64,
}

impl Integrals {
    fn plus(self, other: Integrals, share: f64) -> Self {
        Integrals { area: self.area + share * other.area, flux: self.flux + share * other.flux }
    }

    /// The integrals over a face. `surface` is its surface in a form that is fast to evaluate. `is_inside(i, at)` says whether ring `i` surrounds a place.
    pub(super) fn of(
        (domain, surface): (&Domain, &dyn ParametricSurface),
        (rings, natural): (&[Ring], bool),
        is_inside: impl Fn(usize, Uv) -> bool,
        origin: Point,
    ) -> Self {
        let mut sum = Integrals::default();
        if natural {
            let [(a, b), (c, d)] = domain.ranges();
            let table = CellTable::new((domain, surface), [Uv::new(a, c), Uv::new(b, d)], origin);
            sum = table.whole();
        }
        if rings.is_empty() {
            return sum;
        }
        let table = CellTable::new((domain, surface), ring_bounds(rings), origin);
        for (i, ring) in rings.iter().enumerate() {
            let of_ring = table.within(ring);
            let depth = (0..rings.len()).filter(|&j| j != i && is_inside(j, ring[0].at)).count();
            let adds = depth.is_multiple_of(2) != natural;
            let share = if adds { 1.0 } else { -1.0 };
            sum = sum.plus(of_ring, share * of_ring.area.signum());
        }
        sum
    }
}

/// The cells of a rectangle of the parameter plane.
struct CellTable<'a> {
    surface: &'a dyn ParametricSurface,
    origin: Point,
    us: Vec<f64>,
    vs: Vec<f64>,
    /// The integrals over u from the first line to line i, at the nodes of v in row j.
    before: Vec<[Integrals; NODES]>,
}

impl<'a> CellTable<'a> {
    fn new(
        (domain, surface): (&Domain, &'a dyn ParametricSurface),
        [low, high]: [Uv; 2],
        origin: Point,
    ) -> Self {
        let lines = |axis: usize| lines(domain, axis, (low[axis], high[axis]));
        let mut table =
            CellTable { surface, origin, us: lines(0), vs: lines(1), before: Vec::new() };
        let rows = (0..table.vs.len() - 1).into_par_iter().flat_map_iter(|row| table.row(row));
        table.before = rows.collect();
        table
    }

    /// The integrals over u up to each line, in a row.
    fn row(&self, row: usize) -> Vec<[Integrals; NODES]> {
        let mut sums = [Integrals::default(); NODES];
        let mut kept = vec![sums];
        for u in self.us.windows(2) {
            for (sum, (v, _)) in sums.iter_mut().zip(nodes(self.vs[row], self.vs[row + 1])) {
                *sum = sum.plus(self.along_u(u[0], u[1], v), 1.0);
            }
            kept.push(sums);
        }
        kept
    }

    /// The densities at a place.
    fn density(&self, at: Uv) -> Integrals {
        let jet = self.surface.jet(at);
        let normal = jet.su.cross(&jet.sv);
        Integrals { area: normal.norm(), flux: (jet.s - self.origin).dot(&normal) }
    }

    fn along_u(&self, from: f64, to: f64, v: f64) -> Integrals {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let both = GAUSS_U.into_iter().flat_map(|(x, w)| [(-x, w), (x, w)]);
        both.fold(Integrals::default(), |sum, (x, w)| {
            sum.plus(self.density(Uv::new(middle + half * x, v)), half * w)
        })
    }

    /// The integrals over the whole rectangle.
    fn whole(&self) -> Integrals {
        let columns = self.us.len();
        let mut sum = Integrals::default();
        for row in 0..self.vs.len() - 1 {
            let last = &self.before[row * columns + columns - 1];
            for (of_node, (_, w)) in last.iter().zip(nodes(self.vs[row], self.vs[row + 1])) {
                sum = sum.plus(*of_node, w);
            }
        }
        sum
    }

    /// G at a place: the integrals over u from the first line.
    fn up_to(&self, at: Uv) -> Integrals {
        let of = |lines: &[f64], t: f64| {
            let inner = &lines[1..lines.len() - 1];
            inner.partition_point(|&line| line <= t)
        };
        let (i, row) = (of(&self.us, at.x), of(&self.vs, at.y));
        let kept = &self.before[row * self.us.len() + i];
        let mut sum = self.along_u(self.us[i], at.x, at.y);
        for (value, share) in kept.iter().zip(lagrange(self.vs[row], self.vs[row + 1], at.y)) {
            sum = sum.plus(*value, share);
        }
        sum
    }

    /// The integrals over the inside of a ring. They are negative if it runs clockwise.
    fn within(&self, ring: &Ring) -> Integrals {
        let mut sum = Integrals::default();
        let corner = |i: usize| ring[i % ring.len()];
        let mut i = 0;
        while i < ring.len() {
            let is_curved = corner(i + 1).is_middle;
            let piece = if is_curved {
                [corner(i), corner(i + 1), corner(i + 2)].map(|c: RingCorner| c.at)
            } else {
                let (a, b) = (corner(i).at, corner(i + 1).at);
                [a, nalgebra::center(&a, &b), b]
            };
            sum = sum.plus(self.along(piece), 1.0);
            i += if is_curved { 2 } else { 1 };
        }
        sum
    }

    /// ∫ G dv along a parabola through three points at 0, ½ and 1.
    fn along(&self, [a, b, c]: [Uv; 3]) -> Integrals {
        let mut sum = Integrals::default();
        if a.y == b.y && b.y == c.y {
            return sum;
        }
        // p(s) = a + s first + s² second
        let second = 2.0 * ((a - b) + (c - b));
        let first = (c - a) - second;
        let mut parts = vec![0.0, 1.0];
        for (axis, lines) in [&self.us, &self.vs].into_iter().enumerate() {
            let [low, high] = uv_bounds(&[a, b, c]).map(|p| p[axis]);
            let from = lines.partition_point(|&t| t <= low);
            let crossed = lines[from..].iter().take_while(|t| **t < high);
            crossed.for_each(|t| parts.extend(roots(second[axis], first[axis], a[axis] - t)));
        }
        parts.retain(|s| (0.0..=1.0).contains(s));
        parts.sort_by(f64::total_cmp);
        for part in parts.windows(2).filter(|part| part[0] < part[1]) {
            for (s, w) in nodes(part[0], part[1]) {
                let at = a + first * s + second * (s * s);
                sum = sum.plus(self.up_to(at), w * (first.y + 2.0 * s * second.y));
            }
        }
        sum
    }
}

/// The real roots of a s² + b s + c.
fn roots(a: f64, b: f64, c: f64) -> Vec<f64> {
    let root = (b * b - 4.0 * a * c).sqrt();
    if root.is_nan() {
        return Vec::new();
    }
    let q = -0.5 * (b + root.copysign(b));
    [q / a, c / q].into_iter().filter(|s| s.is_finite()).collect()
}

/// The nodes and weights over a range.
fn nodes(from: f64, to: f64) -> [(f64, f64); NODES] {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let mut all = [(0.0, 0.0); NODES];
    for (k, (x, w)) in GAUSS.into_iter().enumerate() {
        all[2 * k] = (middle - half * x, half * w);
        all[2 * k + 1] = (middle + half * x, half * w);
    }
    all
}

/// The values at `t` of the polynomials that are 1 at one node of a range and 0 at the others.
fn lagrange(from: f64, to: f64, t: f64) -> [f64; NODES] {
    let nodes = nodes(from, to);
    let mut values = [1.0; NODES];
    for (i, value) in values.iter_mut().enumerate() {
        for j in (0..NODES).filter(|&j| j != i) {
            *value *= (t - nodes[j].0) / (nodes[i].0 - nodes[j].0);
        }
    }
    values
}

/// The lines between cells along an axis.
fn lines(domain: &Domain, axis: usize, (low, high): (f64, f64)) -> Vec<f64> {
    let (low, high) =
        if low < high { (low, high) } else { (low, low + f64::MIN_POSITIVE.max(low.abs())) };
    let breaks = domain.knots_between(axis, (low, high));
    let (is_angle, is_rational) = kinds(domain.surface)[axis];
    let spans = breaks.len() - 1;
    let mut lines = vec![breaks[0]];
    for span in breaks.windows(2) {
        let length = span[1] - span[0];
        let turned = if is_angle { (length / ARC).ceil() as usize } else { 1 };
        let parts = if is_rational { PARTS } else { 1 }.max(turned).max(FEWEST.div_ceil(spans));
        lines.extend((1..parts).map(|i| span[0] + length * i as f64 / parts as f64));
        lines.push(span[1]);
    }
    lines
}

/// Whether u and v are angles, and whether they are parameters of rational splines.
fn kinds(surface: &CadSurface) -> [(bool, bool); 2] {
    let (angle, plain) = ((true, false), (false, false));
    let of_curve = |curve: &CadCurve<3>| match &curve.shape {
        CurveShape::Spline(spline) => (false, spline.weights().is_some()),
        CurveShape::Ellipse { .. } => angle,
        _ => plain,
    };
    match surface {
        CadSurface::Spline(spline) => [(false, spline.weights().is_some()); 2],
        CadSurface::Plane { .. } => [plain; 2],
        CadSurface::Cylinder { .. } | CadSurface::Cone { .. } => [angle, plain],
        CadSurface::Sphere { .. } | CadSurface::Torus { .. } => [angle; 2],
        CadSurface::Revolution { curve, .. } => [angle, of_curve(curve)],
        CadSurface::Extrusion { curve, .. } => [of_curve(curve), plain],
        CadSurface::Offset { base, .. } | CadSurface::Part { base, .. } => kinds(base),
    }
}
