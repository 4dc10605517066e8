//! How far a stage has come.

use crate::error::Result;

/// A callback that hears about what share of its time a stage has behind it, from 0 to 1. It
/// may hear a slightly smaller share than before. An error of its own stops the stage:
/// [`Error::Stopped`](crate::Error::Stopped) where its caller wants no more.
pub type Progress<'a> = dyn FnMut(f64) -> Result<()> + Send + 'a;

/// A callback for a part of a stage, whose shares from 0 to 1 are those from `from` to `to`
/// of the whole stage.
pub(crate) fn part(progress: &mut Progress, from: f64, to: f64) -> impl FnMut(f64) -> Result<()> {
    move |share| progress(from + share * (to - from))
}

/// A callback that ignores progress.
pub(crate) fn ignore(_: f64) -> Result<()> {
    Ok(())
}
