//! What a run that is stopped must not leave behind: temporary files, and folders
//! that it made.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

#[cfg(unix)]
use super::{children, streams};

/// What was made so far. Who holds the lock is not interrupted.
static MADE: Mutex<Made> = Mutex::new(Made { files: Vec::new(), folders: Vec::new() });

struct Made {
    files: Vec<PathBuf>,
    folders: Vec<PathBuf>,
}

impl Made {
    /// Removes the files, then the folders that are empty. Those that are in their
    /// places by now have no file under the temporary name any more.
    fn sweep(&mut self) {
        for file in self.files.drain(..) {
            let _ = std::fs::remove_file(file);
        }
        for folder in self.folders.drain(..).rev() {
            let _ = std::fs::remove_dir(folder);
        }
    }
}

fn lock() -> MutexGuard<'static, Made> {
    // A panic while it was held leaves nothing half done.
    MADE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes a temporary file and remembers it.
pub fn made<T>(make: impl FnOnce() -> io::Result<(T, PathBuf)>) -> io::Result<T> {
    let mut made = lock();
    let (file, path) = make()?;
    made.files.push(path);
    Ok(file)
}

/// Makes a folder and those it is in, and remembers them.
pub fn folder(path: &Path) -> io::Result<()> {
    let mut made = lock();
    let missing: Vec<&Path> = path.ancestors().take_while(|p| !p.exists()).collect();
    let missing = missing.into_iter().filter(|p| !p.as_os_str().is_empty()).map(Path::to_owned);
    made.folders.extend(missing.collect::<Vec<_>>().into_iter().rev());
    std::fs::create_dir_all(path)
}

/// Does what must not be stopped halfway.
pub fn uninterrupted<T>(work: impl FnOnce() -> T) -> T {
    let _held = lock();
    work()
}

/// Clears up after a run that failed.
pub fn sweep() {
    lock().sweep();
}

/// From now on Ctrl-C and the like clear up before they end the program, as they
/// would have without.
#[cfg(unix)]
pub fn sweep_when_stopped() -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::{iterator::Signals, low_level::emulate_default_handler};

    let ignored = ignored_signals();
    let heeded = [SIGHUP, SIGINT, SIGTERM].into_iter().filter(|s| ignored >> (s - 1) & 1 == 0);
    let mut signals = Signals::new(heeded)?;
    std::thread::Builder::new().name("signals".into()).spawn(move || {
        if let Some(signal) = signals.forever().next() {
            // Held to the end: nothing new may appear.
            let mut made = lock();
            children::stop();
            made.sweep();
            streams::say("\nstopped; no unfinished file is left");
            let _ = emulate_default_handler(signal);
            std::process::exit(128 + signal);
        }
    })?;
    Ok(())
}

/// Without signals there is nothing to heed.
#[cfg(not(unix))]
pub fn sweep_when_stopped() -> io::Result<()> {
    Ok(())
}

/// A bit for every signal that whoever started the program had it ignore, as
/// nohup does; 0 where the system does not tell.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|l| l.strip_prefix("SigIgn:"));
    mask.and_then(|m| u64::from_str_radix(m.trim(), 16).ok()).unwrap_or(0)
}
