//! Cells contain what they claim, and the tree finds what a search of all cells finds.

use super::*;
use crate::geometry::Vector;
use crate::spline::{KnotVector, Surface, foot_point};

/// A rolled-up, waved sheet with uneven knots.
fn rolled() -> Surface {
    let knots = |n: usize| {
        let breaks: Vec<f64> = (0..=n).map(|i| (i as f64 / n as f64).powf(1.5)).collect();
        KnotVector::clamped(3, &breaks, 1)
    };
    let (u, v) = (knots(17), knots(8));
    let mut net = Vec::new();
    for i in 0..u.functions() {
        for j in 0..v.functions() {
            let (angle, height) = (9.0 * u.greville(i), v.greville(j));
            let radius = 10.0 + 4.0 * u.greville(i) + 0.5 * (20.0 * height).sin();
            net.push(Vector::new(radius * angle.cos(), radius * angle.sin(), 40.0 * height));
        }
    }
    Surface::new(u, v, net)
}

fn places(low: Uv, high: Uv) -> impl Iterator<Item = Uv> {
    let share = |i: usize| i as f64 / 9.0;
    (0..100).map(move |n| {
        let (x, y) = (share(n / 10), share(n % 10));
        Uv::new(low.x + x * (high.x - low.x), low.y + y * (high.y - low.y))
    })
}

#[test]
fn a_cell_and_its_parts_hold_the_surface() {
    let surface = rolled();
    let grid = CellGrid::new(&surface);
    for whole in &grid.cells {
        for cell in whole.split(&surface).chain([*whole]) {
            let [low, high] = cell.bounds();
            for at in places(cell.low, cell.high) {
                let p = surface.point(at);
                assert!(cell.nearest(p).1 <= cell.spread() * (1.0 + 1e-9) + 1e-12);
                assert!((p.sup(&low).inf(&high) - p).norm() < 1e-12);
            }
        }
    }
}

#[test]
fn no_place_of_a_cell_is_nearer_than_its_bound() {
    let surface = rolled();
    let grid = CellGrid::new(&surface);
    let mut tight = 0;
    for (n, cell) in grid.cells.iter().enumerate() {
        let p = cell.centre + Vector::new(1.0, -2.0, 0.5) * ((n % 7) as f64 / 3.0);
        let derivative_bounds = cell.derivative_bounds();
        for at in places(cell.low, cell.high).step_by(7) {
            let jet = surface.jet(at);
            let foot = Foot { at, jet, distance: (jet.s - p).norm() };
            let bound = cell.least_distance(p, &foot, &derivative_bounds);
            let nearest = places(cell.low, cell.high).map(|at| (surface.point(at) - p).norm());
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            assert!(bound <= nearest + 1e-9, "{bound} {nearest}");
            tight += u32::from(bound > 0.5 * nearest);
        }
    }
    assert!(tight > 100, "no bound says anything: {tight}");
}

#[test]
fn a_cell_without_a_foot_has_none() {
    let surface = rolled();
    let grid = CellGrid::new(&surface);
    let p = surface.point(Uv::new(0.4, 0.5)) + Vector::new(0.5, 0.5, 0.0);
    let (mut feet, mut without) = (0, 0);
    for cell in &grid.cells {
        let part = CellRestriction { surface: &surface, low: cell.low, high: cell.high };
        let (at, _) = foot_point(&part, p, nalgebra::center(&cell.low, &cell.high));
        let inner = |k: usize| at[k] > cell.low[k] + 1e-9 && at[k] < cell.high[k] - 1e-9;
        let has_none = cell.has_no_foot(p, &cell.derivative_bounds());
        assert!(!(has_none && inner(0) && inner(1)));
        feet += u32::from(inner(0) && inner(1));
        without += u32::from(has_none);
    }
    // For 68 cells the place alone proves it. For the others the tree has to divide cells.
    assert!(feet > 0 && without > 60, "{feet} {without} of {}", grid.cells.len());
}

#[test]
fn the_tree_holds_every_used_cell_once() {
    let surface = rolled();
    let grid = CellGrid::new(&surface);
    let used = |low: Uv, _| low.x > 0.3;
    let tree = BoxTree::new(&grid, used);
    let mut cells: Vec<usize> = tree.nodes.iter().filter_map(|node| node.cell).collect();
    cells.sort_unstable();
    let expected = (0..grid.cells.len()).filter(|&n| grid.cells[n].low.x > 0.3);
    assert_eq!(cells, expected.collect::<Vec<_>>());
    for node in &tree.nodes {
        assert!(node.skip > 0 && node.skip <= tree.nodes.len());
    }
    assert_eq!(BoxTree::new(&grid, |_, _| false).nodes.len(), 0);
}

#[test]
fn what_a_foot_settles_no_other_place_is_nearer() {
    let surface = rolled();
    let search = NearestSearch::new(&surface, |_, _| true);
    let (ends, all) = ([Uv::origin(), Uv::new(1.0, 1.0)], 4000);
    let samples: Vec<Point> = (0..all)
        .map(|n| Uv::new(f64::from(n / 40) / 99.0, f64::from(n % 40) / 39.0))
        .map(|at| surface.point(at))
        .collect();
    let mut settled = 0;
    for at in places(ends[0], ends[1]) {
        let jet = surface.jet(at);
        let normal = jet.su.cross(&jet.sv).normalize();
        for off in [0.01, 0.1, 0.5, 2.0, 6.0] {
            let p = jet.s + off * normal;
            let foot = Foot::find(&surface, p, at);
            if search.proves_nearest(p, &foot, foot.distance) {
                settled += 1;
                let nearest = samples.iter().map(|s| (s - p).norm()).fold(f64::INFINITY, f64::min);
                assert!(nearest > foot.distance - 1e-5);
            }
        }
    }
    // The measured number is 128. In the other cells the points are as far from the sheet as its
    // radius of curvature.
    assert!(settled > 120, "the usual point is not settled: {settled}");
}
