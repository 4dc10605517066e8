//! The surface through four sides: Coons' patch (1967), and what the vertices between the sides add to it.

use std::collections::BTreeMap;

use formats::brep::BrepCurve;
use formats::spline::{SplineCurve, SplineKnots, SplineSurface};

use super::chart::array;
use crate::geometry::{Point, ROUNDING, Uv, Vector, VertexId};
use crate::solve::least_squares::SparseNormal;
use crate::spline::{KnotVector, Surface, foot_point, inserted, refined};

const DEGREE: usize = 3;

/// The two long sides of a surface shape it. How the short ones leave straight lines is lost after so many times their length.
const REACH: f64 = 2.0;

/// Knots so close to each other are one. The parameters of a side run from 0 to 1, so that its curves move by less than what kernels take for
/// exact.
const SAME: f64 = 1e-9;

/// The most control points of a surface. One of so many takes as long as all other faces of a part.
const MOST_POLES: usize = 30_000;

/// A bulge has a span for so many edges of the mesh, so that nine vertices tell each of its control points.
const EDGES_OF_SPAN: f64 = 3.0;

/// The most spans of a bulge in each direction.
const MOST_SPANS: usize = 24;

/// The most spans of a bulge that passes through its points, of which each has a control point.
const MOST_SPANS_THROUGH: usize = 100;

/// The least span as a share of the mean one.
const LEAST_SPAN: f64 = 0.1;

/// So often a bulge through points is brought nearer to them, with so little weight of its second differences.
const PASSES: usize = 4;
const LITTLE: f64 = 1e-4;

/// The weight of the second differences of a bulge beside its nine vertices for each control point. It decides where there are none.
const STIFFNESS: f64 = 0.1;

/// A side of a surface: curves that follow each other, as one cubic B-spline over [0, 1].
pub(super) struct PatchSide {
    knots: Vec<f64>,
    poles: Vec<Vector>,
    /// The parameters where its curves begin and end.
    pub breaks: Vec<f64>,
}

impl PatchSide {
    /// The side that runs along curves, each forwards or backwards.
    pub(super) fn new(curves: &[(&BrepCurve, bool)]) -> Result<Self, String> {
        let cubics = curves.iter().map(|&(curve, forward)| cubic(curve, forward));
        let cubics = cubics.collect::<Result<Vec<_>, String>>()?;
        let long = |curve: &SplineCurve<3>| {
            let (start, end) = curve.knots().range();
            end - start
        };
        let whole: f64 = cubics.iter().map(long).sum();
        let mut side = PatchSide { knots: vec![0.0], poles: Vec::new(), breaks: vec![0.0] };
        let mut before = 0.0;
        for curve in &cubics {
            let (start, _) = curve.knots().range();
            let (knots, poles) = without_double_knots(curve);
            let inner = knots.knots();
            let inner = &inner[DEGREE + 1..inner.len() - DEGREE - 1];
            let place = |t: f64| ((before + t - start) / whole).min(1.0);
            side.knots.extend([place(start); DEGREE]);
            side.knots.extend(inner.iter().map(|&t| place(t)));
            side.poles.extend(poles.into_iter().skip(usize::from(!side.poles.is_empty())));
            before += long(curve);
            side.breaks.push((before / whole).min(1.0));
        }
        side.knots.extend([1.0; DEGREE + 1]);
        if let Some(last) = side.breaks.last_mut() {
            *last = 1.0;
        }
        Ok(side)
    }

    fn reversed(&self) -> Self {
        let knots = self.knots.iter().rev().map(|t| 1.0 - t).collect();
        let poles = self.poles.iter().rev().copied().collect();
        let breaks = self.breaks.iter().rev().map(|t| 1.0 - t).collect();
        PatchSide { knots, poles, breaks }
    }

    /// The control points over finer knots.
    fn over(&self, knots: &KnotVector) -> Vec<Vector> {
        inserted(&self.poles, &moved(&self.knots, knots), knots)
    }

    fn length(&self) -> f64 {
        self.poles.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
    }
}

/// A line or a cubic B-spline as a cubic B-spline in one of its directions.
fn cubic(curve: &BrepCurve, forward: bool) -> Result<SplineCurve<3>, String> {
    let made = match curve {
        BrepCurve::Line(_) => {
            let (start, end) = curve.range();
            let at = |k: usize| curve.point(start + (end - start) * k as f64 / DEGREE as f64);
            let knots = [[start; DEGREE + 1], [end; DEGREE + 1]].concat();
            SplineCurve::new(DEGREE, knots, (0..=DEGREE).map(at).collect(), None)?
        }
        BrepCurve::Spline(spline)
            if spline.knots().degree() == DEGREE && spline.weights().is_none() =>
        {
            spline.clone()
        }
        _ => return Err("a border that is no cubic curve".into()),
    };
    Ok(if forward { made } else { made.reversed() })
}

