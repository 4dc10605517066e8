use super::correct::{FIRM_AREA, LEAST_AREA, correct};
use super::insert::insert;
use super::mend::mend;
use super::remove::remove;
use super::reweight::{MOST_RAISE, reweight};
use super::tangent;
use super::unfold::{inverted, unfold};
use crate::deviation::MissedTriangle;
use crate::geometry::{Point, Uv, VertexId};
use crate::mesh::{Mesh, Outline, Parameterized, Patch, Scaffold};
use crate::spline::{KnotVector, Surface};
use crate::stages::adapt::attempt::Attempt;
use crate::stages::adapt::goal::Goal;
use crate::stages::adapt::options::Options;
use crate::stages::adapt::problem::Problem;
use crate::stages::adapt::state::State;
use crate::stages::fit::{self, STIFFNESSES};
use crate::stages::knots::InsertionLimits;

/// Vertices along each side of the sheet.
const N: usize = 41;

/// The vertex in the middle.
const MIDDLE: usize = N * N / 2;

/// A waved sheet of 50 mm, whose map runs unevenly.
fn sheet() -> Parameterized {
    let share = |k: usize| k as f64 / (N - 1) as f64;
    let at = |v: usize| (share(v / N), share(v % N));
    let wave = |t: f64| t + 0.01 * (2.0 * std::f64::consts::TAU * t).sin();
    let point = |v| {
        let (x, y) = at(v);
        Point::new(50.0 * x, 50.0 * y, 4.0 * (3.0 * x).sin() * (2.0 * y).cos())
    };
    let cell = |k: usize| (k / (N - 1)) * N + k % (N - 1);
    let halves = |a: usize| [[a, a + N, a + N + 1], [a, a + N + 1, a + 1]];
    let triangles = (0..(N - 1) * (N - 1)).map(cell).flat_map(halves);
    let triangles: Vec<_> = triangles.map(|t| t.map(VertexId::from)).collect();
    let around = |side: usize, k: usize| match side {
        0 => k * N,
        1 => (N - 1) * N + k,
        2 => (N - 1 - k) * N + N - 1,
        _ => N - 1 - k,
    };
    let outer = (0..4).flat_map(|side| (0..N - 1).map(move |k| around(side, k)));
    let mesh = Mesh { points: (0..N * N).map(point).collect(), triangles };
    let patch = Patch { outer: outer.map(VertexId::from).collect(), ..Patch::closed(mesh) };
    let uv = (0..N * N).map(|v| Uv::new(wave(at(v).0), wave(at(v).1))).collect();
    Parameterized { patch, uv, outline: Outline::Sides, scaffold: Scaffold::default() }
}

/// What is tried with a problem over a sheet, some points of which are lifted by so many mm.
fn with_problem(noisy: bool, lifted: &[(usize, f64)], test: impl FnOnce(&Problem)) {
    let mut map = sheet();
    lifted.iter().for_each(|&(v, by)| map.patch.mesh.points[v].z += by);
    let goal = Goal { tolerance: 0.01, named: true, outliers: 0.01 };
    test(&Problem::new(
        &map,
        &Options { noise: if noisy { 0.01 } else { 0.0 }, ..Options::default() },
        &goal,
    ));
}

/// The fit of a state over a uniform net of so many control points along each side.
fn fitted(problem: &Problem, state: State) -> Attempt {
    let samples = state.samples(problem);
    let (mut surface, fit) =
        fit::fit(&samples, state.knots.clone(), problem.options.method).unwrap();
    problem.pin_corners(&mut surface);
    Attempt::new(problem, state, surface, fit)
}

fn first(problem: &Problem, net: usize) -> Attempt {
    let knots = [(); 2].map(|()| KnotVector::uniform(3, net));
    fitted(problem, State { knots, ..State::new(problem) })
}

/// A surface over an attempt's state that has moved, as fits leave it.
fn moved(problem: &Problem, of: &Attempt, change: impl FnOnce(&mut Surface)) -> Attempt {
    let mut surface = of.surface.clone();
    change(&mut surface);
    Attempt::new(problem, of.state.clone(), surface, of.fit)
}

