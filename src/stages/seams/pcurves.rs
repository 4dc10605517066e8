//! Curves in the parameter plane of a face.

use std::f64::consts::TAU;

use formats::brep::{BrepCurve, BrepSurface, PCurve};
use nalgebra::{Matrix2, Vector2};

use super::EXACT;
use super::chart::Chart;
use super::hermite::{through, with_slopes};
use crate::geometry::{Point, Vector};

/// A pcurve agrees with its edge within so many mm, a third of the kernels' precision.
const AGREES: f64 = 3e-8;

/// Angles and lengths that differ by less are the same: rounding of the formulas.
const ROUNDED: f64 = 1e-12;

/// A line that leaves an axis of the parameters by less is along it if its edge is, too.
const ALONG: f64 = 1e-7;
/// Places between the middle of a piece and its ends, where the gap is largest if it is zero in the middle.
const BESIDE: [f64; 2] = [0.25, 0.75];

/// A pcurve of an edge that is off its surface is compared at other places than those at which that was measured.
const TWICE: f64 = 2.0;

const FEWEST: usize = 33;
const FEWEST_OF_ARCH: usize = 5;
const MOST: usize = 1500;

/// The pcurve of an edge between two parameter points, and its largest distance from the edge. The second derivative of an edge that is led
/// by points has steps.
pub(super) fn pcurve(
    chart: &Chart,
    curve: &BrepCurve,
    ends: [[f64; 2]; 2],
    is_led: bool,
) -> Result<(PCurve, f64), String> {
    let (start, end) = curve.range();
    let at = |t: f64| Point::from(curve.point(t));
    let places = |n: usize| -> Vec<f64> {
        (0..n).map(|i| start + (end - start) * i as f64 / (n - 1) as f64).collect()
    };
    let gap = |pcurve: &PCurve, t: &[f64]| {
        let off = |&t: &f64| (chart.point(pcurve.point(t)) - at(t)).norm();
        t.iter().map(off).fold(0.0, f64::max)
    };
    if matches!(chart.surface, BrepSurface::Plane { .. }) {
        let made = PCurve::on_plane(&chart.frame, curve)?;
        let worst = gap(&made, &places(FEWEST));
        return Ok((made, worst));
    }
    let parameters = |t: &[f64]| {
        let points: Vec<Point> = t.iter().map(|&t| at(t)).collect();
        let mut uv = chart.unwrapped(&points, Some(ends[0]));
        let last = uv.len() - 1;
        (uv[0], uv[last]) = (ends[0], ends[1]);
        uv
    };
    let t = places(FEWEST);
    let uv = parameters(&t);
    let ends = [exact(uv[0]), exact(uv[uv.len() - 1])];
    for (ends, limit) in [(along_axes(ends), AGREES), (ends, EXACT)] {
        if clips(chart, curve, ends) {
            continue;
        }
        if let Ok(line) = PCurve::line(ends[0], ends[1], (start, end)) {
            let worst = gap(&line, &t);
            if worst < limit {
                return Ok((line, worst));
            }
        }
    }
    let mut t = curve.breaks();
    // A single polynomial is an arch, which turns little.
    let fewest = if t.len() == 2 && curve.spline().is_some() { FEWEST_OF_ARCH } else { FEWEST };
    if t.len() < fewest {
        t = t_with(&t, fewest);
    }
    // No pcurve comes closer to an edge than the surface does.
    let of_surface = |t: &f64| (chart.point(chart.parameters(at(*t)).0) - at(*t)).norm();
    let off = t.iter().map(of_surface).fold(0.0, f64::max);
    let agrees = if off < AGREES { AGREES } else { TWICE * off };
    loop {
        let uv = parameters(&t);
        let made = PCurve::Spline(if is_led {
            with_slopes(&t, &uv, &slopes(chart, curve, &t, &uv))?
        } else {
            through(&t, &uv, false)?
        });
        let middles: Vec<f64> = t.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
        // Between the middle and an end the gap may be larger.
        let beside = |pair: &[f64]| BESIDE.map(|w| pair[0] + w * (pair[1] - pair[0]));
        let quarters: Vec<f64> = t.windows(2).flat_map(beside).collect();
        let (worst, besides) = (gap(&made, &middles), gap(&made, &quarters));
        if worst < agrees && besides < EXACT.max(agrees) || t.len() > MOST {
            return Ok((made, worst));
        }
        let mut finer = vec![t[0]];
        for (pair, middle) in t.windows(2).zip(&middles) {
            // A jump stays one however near its places are.
            let is_wide = pair[1] - pair[0] > ROUNDED * (end - start).abs();
            let is_off =
                || gap(&made, &[*middle]) > 0.5 * agrees || gap(&made, &beside(pair)) > agrees;
            if is_wide && is_off() {
                finer.push(*middle);
            }
            finer.push(pair[1]);
        }
        if finer.len() == t.len() {
            return Ok((made, worst));
        }
        t = finer;
    }
}

/// The derivatives of the parameters of a curve at given places.
fn slopes(chart: &Chart, curve: &BrepCurve, t: &[f64], uv: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let of = |(&t, &[u, v]): (&f64, &[f64; 2])| {
        let [_, su, sv] = chart.surface.tangents(u, v).map(Vector::from);
        let along = Vector::from(curve.speed(t));
        let metric = Matrix2::new(su.dot(&su), su.dot(&sv), su.dot(&sv), sv.dot(&sv));
        let slope =
            metric.try_inverse().unwrap_or_default() * Vector2::new(along.dot(&su), along.dot(&sv));
        [slope.x, slope.y]
    };
    t.iter().zip(uv).map(of).collect()
}

/// Parameters between given ones, at least so many.
fn t_with(breaks: &[f64], fewest: usize) -> Vec<f64> {
    let parts = fewest.div_ceil(breaks.len().max(2) - 1);
    let mut t = Vec::new();
    for pair in breaks.windows(2) {
        t.extend((0..parts).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / parts as f64));
    }
    t.extend(breaks.last());
    t
}

/// Whether readers would clip a line. They take the part within one period: of parameters if it is oblique and both of them
/// are bounded, and of its own parameter if that is an angle.
fn clips(chart: &Chart, curve: &BrepCurve, [from, to]: [[f64; 2]; 2]) -> bool {
    let is_bounded =
        matches!(chart.surface, BrepSurface::Sphere { .. } | BrepSurface::Torus { .. });
    let is_oblique = from[0] != to[0] && from[1] != to[1];
    is_bounded && is_oblique || matches!(curve, BrepCurve::Ellipse(_)) && curve.range().1 > TAU
}

/// The ends of a line, which runs along an axis if it nearly does so.
fn along_axes([from, to]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let middle = exact([0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])]);
    let is_along = [0, 1].map(|k| (from[k] - to[k]).abs() < ALONG);
    [from, to].map(|end| [0, 1].map(|k| if is_along[k] { middle[k] } else { end[k] }))
}

/// Readers take a start of -1e-17 for 2π: multiples of a turn are exact.
fn exact(uv: [f64; 2]) -> [f64; 2] {
    uv.map(|x| {
        let turns = TAU * (x / TAU).round();
        if (x - turns).abs() < ROUNDED { turns } else { x }
    })
}
