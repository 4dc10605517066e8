//! The rounding of a file's numbers, and whether a mesh has no other noise.
//!
//! A mesh that a modelling program made has its vertices on the true surface to within the rounding
//! of the file. Its neighbouring triangles are therefore flat to within the rounding, or differ from
//! flat by much more. Noise of any kind leaves nine times as many pairs between one and ten times
//! the rounding as below it.

use rayon::prelude::*;

use crate::geometry::{FEW, Point, ROUNDING, SAMPLE, VertexId};
use crate::mesh::{Mesh, VertexRings};
use crate::statistics::{CALM, level, quantile};

/// The distance between neighbouring numbers of a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rounding {
    /// Numbers have this relative distance.
    Floating(f64),
    /// Decimals, at this distance.
    Decimal(f64),
}

/// The most decimals that are looked for. More are as fine as numbers of single precision.
const MOST_DECIMALS: i32 = 9;

impl Rounding {
    /// The rounding of coordinates, which may have been multiplied by a power of two.
    pub(super) fn of(points: &[Point]) -> Self {
        let step = points.len().div_ceil(SAMPLE).max(1);
        let sample: Vec<&Point> = points.iter().step_by(step).collect();
        let is_single = |p: &&&Point| p.iter().all(|&x| f64::from(x as f32) == x);
        if 2 * sample.iter().filter(is_single).count() > sample.len() {
            return Rounding::Floating(f64::from(f32::EPSILON));
        }
        let mut numbers: Vec<f64> = sample.iter().flat_map(|p| p.iter()).map(|x| x.abs()).collect();
        numbers.sort_unstable_by(f64::total_cmp);
        numbers.dedup();
        numbers.retain(|&x| x > 0.0);
        let largest = numbers.last().copied().unwrap_or(0.0);
        let steps = (0..=MOST_DECIMALS).filter_map(|decimals| common_step(&numbers, decimals));
        let step = steps.fold(0.0, f64::max);
        // Numbers would not lie on these decimals by chance.
        let is_seen = step * level() > ROUNDING * largest && numbers.len() >= FEW;
        if is_seen { Rounding::Decimal(step) } else { Rounding::Floating(f64::EPSILON) }
    }

    /// The distance between a number and the next one.
    fn step(self, x: f64) -> f64 {
        match self {
            Rounding::Floating(relative) => relative * power_of_two(exponent(x)),
            Rounding::Decimal(step) => step,
        }
    }

    /// Whether the numbers have this rounding. Decimals may be those of a design, whose numbers are
    /// round, and finer decimals would follow.
    pub(crate) fn is_sure(self) -> bool {
        matches!(self, Rounding::Floating(_))
    }

    /// The farthest that rounding moves a point.
    fn farthest(self, p: &Point) -> f64 {
        0.5 * p.coords.map(|x| self.step(x)).norm()
    }

    /// The standard deviation of the points along any direction.
    pub(super) fn deviation(self, points: &[Point]) -> f64 {
        let square = |p: &Point| p.coords.map(|x| self.step(x)).norm_squared();
        let mean = points.iter().map(square).sum::<f64>() / (3 * points.len()).max(1) as f64;
        // Errors are spread evenly over a step.
        (mean / 12.0).sqrt()
    }
}

/// The largest power of two over 5ᵈ of which most numbers are a multiple. Half of them are no multiple
/// of twice as much.
fn common_step(numbers: &[f64], decimals: i32) -> Option<f64> {
    let five = 5f64.powi(decimals);
    let mut steps: Vec<f64> = numbers.iter().map(|x| lowest_digit(x * five)).collect();
    Some(quantile(&mut steps, CALM)? / five)
}

/// The largest power of two of which a number is a multiple as far as its rounding tells.
fn lowest_digit(x: f64) -> f64 {
    let mut step = power_of_two(exponent(x));
    while (x - (x / step).round() * step).abs() > ROUNDING * x {
        step *= 0.5;
    }
    step
}

/// The exponent of the largest power of two that is no larger than a number; a small one for 0.
fn exponent(x: f64) -> i32 {
    x.abs().max(f64::MIN_POSITIVE).log2().floor() as i32
}