/// The root mean square of the distances of points from the surface at their parameters.
fn parametric_rms(problem: &Problem, of: &Attempt) -> f64 {
    let points = &problem.map.patch.mesh.points;
    let off = |(p, uv): (&Point, &Uv)| (of.surface.point(*uv) - p).norm_squared();
    let all: f64 = points.iter().zip(&of.state.uv).map(off).sum();
    (all / points.len() as f64).sqrt()
}

#[test]
fn a_move_leaves_what_it_is_given_and_needs_none_before_it() {
    with_problem(false, &[(MIDDLE, 0.3)], |problem| {
        let start = first(problem, 8);
        let all = |of: &State| (of.uv.clone(), of.weights.clone(), of.knots.clone());
        let before = all(&start.state);
        let bounds = InsertionLimits { depth: 10, most: 1000, price: 0.0 };
        let misses = start.misses(&start.state.uv, 0.01);
        let alone = all(&insert(problem, &start, &misses, &bounds).unwrap());
        // Others in between change nothing.
        reweight(problem, &start, 0.01, FIRM_AREA);
        remove(problem, &start, 0.25).unwrap();
        unfold(problem, &start, &STIFFNESSES);
        assert!(all(&start.state) == before);
        assert!(all(&insert(problem, &start, &misses, &bounds).unwrap()) == alone);
    });
}

#[test]
fn corrected_parameters_are_those_of_the_foot_points_and_bring_the_surface_closer() {
    with_problem(false, &[], |problem| {
        let start = first(problem, 8);
        let state = correct(problem, &start, FIRM_AREA);
        assert!(state.uv == start.foot_points.uv && state.uv != start.state.uv);
        assert!(state.weights == start.state.weights && state.knots == start.state.knots);
        let next = fitted(problem, state);
        let [before, after] = [&start, &next].map(|of| parametric_rms(problem, of));
        assert!(after < 0.8 * before, "{after} {before}");
    });
}

#[test]
fn vertices_on_sides_stay_on_them() {
    with_problem(false, &[], |problem| {
        let state = correct(problem, &first(problem, 8), LEAST_AREA);
        for v in problem.map.patch.outer.iter().map(|v| v.index()) {
            for k in 0..2 {
                let (was, is) = (problem.map.uv[v][k], state.uv[v][k]);
                assert!(was == is || (was != 0.0 && was != 1.0), "{v} {was} {is}");
            }
        }
    });
}

#[test]
fn only_points_beyond_the_limit_get_more_weight_and_come_closer() {
    with_problem(false, &[(MIDDLE, 0.05)], |problem| {
        let start = first(problem, 20);
        let limit = 0.5 * start.foot_points.distances[MIDDLE];
        let state = reweight(problem, &start, limit, FIRM_AREA);
        for (v, d) in start.foot_points.measured().enumerate() {
            let factor = state.weights[v] / start.state.weights[v];
            let wanted = if d > limit { (d / limit).powi(2).min(MOST_RAISE) } else { 1.0 };
            assert!((factor - wanted).abs() < 1e-12, "{v}: {factor} {wanted}");
        }
        assert!(state.weights[MIDDLE] > 3.9);
        let next = fitted(problem, state);
        let [before, after] = [&start, &next].map(|of| of.foot_points.distances[MIDDLE]);
        assert!(after < 0.8 * before, "{after} {before}");
    });
}

#[test]
fn outliers_are_rejected_where_smoothing_is_off_alone() {
    for noisy in [false, true] {
        with_problem(noisy, &[(MIDDLE, 3.0)], |problem| {
            let start = first(problem, 8);
            let found = |state: &State| state.outliers.contains(&MIDDLE);
            assert_eq!(found(&start.state), noisy);
            let state = correct(problem, &start, FIRM_AREA);
            assert_eq!(found(&state), noisy);
            let weight = state.samples(problem).weights[MIDDLE];
            assert_eq!(weight < 1e-5, noisy, "{weight}");
            assert_eq!(state.weights[MIDDLE], 1.0);
        });
    }
}

