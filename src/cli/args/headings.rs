//! The headings of options in help texts and manual pages.

pub(crate) const FILES: &str = "Files to write";
pub(crate) const SCAN: &str = "The scan";
pub(crate) const CLOUD: &str = "Clouds of points";
pub(crate) const SHAPE: &str = "What the scan becomes";
pub(crate) const ACCURACY: &str = "Accuracy";
pub(crate) const HOLES: &str = "Holes and the outer boundary";
pub(crate) const DETAILS: &str = "Details of the method";
pub(crate) const RUN: &str = "The run";
