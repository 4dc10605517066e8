//! The headings of options in help texts and manual pages.

pub const FILES: &str = "Files to write";
pub const SCAN: &str = "The scan";
pub const CLOUD: &str = "Clouds of points";
pub const SHAPE: &str = "What the scan becomes";
pub const ACCURACY: &str = "Accuracy";
pub const HOLES: &str = "Holes and the outer boundary";
pub const DETAILS: &str = "Details of the method";
pub const RUN: &str = "The run";
