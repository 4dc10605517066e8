//! Curves in the parameter plane of a face.

use std::f64::consts::TAU;

use formats::brep::{BrepCurve, BrepSurface, PCurve};

use super::EXACT;
use super::chart::Chart;
use super::hermite::through;
use crate::geometry::Point;

/// A pcurve agrees with its edge within so many mm, a third of the kernels' precision.
const AGREES: f64 = 3e-8;

/// Angles and lengths that differ by less are the same: rounding of the formulas.
const ROUNDED: f64 = 1e-12;

/// The pcurve of an edge beside a B-spline adds no more than this share to the distance of the edge.
const SHARE: f64 = 0.25;

const FEWEST: usize = 33;
const MOST: usize = 1500;

/// The pcurve of an edge between two parameter points, and its largest distance from the edge.
pub(super) fn pcurve(
    chart: &Chart,
    curve: &BrepCurve,
    ends: [[f64; 2]; 2],
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
    // A B-spline is not exactly below its edges.
    let off = match chart.sheet {
        Some(_) => t.iter().zip(&uv).map(|(&t, &uv)| (chart.point(uv) - at(t)).norm()).fold(0.0, f64::max),
        None => 0.0,
    };
    let agrees = AGREES.max(SHARE * off) + off;
    let (from, mut to) = (exact(uv[0]), exact(uv[uv.len() - 1]));
    for k in 0..2 {
        if (from[k] - to[k]).abs() < ROUNDED * from[k].abs().max(1.0) {
            to[k] = from[k];
        }
    }
    if let Ok(line) = PCurve::line(from, to, (start, end)) {
        let worst = gap(&line, &t);
        if worst < EXACT.max(off) {
            return Ok((line, worst));
        }
    }
    let mut t = curve.breaks();
    if t.len() < FEWEST {
        t = t_with(&t, FEWEST);
    }
    loop {
        let made = PCurve::Spline(through(&t, &parameters(&t), false)?);
        let middles: Vec<f64> = t.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
        let worst = gap(&made, &middles);
        if worst < agrees || t.len() > MOST {
            return Ok((made, worst));
        }
        let mut finer = vec![t[0]];
        for (pair, middle) in t.windows(2).zip(&middles) {
            if gap(&made, &[*middle]) > agrees - 0.5 * AGREES.max(SHARE * off) {
                finer.push(*middle);
            }
            finer.push(pair[1]);
        }
        t = finer;
    }
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

/// Readers take a start of -1e-17 for 2π: multiples of a turn are exact.
fn exact(uv: [f64; 2]) -> [f64; 2] {
    uv.map(|x| {
        let turns = TAU * (x / TAU).round();
        if (x - turns).abs() < ROUNDED { turns } else { x }
    })
}
