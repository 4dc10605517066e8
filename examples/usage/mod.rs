//! The resources that a process has used so far, as Linux reports them.
//!
//! Not every example uses all functions.
#![allow(dead_code)]

use std::error::Error;
use std::fs;

/// The CPU seconds of all threads so far.
pub fn cpu_s() -> Result<f64, Box<dyn Error>> {
    let mut ns = 0.0;
    for task in fs::read_dir("/proc/self/task")? {
        let stat = fs::read_to_string(task?.path().join("schedstat"))?;
        ns += stat.split(' ').next().unwrap_or_default().parse::<f64>()?;
    }
    Ok(ns / 1e9)
}

/// The peak resident memory of the process so far, in MB (10⁶ bytes).
pub fn peak_rss_mb() -> Result<f64, Box<dyn Error>> {
    let status = fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:")).ok_or("no VmHWM")?;
    Ok(line.trim().trim_end_matches("kB").trim().parse::<f64>()? * 1024.0 / 1e6)
}
