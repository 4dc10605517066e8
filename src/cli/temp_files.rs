//! The temporary files and the new folders of a run. They are removed when the run fails or
//! is stopped.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

#[cfg(unix)]
use super::{streams, subprocess};

/// What the run has made so far. A signal waits until this lock is free.
static MADE: Mutex<Made> = Mutex::new(Made { files: Vec::new(), folders: Vec::new() });

struct Made {
    files: Vec<PathBuf>,
    folders: Vec<PathBuf>,
}

impl Made {
    /// Removes the files, then the folders that are empty. A file that was already renamed to
    /// its final name is kept, because nothing has the temporary name any more.
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
    // The lists are valid even if a thread panicked while it held the lock.
    MADE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes a temporary file and remembers it.
pub(crate) fn made<T>(make: impl FnOnce() -> io::Result<(T, PathBuf)>) -> io::Result<T> {
    let mut made = lock();
    let (file, path) = make()?;
    made.files.push(path);
    Ok(file)
}

/// Makes a folder and its missing parents, and remembers those that it made.
pub(crate) fn folder(path: &Path) -> io::Result<()> {
    let mut made = lock();
    let missing: Vec<&Path> = path.ancestors().take_while(|p| !p.exists()).collect();
    let missing = missing.into_iter().filter(|p| !p.as_os_str().is_empty()).map(Path::to_owned);
    made.folders.extend(missing.collect::<Vec<_>>().into_iter().rev());
    std::fs::create_dir_all(path)
}

/// Does work that no signal may interrupt.
pub(crate) fn uninterrupted<T>(work: impl FnOnce() -> T) -> T {
    let _held = lock();
    work()
}

/// Removes what a failed run has left.
pub(crate) fn sweep() {
    lock().sweep();
}

/// From now on the run removes its temporary files when Ctrl-C or another signal ends it.
#[cfg(unix)]
pub(crate) fn sweep_when_stopped() -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::{iterator::Signals, low_level::emulate_default_handler};

    let ignored = ignored_signals();
    let heeded = [SIGHUP, SIGINT, SIGTERM].into_iter().filter(|s| ignored >> (s - 1) & 1 == 0);
    let mut signals = Signals::new(heeded)?;
    std::thread::Builder::new().name("signals".into()).spawn(move || {
        if let Some(signal) = signals.forever().next() {
            // Hold the lock until the end, so that no new file appears.
            let mut made = lock();
            subprocess::stop();
            made.sweep();
            streams::say_as_is("\nstopped; no unfinished file is left");
            let _ = emulate_default_handler(signal);
            std::process::exit(128 + signal);
        }
    })?;
    Ok(())
}

/// From now on the run ends, and removes its temporary files, when its standard input ends. So a conversion ends with
/// the batch that started it and holds the other end, however that ends.
pub(crate) fn end_with_input() -> io::Result<()> {
    std::thread::Builder::new().name("parent".into()).spawn(|| {
        let _ = io::copy(&mut io::stdin(), &mut io::sink());
        let mut made = lock();
        made.sweep();
        std::process::exit(1);
    })?;
    Ok(())
}

/// This system has no signals to wait for.
#[cfg(not(unix))]
pub(crate) fn sweep_when_stopped() -> io::Result<()> {
    Ok(())
}

/// The signals that the program was started to ignore, as with nohup: one bit for each.
/// 0 if the system does not say.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|l| l.strip_prefix("SigIgn:"));
    mask.and_then(|m| u64::from_str_radix(m.trim(), 16).ok()).unwrap_or(0)
}
