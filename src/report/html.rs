//! The report as one page that needs nothing else: no network, no other file.
//!
//! Figures, tables and drawings are text and SVG. A still picture takes the place of the scan
//! that turns, so that a browser without WebGL or scripts shows the page, too.

use std::io::{self, Write};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use minijinja::context;
use minijinja::value::Serde;
use serde_json::{Value, json};

use super::bars::histograms;
use super::command::shell_words;
use super::far_places::far_places;
use super::scale::Ends;
use super::{Report, ReportView, exact_rows, filters, scene};
use crate::words::{box_extents, printable_lines, tolerance_reason};

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
    /// those of the bodies of the report, in its order, and `still` is a picture of them
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
        let page = page(&self.name(), &self.to_value(), views, still);
        // Names may hold anything. As in JSON, escapes are the same within the data of the page.
        out.write_all(printable_lines(&page.map_err(io::Error::other)?).as_bytes())
    }
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
        let figures = of_parts.and_then(|parts| parts.get(k)).unwrap_or(figures);
        json!({
            "figures": figures,
            "size": box_extents(view.figures.bounds),
            "places": far_places(view).iter().map(|place| json!({
                "at": <[f64; 3]>::from(place.at), "measured_mm": place.measured,
                "smoothed_mm": place.smoothed,
            })).collect::<Vec<_>>(),
            "holes": longest_first(&figures["fill"]["holes"]),
            "made": view.figures.made,
            "exact": view.exact.as_ref().map(exact_rows::rows),
            "tolerance_reason": match view.exact {
                Some(_) => "twice the rounding of the file".into(),
                None => tolerance_reason(tolerance, figures["noise_mm"].as_f64().unwrap_or(0.0)),
            },
            "plane": view.plane.as_ref().map(|plane| plane.svg(k)),
            "measured": histograms(&view.measured, ends.measured, tolerance),
            "smoothed": histograms(&view.smoothed, ends.smoothed, tolerance),
            "drawn": view.scan.mesh.triangles.len(),
            "triangles": view.triangles,
            "face": view.face.is_some(),
        })
    };
    let command: Vec<&str> =
        figures["command"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let parts: Vec<Value> = views.iter().enumerate().map(part).collect();
    filters::environment()?.get_template("report.html")?.render(context! {
        name,
        report => Serde(figures),
        parts => Serde(&parts),
        command => shell_words(&command),
        still => STANDARD.encode(still),
        scene => Serde(scene::scene(views, &ends)),
        style => include_str!("page/report.css"),
        script => SCRIPT,
    })
}

/// Holes with their numbers, the longest rim first, as `inspect` lists them.
fn longest_first(holes: &Value) -> Vec<Value> {
    let numbered = holes.as_array().into_iter().flatten().enumerate();
    let mut holes: Vec<Value> = numbered
        .map(|(number, hole)| {
            let mut hole = hole.clone();
            hole["number"] = number.into();
            hole
        })
        .collect();
    let length = |hole: &Value| hole["rim_length_mm"].as_f64().unwrap_or(0.0);
    holes.sort_by(|a, b| length(b).total_cmp(&length(a)));
    holes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_rim_comes_first_and_keeps_its_number() {
        let holes = json!([{ "rim_length_mm": 2.0 }, { "rim_length_mm": 30.0 }]);
        let numbers: Vec<Value> =
            longest_first(&holes).into_iter().map(|hole| hole["number"].clone()).collect();
        assert_eq!(numbers, [1, 0]);
    }
}
