//! The border between the lengths that the pipeline works in and mm, which are its
//! caller's.

use super::{BodyConversion, Conversion, Observer, Stage};
use crate::convert::Options;
use crate::error::{Error, Result};
use crate::stages::smooth::Support;

/// Shows a caller in mm what stages made in other lengths.
pub(crate) struct Shown<'a> {
    watch: &'a mut Observer<'a>,
    mm: f64,
    /// Whether the caller answered with an error.
    stopped: bool,
}

impl<'a> Shown<'a> {
    /// One of the pipeline's lengths is so many `mm`.
    pub(crate) fn new(watch: &'a mut Observer<'a>, mm: f64) -> Self {
        Shown { watch, mm, stopped: false }
    }

    /// Shows a stage. What ends after the fit is in mm.
    pub(crate) fn see(&mut self, stage: Stage) -> Result<()> {
        let (watch, mm) = (&mut *self.watch, self.mm);
        let answer = match stage {
            stage if mm == 1.0 => watch(stage),
            Stage::Mesh(disk) => watch(Stage::Mesh(&disk.clone().scaled(mm))),
            Stage::Smooth(disk) => watch(Stage::Smooth(&disk.clone().scaled(mm))),
            Stage::Fill(patch) => watch(Stage::Fill(&patch.clone().scaled(mm))),
            Stage::Parameterize(map, crushed) => {
                let crushed = crushed.map(|crushed| crushed.scaled(mm));
                watch(Stage::Parameterize(&map.clone().scaled(mm), crushed))
            }
            Stage::Fit(surface) => watch(Stage::Fit(&surface.clone().scaled(mm))),
            Stage::Layout(quads) => watch(Stage::Layout(&quads.clone().scaled(mm))),
            stage => watch(stage),
        };
        self.stopped |= answer.is_err();
        answer
    }

    /// What stopped the pipeline, in mm. The caller's own error is so already.
    pub(crate) fn in_mm(&self, error: Error) -> Error {
        if self.stopped { error } else { error.scaled(self.mm) }
    }
}

/// A length that was divided and multiplied again may differ in its last digit from the
/// one that the caller named. These say what was named.
impl Conversion {
    pub(crate) fn with_named(mut self, options: &Options) -> Self {
        self.tolerance = options.tolerance.unwrap_or(self.tolerance);
        self.fit.kappa = options.knots.kappa.or(self.fit.kappa);
        if let Support::Fixed(h) = options.smooth.support {
            self.smooth.h = h;
        }
        self
    }
}

impl BodyConversion {
    pub(crate) fn with_named(mut self, options: &Options) -> Self {
        self.tolerance = options.tolerance.unwrap_or(self.tolerance);
        if let Support::Fixed(h) = options.smooth.support {
            self.smooth.h = h;
        }
        self
    }
}

impl Error {
    pub(crate) fn with_named(mut self, options: &Options) -> Self {
        if let (Error::Support { h, .. }, Support::Fixed(named)) =
            (&mut self, options.smooth.support)
        {
            *h = named;
        }
        self
    }
}
