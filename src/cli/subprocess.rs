//! Processes that a run starts. They end when the run is stopped.

use std::io;
use std::process::{Command, Output, Stdio};
use std::sync::{Mutex, PoisonError};

use super::temp_files;

/// The numbers of the running processes.
static RUNNING: Mutex<Vec<u32>> = Mutex::new(Vec::new());

fn change(what: impl FnOnce(&mut Vec<u32>)) {
    what(&mut RUNNING.lock().unwrap_or_else(PoisonError::into_inner));
}

/// Runs a command to its end and returns what it wrote to standard error. Its standard input ends with this process, even
/// if nothing else can tell the command that this process was killed.
pub(crate) fn run(command: &mut Command) -> io::Result<Output> {
    command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    // No process starts once the run is being stopped.
    let mut child = temp_files::uninterrupted(|| {
        let child = command.spawn()?;
        change(|running| running.push(child.id()));
        io::Result::Ok(child)
    })?;
    let id = child.id();
    // It would be closed before the wait.
    let input = child.stdin.take();
    let output = child.wait_with_output();
    drop(input);
    change(|running| running.retain(|&other| other != id));
    output
}

/// Asks all running processes to remove their temporary files and end, and waits for them.
#[cfg(unix)]
pub(crate) fn stop() {
    use rustix::process::{Pid, Signal, kill_process};
    use std::time::{Duration, Instant};

    change(|running| {
        for &id in running.iter() {
            if let Some(pid) = Pid::from_raw(id as i32) {
                // The process may have ended already.
                let _ = kill_process(pid, Signal::TERM);
            }
        }
    });
    // Ten seconds suffice, because the processes only remove files.
    let begun = Instant::now();
    let mut some = true;
    while some && begun.elapsed() < Duration::from_secs(10) {
        std::thread::sleep(Duration::from_millis(5));
        change(|running| some = !running.is_empty());
    }
}
