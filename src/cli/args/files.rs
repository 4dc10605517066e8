//! Files to read and to write. The extension of an output gives its format.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use clap::builder::{PathBufValueParser, TypedValueParser};

use super::choices::Unit;
use crate::cli::report::{ReportFile, ReportFormat};
use crate::cli::streams;

/// A file to read, or standard input.
#[derive(Debug, Clone)]
pub(crate) struct InputFile {
    /// The path, or what messages and outputs call standard input.
    pub name: PathBuf,
    pub is_stdin: bool,
}

impl From<PathBuf> for InputFile {
    fn from(path: PathBuf) -> Self {
        let is_stdin = path == Path::new(streams::DASH);
        InputFile { name: if is_stdin { streams::STDIN.into() } else { path }, is_stdin }
    }
}

/// Takes any path, even one that is no Unicode.
pub(crate) fn input_file() -> impl TypedValueParser<Value = InputFile> {
    PathBufValueParser::new().map(InputFile::from)
}

/// A CAD file to write.
#[derive(Debug, Clone)]
pub(crate) struct CadFile {
    pub path: PathBuf,
    pub kind: CadKind,
}

/// Its format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum CadKind {
    Step,
    Iges,
}

impl CadKind {
    /// The extension of a file that gets its name from the scan.
    pub(crate) fn extension(self) -> &'static str {
        match self {
            CadKind::Step => "step",
            CadKind::Iges => "igs",
        }
    }
}

fn extension(path: &str) -> String {
    let extension = PathBuf::from(path).extension().map(|e| e.to_string_lossy().to_lowercase());
    extension.unwrap_or_default()
}

pub(crate) fn cad_file(path: &str) -> Result<CadFile, String> {
    let kind = match extension(path).as_str() {
        // The option --to may name another one.
        _ if path == streams::DASH => CadKind::Step,
        "step" | "stp" => CadKind::Step,
        "igs" | "iges" => CadKind::Iges,
        // What a shell makes of "--tolerance 0.2 mm".
        _ if <Unit as ValueEnum>::from_str(path, true).is_ok() => {
            return Err("a unit of length belongs to its number without a blank, as 0.2mm".into());
        }
        _ => return Err("not .step, .stp, .igs or .iges, nor - for standard output".into()),
    };
    Ok(CadFile { path: path.into(), kind })
}

pub(crate) fn report_file(path: &str) -> Result<ReportFile, String> {
    let kind = match extension(path).as_str() {
        _ if path == streams::DASH => ReportFormat::Json,
        "json" => ReportFormat::Json,
        "html" | "htm" => ReportFormat::Html,
        "png" => ReportFormat::Png,
        _ => return Err("not .json, .html or .png, nor - for JSON on standard output".into()),
    };
    Ok(ReportFile { path: path.into(), kind })
}
