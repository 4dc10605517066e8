//! The results of all scans of a batch: a table, `summary.csv`, `summary.json`.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use scan2step::words::{plural, printable, significant};
use serde::Serialize;
use serde_json::json;
use tabled::builder::Builder;
use tabled::settings::object::Columns;
use tabled::settings::{Alignment, Style};

use super::record::{FOLDER, Record};
use super::scans::{FoundScan, UnusedFile};
use crate::cli::output::{self, Pending};
use crate::cli::streams;

/// The status of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Status {
    /// Converted.
    Ok,
    /// Converted, but a tolerance that the user named is not met.
    Missed,
    Failed,
    /// An earlier run has converted it.
    Skipped,
    /// Another shard has it, and has not converted it yet.
    Pending,
}

impl Status {
    /// The status that a record stands for.
    pub(super) fn of(record: &Record) -> Status {
        match record.exit_code {
            0 => Status::Ok,
            3 => Status::Missed,
            _ => Status::Failed,
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Status::Ok => "ok",
            Status::Missed => "missed",
            Status::Failed => "failed",
            Status::Skipped => "skipped",
            Status::Pending => "pending",
        }
    }
}

/// A scan in the summary.
pub(crate) struct Row {
    pub scan: FoundScan,
    pub status: Status,
    pub record: Option<Record>,
}

/// Writes both summaries. `done` is `None` for a scan that this run did not convert; its record
/// gives its status. Shards that end at the same time take turns, so that the last one reads all
/// records.
pub(super) fn write(
    out: &Path,
    scans: &[FoundScan],
    done: Vec<Option<Row>>,
    left_out: &[UnusedFile],
) -> Result<Vec<Row>, formats::Error> {
    let path = out.join(FOLDER).join("lock");
    let lock = File::create(&path).map_err(|e| output::failed(&path, e))?;
    // Some network drives have no locks. Two shards that end at the same time may then miss one
    // another's records; a later run writes the summary again.
    if let Err(e) = lock.lock() {
        streams::say(format_args!(
            "note: {}: {e}; shards that end at the same time may miss one another in the summary",
            path.display()
        ));
    }
    let row = |(scan, done): (&FoundScan, Option<Row>)| {
        done.unwrap_or_else(|| {
            let record = Record::read(out, scan);
            let status = record.as_ref().map_or(Status::Pending, Status::of);
            Row { scan: scan.clone(), status, record }
        })
    };
    let rows: Vec<Row> = scans.iter().zip(done).map(row).collect();
    let csv = output::write(&out.join("summary.csv"), |to| csv(&rows, to))?;
    let json = output::write(&out.join("summary.json"), |to| {
        serde_json::to_writer_pretty(&mut *to, &as_json(&rows, left_out))?;
        writeln!(to)
    })?;
    Pending::publish(vec![csv, json])?;
    Ok(rows)
}

/// How many scans have a status.
pub(super) fn count(rows: &[Row], status: Status) -> usize {
    rows.iter().filter(|row| row.status == status).count()
}

const ALL: [Status; 5] =
    [Status::Ok, Status::Missed, Status::Failed, Status::Skipped, Status::Pending];

fn as_json(rows: &[Row], left_out: &[UnusedFile]) -> serde_json::Value {
    let counts = ALL.map(|status| (status.name().to_owned(), json!(count(rows, status))));
    let scans = rows.iter().map(|row| {
        let r = row.record.as_ref();
        let f = r.map(|r| &r.figures);
        json!({
            "file": row.scan.path.display().to_string(),
            "status": row.status,
            "exit_code": r.map(|r| r.exit_code),
            "seconds": r.map(|r| r.seconds),
            "shape": f.and_then(|f| f.shape.as_ref()),
            "faces": f.and_then(|f| f.faces),
            "net": f.map_or(&[][..], |f| &f.net),
            "rms_mm": f.and_then(|f| f.rms_mm),
            "max_mm": f.and_then(|f| f.max_mm),
            "tolerance_mm": f.and_then(|f| f.tolerance_mm),
            "holes": f.and_then(|f| f.holes),
            "units": f.and_then(|f| f.units.as_ref()),
            "units_assumed": f.and_then(|f| f.units_assumed),
            "error": r.and_then(|r| r.error.as_ref()),
            "help": r.and_then(|r| r.help.as_ref()),
            "hints": r.map_or(&[][..], |r| &r.hints),
            "outputs": r.map_or(&[][..], |r| &r.outputs),
        })
    });
    json!({
        "scan2step": env!("CARGO_PKG_VERSION"),
        "counts": counts.into_iter().collect::<serde_json::Map<_, _>>(),
        "scans": scans.collect::<Vec<_>>(),
        "left_out": left_out,
    })
}

