//! The histograms of the page.

use serde_json::{Value, json};

use super::filters::signed;
use super::histogram::Histogram;
use super::scale::short;
use crate::report::picture::colour::encoded;
use crate::report::picture::scale::{DISTANCE, SIGNED, colour};

/// Both histograms of some distances, as the template draws them.
pub(super) fn histograms(distances: &[f32], end: f64, tolerance: f64) -> Value {
    let histogram = Histogram::of(distances.iter().copied(), end);
    let hex = |scale: &[u32; 9], share: f64| {
        let [r, g, b] = encoded(colour(scale, share));
        format!("#{r:02x}{g:02x}{b:02x}")
    };
    let bars = |counts: &[usize], scale: &[u32; 9], from: f64| -> Value {
        let most = counts.iter().copied().max().unwrap_or(0).max(1) as f64;
        let n = counts.len() as f64;
        let bar = |(k, &count): (usize, &usize)| {
            let share = (k as f64 + 0.5) / n;
            json!({
                "x": 1000.0 * k as f64 / n, "width": 1000.0 / n,
                "height": 300.0 * count as f64 / most, "colour": hex(scale, share),
                "mm": from + (end - from) * share, "count": count,
                "from": from + (end - from) * k as f64 / n,
                "to": from + (end - from) * (k as f64 + 1.0) / n,
            })
        };
        counts.iter().enumerate().map(bar).collect()
    };
    let place = |d: f64, from: f64| 1000.0 * (d - from) / (end - from);
    let marks = |ds: &[f64], from: f64| -> Vec<f64> {
        ds.iter().filter(|d| d.abs() < end).map(|&d| place(d, from)).collect()
    };
    let ticks = |ds: &[f64], from: f64| -> Vec<Value> {
        let text = |d: f64| if from < 0.0 { signed(d) } else { short(d) };
        ds.iter().map(|&d| json!({ "x": place(d, from), "text": text(d) })).collect()
    };
    json!({
        "signed": {
            "bars": bars(&histogram.counts, &SIGNED, -end),
            "tolerance": marks(&[-tolerance, tolerance], -end),
            "ticks": ticks(&[-1.0, -0.5, 0.0, 0.5, 1.0].map(|s| s * end), -end),
        },
        "distance": {
            "bars": bars(&histogram.absolute(), &DISTANCE, 0.0),
            "tolerance": marks(&[tolerance], 0.0),
            "ticks": ticks(&[0.0, 0.25, 0.5, 0.75, 1.0].map(|s| s * end), 0.0),
        },
    })
}
