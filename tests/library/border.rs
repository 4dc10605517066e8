//! Every invalid argument of a library call gives an error of the documented kind and never a
//! panic.

use crate::common::face_of;
use formats::Soup;
use scan2step::geometry::{Point, Uv, Vector};
use scan2step::mesh::{self, Bound, Choice, Components, Disk, Outer};
use scan2step::rules::Fault;
use scan2step::spline::{Curve, KnotVector, Samples, Surface};
use scan2step::stages::adapt::{self, Goal};
use scan2step::stages::trim::{self, Rim};
use scan2step::stages::{brep, fill, fit, parameterize, smooth};
use scan2step::{Builder, Cut, Error, Options};

const NONSENSE: [f64; 4] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0];

/// A sheet of n × n squares of 1 mm with a hole of four squares.
fn sheet(n: u32) -> Soup {
    let mut soup = Soup::default();
    let m = n + 1;
    for k in 0..m * m {
        let (x, y) = (f64::from(k % m), f64::from(k / m));
        soup.points.push([x, y, 0.2 * x.sin()]);
    }
    let middle = n / 2 - 1..n / 2 + 1;
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        if !(middle.contains(&i) && middle.contains(&j)) {
            let a = j * m + i;
            soup.polygons.push([a, a + 1, a + m + 1, a + m]);
        }
    }
    soup
}

fn disk() -> Disk {
    let pieces = Components::new(mesh::from_soup(&sheet(12), 1.0).expect("a mesh"));
    let mut repairs = pieces.repairs().clone();
    let piece = pieces.take(Choice::Largest).expect("a piece");
    piece.into_disk(Outer::Auto, &mut repairs).expect("a disk")
}

fn option<T>(found: Result<T, Error>) -> (&'static str, Fault) {
    match found {
        Err(Error::Option { option, fault }) => (option, fault),
        Err(e) => panic!("another error: {e}"),
        Ok(_) => panic!("it was taken"),
    }
}

fn is_input<T>(found: Result<T, Error>) -> bool {
    matches!(found, Err(Error::Input(_)))
}

#[test]
fn options_that_cannot_be_are_not_built() {
    type Set = fn(Builder, f64) -> Builder;
    let lengths: [(&str, Set); 4] = [
        ("tolerance", |b, x| b.tolerance(x)),
        ("kappa", |b, x| b.kappa(x)),
        ("unit", |b, x| b.unit_mm(x)),
        ("smooth", |b, x| b.smooth(smooth::Support::Fixed(x))),
    ];
    for (name, set) in lengths {
        for x in NONSENSE.into_iter().chain([0.0]) {
            let found = option(set(Options::builder(), x).build());
            assert_eq!(found, (name, Fault::Length), "{x}");
        }
        set(Options::builder(), 0.5).build().expect("half a millimetre is a length");
    }
    for x in NONSENSE {
        let nowhere = Point::new(0.0, x, 0.0);
        let b = Options::builder;
        assert_eq!(option(b().outliers(x).build()), ("outliers", Fault::Share));
        assert_eq!(option(b().ear_angle(x).build()), ("ear_angle", Fault::Angle));
        assert_eq!(option(b().cut(Cut::FromLength(x)).build()), ("cut", Fault::Extent));
        if !x.is_finite() {
            let at = smooth::Corners::At(vec![nowhere]);
            assert_eq!(option(b().boundary_corners(at).build()).0, "boundary_corners");
            assert_eq!(option(b().corners([nowhere; 4]).build()), ("corners", Fault::Point));
            assert_eq!(option(b().outer(Outer::Near(nowhere)).build()), ("outer", Fault::Point));
        }
    }
}

