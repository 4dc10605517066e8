//! A part with exact trim curves. The surface is a bicubic B-spline that is a polynomial, so the
//! image of a Bézier pcurve is a Bézier curve.

use formats::Brep;
use formats::brep::{BrepCurve, BrepSurface, EdgeId, EdgeUse, Face, PCurve, Shell, VertexId};
use formats::spline::{SplineCurve, SplineKnots, SplineSurface};

pub const SIZE: f64 = 100.0;
pub const HEIGHT: f64 = 160.0; // of 16 u(1-u)v(1-v) / 16, so the top is at 10
const SPANS: usize = 5;

/// The knots of a Bézier curve over [0, 1].
pub fn bezier(degree: usize) -> Vec<f64> {
    [vec![0.0; degree + 1], vec![1.0; degree + 1]].concat()
}

/// A Bézier curve over [0, 1].
pub fn bezier_curve<const D: usize>(poles: Vec<[f64; D]>) -> SplineCurve<D> {
    let degree = poles.len() - 1;
    SplineCurve::new(degree, bezier(degree), poles, None).unwrap()
}

/// The surface z = HEIGHT u(1-u) v(1-v) over (SIZE u, SIZE v + shift).
pub fn surface(shift: f64) -> SplineSurface {
    let inner = (1..SPANS).map(|i| i as f64 / SPANS as f64);
    let knots: Vec<f64> = [0.0; 4].into_iter().chain(inner).chain([1.0; 4]).collect();
    // The poles are the blossoms of t and of t(1-t).
    let blossom = |i: usize| {
        let (a, b, c) = (knots[i + 1], knots[i + 2], knots[i + 3]);
        let t = (a + b + c) / 3.0;
        (t, t - (a * b + b * c + a * c) / 3.0)
    };
    let pole = |i, j| {
        let ((u, hu), (v, hv)) = (blossom(i), blossom(j));
        [SIZE * u, SIZE * v + shift, HEIGHT * hu * hv]
    };
    let n = SPANS + 3;
    let net = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| pole(i, j)).collect();
    let knots = SplineKnots::new(3, knots.clone(), n).unwrap();
    SplineSurface::new(knots.clone(), knots, net, None).unwrap()
}

fn point(u: f64, v: f64, shift: f64) -> [f64; 3] {
    [SIZE * u, SIZE * v + shift, HEIGHT * u * (1.0 - u) * v * (1.0 - v)]
}

/// Adds the edge between two vertices. The surface is flat at its boundary.
fn side(brep: &mut Brep, from: VertexId, to: VertexId) -> EdgeId {
    let poles = [from, to].map(|end| brep.vertices[end.0]).to_vec();
    brep.add_edge(BrepCurve::Spline(bezier_curve(poles)), [from, to])
}

pub fn along(edge: EdgeId, pcurve: SplineCurve<2>) -> EdgeUse {
    EdgeUse { edge, forward: true, pcurve: PCurve::Spline(pcurve) }
}

pub fn against(edge: EdgeId, pcurve: SplineCurve<2>) -> EdgeUse {
    EdgeUse { edge, forward: false, pcurve: PCurve::Spline(pcurve) }
}

/// Half of a round hole from left to right. `side` is 1 for the upper and -1 for the lower half.
fn half(center: (f64, f64), radius: f64, side: f64) -> SplineCurve<2> {
    let (left, right, bulge) = (center.0 - radius, center.0 + radius, side * radius * 4.0 / 3.0);
    let poles = [(left, 0.0), (left, bulge), (right, bulge), (right, 0.0)];
    bezier_curve(poles.map(|(u, v)| [u, center.1 + v]).to_vec())
}

/// The exact image of a Bézier pcurve on the surface. It has degree 12.
fn image(pcurve: &SplineCurve<2>) -> SplineCurve<3> {
    let u: Vec<f64> = pcurve.poles().iter().map(|p| p[0]).collect();
    let v: Vec<f64> = pcurve.poles().iter().map(|p| p[1]).collect();
    let rest = |t: &[f64]| t.iter().map(|t| 1.0 - t).collect::<Vec<_>>();
    let z = product(&product(&u, &rest(&u)), &product(&v, &rest(&v)));
    let one = [1.0; 10];
    let (x, y) = (product(&u, &one), product(&v, &one));
    bezier_curve((0..z.len()).map(|i| [SIZE * x[i], SIZE * y[i], HEIGHT * z[i]]).collect())
}

