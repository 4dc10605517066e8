//! The resources that a process has used so far, as Linux reports them.
//!
//! Not every example uses all functions.
#![allow(dead_code)]

use std::error::Error;
use std::fs;

/// The CPU seconds of all threads so far, including threads that have ended.
pub fn cpu_s() -> Result<f64, Box<dyn Error>> {
    Ok(cpu_time::ProcessTime::try_now()?.as_duration().as_secs_f64())
}

/// The peak resident memory of the process so far, in MB (10⁶ bytes).
pub fn peak_rss_mb() -> Result<f64, Box<dyn Error>> {
    let status = fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:")).ok_or("no VmHWM")?;
    Ok(line.trim().trim_end_matches("kB").trim().parse::<f64>()? * 1024.0 / 1e6)
}
