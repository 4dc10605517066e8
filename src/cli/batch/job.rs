//! One scan of a batch. `convert` runs as a process of its own, so that a crash, or memory that
//! runs out, affects no other scan.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};
use std::time::Instant;

use serde_json::Value;

use super::record::{self, Figures, Output, Record, Stamp};
use super::scans::FoundScan;
use crate::cli::{output, subprocess, temp_files};

/// The settings that all scans of a batch share.
pub(crate) struct Job {
    pub program: PathBuf,
    pub out: PathBuf,
    /// Extensions of the files to write: CAD files, reports.
    pub cad: Vec<String>,
    pub reports: Vec<String>,
    /// Options of `convert`.
    pub options: Vec<String>,
    /// What decides, besides the scan, whether files of an earlier run are the same.
    pub fingerprint: Vec<String>,
    pub threads: Option<u16>,
    /// The largest number of bytes that a scan may need.
    pub memory: Option<u64>,
}

impl Job {
    /// Converts a scan and records the result.
    pub(crate) fn run(&self, scan: &FoundScan) -> Record {
        let begun = Instant::now();
        let mut record = Record {
            scan2step: env!("CARGO_PKG_VERSION").into(),
            file: scan.path.display().to_string(),
            // Taken before the work: a scan that changes meanwhile is converted again.
            input: Stamp::of(&scan.path).unwrap_or_default(),
            options: self.fingerprint.clone(),
            exit_code: 1,
            seconds: 0.0,
            figures: Figures::default(),
            hints: Vec::new(),
            error: None,
            help: None,
            outputs: Vec::new(),
        };
        let done = self.convert(scan, &mut record);
        record.seconds = begun.elapsed().as_secs_f64();
        if let Err(e) = done.and_then(|()| record.write(&self.out, scan)) {
            record.exit_code = 1;
            record.error = Some(e.to_string());
            record.help = Some(e.help);
        }
        record
    }

    fn convert(&self, scan: &FoundScan, record: &mut Record) -> Result<(), formats::Error> {
        let report = record::path(&self.out, scan, "report.json");
        let files = |extensions: &[String]| -> Vec<PathBuf> {
            extensions.iter().map(|e| with_extension(&scan.name, e)).collect()
        };
        let (cad, reports) = (files(&self.cad), files(&self.reports));
        if let Some(folder) = self.out.join(&scan.name).parent() {
            temp_files::folder(folder).map_err(|e| output::failed(folder, e))?;
        }
        let mut command = Command::new(&self.program);
        command
            .args(["convert", "--quiet", "--color=never", "--end-with-input"])
            .args(&self.options);
        command.args(self.threads.map(|n| format!("--threads={n}")));
        command.args(self.memory.map(|bytes| format!("--max-memory={bytes}")));
        for file in reports.iter().map(|file| self.out.join(file)).chain([report.clone()]) {
            command.arg("--report").arg(file);
        }
        command.arg("--").arg(&scan.path).args(cad.iter().map(|file| self.out.join(file)));
        let failed = |e: std::io::Error| {
            let help = "check that the program can still be started";
            formats::Error::new(&scan.path, format!("cannot be converted: {e}"), help)
        };
        let ended = subprocess::run(&mut command).map_err(failed)?;
        record.exit_code = exit_code(ended.status);
        let said = String::from_utf8_lossy(&ended.stderr);
        if !matches!(record.exit_code, 0 | 3) {
            let after = |word: &str| said.lines().find_map(|l| l.strip_prefix(word));
            let unsaid = || format!("{}: convert ended with {}", scan.path.display(), ended.status);
            record.error = Some(after("error: ").map_or_else(unsaid, str::to_owned));
            record.help = after("help: ").map(str::to_owned);
            return Ok(());
        }
        record.error = said.lines().find(|l| l.starts_with("tolerance not met")).map(str::to_owned);
        let text = std::fs::read(&report).map_err(failed)?;
        let figures: Value = serde_json::from_slice(&text).map_err(|e| failed(e.into()))?;
        record.figures = Figures::of(&figures);
        let hints = figures["hints"].as_array().into_iter().flatten();
        record.hints = hints.filter_map(|hint| hint.as_str().map(str::to_owned)).collect();
        let all = cad.iter().chain(&reports);
        let outputs: std::io::Result<_> = all.map(|file| Output::of(&self.out, file)).collect();
        record.outputs = outputs.map_err(failed)?;
        Ok(())
    }
}

/// The exit code as shells give it: 128 and the signal's number for a process that a signal
/// ended.
fn exit_code(status: ExitStatus) -> i32 {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return 128 + signal;
    }
    status.code().unwrap_or(1)
}

/// The name with one more extension. A point in the name is part of it.
fn with_extension(name: &Path, extension: &str) -> PathBuf {
    let mut name = name.as_os_str().to_owned();
    name.push(".");
    name.push(extension);
    name.into()
}
