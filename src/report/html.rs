//! The report as one page that needs nothing else: no network, no other file.
//!
//! Figures, tables and drawings are text and SVG. A still picture takes the place of the scan
//! that turns, so that a browser without WebGL or scripts shows the page, too.

use std::io::{self, Write};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use minijinja::value::{Serde, ValueKind};
use minijinja::{AutoEscape, Environment, UndefinedBehavior, context};
use serde_json::{Value, json};

use super::histogram::Histogram;
use super::scale::{Ends, short};
use super::{BodyReport, Report, ReportView, file_name, scene};
use crate::picture::colour::encoded;
use crate::picture::scale::{DISTANCE, SIGNED, colour};
use crate::words::mm;

/// The page's program, in parts that share one function.
const SCRIPT: &str = concat!(
    include_str!("page/start.js"),
    include_str!("page/shaders.js"),
    include_str!("page/scene.js"),
    include_str!("page/paint.js"),
    include_str!("page/controls.js"),
);

impl Report {
    /// Writes the report as a page for a browser: one file that needs nothing else. `views` are
    /// those of the conversions of the report, in its order, and `still` is a picture of them
    /// ([`picture_png`](super::picture_png)).
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_html(
        &self,
        views: &[ReportView],
        still: &[u8],
        out: &mut dyn Write,
    ) -> io::Result<()> {
        write_page(&self.name(), &self.to_value(), views, still, out)
    }
}

impl BodyReport {
    /// The same for the report of solids and shells.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_html(
        &self,
        views: &[ReportView],
        still: &[u8],
        out: &mut dyn Write,
    ) -> io::Result<()> {
        write_page(&self.name(), &self.to_value(), views, still, out)
    }
}

fn write_page(
    name: &str,
    figures: &Value,
    views: &[ReportView],
    still: &[u8],
    out: &mut dyn Write,
) -> io::Result<()> {
    let page = page(name, figures, views, still);
    out.write_all(page.map_err(io::Error::other)?.as_bytes())
}

/// The text of the page.
fn page(
    name: &str,
    figures: &Value,
    views: &[ReportView],
    still: &[u8],
) -> Result<String, minijinja::Error> {
    let ends = Ends::of(views);
    // With one component the report itself has its figures.
    let of_parts = figures["components"].as_array();
    let part = |(k, view): (usize, &ReportView)| {
        let tolerance = view.figures.tolerance;
        json!({
            "figures": of_parts.and_then(|parts| parts.get(k)).unwrap_or(figures),
            "made": view.figures.made,
            "plane": view.plane.as_ref().map(|plane| plane.svg(k)),
            "measured": histograms(&view.measured, ends.measured, tolerance),
            "smoothed": histograms(&view.smoothed, ends.smoothed, tolerance),
            "drawn": view.scan.mesh.triangles.len(),
            "triangles": view.triangles,
            "face": view.face.is_some(),
        })
    };
    let parts: Vec<Value> = views.iter().enumerate().map(part).collect();
    environment()?.get_template("report.html")?.render(context! {
        name,
        report => Serde(figures),
        parts => Serde(&parts),
        still => STANDARD.encode(still),
        scene => Serde(scene::scene(views, &ends)),
        style => include_str!("page/report.css"),
        script => SCRIPT,
    })
}

fn environment() -> Result<Environment<'static>, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_filter("mm", |x: minijinja::Value| of_number(&x, mm));
    environment.add_filter("short", |x: minijinja::Value| of_number(&x, short));
    environment.add_filter("count", |x: minijinja::Value| of_number(&x, grouped));
    environment.add_filter("fixed", |x: minijinja::Value, digits: usize| {
        of_number(&x, |x| format!("{x:.digits$}"))
    });
    environment.add_filter("option", option);
    environment.add_filter("words", |s: String| s.replace('_', " "));
    environment.add_filter("file", |s: String| file_name(&s));
    environment.add_template("report.html", include_str!("page/report.html"))?;
    Ok(environment)
}

/// A number as text, or a dash for a value that is no number.
fn of_number(x: &minijinja::Value, text: impl Fn(f64) -> String) -> String {
    f64::try_from(x.clone()).map_or_else(|_| "–".into(), text)
}

/// The value of an option as text.
fn option(value: minijinja::Value) -> String {
    match value.kind() {
        ValueKind::None => "not given".into(),
        ValueKind::Bool => if value.is_true() { "yes" } else { "no" }.into(),
        _ => value.to_string(),
    }
}

/// A count with a thin space between thousands.
fn grouped(x: f64) -> String {
    let digits = format!("{x:.0}");
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push('\u{2009}');
        }
        text.push(digit);
    }
    text
}

/// Both histograms of some distances, as the template draws them.
fn histograms(distances: &[f32], end: f64, tolerance: f64) -> Value {
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
            })
        };
        counts.iter().enumerate().map(bar).collect()
    };
    let place = |d: f64, from: f64| 1000.0 * (d - from) / (end - from);
    let marks = |ds: &[f64], from: f64| -> Vec<f64> {
        ds.iter().filter(|d| d.abs() < end).map(|&d| place(d, from)).collect()
    };
    let ticks = |ds: &[f64], from: f64| -> Vec<Value> {
        let text = |d: f64| match d {
            d if d > 0.0 && from < 0.0 => format!("+{}", short(d)),
            d if d < 0.0 => format!("−{}", short(-d)),
            d => short(d),
        };
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

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn thousands_stand_apart() {
        assert_eq!(grouped(1_234_567.0), "1\u{2009}234\u{2009}567");
        assert_eq!(grouped(999.0), "999");
    }
}
