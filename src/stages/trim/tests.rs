//! Tests on a plate of 200 mm × 100 mm with rims whose loops are known.

use std::f64::consts::TAU;

use super::*;
use crate::geometry::Vector;
use crate::spline::KnotVector;

const OPTIONS: Options =
    Options { tolerance: 0.04, rim: 0.0, least_rim: 0.0, keeps_vertices: true };

fn plate() -> Surface {
    let k = KnotVector::uniform(3, 12);
    let height = |i: usize, j: usize| ((3 * i + 5 * j) % 7) as f64;
    let net = (0..144).map(|n| (n / 12, n % 12));
    let net = net.map(|(i, j)| {
        Vector::new(200.0 * k.greville(i), 100.0 * k.greville(j), 0.3 * height(i, j))
    });
    Surface::new(k.clone(), k.clone(), net.collect())
}

/// A rim through the surface's points at `at(0)`, `at(1 / n)`, `at(2 / n)` and so on.
fn rim(surface: &Surface, n: usize, at: impl Fn(f64) -> (f64, f64)) -> Rim {
    let uv: Vec<Uv> = (0..n).map(|i| at(i as f64 / n as f64)).map(|(u, v)| Uv::new(u, v)).collect();
    let points = uv.iter().map(|&at| surface.point(at)).collect();
    Rim { of: Bound::Hole(0), within: None, points, uv }
}

/// A clockwise ellipse that is a circle of radius `r` mm on the plate; r may
/// depend on the angle.
fn round(u: f64, v: f64, r: impl Fn(f64) -> f64) -> impl Fn(f64) -> (f64, f64) {
    move |t| {
        let a = -TAU * t;
        (u + r(a) * a.cos() / 200.0, v + r(a) * a.sin() / 100.0)
    }
}

fn loops(surface: &Surface, rims: &[Rim]) -> Vec<(TrimLoop, LoopReport)> {
    let (loops, reports) = trim(surface, rims, &OPTIONS).unwrap();
    loops.into_iter().zip(reports).collect()
}

#[test]
fn knots_come_where_the_rim_needs_them() {
    let plate = plate();
    let tooth = |a: f64| if ((a / TAU * 600.0).round() as i64) % 2 == 0 { 10.1 } else { 9.9 };
    let smooth = loops(&plate, &[rim(&plate, 600, round(0.5, 0.5, |_| 10.0))]);
    let ragged = loops(&plate, &[rim(&plate, 600, round(0.5, 0.5, tooth))]);
    for (ring, report) in [&smooth[0], &ragged[0]] {
        // An edge has at most twelve spans.
        assert!(ring.pcurves.iter().all(|arc| arc.control.len() <= 15));
        assert!(report.max_off_surface < EDGE_ACCURACY);
        // The distance that decides on knots is exact only to first order.
        assert!(report.max_from_rim < 0.025, "{report:?}");
    }
    assert_eq!(smooth[0].0.edges.len(), 2);
    assert!(smooth[0].1.control_points < 30, "{:?}", smooth[0].1);
}

#[test]
fn a_fair_loop_passes_teeth_in_the_middle_and_keeps_to_its_room() {
    let plate = plate();
    let tooth = |a: f64| if ((a / TAU * 600.0).round() as i64) % 2 == 0 { 10.1 } else { 9.9 };
    let ragged = rim(&plate, 600, round(0.5, 0.5, tooth));
    let fair = Options { tolerance: 0.04, rim: 0.15, least_rim: 0.15, keeps_vertices: false };
    let (rings, reports) = trim(&plate, std::slice::from_ref(&ragged), &fair).unwrap();
    assert!(reports[0].control_points < 20, "{:?}", reports[0]);
    assert!(reports[0].max_from_rim < 0.15, "{:?}", reports[0]);
    // The teeth are 0.1 mm high on both sides of a circle.
    let centre = plate.point(Uv::new(0.5, 0.5));
    for edge in &rings[0].edges {
        for i in 0..=50 {
            let (a, b) = edge.knots.range();
            let p = Point::from(edge.point(a + (b - a) * f64::from(i) / 50.0));
            let r = (p - centre).xy().norm();
            assert!((r - 10.0).abs() < 0.05, "{r}");
        }
    }
    // If the vertices must stay within the tolerance, the loop has to follow the teeth.
    let strict = Options { keeps_vertices: true, ..fair };
    let (_, reports) = trim(&plate, &[ragged], &strict).unwrap();
    assert!(reports[0].control_points > 300 && reports[0].max_from_rim < 0.041, "{reports:?}");
}

#[test]
fn a_vertex_as_far_off_as_may_be_leaves_room_within_the_tolerance() {
    for share in [0.0f64, 0.3, 0.9, 1.0] {
        let off = share * Options::most_off(OPTIONS.tolerance);
        let farthest = off.hypot(OPTIONS.room(off));
        assert!(farthest <= OPTIONS.tolerance * (1.0 + 1e-12), "{share}");
        assert!(OPTIONS.room(off) >= LEAST_SHARE * OPTIONS.tolerance, "{share}");
    }
}