/// A value as text, or nothing.
fn number<T: ToString>(x: Option<T>) -> String {
    x.map_or(String::new(), |x| x.to_string())
}

/// The control nets, as 40x52.
fn nets(r: Option<&Record>) -> String {
    let nets = r.iter().flat_map(|r| &r.figures.net).map(|[m, n]| format!("{m}x{n}"));
    nets.collect::<Vec<_>>().join(" ")
}

/// A text as a cell of a table. Spreadsheets take one that begins with some signs for a formula, and run it; an
/// apostrophe before it tells them that it is text.
fn cell(text: &str) -> String {
    let text = printable(text);
    let is_formula = text.starts_with(['=', '+', '-', '@']);
    if is_formula { format!("'{text}") } else { text.into_owned() }
}

fn csv(rows: &[Row], to: &mut dyn Write) -> std::io::Result<()> {
    let mut csv = csv::Writer::from_writer(to);
    csv.write_record([
        "file",
        "status",
        "exit_code",
        "seconds",
        "shape",
        "faces",
        "net",
        "rms_mm",
        "max_mm",
        "tolerance_mm",
        "holes",
        "error",
        "outputs",
        "help",
        "hints",
        "units",
        "units_assumed",
    ])?;
    for row in rows {
        let r = row.record.as_ref();
        let f = r.map(|r| &r.figures);
        let outputs = r.iter().flat_map(|r| &r.outputs);
        let outputs = outputs.map(|o| format!("{}={}", o.file, o.sha256));
        csv.write_record([
            cell(&row.scan.path.display().to_string()),
            row.status.name().into(),
            number(r.map(|r| r.exit_code)),
            number(r.map(|r| r.seconds)),
            number(f.and_then(|f| f.shape.as_ref())),
            number(f.and_then(|f| f.faces)),
            nets(r),
            number(f.and_then(|f| f.rms_mm)),
            number(f.and_then(|f| f.max_mm)),
            number(f.and_then(|f| f.tolerance_mm)),
            number(f.and_then(|f| f.holes)),
            cell(&number(r.and_then(|r| r.error.as_ref()))),
            cell(&outputs.collect::<Vec<_>>().join(";")),
            cell(&number(r.and_then(|r| r.help.as_ref()))),
            cell(&r.map_or(String::new(), |r| r.hints.join("; "))),
            number(f.and_then(|f| f.units.as_ref())),
            number(f.and_then(|f| f.units_assumed)),
        ])?;
    }
    csv.flush()
}

/// The table for people. It has what fits on a terminal of 80 columns beside a short path; the
/// other figures are in the summaries.
pub(crate) fn table(rows: &[Row]) -> String {
    let mut table = Builder::default();
    table.push_record(["scan", "status", "seconds", "made", "rms mm", "max mm", "holes"]);
    for row in rows {
        let r = row.record.as_ref();
        let f = r.map(|r| &r.figures);
        let length = |x: Option<f64>| x.map_or(String::new(), significant);
        table.push_record([
            printable(&row.scan.path.display().to_string()).into_owned(),
            row.status.name().into(),
            r.map_or(String::new(), |r| format!("{:.1}", r.seconds)),
            made(r),
            length(f.and_then(|f| f.rms_mm)),
            length(f.and_then(|f| f.max_mm)),
            number(f.and_then(|f| f.holes)),
        ]);
    }
    let mut table = table.build();
    table.with(Style::blank()).modify(Columns::new(2..), Alignment::right());
    let counts = ALL.into_iter().filter(|&status| count(rows, status) > 0);
    let counts = counts.map(|status| format!("{} {}", count(rows, status), status.name()));
    format!("{table}\n{}\n", counts.collect::<Vec<_>>().join(", "))
}

/// What a scan became: "face 40x52", "solid of 22".
fn made(record: Option<&Record>) -> String {
    let Some(figures) = record.map(|record| &record.figures) else { return String::new() };
    match (&figures.shape, figures.net.as_slice(), figures.faces) {
        (Some(shape), [[m, n]], _) => format!("{shape} {m}x{n}"),
        (Some(shape), [], Some(faces)) => format!("{shape} of {faces}"),
        (Some(shape), [], None) => shape.clone(),
        (Some(_), _, _) => plural(figures.net.len(), "face"),
        (None, ..) => String::new(),
    }
}
