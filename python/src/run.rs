//! Long tasks: a thread of their own, progress, and Ctrl-C.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;
use scan2step::{Error, threads};

use crate::errors::Failure;

/// The longest time between two looks for signals. A person does not notice it.
const BEAT: Duration = Duration::from_millis(20);

/// How a task tells how far it has come.
pub struct Watch<'a> {
    events: Sender<(&'static str, f64)>,
    stop: &'a AtomicBool,
}

impl Watch<'_> {
    /// Tells the share of a stage that is done. An error means that the caller wants no more.
    pub fn tell(&self, stage: &'static str, share: f64) -> scan2step::Result<()> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(Error::Stopped);
        }
        // The caller hears no more if it has failed, and has set `stop` then.
        let _ = self.events.send((stage, share));
        Ok(())
    }
}

/// Runs a task on a thread of its own, so that Python's other threads go on. Its loops have a pool of threads
/// that ends with it, because a process that is forked later would wait for those of a pool that goes on. Meanwhile the calling thread
/// calls `progress(stage, share)` and looks for signals, because only Python's main thread may. What these
/// raise stops the task and is raised again.
pub fn run<R: Send>(
    py: Python,
    threads: Option<usize>,
    progress: Option<&Bound<PyAny>>,
    task: impl FnOnce(&Watch) -> Result<R, Failure> + Send,
) -> PyResult<R> {
    let stop = AtomicBool::new(false);
    let (sender, events) = mpsc::channel();
    let events = std::sync::Mutex::new(events);
    let watch = Watch { events: sender, stop: &stop };
    thread::scope(|scope| {
        let worker = scope.spawn(move || threads::run(threads, move || task(&watch)));
        let mut raised = None;
        loop {
            let next = py.detach(|| match events.lock() {
                Ok(events) => events.recv_timeout(BEAT),
                Err(_) => Err(RecvTimeoutError::Disconnected),
            });
            let heard = match (next, progress) {
                (Err(RecvTimeoutError::Disconnected), _) => break,
                (Ok(event), Some(progress)) if raised.is_none() => {
                    progress.call1(event).and_then(|_| py.check_signals())
                }
                _ => py.check_signals(),
            };
            if let Err(error) = heard {
                stop.store(true, Ordering::Relaxed);
                raised.get_or_insert(error);
            }
        }
        let done = py.detach(|| worker.join());
        if let Some(error) = raised {
            return Err(error);
        }
        match done {
            Ok(done) => Ok(done.map_err(Failure::from)??),
            Err(panic) => Err(Failure::Internal(message(&*panic)).into()),
        }
    })
}

/// What a panic says.
fn message(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
    format!("a thread panicked: {}", text.unwrap_or_else(|| "it does not say why".into()))
}
