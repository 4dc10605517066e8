//! What the face must reach: the tolerance that is named, or that which the scan's noise
//! lets one ask for.

use crate::convert::Options;
use crate::mesh::Mesh;
use crate::stages::adapt::{Goal, TOLERANCE_OF_NOISE};
use crate::stages::trim;

impl Goal {
    /// A tolerance that the user names, in the lengths of the scan's mesh, and the share of points
    /// that may miss it. The fit keeps to a little less, as trim loops take the rest.
    pub fn named(tolerance: f64, outliers: f64) -> Self {
        Goal { tolerance: trim::Options::most_off(tolerance), named: true, outliers }
    }

    /// What a scan lets one ask for whose noise has that standard deviation. It is never less
    /// than a ten-thousandth of the scan's diagonal.
    pub fn of_scan(measured: &Mesh, noise: f64) -> Self {
        Goal::of_noise(noise.max(least_noise(measured, noise)))
    }

    pub(super) fn of(options: &Options, measured: &Mesh, noise: f64) -> Self {
        match options.tolerance {
            Some(tolerance) => Goal::named(tolerance, options.outliers),
            None => Goal::of_scan(measured, noise),
        }
    }
}

/// A tolerance that nobody named is no less than this share of the scan's diagonal.
const LEAST_TOLERANCE: f64 = 1e-4;

/// The noise that a tolerance is at least made of. A scan without any tells its surface only as
/// well as flat triangles stand for it: their chord error takes the place of noise.
fn least_noise(mesh: &Mesh, noise: f64) -> f64 {
    let least = LEAST_TOLERANCE * mesh.diagonal() / TOLERANCE_OF_NOISE;
    if noise == 0.0 { least.max(mesh.mean_chord_error()) } else { least }
}