#[test]
fn a_side_that_misses_its_corner_is_divided_not_the_next_one() {
    let plate = plate();
    for high in (1..80).map(|i| 1e-5 * f64::from(i)) {
        // A plate 40 mm × 10 mm; its first side waves so that one span misses it at its
        // ends by twice as much as between.
        let end = 0.3 + high;
        let wave = |x: f64| 0.3 + high * (35.0 * x.powi(4) - 30.0 * x * x + 3.0) / 8.0;
        let side = |t: f64| match 10.0 * t {
            s if s < 1.0 => (wave(2.0 * s - 1.0), 0.4 + 0.1 * s),
            s if s < 5.0 => (end + (0.5 - end) * (s - 1.0) / 4.0, 0.5),
            s if s < 6.0 => (0.5, 0.5 - 0.1 * (s - 5.0)),
            s => (0.5 + (end - 0.5) * (s - 6.0) / 4.0, 0.4),
        };
        let (ring, report) = &loops(&plate, &[rim(&plate, 100, side)])[0];
        assert_eq!(ring.edges.len(), 4);
        // The room that the loop has, to first order.
        let room = 1.005 * ROOM_SHARE * OPTIONS.tolerance;
        assert!(report.max_from_rim < room, "{high} {report:?}");
    }
}

#[test]
fn a_square_hole_has_four_straight_edges() {
    let plate = plate();
    let corners = [(0.3, 0.3), (0.3, 0.7), (0.5, 0.7), (0.5, 0.3)];
    let side = |t: f64| {
        let (i, s) = ((4.0 * t) as usize, (4.0 * t).fract());
        let (a, b) = (corners[i % 4], corners[(i + 1) % 4]);
        (a.0 + s * (b.0 - a.0), a.1 + s * (b.1 - a.1))
    };
    // The rim does not begin at a corner.
    let rim = rim(&plate, 100, |t| side((t + 0.1).fract()));
    let (ring, report) = &loops(&plate, &[rim])[0];
    assert_eq!(ring.edges.len(), 4);
    assert!(report.max_from_rim < 0.02 && report.control_points < 60, "{report:?}");
    for c in &ring.pcurves {
        let near = |(u, v): &(f64, f64)| (c.control[0] - Uv::new(*u, *v).coords).norm() < 1e-4;
        assert!(corners.iter().any(near));
    }
}

#[test]
fn loops_make_way_for_each_other_across_a_narrow_bridge() {
    let plate = plate();
    // A wave with teeth that the other rim follows 0.3 mm away; spans of four
    // vertices would cut it off.
    let wave = |x: f64| 0.5 + 0.02 * (TAU * x * 12.0).sin();
    let strip = |low: f64, high: f64, t: f64| {
        // Clockwise: up along the left, along the top, and back below.
        let (x, top) = if t < 0.5 { (2.0 * t, true) } else { (2.0 - 2.0 * t, false) };
        (0.2 + 0.6 * x, wave(x) + if top { high } else { low })
    };
    let rims =
        [rim(&plate, 120, |t| strip(0.0, 0.1, t)), rim(&plate, 120, |t| strip(-0.1, -0.003, t))];
    let found = loops(&plate, &rims);
    assert!(found.iter().all(|(_, report)| report.max_from_rim < 1.0));
}

#[test]
fn rims_that_cross_are_refused_with_the_place() {
    let plate = plate();
    let one = rim(&plate, 60, round(0.5, 0.5, |_| 10.0));
    let other = rim(&plate, 60, round(0.56, 0.5, |_| 10.0));
    let found = trim(&plate, &[one, other], &OPTIONS);
    let Err(Error::Trim { at, .. }) = found else { panic!("{found:?}") };
    assert!((at.x - 106.0).abs() < 1.0 && ((at.y - 50.0).abs() - 8.0).abs() < 1.0, "{at}");
}

#[test]
fn three_vertices_make_a_loop_and_one_place_makes_none() {
    let plate = plate();
    let (ring, report) = &loops(&plate, &[rim(&plate, 3, round(0.5, 0.5, |_| 1.0))])[0];
    assert!(ring.edges.len() <= 4 && report.max_from_rim < 0.5, "{report:?}");
    let nothing = rim(&plate, 3, |_| (0.5, 0.5));
    assert!(trim(&plate, &[nothing], &OPTIONS).is_err());
}

#[test]
fn four_thousand_vertices_with_teeth_end() {
    let plate = plate();
    let star = |a: f64| 30.0 * (1.0 + 0.3 * (40.0 * a).cos()) + 0.05 * (911.0 * a).sin();
    let (_, report) = &loops(&plate, &[rim(&plate, 4000, round(0.5, 0.5, star))])[0];
    assert!(report.control_points <= 2000 && report.max_from_rim < 0.03, "{report:?}");
}
