//! A part whose trim curves are exact: the surface is a bicubic B-spline that
//! is a polynomial, so the image of a Bézier pcurve is a Bézier curve too.

use formats::{Brep, PCurve, TrimmedFace};
use truck_modeling::{
    BSplineCurve, BSplineSurface, Curve, Edge, Face, KnotVec, Point2, Point3, Surface, Vertex, Wire,
};

pub const SIZE: f64 = 100.0;
pub const HEIGHT: f64 = 160.0; // of 16 u(1-u)v(1-v) / 16, so the top is at 10
const SPANS: usize = 5;

/// z = HEIGHT u(1-u) v(1-v) over (SIZE u, SIZE v + shift).
pub fn surface(shift: f64) -> BSplineSurface<Point3> {
    let knots = KnotVec::uniform_knot(3, SPANS);
    // The blossoms of t and of t(1-t) are the poles that give them.
    let blossom = |i: usize| {
        let (a, b, c) = (knots[i + 1], knots[i + 2], knots[i + 3]);
        let t = (a + b + c) / 3.0;
        (t, t - (a * b + b * c + a * c) / 3.0)
    };
    let pole = |i, j| {
        let ((u, hu), (v, hv)) = (blossom(i), blossom(j));
        Point3::new(SIZE * u, SIZE * v + shift, HEIGHT * hu * hv)
    };
    let n = SPANS + 3;
    let net = (0..n).map(|i| (0..n).map(|j| pole(i, j)).collect()).collect();
    BSplineSurface::new((knots.clone(), knots), net)
}

pub fn point(u: f64, v: f64, shift: f64) -> Point3 {
    Point3::new(SIZE * u, SIZE * v + shift, HEIGHT * u * (1.0 - u) * v * (1.0 - v))
}

/// Vertices of the corners (0,0), (1,0), (1,1), (0,1).
type Corners = [Vertex; 4];

/// The edge between two corners; at the rim the surface is flat.
fn side(from: &Vertex, to: &Vertex) -> Edge {
    let poles = vec![from.point(), to.point()];
    Edge::new(from, to, Curve::BSplineCurve(BSplineCurve::new(KnotVec::bezier_knot(1), poles)))
}

fn line(from: (f64, f64), to: (f64, f64)) -> PCurve {
    let poles = vec![Point2::new(from.0, from.1), Point2::new(to.0, to.1)];
    PCurve::new(KnotVec::bezier_knot(1), poles)
}

/// Half a round hole, from its left to its right; `side` is 1 above, -1 below.
fn half(center: (f64, f64), radius: f64, side: f64) -> PCurve {
    let (left, right, bulge) = (center.0 - radius, center.0 + radius, side * radius * 4.0 / 3.0);
    let poles = [(left, 0.0), (left, bulge), (right, bulge), (right, 0.0)];
    let poles = poles.map(|(u, v)| Point2::new(u, center.1 + v)).to_vec();
    PCurve::new(KnotVec::bezier_knot(3), poles)
}

/// The image of a Bézier pcurve on the surface, of degree 12 and exact.
fn image(pcurve: &PCurve) -> BSplineCurve<Point3> {
    let u: Vec<f64> = pcurve.control_points().iter().map(|p| p.x).collect();
    let v: Vec<f64> = pcurve.control_points().iter().map(|p| p.y).collect();
    let rest = |t: &[f64]| t.iter().map(|t| 1.0 - t).collect::<Vec<_>>();
    let z = product(&product(&u, &rest(&u)), &product(&v, &rest(&v)));
    let one = [1.0; 10];
    let (x, y) = (product(&u, &one), product(&v, &one));
    let poles = (0..z.len()).map(|i| Point3::new(SIZE * x[i], SIZE * y[i], HEIGHT * z[i]));
    BSplineCurve::new(KnotVec::bezier_knot(12), poles.collect())
}

/// Product of two polynomials in Bernstein form.
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