#[test]
fn knots_are_inserted_where_points_are_missed() {
    with_problem(false, &[(MIDDLE, 1.0)], |problem| {
        let start = first(problem, 8);
        let bounds = InsertionLimits { depth: 10, most: 1000, price: 0.0 };
        let only = [(start.state.uv[MIDDLE], 1.0)];
        let state = insert(problem, &start, &only, &bounds).unwrap();
        let old = start.state.knots.each_ref().map(KnotVector::breaks);
        let new: Vec<f64> = (0..2)
            .flat_map(|k| state.knots[k].breaks())
            .filter(|b| !old.iter().flatten().any(|o| o == b))
            .collect();
        // The middle of the middle one of five spans.
        assert!(!new.is_empty() && new.iter().all(|b| (b - 0.5).abs() < 1e-9), "{new:?}");
        assert!(insert(problem, &start, &[], &bounds).is_none());
        let full = InsertionLimits { most: 64, ..bounds };
        assert!(insert(problem, &start, &only, &full).is_none());
    });
}

#[test]
fn knot_lines_are_removed_until_none_is_left() {
    with_problem(false, &[], |problem| {
        let start = first(problem, 24);
        let state = remove(problem, &start, 0.25).unwrap();
        let count = |state: &State| state.knots.iter().map(KnotVector::functions).sum::<usize>();
        // A quarter of forty inner lines.
        assert_eq!((count(&start.state), count(&state)), (48, 38));
        assert!(remove(problem, &first(problem, 4), 0.25).is_none());
    });
}

#[test]
fn a_tangent_step_brings_the_surface_closer_and_an_idle_one_is_told() {
    with_problem(false, &[], |problem| {
        let start = first(problem, 8);
        let before = start.rms();
        let (mut now, is_idle) = tangent::step(problem, start);
        assert!(!is_idle && now.rms() < 0.93 * before, "{} {before}", now.rms());
        let mut idle = 0;
        for _ in 0..8 {
            let before = now.rms();
            let (next, is_idle) = tangent::step(problem, now);
            assert!(next.rms() <= before);
            (now, idle) = (next, idle + usize::from(is_idle));
        }
        assert!(idle > 0);
    });
}

#[test]
fn folds_are_taken_out_and_points_stay() {
    with_problem(false, &[], |problem| {
        let flat = first(problem, 20);
        assert_eq!(inverted(problem, &flat), 0);
        assert!(unfold(problem, &flat, &STIFFNESSES).found.is_empty());
        let folded = moved(problem, &flat, |surface| {
            surface.net[9 * 20 + 10].x += 6.0;
            surface.net[11 * 20 + 10].x -= 6.0;
        });
        let unfolded = unfold(problem, &folded, &STIFFNESSES);
        assert!(unfolded.before > 0 && unfolded.before == inverted(problem, &folded));
        let (best, left) = unfolded.found.last().unwrap();
        assert_eq!((*left, inverted(problem, best)), (0, 0));
        assert!(best.rms() < folded.rms(), "{} {}", best.rms(), folded.rms());
    });
}

#[test]
fn a_triangle_that_is_left_is_mended_with_inner_samples() {
    with_problem(false, &[], |problem| {
        let flat = first(problem, 20);
        let dented = moved(problem, &flat, |surface| surface.net[10 * 20 + 10].z += 1.0);
        let left = |of: &Attempt| problem.left(&of.surface, &of.state.uv, 1.0);
        let before = left(&dented);
        assert!(!before.is_empty());
        let mended = mend(problem, &dented, &before).unwrap();
        let worst =
            |left: &[MissedTriangle]| left.iter().map(|left| left.ratio).fold(0.0, f64::max);
        let after = worst(&left(&mended));
        assert!(after < 0.2 * worst(&before), "{after} {}", worst(&before));
        for left in &before {
            assert!(!mended.state.inner.of(left.triangle).is_empty());
        }
        assert!(dented.state.inner.all.is_empty());
        // What is far from the dent stays.
        assert_eq!(mended.surface.net[0], dented.surface.net[0]);
        assert_eq!(mended.surface.net[399], dented.surface.net[399]);
    });
}
