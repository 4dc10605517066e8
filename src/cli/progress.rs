//! What a run says on standard error, and how long its stages take.

use std::time::Instant;

/// Seconds and memory of one stage.
#[derive(Debug, Clone)]
pub struct StageTime {
    pub name: &'static str,
    pub seconds: f64,
    pub peak_rss_mb: f64,
}

/// The clock and the voice of a run.
#[derive(Debug)]
pub struct Progress {
    quiet: bool,
    verbose: bool,
    begun: Instant,
    stage_begun: Instant,
    pub stages: Vec<StageTime>,
}

impl Progress {
    pub fn new(quiet: bool, verbose: bool) -> Self {
        let now = Instant::now();
        Progress { quiet, verbose, begun: now, stage_begun: now, stages: Vec::new() }
    }

    /// Says a line, unless the run is quiet.
    pub fn say(&self, line: &str) {
        if !self.quiet {
            eprintln!("{line}");
        }
    }

    /// Says a line only where the user asked for more.
    pub fn detail(&self, line: &str) {
        if self.verbose {
            eprintln!("{line}");
        }
    }

    /// Ends a stage; the next one begins now.
    pub fn ended(&mut self, name: &'static str) {
        let seconds = self.stage_begun.elapsed().as_secs_f64();
        self.detail(&format!("{name:14}{seconds:9.3} s"));
        self.stages.push(StageTime { name, seconds, peak_rss_mb: peak_rss_mb() });
        self.stage_begun = Instant::now();
    }

    /// Seconds since the run began.
    pub fn seconds(&self) -> f64 {
        self.begun.elapsed().as_secs_f64()
    }
}

/// A length in mm with four significant digits, for people: scans are as large as
/// a mountain and, with the wrong unit, as small as a grain.
pub fn mm(length: f64) -> String {
    let digits = if length > 0.0 { 3 - length.log10().floor() as i32 } else { 0 };
    format!("{length:.*} mm", digits.clamp(0, 12) as usize)
}

/// The process's peak resident memory so far, in MB (10⁶ bytes); 0 where the
/// system does not tell.
pub fn peak_rss_mb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    let kib = line.and_then(|l| l.trim().trim_end_matches("kB").trim().parse::<f64>().ok());
    kib.unwrap_or(0.0) * 1024.0 / 1e6
}

#[cfg(test)]
mod tests {
    use super::mm;

    #[test]
    fn lengths_have_four_digits() {
        assert_eq!(mm(0.059712), "0.05971 mm");
        assert_eq!(mm(22.532185), "22.53 mm");
        assert_eq!(mm(53468.6), "53469 mm");
        assert_eq!(mm(0.0), "0 mm");
        assert_eq!(mm(1.2345e-5), "0.00001234 mm");
    }
}
