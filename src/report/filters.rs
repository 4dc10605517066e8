//! How the page writes numbers.

use minijinja::value::ValueKind;
use minijinja::{AutoEscape, Environment, UndefinedBehavior};

use super::file_name;
use super::scale::short;
use crate::words::{mm, plain_mm, repair, separated};

/// The environment with the template and the filters that write numbers.
pub(super) fn environment() -> Result<Environment<'static>, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_filter("mm", |x: minijinja::Value| of_number(&x, |x| separated(&mm(x))));
    environment.add_filter("plain_mm", |x: minijinja::Value| of_number(&x, plain_mm));
    environment.add_filter("signed", |x: minijinja::Value| of_number(&x, signed));
    environment.add_filter("short", |x: minijinja::Value| of_number(&x, short));
    environment.add_filter("count", |x: minijinja::Value| {
        of_number(&x, |x| separated(&format!("{x:.0}")))
    });
    environment.add_filter("fixed", |x: minijinja::Value, digits: usize| {
        of_number(&x, |x| format!("{x:.digits$}"))
    });
    environment.add_filter("option", option);
    environment.add_filter("repair", |kind: String, count: usize| repair(&kind, count));
    environment.add_filter("words", |s: String| s.replace('_', " "));
    environment.add_filter("file", |s: String| file_name(&s));
    environment.add_template(
        "report.html",
        concat!(include_str!("page/macros.html"), include_str!("page/report.html")),
    )?;
    environment.add_template(
        "assembly.html",
        concat!(include_str!("page/macros.html"), include_str!("page/assembly.html")),
    )?;
    Ok(environment)
}

/// A number as text, or a dash for a value that is no number.
fn of_number(x: &minijinja::Value, text: impl Fn(f64) -> String) -> String {
    f64::try_from(x.clone()).map_or_else(|_| "–".into(), text)
}

/// A distance with its sign.
pub(super) fn signed(x: f64) -> String {
    if x > 0.0 { format!("+{}", short(x)) } else { short(x) }
}

/// The value of an option as text.
fn option(value: minijinja::Value) -> String {
    match value.kind() {
        ValueKind::None => "not given".into(),
        ValueKind::Bool => if value.is_true() { "yes" } else { "no" }.into(),
        ValueKind::Number => separated(&value.to_string()),
        _ => value.to_string(),
    }
}
