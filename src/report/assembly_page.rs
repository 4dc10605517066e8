//! The report of an assembly as one page that needs nothing else.

use std::io::{self, Write};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use minijinja::context;
use minijinja::value::Serde;
use serde_json::{Value, json};

use super::bars::histograms;
use super::command::shell_words;
use super::scale::Ends;
use super::whole::PartView;
use super::{AssemblyReport, AssemblyView, file_name, filters};
use crate::words::{box_extents, printable_lines};

/// The most places of a part that the page lists. The JSON has all.
const LISTED: usize = 200;

impl AssemblyReport {
    /// Writes the report as a page for a browser: one file that needs nothing else. `view` is that of the same
    /// conversion, and `still` is the picture of it ([`assembly_png`](super::assembly_png)).
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_html(
        &self,
        view: &AssemblyView,
        still: &[u8],
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let page = self.page(view, still).map_err(io::Error::other)?;
        out.write_all(printable_lines(&page).as_bytes())
    }

    fn page(&self, view: &AssemblyView, still: &[u8]) -> Result<String, minijinja::Error> {
        let figures = self.to_value();
        let of_parts = figures["parts"].as_array().map(Vec::as_slice).unwrap_or_default();
        let part = |(number, (part, figures)): (usize, (&PartView, &Value))| {
            let [r, g, b] = view.colour(number);
            let bodies = figures["components"].as_array().map_or(1, Vec::len);
            let views = &part.views;
            let ends = Ends::of(views);
            let distances: Vec<f32> =
                views.iter().flat_map(|view| view.measured.iter().copied()).collect();
            let tolerance = views.iter().map(|view| view.figures.tolerance).fold(0.0, f64::max);
            let corners = views.iter().flat_map(|view| view.figures.bounds);
            let bounds = crate::geometry::box_of(corners.map(crate::geometry::Point::from));
            let places = figures["places"].as_array().map(Vec::as_slice).unwrap_or_default();
            json!({
                "figures": figures,
                "colour": format!("#{r:02x}{g:02x}{b:02x}"),
                "bodies": bodies,
                "size": if views.is_empty() { String::new() } else { box_extents(bounds) },
                "made": views.first().map(|view| view.figures.made.clone()),
                "histogram": (!views.is_empty()).then(|| histograms(&distances, ends.measured, tolerance)),
                "places": places.iter().take(LISTED).map(place).collect::<Vec<_>>(),
                "more": places.len().saturating_sub(LISTED),
            })
        };
        let parts: Vec<Value> = view.parts.iter().zip(of_parts).enumerate().map(part).collect();
        let places: usize = self.parts.iter().map(|part| part.places.len()).sum();
        let command: Vec<&str> = self.command.iter().map(String::as_str).collect();
        filters::environment()?.get_template("assembly.html")?.render(context! {
            name => file_name(&self.input.file),
            report => Serde(&figures),
            parts => Serde(&parts),
            places,
            size => if places > 0 { box_extents(view.extent()) } else { String::new() },
            command => shell_words(&command),
            still => STANDARD.encode(still),
            style => include_str!("page/report.css"),
        })
    }
}

/// A place in the list: its path, and where the origin of the part is.
fn place(place: &Value) -> Value {
    let path: Vec<&str> =
        place["path"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let at: Vec<&Value> =
        place["matrix"].as_array().into_iter().flatten().map(|row| &row[3]).collect();
    json!({ "path": path.join(" / "), "at": at })
}
