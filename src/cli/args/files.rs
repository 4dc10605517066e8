//! Files to write. The extension of a name gives the format.

use std::path::PathBuf;

use crate::cli::report::{ReportFile, ReportFormat};

/// A CAD file to write.
#[derive(Debug, Clone)]
pub struct CadFile {
    pub path: PathBuf,
    pub kind: CadKind,
}

/// Its format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CadKind {
    Step,
    Iges,
}

fn extension(path: &str) -> String {
    let extension = PathBuf::from(path).extension().map(|e| e.to_string_lossy().to_lowercase());
    extension.unwrap_or_default()
}

pub fn cad_file(path: &str) -> Result<CadFile, String> {
    let kind = match extension(path).as_str() {
        "step" | "stp" => CadKind::Step,
        "igs" | "iges" => CadKind::Iges,
        _ => return Err("not .step, .stp, .igs or .iges".into()),
    };
    Ok(CadFile { path: path.into(), kind })
}

pub fn report_file(path: &str) -> Result<ReportFile, String> {
    let kind = match extension(path).as_str() {
        "json" => ReportFormat::Json,
        "html" | "htm" => ReportFormat::Html,
        "png" => ReportFormat::Png,
        _ => return Err("not .json, .html or .png".into()),
    };
    Ok(ReportFile { path: path.into(), kind })
}