#[test]
fn nets_have_bounds() {
    let b = Options::builder;
    for absurd in [0, 15, (1 << 24) + 1, usize::MAX] {
        assert_eq!(option(b().max_net(absurd).build()), ("max_net", Fault::MaxNet));
    }
    assert_eq!(option(b().depth(21).build()), ("depth", Fault::Depth));
    assert_eq!(option(b().net([3, 100]).build()), ("net", Fault::SmallNet));
    let net = [usize::MAX, usize::MAX];
    let large = Fault::LargeNet { net, most: 250_000 };
    assert_eq!(option(b().net(net).build()), ("net", large));
}

#[test]
fn stages_look_at_what_they_are_given() {
    let disk = disk();
    let measured = disk.mesh.points.as_slice();
    let how = fill::Options::default();
    assert!(is_input(fill::fill(disk.clone(), &[], &how)));
    let (patch, _) = fill::fill(disk.clone(), measured, &how).expect("a patch");
    let how = parameterize::Options::default();
    let (mut map, _) = parameterize::parameterize(patch.clone(), &how).expect("a map");
    for x in NONSENSE {
        let how = smooth::Options { support: smooth::Support::Fixed(x), ..Default::default() };
        assert_eq!(option(smooth::smooth(&disk, &how)).0, "smooth");
        let how = fill::Options { noise: x, ..Default::default() };
        assert_eq!(option(fill::fill(disk.clone(), measured, &how)).0, "noise");
        let goal = Goal { tolerance: x, named: true, outliers: 0.0 };
        assert_eq!(option(adapt::fit(&mut map, &adapt::Options::default(), &goal)).0, "tolerance");
        let goal = Goal { tolerance: 0.1, named: true, outliers: 0.0 };
        let mut how = adapt::Options::default();
        how.knots.kappa = Some(x);
        assert_eq!(option(adapt::fit(&mut map, &how, &goal)).0, "kappa");
        let goal = Goal { tolerance: 0.1, named: true, outliers: x };
        assert_eq!(option(adapt::fit(&mut map, &adapt::Options::default(), &goal)).0, "outliers");
    }
    let how = parameterize::Options {
        corners: Some([Point::new(f64::NAN, 0.0, 0.0); 4]),
        ..Default::default()
    };
    assert_eq!(option(parameterize::parameterize(patch, &how)), ("corners", Fault::Point));
}

#[test]
fn a_soup_of_ones_own_may_be_nonsense() {
    let mut soup = sheet(6);
    for mm in NONSENSE.into_iter().chain([0.0]) {
        assert_eq!(option(mesh::from_soup(&soup, mm)), ("unit", Fault::Length));
    }
    // Too few corners, repeated corners, and non-finite points are repaired.
    soup.polygons.push([]);
    soup.polygons.push([1]);
    soup.polygons.push([1, 2]);
    soup.polygons.push([1, 1, 2]);
    soup.points.push([f64::NAN, 0.0, 1e300]);
    let last = soup.points.len() as u32 - 1;
    soup.polygons.push([0, 1, last]);
    assert_eq!(soup.polygons.triangle_count(), 6 * 6 * 2 - 8 + 2);
    let made = mesh::from_soup(&soup, 1.0).expect("the rest is sound");
    assert_eq!(made.repairs.get("degenerate_faces"), Some(&4));
    face_of(&soup, &Options::default()).expect("the rest is sound");
    soup.polygons.push([0, 1, last + 1]);
    assert!(is_input(face_of(&soup, &Options::default())));
    assert!(matches!(mesh::from_soup(&Soup::default(), 1.0), Err(Error::Empty(_))));
}

fn plate() -> Surface {
    let k = KnotVector::cubic(5).expect("knots");
    let at = |n: usize| Vector::new(10.0 * k.greville(n / 5), 10.0 * k.greville(n % 5), 0.0);
    Surface::try_new(k.clone(), k.clone(), (0..25).map(at).collect()).expect("a surface")
}

