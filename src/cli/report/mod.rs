//! `--report FILE`: what a run did and how well, for programs (`.json`), for a
//! browser (`.html`) and as a picture (`.png`).

mod data;
mod histogram;
mod html;
mod json;
mod plane;
mod shown;
mod still;

use std::io::Write;
use std::path::{Path, PathBuf};

use scan2step::Conversion;
use scan2step::deviation::Deviation;
use serde_json::Value;

use super::input::Scan;
use super::output::{self, Pending};
use super::progress::Progress;

pub use json::{deviation, input};
pub use shown::{Shown, Watch};

/// A report to write.
#[derive(Debug, Clone)]
pub struct ReportFile {
    pub path: PathBuf,
    pub kind: Kind,
}

/// Its format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Kind {
    Json,
    Html,
    Png,
}

impl Kind {
    /// Whether it shows meshes, and not only figures.
    pub fn is_picture(self) -> bool {
        self != Kind::Json
    }
}

/// What the report says besides the conversions.
pub struct Context<'a> {
    pub scan: &'a Scan,
    pub options: Value,
    pub hints: Vec<String>,
    pub tolerance_named: bool,
    pub outliers_pct: f64,
    pub outputs: Vec<(&'a Path, &'a Pending)>,
    pub progress: &'a Progress,
}

/// Writes the reports that were asked for. `shown` has the meshes of each
/// conversion, where a report shows them.
pub fn write(
    files: &[ReportFile],
    conversions: &[Conversion],
    shown: &[Shown],
    context: &Context,
) -> Result<Vec<Pending>, formats::Error> {
    let figures = json::report(conversions, context);
    let name = file_name(&context.scan.path);
    let scene: Vec<_> = conversions.iter().zip(shown).collect();
    let mut still = Vec::new();
    if let Some(file) = files.iter().find(|file| file.kind.is_picture()) {
        let failed = |e| {
            formats::Error::new(
                &file.path,
                format!("cannot be drawn: {e}"),
                "please report this as a bug",
            )
        };
        still = still::png(&name, &scene).map_err(failed)?;
    }
    let content = |kind: Kind, out: &mut dyn Write| match kind {
        Kind::Json => {
            serde_json::to_writer_pretty(&mut *out, &figures)?;
            writeln!(out)
        }
        Kind::Html => html::write(&name, &figures, &scene, &still, out),
        Kind::Png => out.write_all(&still),
    };
    files.iter().map(|f| output::write(&f.path, |out| content(f.kind, out))).collect()
}

/// The name of a file without its folder.
pub fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// The ends of the colour scales, in mm.
struct Ends {
    measured: f64,
    smoothed: f64,
}

impl Ends {
    fn of(scene: &[(&Conversion, &Shown)]) -> Ends {
        let tolerance = scene.iter().map(|(c, _)| c.tolerance).fold(0.0, f64::max);
        let end = |of: fn(&Conversion) -> &Deviation| {
            // The few that are farthest would make all others look alike.
            let most = SPREAD * scene.iter().map(|(c, _)| of(c).p95).fold(0.0, f64::max);
            let with_tolerance = 1.1 * tolerance;
            let end = if with_tolerance < NEAR * most { most.max(with_tolerance) } else { most };
            scan2step::picture::scale::rounded_up(end)
        };
        Ends { measured: end(|c| &c.deviation), smoothed: end(|c| &c.fit_deviation) }
    }
}

/// A scale's end as a multiple of the 95th percentile of the distances, and the
/// multiple of that up to which it is moved to have the tolerance on the scale;
/// farther, it would leave the distances without colours.
const SPREAD: f64 = 1.3;
const NEAR: f64 = 3.0;

/// A number with as few digits as tell it from others of its kind.
fn short(x: f64) -> String {
    let digits = if x > 0.0 { 2 - x.log10().floor() as i32 } else { 0 };
    let text = format!("{x:.*}", digits.clamp(0, 14) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}
