//! `--report FILE`: which reports to write, and where. The library makes their content.

use std::io::{self, Write};
use std::path::PathBuf;

use scan2step::report::{BodyReport, Report, ReportView, picture_png};

use super::output::{self, Pending};

/// A report to write.
#[derive(Debug, Clone)]
pub struct ReportFile {
    pub path: PathBuf,
    pub kind: ReportFormat,
}

/// Its format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ReportFormat {
    Json,
    Html,
    Png,
}

impl ReportFormat {
    /// Whether it shows meshes, and not only figures.
    pub fn is_picture(self) -> bool {
        self != ReportFormat::Json
    }
}

/// A report of faces, or of solids and shells.
pub trait WrittenReport {
    /// Writes it as JSON.
    fn json(&self, out: &mut dyn Write) -> io::Result<()>;
    /// Writes it as a page.
    fn html(&self, views: &[ReportView], still: &[u8], out: &mut dyn Write) -> io::Result<()>;
}

impl WrittenReport for Report {
    fn json(&self, out: &mut dyn Write) -> io::Result<()> {
        self.write_json(out)
    }

    fn html(&self, views: &[ReportView], still: &[u8], out: &mut dyn Write) -> io::Result<()> {
        self.write_html(views, still, out)
    }
}

impl WrittenReport for BodyReport {
    fn json(&self, out: &mut dyn Write) -> io::Result<()> {
        self.write_json(out)
    }

    fn html(&self, views: &[ReportView], still: &[u8], out: &mut dyn Write) -> io::Result<()> {
        self.write_html(views, still, out)
    }
}

/// Writes the reports that were asked for under temporary names. `name` is the scan's file
/// without its folder. `views` has the meshes of each conversion if a report shows them.
pub fn write(
    files: &[ReportFile],
    name: &str,
    report: &dyn WrittenReport,
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
        ReportFormat::Json => report.json(out),
        ReportFormat::Html => report.html(views, &still, out),
        ReportFormat::Png => out.write_all(&still),
    };
    files.iter().map(|f| output::write(&f.path, |out| content(f.kind, out))).collect()
}
