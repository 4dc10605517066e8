//! `--report FILE`: which reports to write, and where. The library makes their content.

use std::io::Write;
use std::path::PathBuf;

use scan2step::report::{Report, ReportView, picture_png};

use super::output::{self, Pending};

/// A report to write.
#[derive(Debug, Clone)]
pub(crate) struct ReportFile {
    pub path: PathBuf,
    pub kind: ReportFormat,
}

/// Its format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum ReportFormat {
    Json,
    Html,
    Png,
}

impl ReportFormat {
    /// Whether it shows meshes, and not only figures.
    pub(crate) fn is_picture(self) -> bool {
        self != ReportFormat::Json
    }
}

/// Writes the reports that were asked for under temporary names. `name` is the scan's file
/// without its folder. `views` has the meshes of each conversion if a report shows them.
pub(super) fn write(
    files: &[ReportFile],
    name: &str,
    report: &Report,
    views: &[ReportView],
) -> Result<Vec<Pending>, formats::Error> {
    let mut still = Vec::new();
    if let Some(file) = files.iter().find(|file| file.kind.is_picture()) {
        let failed = |e| {
            formats::Error::new(
                &file.path,
                format!("cannot be drawn: {e}"),
                "please report this as a bug",
            )
        };
        still = picture_png(name, views).map_err(failed)?;
    }
    let content = |kind: ReportFormat, out: &mut dyn Write| match kind {
        ReportFormat::Json => report.write_json(out),
        ReportFormat::Html => report.write_html(views, &still, out),
        ReportFormat::Png => out.write_all(&still),
    };
    files.iter().map(|f| output::write(&f.path, |out| content(f.kind, out))).collect()
}
