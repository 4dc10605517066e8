//! How far a stage has come.

use crate::error::Result;

/// Is told the share of its time that a stage has behind it, about; it may go back a
/// little. An error of its own stops the stage.
pub type Progress<'a> = dyn FnMut(f64) -> Result<()> + 'a;

/// The progress of a part of a stage, which takes the shares from `from` to `to`.
pub(crate) fn part(progress: &mut Progress, from: f64, to: f64) -> impl FnMut(f64) -> Result<()> {
    move |share| progress(from + share * (to - from))
}

/// For whom it is all the same.
pub(crate) fn ignore(_: f64) -> Result<()> {
    Ok(())
}