fn power_of_two(exponent: i32) -> f64 {
    2f64.powi(exponent)
}

/// The cosine of the largest angle by which facets of a curved surface turn: no program makes fewer
/// than nine of a full turn. A larger angle is an edge.
const FACETS_TURN: f64 = 0.760_4;

/// The precision of modelling programs as a share of the diagonal: 1e-7 mm of 100 mm.
const MODELLING: f64 = 1e-9;

/// What the flat pairs of triangles say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Flatness {
    /// There is no noise but the rounding.
    Clean,
    /// There is noise.
    Noisy,
    /// Too few pairs are nearly flat.
    Unknown,
}

/// So few pairs say nothing: noise makes two flat ones and no other once in a hundred meshes.
const LEAST_PAIRS: usize = 3;

/// So many sides of triangles tell what all of them do.
const MOST_SIDES: usize = 1 << 20;

/// Looks at pairs of neighbouring triangles.
pub(super) fn flatness(mesh: &Mesh, rings: &VertexRings, rounding: Rounding) -> Flatness {
    let least = MODELLING * mesh.diagonal();
    let near: Vec<f64> = mesh.points.par_iter().map(|p| rounding.farthest(p) + least).collect();
    let look = |side: usize| {
        let other = across(mesh, rings, side).filter(|&other| side < other)?;
        bend(mesh, &near, side, other)
    };
    let count = |bend: f64| match bend {
        ..=1.0 => [1, 0],
        ..=10.0 => [0, 1],
        _ => [0, 0],
    };
    let sides = 3 * mesh.triangles.len();
    let [flat, nearly] = (0..sides)
        .into_par_iter()
        .step_by(sides.div_ceil(MOST_SIDES).max(1))
        .filter_map(look)
        .map(count)
        .reduce(|| [0, 0], |a, b| [a[0] + b[0], a[1] + b[1]]);
    match flat + nearly {
        ..LEAST_PAIRS => Flatness::Unknown,
        _ if flat > nearly => Flatness::Clean,
        _ => Flatness::Noisy,
    }
}

/// The other side of the same edge, if two triangles share it.
fn across(mesh: &Mesh, rings: &VertexRings, side: usize) -> Option<usize> {
    let (a, b) = mesh.side(side);
    let of_triangle = |t: usize| {
        let is_same = |other: &usize| [(a, b), (b, a)].contains(&mesh.side(*other));
        (3 * t..3 * t + 3).find(is_same)
    };
    // Both ends have all triangles of the edge, but one may have very many others.
    let [around, others] = [a, b].map(|v| rings.triangles(v));
    let around = if around.len() <= others.len() { around } else { others };
    let around = around.iter().map(|&t| t as usize).filter(|&t| t != side / 3);
    let mut others = around.filter_map(of_triangle);
    others.next().filter(|_| others.next().is_none())
}

/// The volume between two triangles, as a multiple of what rounding may make of a flat pair; `None`
/// at an edge of the object.
fn bend(mesh: &Mesh, near: &[f64], side: usize, other: usize) -> Option<f64> {
    let third = |side: usize| mesh.triangles[side / 3][(side % 3 + 2) % 3];
    let (a, b) = mesh.side(side);
    let four: [VertexId; 4] = [a, b, third(side), third(other)];
    let [n, m] = [side, other].map(|side| mesh.area_vector(mesh.triangles[side / 3]));
    if n.dot(&m) < FACETS_TURN * n.norm() * m.norm() {
        return None;
    }
    let volume = n.dot(&(mesh.point(four[3]) - mesh.point(a))).abs();
    let [a, b, c, d] = four;
    // The triangle opposite to each of the four.
    let opposite = [[b, c, d], [a, c, d], [a, b, d], [a, b, c]];
    let moved = |(v, t): (VertexId, [VertexId; 3])| mesh.area_vector(t).norm() * near[v.index()];
    let explained: f64 = four.into_iter().zip(opposite).map(moved).sum();
    Some(if explained > 0.0 { volume / explained } else { f64::INFINITY })
}
