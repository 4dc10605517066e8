//! How far a stage has come.

use crate::error::Result;

/// A callback that hears about what share of its time a stage has behind it, from 0 to 1. It
/// may hear a slightly smaller share than before. An error of its own stops the stage:
/// [`Error::Stopped`](crate::error::Error::Stopped) where its caller wants no more.
pub type Progress<'a> = dyn FnMut(f64) -> Result<()> + Send + 'a;

/// A callback for step `k` of `count` steps of a stage, which are assumed to take the same time.
pub(crate) fn step(
    progress: &mut Progress,
    k: usize,
    count: usize,
) -> impl FnMut(f64) -> Result<()> {
    move |share| progress((k as f64 + share) / count as f64)
}

/// A callback that ignores progress.
pub(crate) fn ignore(_: f64) -> Result<()> {
    Ok(())
}