/// The product of two polynomials in Bernstein form.
fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    let (m, n) = (a.len() - 1, b.len() - 1);
    let mut c = vec![0.0; m + n + 1];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            c[i + j] += x * y * binomial(m, i) * binomial(n, j) / binomial(m + n, i + j);
        }
    }
    c
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product()
}

/// A clockwise hole of two edges. If `reversed`, one of them has the opposite direction, so that
/// both directions occur.
fn hole(brep: &mut Brep, center: (f64, f64), radius: f64, reversed: bool) -> Vec<EdgeUse> {
    let (above, mut below) = (half(center, radius, 1.0), half(center, radius, -1.0));
    let [left, right] = image(&above).ends().map(|end| brep.add_vertex(end));
    let there = brep.add_edge(BrepCurve::Spline(image(&above)), [left, right]);
    let mut ends = [left, right];
    if !reversed {
        below = below.reversed();
        ends.reverse();
    }
    let back = brep.add_edge(BrepCurve::Spline(image(&below)), ends);
    vec![along(there, above), EdgeUse { edge: back, forward: !reversed, pcurve: below.into() }]
}

/// The sheet with two holes as face 0. Its third side, edge 2, runs against its curve.
pub fn sheet(name: &str) -> Brep {
    let mut brep = Brep { name: name.into(), uncertainty_mm: 1e-7, ..Brep::default() };
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let [a, b, c, d] = corners.map(|(u, v)| brep.add_vertex(point(u, v, 0.0)));
    let [ab, bc] = [(a, b), (b, c)].map(|(from, to)| side(&mut brep, from, to));
    let [dc, da] = [(d, c), (d, a)].map(|(from, to)| side(&mut brep, from, to));
    let outer = vec![
        along(ab, bezier_curve(vec![[0.0, 0.0], [1.0, 0.0]])),
        along(bc, bezier_curve(vec![[1.0, 0.0], [1.0, 1.0]])),
        against(dc, bezier_curve(vec![[0.0, 1.0], [1.0, 1.0]])),
        along(da, bezier_curve(vec![[0.0, 1.0], [0.0, 0.0]])),
    ];
    let first = hole(&mut brep, (0.3, 0.4), 0.13, true);
    let second = hole(&mut brep, (0.7, 0.55), 0.1, false);
    let surface = brep.add_surface(BrepSurface::Spline(surface(0.0)));
    let face = brep.add_face(Face { surface, forward: true, loops: vec![outer, first, second] });
    brep.add_shell(Shell { faces: vec![face], closed: false });
    brep
}

/// Adds a second sheet behind the first one. They share the third side of the first one.
fn add_neighbour(brep: &mut Brep) {
    let [c, d] = [VertexId(2), VertexId(3)];
    let [e, f] = [(1.0, 1.0), (0.0, 1.0)].map(|(u, v)| brep.add_vertex(point(u, v, SIZE)));
    let sides = [(c, e), (e, f), (f, d)].map(|(from, to)| side(brep, from, to));
    let outer = vec![
        along(EdgeId(2), bezier_curve(vec![[0.0, 0.0], [1.0, 0.0]])),
        along(sides[0], bezier_curve(vec![[1.0, 0.0], [1.0, 1.0]])),
        along(sides[1], bezier_curve(vec![[1.0, 1.0], [0.0, 1.0]])),
        along(sides[2], bezier_curve(vec![[0.0, 1.0], [0.0, 0.0]])),
    ];
    let surface = brep.add_surface(BrepSurface::Spline(surface(SIZE)));
    let face = brep.add_face(Face { surface, forward: true, loops: vec![outer] });
    brep.shells[0].faces.push(face);
}

pub fn one_face(name: &str) -> Brep {
    sheet(name)
}

pub fn two_faces(name: &str) -> Brep {
    let mut brep = sheet(name);
    add_neighbour(&mut brep);
    brep
}

/// The sheet with the opposite normal.
pub fn inverted(name: &str) -> Brep {
    let mut brep = sheet(name);
    let face = &mut brep.faces[0];
    face.forward = false;
    for uses in &mut face.loops {
        uses.reverse();
        uses.iter_mut().for_each(|of_loop| of_loop.forward = !of_loop.forward);
    }
    brep
}
