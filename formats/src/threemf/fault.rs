//! What is wrong with a 3MF file.

use crate::Location;
use crate::source::EXPORT_AGAIN;

/// A fault, before the file is known.
#[derive(Debug)]
pub(super) struct PackageFault {
    pub(super) what: String,
    pub(super) help: &'static str,
    pub(super) place: Option<Location>,
}

impl PackageFault {
    pub(super) fn new(what: impl Into<String>) -> PackageFault {
        PackageFault { what: what.into(), help: EXPORT_AGAIN, place: None }
    }

    /// A fault that another way of exporting avoids.
    pub(super) fn helped(what: impl Into<String>, help: &'static str) -> PackageFault {
        PackageFault { what: what.into(), help, place: None }
    }

    /// The same fault at a place, if it has none yet.
    pub(super) fn at(self, place: Option<Location>) -> PackageFault {
        PackageFault { place: self.place.or(place), ..self }
    }

    /// The same fault in a part. That of the root need not be named.
    pub(super) fn within(self, part: &str, number: usize) -> PackageFault {
        match number {
            0 => self,
            _ => PackageFault { what: format!("{}, in its part {part}", self.what), ..self },
        }
    }

    pub(super) fn encrypted() -> PackageFault {
        let help = "Export it without encryption (the secure content extension of 3MF).";
        PackageFault::helped("has encrypted parts", help)
    }

    pub(super) fn no_model() -> PackageFault {
        let help = "Unpack it and name the scan in it, or export it as 3MF again.";
        PackageFault::helped(
            "is a ZIP archive, but no 3MF file: no relationship names a 3D model",
            help,
        )
    }
}