#[test]
fn splines_of_ones_own_are_looked_at() {
    assert!(is_input(KnotVector::cubic(3)));
    assert!(is_input(KnotVector::try_new(0, vec![0.0, 1.0])));
    assert!(is_input(KnotVector::try_new(6, vec![0.0; 14])));
    assert!(is_input(KnotVector::try_new(3, vec![0.0; 8])));
    assert!(is_input(KnotVector::try_new(1, vec![0.0, 1.0, 0.5, 2.0])));
    assert!(is_input(KnotVector::try_new(1, vec![0.0, f64::NAN, 1.0, 2.0])));
    let line = KnotVector::try_new(1, vec![0.0, 0.0, 1.0, 1.0]).expect("a line's");
    assert!(is_input(Curve::<2>::try_new(line.clone(), Vec::new())));
    assert!(is_input(Surface::try_new(line.clone(), line, Vec::new())));
}

#[test]
fn samples_are_looked_at() {
    let samples = |n: usize| Samples {
        points: (0..n).map(|k| Point::new(k as f64, 0.0, 0.0)).collect(),
        uv: (0..n).map(|k| Uv::new(k as f64 / n as f64, 0.5)).collect(),
        weights: vec![1.0; n],
        open: false,
    };
    let knots = || [0, 1].map(|_| KnotVector::cubic(4).expect("knots"));
    for method in [fit::Method::Blend, fit::Method::Refined, fit::Method::Global] {
        assert!(matches!(fit::fit(&samples(0), knots(), method), Err(Error::Empty(_))));
        let mut wrong = samples(40);
        wrong.uv.pop();
        assert!(is_input(fit::fit(&wrong, knots(), method)));
        let mut wrong = samples(40);
        wrong.points[7].z = f64::NAN;
        assert!(is_input(fit::fit(&wrong, knots(), method)));
        let mut wrong = samples(40);
        wrong.weights[7] = 0.0;
        assert!(is_input(fit::fit(&wrong, knots(), method)));
        let line = || KnotVector::try_new(1, vec![0.0, 0.0, 1.0, 1.0]).expect("knots");
        assert!(is_input(fit::fit(&samples(40), [line(), line()], method)));
    }
}

#[test]
fn rims_are_looked_at() {
    let plate = plate();
    let around = |n: usize, within| {
        let uv: Vec<Uv> = (0..n)
            .map(|k| -std::f64::consts::TAU * k as f64 / n as f64)
            .map(|a| Uv::new(0.5 + 0.2 * a.cos(), 0.5 + 0.2 * a.sin()))
            .collect();
        let points = uv.iter().map(|&at| plate.point(at)).collect();
        Rim { of: Bound::Hole(0), within, points, uv }
    };
    let trim = |rims: &[Rim], tolerance| {
        let options = trim::Options { tolerance, rim: 0.0, least_rim: 0.0, keeps_vertices: true };
        trim::trim(&plate, rims, &options)
    };
    let (loops, _) = trim(&[around(30, None)], 0.1).expect("a loop");
    for x in NONSENSE.into_iter().chain([0.0]) {
        assert_eq!(option(trim(&[around(30, None)], x)).0, "tolerance");
    }
    assert!(is_input(trim(&[around(0, None)], 0.1)));
    assert!(is_input(trim(&[around(30, Some(0))], 0.1)));
    assert!(is_input(trim(&[around(30, Some(7))], 0.1)));
    let mut short = around(30, None);
    short.uv.pop();
    assert!(is_input(trim(&[short], 0.1)));
    for n in [1, 2] {
        assert!(matches!(trim(&[around(n, None)], 0.1), Err(Error::Trim { .. })), "{n}");
    }
    // A loop that is not closed, a loop without an edge, and a loop with one edge more than
    // pcurves.
    let (arcs, edges) = (loops[0].pcurves.as_slice(), loops[0].edges.as_slice());
    for inner in [(&arcs[1..], &edges[1..]), (&arcs[..0], &edges[..0]), (&arcs[1..], edges)] {
        let bounds = brep::FaceBounds { outer: None, inner: vec![inner] };
        let built = brep::build(&plate, &[bounds], "plate", trim::EDGE_ACCURACY);
        assert!(matches!(built, Err(Error::Brep(_))));
    }
}
