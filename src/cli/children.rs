//! Processes that a run starts, which end with it.

use std::io;
use std::process::{Command, Output, Stdio};
use std::sync::{Mutex, PoisonError};

use super::leftovers;

/// Those that are running.
static RUNNING: Mutex<Vec<u32>> = Mutex::new(Vec::new());

fn change(what: impl FnOnce(&mut Vec<u32>)) {
    what(&mut RUNNING.lock().unwrap_or_else(PoisonError::into_inner));
}

/// Runs a command to its end and returns what it said.
pub fn run(command: &mut Command) -> io::Result<Output> {
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    // None starts any more once the run is being stopped.
    let child = leftovers::uninterrupted(|| {
        let child = command.spawn()?;
        change(|running| running.push(child.id()));
        io::Result::Ok(child)
    })?;
    let id = child.id();
    let output = child.wait_with_output();
    change(|running| running.retain(|&other| other != id));
    output
}

/// Has all that are running clear up and end, and waits for them.
#[cfg(unix)]
pub fn stop() {
    use rustix::process::{Pid, Signal, kill_process};
    use std::time::{Duration, Instant};

    change(|running| {
        for &id in running.iter() {
            if let Some(pid) = Pid::from_raw(id as i32) {
                // It may have ended by itself.
                let _ = kill_process(pid, Signal::TERM);
            }
        }
    });
    // They have nothing to do but to remove files.
    let begun = Instant::now();
    let mut some = true;
    while some && begun.elapsed() < Duration::from_secs(10) {
        std::thread::sleep(Duration::from_millis(5));
        change(|running| some = !running.is_empty());
    }
}
