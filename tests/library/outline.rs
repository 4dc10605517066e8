//! The outer boundary as a trim loop.

use crate::common::virtual_scan::{VirtualScan, island_scan, ragged_scan, relief, relief_scan};
use crate::common::{OneFace, face_seen};
use scan2step::geometry::{Point, Uv};
use scan2step::mesh::{Bound, FaceOrigin, Patch};
use scan2step::spline::Curve;
use scan2step::stages::parameterize::Outline;
use scan2step::stages::trim::{TrimLoop, distance_to_edges};
use scan2step::{Body, Options, Stage};

/// A conversion and the outer boundary of the smoothed scan.
struct Run {
    conversion: Body,
    outer: Vec<Point>,
}

fn soup(scan: &VirtualScan) -> formats::Soup {
    let mut soup = formats::Soup { points: scan.points.clone(), ..formats::Soup::default() };
    scan.triangles.iter().for_each(|t| soup.polygons.push(*t));
    soup
}

fn run(scan: &VirtualScan, outline: Outline, tolerance: Option<f64>) -> Run {
    let soup = soup(scan);
    let options = Options::builder().outline(outline).tolerance(tolerance).build().unwrap();
    let mut outer = Vec::new();
    let mut watch = |stage: Stage| {
        if let Stage::Parameterize(map, _) = stage {
            let measured = map.patch.loop_of(Bound::Outer);
            outer = measured.iter().map(|&v| map.patch.mesh.point(v)).collect();
        }
        Ok(())
    };
    let conversion = face_seen(&soup, &options, &mut watch).expect("a face");
    Run { conversion, outer }
}

fn free(scan: &VirtualScan) -> Run {
    run(scan, Outline::Free, None)
}

/// The corners of a polygon that follows a loop in (u, v).
fn polygon(ring: &TrimLoop) -> Vec<[f64; 2]> {
    let of_arc = |arc: &Curve<2>| {
        let (first, last) = arc.knots.range();
        let at = |i: i32| arc.point(first + (last - first) * f64::from(i) / 4000.0);
        (0..4000).map(at).map(|p| [p.x, p.y]).collect::<Vec<_>>()
    };
    ring.pcurves.iter().flat_map(of_arc).collect()
}

/// Twice the signed area of a polygon.
fn area(polygon: &[[f64; 2]]) -> f64 {
    let nexts = polygon.iter().cycle().skip(1);
    polygon.iter().zip(nexts).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum()
}

fn is_inside(p: [f64; 2], polygon: &[[f64; 2]]) -> bool {
    let nexts = polygon.iter().cycle().skip(1);
    let crossed = polygon.iter().zip(nexts).filter(|(a, b)| {
        (a[1] > p[1]) != (b[1] > p[1])
            && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    });
    crossed.count() % 2 == 1
}

#[test]
fn the_outer_loop_follows_the_rim_around_all_others() {
    for scan in [relief_scan(), island_scan(), ragged_scan()] {
        let Run { conversion: c, outer } = free(&scan);
        assert_eq!(c.one().loops[0].of, Bound::Outer);
        assert!(c.one().outer.is_none(), "the sides are not the outer boundary");
        let off = distance_to_edges(&outer, &c.one().loops[0].edges);
        let rim = c.one().rim_tolerance;
        assert!(off <= rim, "{off} mm off the rim, of {rim}");
        assert!(c.one().trim[0].max_off_surface < 1e-7, "{:?}", c.one().trim[0]);

        let around = polygon(&c.one().loops[0]);
        assert!(area(&around) > 0.0, "it runs counter-clockwise");
        assert!(around.iter().flatten().all(|t| (0.001..0.999).contains(t)));
        for ring in &c.one().loops[1..] {
            let ring_polygon = polygon(ring);
            assert!(ring_polygon.iter().step_by(100).all(|&p| is_inside(p, &around)));
            assert_eq!(area(&ring_polygon) < 0.0, matches!(ring.of, Bound::Hole(_)));
            assert!(ring.within.is_some(), "every loop is in another one");
        }
        let faces = scan.faces_and_inner_loops().0;
        assert_eq!(c.brep.faces.len(), faces);
    }
}

