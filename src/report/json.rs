//! Reports as JSON text.

use std::io::{self, Write};

use serde_json::Value;

use crate::words::printable_lines;

use super::{AssemblyInspection, AssemblyReport, CheckFigures, InspectionFigures, Report};

impl Report {
    /// The report as JSON, with a line feed at the end. `docs/report.schema.json` describes it.
    /// Keys are sorted; numbers that are not finite are `null`.
    pub fn to_json(&self) -> String {
        text(&self.to_value())
    }

    /// Writes the same text.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_json(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(self.to_json().as_bytes())
    }

    /// The report as a JSON value.
    pub fn to_value(&self) -> Value {
        value(self)
    }
}

impl AssemblyReport {
    /// The report as a JSON value.
    pub fn to_value(&self) -> Value {
        value(self)
    }

    /// The report as JSON, as [`Report::to_json`] has it.
    pub fn to_json(&self) -> String {
        text(&self.to_value())
    }

    /// Writes the same text.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_json(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(self.to_json().as_bytes())
    }
}

impl AssemblyInspection {
    /// The figures as JSON, as `inspect --json` prints them.
    pub fn to_json(&self) -> String {
        text(&value(self))
    }
}

impl InspectionFigures {
    /// The figures as JSON, as `inspect --json` prints them.
    pub fn to_json(&self) -> String {
        text(&value(self))
    }
}

impl CheckFigures {
    /// The figures as JSON, as `check --json` prints them.
    pub fn to_json(&self) -> String {
        text(&value(self))
    }
}

/// A report as a JSON value. It only has fields with names, numbers and text, of which none is
/// refused.
fn value(report: &impl serde::Serialize) -> Value {
    serde_json::to_value(report).unwrap_or(Value::Null)
}

/// The text of a value. What JSON need not escape, but a terminal may obey, is escaped, too.
fn text(value: &Value) -> String {
    printable_lines(&format!("{value:#}\n")).into_owned()
}