/// A clockwise hole of two edges; one of them runs against its curve where
/// `reversed`, so that both directions occur.
fn hole(center: (f64, f64), radius: f64, reversed: bool) -> (Wire, Vec<PCurve>) {
    let (above, below) = (half(center, radius, 1.0), half(center, radius, -1.0));
    let left = Vertex::new(image(&above).control_points()[0]);
    let right = Vertex::new(*image(&above).control_points().last().unwrap());
    let there = Edge::new(&left, &right, Curve::BSplineCurve(image(&above)));
    if reversed {
        let back = Edge::new(&left, &right, Curve::BSplineCurve(image(&below))).inverse();
        return (vec![there, back].into(), vec![above, below]);
    }
    let mut below = below;
    below.invert();
    let back = Edge::new(&right, &left, Curve::BSplineCurve(image(&below)));
    (vec![there, back].into(), vec![above, below])
}

fn corners() -> Corners {
    [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| Vertex::new(point(u, v, 0.0)))
}

/// The sheet with two holes; its third side runs against its curve.
pub fn sheet() -> (TrimmedFace, Corners, Edge) {
    let [a, b, c, d] = corners();
    let top = side(&d, &c);
    let outer: Wire = vec![side(&a, &b), side(&b, &c), top.inverse(), side(&d, &a)].into();
    let sides = vec![
        line((0.0, 0.0), (1.0, 0.0)),
        line((1.0, 0.0), (1.0, 1.0)),
        line((0.0, 1.0), (1.0, 1.0)),
        line((0.0, 1.0), (0.0, 0.0)),
    ];
    let (first, of_first) = hole((0.3, 0.4), 0.13, true);
    let (second, of_second) = hole((0.7, 0.55), 0.1, false);
    let surface = Surface::BSplineSurface(surface(0.0));
    let face = Face::new(vec![outer, first, second], surface);
    let pcurves = vec![sides, of_first, of_second];
    (TrimmedFace { face, pcurves }, [a, b, c, d], top)
}

/// A second sheet behind the first; they share the edge `top`.
fn neighbour(corners: &Corners, top: &Edge) -> TrimmedFace {
    let [_, _, c, d] = corners;
    let (e, f) = (Vertex::new(point(1.0, 1.0, SIZE)), Vertex::new(point(0.0, 1.0, SIZE)));
    let wire: Wire = vec![top.clone(), side(c, &e), side(&e, &f), side(&f, d)].into();
    let sides = vec![
        line((0.0, 0.0), (1.0, 0.0)),
        line((1.0, 0.0), (1.0, 1.0)),
        line((1.0, 1.0), (0.0, 1.0)),
        line((0.0, 1.0), (0.0, 0.0)),
    ];
    let face = Face::new(vec![wire], Surface::BSplineSurface(surface(SIZE)));
    TrimmedFace { face, pcurves: vec![sides] }
}

fn brep(name: &str, faces: Vec<TrimmedFace>) -> Brep {
    Brep { name: name.into(), faces, uncertainty_mm: 1e-7 }
}

pub fn one_face(name: &str) -> Brep {
    brep(name, vec![sheet().0])
}

pub fn two_faces(name: &str) -> Brep {
    let (face, corners, top) = sheet();
    let second = neighbour(&corners, &top);
    brep(name, vec![face, second])
}

/// The sheet, looking against its surface's normal.
pub fn inverted(name: &str) -> Brep {
    let TrimmedFace { face, pcurves } = sheet().0;
    let pcurves = pcurves.into_iter().map(|of_loop| of_loop.into_iter().rev().collect());
    let pcurves = pcurves.collect();
    brep(name, vec![TrimmedFace { face: face.inverse(), pcurves }])
}

/// The sheet with a hole that runs the wrong way.
pub fn flipped_hole(name: &str) -> Brep {
    let TrimmedFace { face, mut pcurves } = sheet().0;
    let mut wires = face.boundaries();
    wires[1].invert();
    pcurves[1].reverse();
    let face = Face::new(wires, face.surface());
    brep(name, vec![TrimmedFace { face, pcurves }])
}