#[test]
fn a_named_tolerance_holds_up_to_the_outer_loop() {
    for tolerance in [0.02, 0.05] {
        let c = run(&relief_scan(), Outline::Free, Some(tolerance)).conversion;
        assert_eq!(c.missed.points, 0, "{} of {tolerance}", c.fit_deviation.max);
        assert!(c.tolerance_met(0.0), "{:?}", c.face_to_scan);
    }
}

/// Beyond its samples the surface continues smoothly without folds, and its net stays near.
#[test]
fn the_surface_is_calm_beyond_the_outer_loop() {
    for scan in [relief_scan(), ragged_scan()] {
        let Run { conversion: c, outer } = free(&scan);
        let [low, high] = [f64::min, f64::max].map(|pick| {
            let point = |axis: usize| outer.iter().map(|p| p[axis]).reduce(pick);
            [0, 1, 2].map(|axis| point(axis).expect("a rim"))
        });
        let size = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        for p in &c.one().surface.net {
            let beyond = (0..3).map(|axis| (low[axis] - p[axis]).max(p[axis] - high[axis]));
            // The dome rises above its rim by a fifth of its size.
            let beyond = beyond.fold(0.0, f64::max);
            assert!(beyond < 0.3 * size, "{p} is {beyond} mm away");
        }
    }
}

/// If the boundary is clean, the surface is as accurate as with four sides.
#[test]
fn the_truth_is_met_as_well_as_with_sides() {
    let holes = relief_scan().holes;
    // The chosen knots, and with them the error, depend on the noise.
    let scans =
        [1, 2, 3, 4].map(|seed| VirtualScan::new(relief, [70, 60], 0.06, holes.clone(), seed));
    let square = |outline| {
        let squares = scans.iter().map(|scan| {
            let c = run(scan, outline, None).conversion;
            let at = (1..40).flat_map(|i| (1..40).map(move |j| (f64::from(i), f64::from(j))));
            let at = at.map(|(i, j)| [0.025 * i, 0.025 * j]);
            let outer = c.one().loops.iter().find(|l| l.of == Bound::Outer).map(polygon);
            let inside = at.filter(|&p| outer.as_ref().is_none_or(|outer| is_inside(p, outer)));
            let points = inside.map(|[u, v]| c.one().surface.point(Uv::new(u, v)));
            let rms = scan.rms(points.map(|p| p.coords.into()));
            println!("{outline:?}: {rms}");
            rms * rms
        });
        squares.sum::<f64>()
    };
    let (sides, free) = (square(Outline::Sides).sqrt(), square(Outline::Free).sqrt());
    assert!(free < 1.1 * sides, "{free} mm rms, with sides {sides}");
}

#[test]
fn the_same_loop_on_any_number_of_threads() {
    let scan = ragged_scan();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let c = pool.install(|| free(&scan)).conversion;
        (c.one().surface.net.clone(), format!("{:?}", c.one().loops))
    };
    assert_eq!(on(1), on(2));
}

/// The triangles of a patch with a given origin.
fn count(patch: &Patch, of: fn(&FaceOrigin) -> bool) -> usize {
    patch.origin.iter().filter(|origin| of(origin)).count()
}

#[test]
fn bays_are_no_fills() {
    let scan = ragged_scan();
    for outline in [Outline::Free, Outline::Sides] {
        let mut there = [0, 0];
        let options = Options::builder().outline(outline).build().unwrap();
        let mut watch = |stage: Stage| {
            if let Stage::Parameterize(map, _) = stage {
                let of_hole: fn(&FaceOrigin) -> bool = |o| matches!(o, FaceOrigin::Hole(_));
                there = [of_hole, |o| *o == FaceOrigin::Bay].map(|of| count(&map.patch, of));
            }
            Ok(())
        };
        let c = face_seen(&soup(&scan), &options, &mut watch).expect("a face");
        let added: usize = c.fill.holes.iter().map(|hole| hole.added_triangles).sum();
        assert_eq!([added, c.one().parameterize.bays.added_triangles], there, "{outline:?}");
        let are_bays = outline == Outline::Free;
        assert_eq!((c.one().parameterize.bays.count > 0, there[1] > 0), (are_bays, are_bays));
    }
}
