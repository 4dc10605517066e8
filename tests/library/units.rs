//! The same scan in other units, or multiplied by a power of two, becomes the same face up to that
//! factor. The same is true of all reported figures.

use crate::common::{OneFace, face_of, face_seen};
use std::fmt::Debug;

use scan2step::formats::{LengthUnit, Soup};
use scan2step::geometry::Point;
use scan2step::mesh::{Components, Outer};
use scan2step::stages::smooth;
use scan2step::{Body, Builder, Cut, Error, Options, Stage, mesh};

/// A factor that is exact in binary.
const FACTOR: f64 = 1024.0;

/// A wavy sheet of 36 × 24 with rough points and a hole. All lengths are multiplied by a factor.
fn sheet(factor: f64) -> Soup {
    let (m, n) = (37_u32, 25_u32);
    let mut soup = Soup::default();
    let mut state = 1_u64;
    for k in 0..m * n {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let noise = (state >> 40) as f64 / (1_u64 << 24) as f64 - 0.5;
        let (x, y) = (f64::from(k % m), f64::from(k / m));
        let z = (0.2 * x).sin() * (0.15 * y).cos() + 0.05 * noise;
        soup.points.push([x, y, z].map(|x| x * factor));
    }
    for k in 0..(m - 1) * (n - 1) {
        let (i, j) = (k % (m - 1), k / (m - 1));
        if (f64::from(i) - 20.5).hypot(f64::from(j) - 11.5) > 4.0 {
            let a = j * m + i;
            soup.polygons.push([a, a + 1, a + m + 1, a + m]);
        }
    }
    soup
}

/// A conversion and the points that its stages showed.
fn converted(soup: &Soup, options: Builder) -> (Body, Vec<Vec<Point>>) {
    let options = options.build().expect("sound options");
    let mut seen = Vec::new();
    let mut watch = |stage: Stage| {
        seen.push(match stage {
            Stage::Mesh(disk) | Stage::Smooth(disk) => disk.mesh.points.clone(),
            Stage::Fill(patch) => patch.mesh.points.clone(),
            Stage::Parameterize(map, _) => map.patch.mesh.points.clone(),
            Stage::Fit(s) | Stage::Trim(s, _) => s.net.iter().map(|&p| p.into()).collect(),
            _ => return Ok(()),
        });
        Ok(())
    };
    (face_seen(soup, &options, &mut watch).expect("a face"), seen)
}

/// The numbers except counts in the printed form of a value.
fn numbers(of: &dyn Debug) -> Vec<f64> {
    let text = format!("{of:?}");
    let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c)));
    words.filter(|w| w.contains(['.', 'e'])).filter_map(|w| w.parse().ok()).collect()
}

/// The lengths of a conversion, and the values that are not lengths.
fn lengths(c: &Body) -> Vec<Vec<f64>> {
    let all: [&dyn Debug; 10] = [
        &c.input.bounds,
        &c.one().surface.net,
        &c.smooth,
        &c.fill,
        &c.one().adapted,
        &c.tolerance,
        &c.fit_deviation,
        &c.deviation,
        &c.one().outer,
        &c.one().crushed.map(|crushed| crushed.at),
    ];
    all.iter().map(|of| numbers(*of)).collect()
}

fn rest(c: &Body) -> String {
    let pcurves: Vec<_> = c.one().loops.iter().map(|l| (l.of, l.within, &l.pcurves)).collect();
    let knots = (&c.one().surface.u, &c.one().surface.v);
    let mut input = c.input.clone();
    input.bounds = Default::default();
    format!(
        "{:?}",
        (pcurves, knots, input, &c.trimmed, &c.one().parameterize, &c.one().adapted.knots)
    )
}

/// Whether the second conversion is the first one with all lengths multiplied by `factor`, within a
/// relative error of a length.
fn are_alike(a: &(Body, Vec<Vec<Point>>), b: &(Body, Vec<Vec<Point>>), factor: f64, share: f64) {
    let alike = |a: f64, b: f64| (factor * a - b).abs() <= share * b.abs();
    for (which, (a, b)) in lengths(&a.0).iter().zip(lengths(&b.0)).enumerate() {
        assert_eq!(a.len(), b.len(), "{which}");
        a.iter().zip(&b).for_each(|(&a, &b)| assert!(alike(a, b), "{which}: {a} {b}"));
    }
    assert_eq!(rest(&a.0), rest(&b.0));
    assert_eq!((a.1.len(), b.1.len()), (6, 6));
    for (a, b) in a.1.iter().flatten().zip(b.1.iter().flatten()) {
        assert!((0..3).all(|k| alike(a[k], b[k])), "{a} {b}");
    }
    // Edges are traced in mm with the accuracy that CAD needs, and distances from rims are measured
    // from them.
    for (a, b) in a.0.one().trim.iter().zip(&b.0.one().trim) {
        assert!((factor * a.max_from_rim - b.max_from_rim).abs() < 3e-7 * factor.max(1.0));
    }
    for (a, b) in a.0.one().loops.iter().zip(&b.0.one().loops) {
        for (a, b) in a.edges.iter().zip(&b.edges) {
            let (from, to) = a.knots.range();
            let middle = 0.5 * (from + to);
            assert!((factor * a.point(middle) - b.point(middle)).norm() < 3e-7 * factor.max(1.0));
        }
    }
    assert!(b.0.one().trim.iter().all(|l| l.max_off_surface < 1.01e-7), "{:?}", b.0.one().trim);
}

