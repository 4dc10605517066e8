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

/// A callback for one of several steps of a stage, numbered from 0, that count as equally long.
pub(crate) fn step(progress: &mut Progress, number: u32, of: u32) -> impl FnMut(f64) -> Result<()> {
    part(progress, f64::from(number) / f64::from(of), f64::from(number + 1) / f64::from(of))
}

/// A callback that ignores progress.
pub(crate) fn ignore(_: f64) -> Result<()> {
    Ok(())
}