/// The knots and the control points of a cubic curve, with single knots if its second derivative is continuous.
fn without_double_knots(curve: &SplineCurve<3>) -> (KnotVector, Vec<Vector>) {
    let knots = KnotVector::new(DEGREE, curve.knots().knots().to_vec());
    let poles: Vec<Vector> = curve.poles().iter().map(|&p| Vector::from(p)).collect();
    let single = KnotVector::clamped(DEGREE, &knots.breaks(), 1);
    let fewer = inserted(&poles, &knots, &single);
    let back = inserted(&fewer, &single, &knots);
    let size = poles.iter().map(|p| (p - poles[0]).norm()).fold(0.0, f64::max);
    let is_same = back.iter().zip(&poles).all(|(p, q)| (p - q).norm() <= ROUNDING * size);
    if is_same { (single, fewer) } else { (knots, poles) }
}

/// The knots of two sides and some more, each as often as where it is most.
fn common(lists: [&[f64]; 3]) -> Result<KnotVector, String> {
    let mut all: Vec<(f64, usize)> = Vec::new();
    for (list, knots) in lists.iter().enumerate() {
        all.extend(knots.iter().map(|&t| (t, list)));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut made = Vec::new();
    for near in all.chunk_by(|a, b| b.0 - a.0 < SAME) {
        let times = (0..lists.len()).map(|k| near.iter().filter(|of| of.1 == k).count());
        let times = times.max().unwrap_or(0);
        let is_end = near[0].0 < SAME || near[near.len() - 1].0 > 1.0 - SAME;
        if times > DEGREE + usize::from(is_end) {
            return Err("a border with an edge that has no length".into());
        }
        made.extend(std::iter::repeat_n(near[0].0, times));
    }
    // The chunks at the ends hold 0 and 1 themselves.
    let count = made.len();
    made[..=DEGREE].fill(0.0);
    made[count - DEGREE - 1..].fill(1.0);
    Ok(KnotVector::new(DEGREE, made))
}

/// Some knots at those of a finer vector that are the same.
fn moved(knots: &[f64], to: &KnotVector) -> KnotVector {
    let all = to.knots();
    let own = knots.iter().map(|&t| {
        let k = all.partition_point(|&s| s < t - SAME);
        all[k.min(all.len() - 1)]
    });
    KnotVector::new(DEGREE, own.collect())
}

/// The vertices of a face in its parameters.
pub(super) struct InnerVertices {
    /// The places on the border.
    pub border: BTreeMap<VertexId, Uv>,
    /// The vertices inside, each with the weights of its neighbours.
    pub inner: BTreeMap<VertexId, BTreeMap<VertexId, f64>>,
}

impl InnerVertices {
    /// Adds the corner that a triangle has at a vertex inside, with the other two vertices of the triangle: their mean value weights (Floater 2003).
    pub(super) fn add_corner(&mut self, v: VertexId, p: Point, others: [(VertexId, Point); 2]) {
        let [a, b] = others.map(|(_, q)| q - p);
        let half = (0.5 * a.angle(&b)).tan();
        let weights = self.inner.entry(v).or_default();
        for (w, q) in others {
            *weights.entry(w).or_default() += half / (q - p).norm();
        }
    }

    /// The parameters of all vertices: each inside is a weighted mean of its neighbours.
    pub(super) fn places(&self) -> Option<BTreeMap<VertexId, Uv>> {
        let mut places = self.border.clone();
        let number: BTreeMap<VertexId, usize> =
            self.inner.keys().enumerate().map(|(k, &v)| (v, k)).collect();
        if number.is_empty() {
            return Some(places);
        }
        let mut rows = Vec::with_capacity(number.len());
        let mut columns = vec![Vec::new(); number.len()];
        for (v, weights) in &self.inner {
            let whole: f64 = weights.values().sum();
            let mut row = vec![(number[v], 1.0)];
            let mut target = Vector::zeros();
            for (w, weight) in weights {
                match (number.get(w), self.border.get(w)) {
                    (Some(&other), _) => row.push((other, -weight / whole)),
                    (None, Some(at)) => target += weight / whole * Vector::new(at.x, at.y, 0.0),
                    (None, None) => return None,
                }
            }
            for &(a, _) in &row {
                columns[a].extend(row.iter().map(|of| of.0).filter(|&b| b >= a));
            }
            rows.push((row, target));
        }
        let mut equations = SparseNormal::new(columns)?;
        rows.iter().for_each(|(row, target)| equations.add_row(row, 1.0, *target));
        let found = equations.solve()?;
        places.extend(number.iter().map(|(&v, &k)| (v, Uv::new(found[k].x, found[k].y))));
        Some(places)
    }
}

/// How the vertices inside bend a surface.
#[derive(Debug, Clone, Copy)]
pub(super) enum Bulging {
    /// Their noise is averaged. The mean edge of the mesh is given.
    Averages(f64),
    /// It passes through them.
    PassesThrough,
}

/// The surface through four sides, of which each begins where the one before ends. The first two run with u and with v, the others
/// against them.
pub(super) fn coons(
    sides: &[PatchSide; 4],
    points: &[(Uv, Point)],
    how: Bulging,
) -> Result<Surface, String> {
    let [bottom, right, top, left] = sides;
    let (top, left) = (top.reversed(), left.reversed());
    let lengths = [bottom.length().max(top.length()), left.length().max(right.length())];
    let even = match how {
        Bulging::Averages(edge) => lengths.map(|long| {
            let spans = ((long / (EDGES_OF_SPAN * edge)) as usize).clamp(1, MOST_SPANS);
            KnotVector::uniform(DEGREE, spans + DEGREE)
        }),
        Bulging::PassesThrough => knots_among(points, lengths),
    };
    let coarse = |k: usize| if points.is_empty() { &[][..] } else { even[k].knots() };
    let u = common([&bottom.knots, &top.knots, coarse(0)])?;
    let v = common([&left.knots, &right.knots, coarse(1)])?;
    if u.functions() * v.functions() > MOST_POLES {
        return Err("a border with too many edges for one surface".into());
    }
    let [bottom, top] = [bottom, &top].map(|side| side.over(&u));
    let [left, right] = [&left, right].map(|side| side.over(&v));
    let [nu, nv] = [u.functions(), v.functions()];
    let is_along_u = lengths[0] >= lengths[1];
    let reach = (lengths[0] / lengths[1]).max(lengths[1] / lengths[0]) / REACH;
    // Of each end: 1 there, and 0 at the other one.
    let share = |t: f64| (1.0 - t * reach.max(1.0)).max(0.0);
    let mix = |t: f64, a: Vector, b: Vector| (1.0 - t) * a + t * b;
    let mut net = Vec::with_capacity(nu * nv);
    for i in 0..nu {
        let x = u.greville(i);
        for j in 0..nv {
            let y = v.greville(j);
            net.push(if is_along_u {
                let [start, end] = [0, nu - 1].map(|i| mix(y, bottom[i], top[i]));
                let off = share(x) * (left[j] - start) + share(1.0 - x) * (right[j] - end);
                mix(y, bottom[i], top[i]) + off
            } else {
                let [start, end] = [0, nv - 1].map(|j| mix(x, left[j], right[j]));
                let off = share(y) * (bottom[i] - start) + share(1.0 - y) * (top[i] - end);
                mix(x, left[j], right[j]) + off
            });
        }
    }
    let mut surface = Surface::new(u, v, net);
    let (passes, stiffness) = match how {
        _ if points.is_empty() => (0, STIFFNESS),
        Bulging::Averages(_) => (1, STIFFNESS),
        Bulging::PassesThrough => (PASSES, LITTLE),
    };
    for pass in 0..passes {
        // The first of several passes leaves the points at their places: the feet on a surface that is far from them may lie on one another.
        let are_places = pass == 0 && passes > 1;
        let Some(bulge) = bulge(&surface, points, &even, stiffness, are_places) else { break };
        let own = [moved(even[0].knots(), &surface.u), moved(even[1].knots(), &surface.v)];
        let more = refined(&bulge, [&own[0], &own[1]], [&surface.u, &surface.v]);
        surface.net.iter_mut().zip(more).for_each(|(p, by)| *p += by);
    }
    Ok(surface)
}

/// Knots of a bulge with about one control point for each point inside, as close to each other as the points are.
fn knots_among(points: &[(Uv, Point)], lengths: [f64; 2]) -> [KnotVector; 2] {
    let ratio = (lengths[0] / lengths[1]).sqrt();
    let root = (points.len() as f64).sqrt();
    [(0, root * ratio), (1, root / ratio)].map(|(k, wanted)| {
        let spans = (wanted.ceil() as usize).clamp(1, MOST_SPANS_THROUGH);
        let mut places: Vec<f64> = points.iter().map(|(at, _)| at[k]).collect();
        places.sort_by(f64::total_cmp);
        let at = |j: usize| places[j * (places.len() - 1) / spans];
        let mut inner: Vec<f64> = (1..spans).filter(|_| !places.is_empty()).map(at).collect();
        inner.dedup_by(|a, b| *a - *b < LEAST_SPAN / spans as f64);
        inner.retain(|t| *t > SAME && *t < 1.0 - SAME);
        let knots = [&[0.0; DEGREE + 1][..], &inner, &[1.0; DEGREE + 1]].concat();
        KnotVector::new(DEGREE, knots)
    })
}

/// The control points of a bulge with their factors, whose sum is to be the target.
struct BulgeRow {
    terms: Vec<(usize, f64)>,
    weight: f64,
    target: Vector,
}

/// The control net of what brings a surface to points inside of it and leaves its sides where they are. Each point comes with
/// its parameters: its place itself, or a start for its foot point.
fn bulge(
    surface: &Surface,
    points: &[(Uv, Point)],
    knots: &[KnotVector; 2],
    stiffness: f64,
    are_places: bool,
) -> Option<Vec<Vector>> {
    let [nu, nv] = [0, 1].map(|k| knots[k].functions());
    let inner = |i: usize, j: usize| {
        (i > 0 && j > 0 && i + 1 < nu && j + 1 < nv).then(|| (i - 1) * (nv - 2) + j - 1)
    };
    let mut rows: Vec<BulgeRow> = Vec::new();
    for &(start, p) in points {
        let at = if are_places { start } else { foot_point(surface, p, start).0 };
        let [a, b] = [knots[0].basis(at.x), knots[1].basis(at.y)];
        let mut row = Vec::new();
        for i in 0..=DEGREE {
            for j in 0..=DEGREE {
                let weight = a.derivative[0][i] * b.derivative[0][j];
                row.extend(inner(a.first + i, b.first + j).map(|k| (k, weight)));
            }
        }
        rows.push(BulgeRow { terms: row, weight: 1.0, target: p - surface.point(at) });
    }
    // The control points at the sides are zero.
    let mut stiff = |places: [(usize, usize); 3]| {
        let terms = places.into_iter().zip([1.0, -2.0, 1.0]);
        let row: Vec<_> = terms.filter_map(|((i, j), w)| inner(i, j).map(|k| (k, w))).collect();
        rows.push(BulgeRow { terms: row, weight: stiffness, target: Vector::zeros() });
    };
    for i in 1..nu - 1 {
        for j in 1..nv - 1 {
            stiff([(i - 1, j), (i, j), (i + 1, j)]);
            stiff([(i, j - 1), (i, j), (i, j + 1)]);
        }
    }
    let mut columns = vec![Vec::new(); (nu - 2) * (nv - 2)];
    for BulgeRow { terms, .. } in &rows {
        for &(a, _) in terms {
            columns[a].extend(terms.iter().map(|of| of.0).filter(|&b| b >= a));
        }
    }
    let mut equations = SparseNormal::new(columns)?;
    rows.iter().for_each(|row| equations.add_row(&row.terms, row.weight, row.target));
    let found = equations.solve()?;
    let at = |n: usize| inner(n / nv, n % nv).map_or_else(Vector::zeros, |k| found[k]);
    Some((0..nu * nv).map(at).collect())
}

/// A surface as files know it.
pub(super) fn spline_of(surface: &Surface) -> Result<SplineSurface, String> {
    let poles = surface.net.iter().map(|&p| array(Point::from(p))).collect();
    let knots =
        |of: &KnotVector| SplineKnots::new(of.degree(), of.knots().to_vec(), of.functions());
    SplineSurface::new(knots(&surface.u)?, knots(&surface.v)?, poles, None)
}

#[cfg(test)]
mod tests {
    use super::super::followed::led_curve;
    use super::*;
    use crate::spline::ParametricSurface;

    /// A side through points, cut into curves of so many points.
    fn side(points: &[Point], pieces: usize) -> Vec<BrepCurve> {
        let step = (points.len() - 1) / pieces;
        let piece = |k: usize| {
            let own = &points[k * step..=(k + 1) * step];
            match own {
                [from, to] => BrepCurve::line(array(*from), array(*to)).expect("a line"),
                own => BrepCurve::Spline(led_curve(own, [None; 2], None).expect("a curve")),
            }
        };
        (0..pieces).map(piece).collect()
    }

    /// The sides of a square under a function, counterclockwise.
    fn sides_under(
        height: impl Fn(f64, f64) -> f64,
        n: usize,
        pieces: usize,
    ) -> [Vec<BrepCurve>; 4] {
        let at = |x: f64, y: f64| Point::new(x, y, height(x, y));
        let along = |from: [f64; 2], to: [f64; 2]| {
            let share = |k: usize| k as f64 / n as f64;
            let place = |k: usize| {
                let s = share(k);
                at(from[0] + s * (to[0] - from[0]), from[1] + s * (to[1] - from[1]))
            };
            (0..=n).map(place).collect::<Vec<Point>>()
        };
        let corners = [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]];
        [0, 1, 2, 3].map(|k| side(&along(corners[k], corners[(k + 1) % 4]), pieces))
    }

    fn patch_sides(curves: &[Vec<BrepCurve>; 4]) -> [PatchSide; 4] {
        [0, 1, 2, 3].map(|k| {
            let forwards: Vec<_> = curves[k].iter().map(|curve| (curve, true)).collect();
            PatchSide::new(&forwards).expect("a side")
        })
    }

    #[test]
    fn a_surface_has_the_curves_of_its_sides() {
        let curves = sides_under(|x, y| 0.05 * x * y + 0.3 * (0.7 * x).sin(), 12, 3);
        let sides = patch_sides(&curves);
        let surface = coons(&sides, &[], Bulging::Averages(1.0)).expect("a surface");
        let place = |side: usize, t: f64| match side {
            0 => Uv::new(t, 0.0),
            1 => Uv::new(1.0, t),
            2 => Uv::new(1.0 - t, 1.0),
            _ => Uv::new(0.0, 1.0 - t),
        };
        for (number, (own, side)) in curves.iter().zip(&sides).enumerate() {
            for (curve, range) in own.iter().zip(side.breaks.windows(2)) {
                let (start, end) = curve.range();
                for k in 0..=20 {
                    let share = f64::from(k) / 20.0;
                    let at = place(number, range[0] + share * (range[1] - range[0]));
                    let p = Point::from(curve.point(start + share * (end - start)));
                    assert!((surface.point(at) - p).norm() < 1e-7, "side {number} at {share}");
                }
            }
        }
    }

    #[test]
    fn points_inside_bend_a_surface_and_leave_its_sides() {
        let height = |x: f64, y: f64| 0.05 * x * (9.0 - x) * (0.3 * y).sin();
        let sides = patch_sides(&sides_under(height, 9, 1));
        let inside = (1..9).flat_map(|i| (1..9).map(move |j| [f64::from(i), f64::from(j)]));
        let points: Vec<(Uv, Point)> = inside
            .map(|[x, y]| (Uv::new(x / 9.0, y / 9.0), Point::new(x, y, height(x, y))))
            .collect();
        let [plain, bent] = [&[][..], &points]
            .map(|of| coons(&sides, of, Bulging::Averages(1.0)).expect("a surface"));
        let off = |surface: &Surface| {
            let of = |&(at, p): &(Uv, Point)| foot_point(surface, p, at).1;
            points.iter().map(of).fold(0.0, f64::max)
        };
        assert!(off(&plain) > 0.5 && off(&bent) < 0.1, "{} {}", off(&plain), off(&bent));
        for k in 0..=10 {
            let at = Uv::new(f64::from(k) / 10.0, 0.0);
            let [p, q] = [&plain, &bent].map(|of| ParametricSurface::jet(of, at).s);
            assert!((p - q).norm() < 1e-9);
        }
    }

    #[test]
    fn knots_that_are_nearly_the_same_are_one() {
        let list = |inner: f64| [[0.0; 4].to_vec(), vec![inner], [1.0; 4].to_vec()].concat();
        let [a, b] = [list(0.5), list(0.5 + 1e-12)];
        let both = common([&a, &b, &[]]).expect("knots");
        assert_eq!(both.functions(), 5);
        let apart = common([&a, &list(0.6), &[]]).expect("knots");
        assert_eq!(apart.functions(), 6);
        assert!(common([&list(1e-12), &a, &[]]).is_err());
    }

    #[test]
    fn vertices_inside_a_plane_keep_their_places() {
        let v = |k: u32| VertexId(k);
        let corner = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let border = (0..4).map(|k| (v(k), Uv::from(corner[k as usize]))).collect();
        let at = |k: u32| Point::new(corner[k as usize][0], corner[k as usize][1], 0.0);
        let mut all = InnerVertices { border, inner: BTreeMap::new() };
        let p = Point::new(0.3, 0.6, 0.0);
        for k in 0..4 {
            all.add_corner(v(9), p, [k, (k + 1) % 4].map(|k| (v(k), at(k))));
        }
        let places = all.places().expect("places");
        assert!((places[&v(9)] - Uv::new(0.3, 0.6)).norm() < 1e-12);
    }
}