#[test]
fn a_power_of_two_changes_no_digit() {
    let a = converted(&sheet(1.0), Options::builder());
    assert!(lengths(&a.0).iter().flatten().count() > 1000, "there is much to compare");
    assert_eq!(a.0.one().loops.len(), 1);
    let larger = converted(&sheet(FACTOR), Options::builder());
    are_alike(&a, &larger, FACTOR, 0.0);
    let in_km = converted(&sheet(1.0), Options::builder().unit_mm(FACTOR));
    are_alike(&a, &in_km, FACTOR, 0.0);
}

#[test]
fn a_unit_changes_roundings_only() {
    let a = converted(&sheet(1.0), Options::builder());
    for unit in [LengthUnit::Centimetre, LengthUnit::Metre, LengthUnit::Inch] {
        let b = converted(&sheet(1.0), Options::builder().unit(unit));
        are_alike(&a, &b, unit.in_mm(), 1e-15);
    }
}

#[test]
fn what_is_named_in_mm_is_meant_in_mm() {
    let options = |mm: f64| {
        let at = |x: f64, y: f64| Point::new(x * mm, y * mm, 0.0);
        Options::builder()
            .tolerance(0.3 * mm)
            .kappa(0.2 * mm)
            .smooth(smooth::Support::Fixed(2.5 * mm))
            .boundary_corners(smooth::Corners::At(vec![at(36.0, 24.0)]))
            .corners([at(0.0, 0.0), at(36.0, 0.0), at(36.0, 24.0), at(0.0, 24.0)])
            .outer(Outer::Near(at(0.0, 0.0)))
            .cut(Cut::FromLength(100.0 * mm))
    };
    let a = converted(&sheet(1.0), options(1.0));
    assert_eq!((a.0.trimmed.as_slice(), a.0.smooth.corners.len()), (&[false][..], 1));
    are_alike(&a, &converted(&sheet(FACTOR), options(FACTOR)), FACTOR, 0.0);
    let b = converted(&sheet(1.0), options(25.4).unit(LengthUnit::Inch));
    are_alike(&a, &b, 25.4, 1e-9);
    // The values must be the given ones to the last digit.
    let named = (0.3 * 25.4, Some(0.2 * 25.4), 2.5 * 25.4);
    assert_eq!((b.0.tolerance, b.0.one().adapted.kappa, b.0.smooth.h), named);
}

#[test]
fn a_scan_has_the_unit_that_it_declares() {
    let mut soup = sheet(1e-3);
    soup.unit = Some(LengthUnit::Metre);
    let across = |options: Builder| {
        let (c, _) = converted(&soup, options);
        c.one().surface.net.iter().map(|p| p.x).fold(0.0, f64::max)
    };
    assert!((across(Options::builder()) - 36.0).abs() < 0.5);
    assert!((across(Options::builder().unit(LengthUnit::Millimetre)) - 0.036).abs() < 5e-4);
}

#[test]
fn what_is_looked_at_is_in_mm() {
    let looked = |soup: &Soup, mm: f64| {
        let pieces = || Components::new(mesh::from_soup(soup, mm).expect("a mesh"));
        let found = scan2step::inspect(pieces(), mesh::Choice::Largest, Outer::Auto);
        let found = found.expect("a piece");
        let measured = scan2step::measured(&pieces(), &[mesh::Choice::Largest], Outer::Auto);
        let mesh = measured.expect("a piece").mesh;
        let piece = pieces().take(mesh::Choice::Largest).expect("a piece");
        let all: [&dyn Debug; 6] = [
            &found.loops,
            &found.input.bounds,
            &found.noise,
            &found.tolerance,
            &mesh.points,
            &piece.mesh().points,
        ];
        all.iter().flat_map(|of| numbers(*of)).collect::<Vec<_>>()
    };
    let a = looked(&sheet(1.0), 1.0);
    let larger: Vec<f64> = a.iter().map(|x| FACTOR * x).collect();
    assert_eq!(looked(&sheet(FACTOR), 1.0), larger);
    assert_eq!(looked(&sheet(1.0), FACTOR), larger);
    assert!(a.contains(&36.0), "the sheet's width");
}

#[test]
fn errors_speak_of_mm() {
    let support = |mm: f64| {
        let options = Options::builder().unit_mm(mm).smooth(smooth::Support::Fixed(0.1 * mm));
        let options = options.build().expect("options");
        match face_of(&sheet(1.0), &options) {
            Err(Error::Support { h, shortest, longest }) => [h, shortest, longest],
            other => panic!("{other:?}"),
        }
    };
    let one = support(1.0);
    assert!(one[0] == 0.1 && one[2] > 43.0 && one[2] < 44.0, "{one:?}");
    assert_eq!(support(FACTOR), one.map(|x| FACTOR * x));
    // A setting of the caller is not changed.
    let own = Error::Support { h: 1.0, shortest: 2.0, longest: 3.0 };
    let mut own = Some(own);
    let answer =
        face_seen(&sheet(1.0), &Options::default(), &mut |_| own.take().map_or(Ok(()), Err));
    assert!(matches!(answer, Err(Error::Support { h: 1.0, shortest: 2.0, longest: 3.0 })));
}

#[test]
fn specks_and_giants_have_the_same_net() {
    let net = |factor: f64| converted(&sheet(factor), Options::builder()).0.one().surface.shape();
    let usual = net(1.0);
    for power in [-40, -20, 20, 60] {
        assert_eq!(net(2f64.powi(power)), usual, "two to the power of {power}");
    }
    for (factor, mm) in [(1e-300, 1.0), (1e-200, 1e-200)] {
        let options = Options::builder().unit_mm(mm).build().expect("options");
        let found = face_of(&sheet(factor), &options);
        assert!(!matches!(found, Err(Error::Singular(_) | Error::Brep(_))), "{factor}: {found:?}");
    }
}
