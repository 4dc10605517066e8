//! What the face must reach: the tolerance that is named, or that which the scan's noise
//! lets one ask for.

use crate::convert::Options;
use crate::mesh::Mesh;
use crate::stages::adapt::Goal;
use crate::stages::trim;
use crate::statistics::SIGNIFICANT;

impl Goal {
    /// A tolerance that the user names, in the lengths of the scan's mesh, and the share of points
    /// that may miss it. The fit keeps to a little less, as trim loops take the rest.
    pub fn named(tolerance: f64, outliers: f64) -> Self {
        Goal { tolerance: trim::Options::most_off(tolerance), named: true, outliers }
    }

    /// What a scan lets one ask for whose noise has that standard deviation. Where noise is visible, the
    /// tolerance is no less than a ten-thousandth of the scan's diagonal. Otherwise flat triangles stand for
    /// the surface: their chord errors take the place of noise, up to a thousandth of the diagonal.
    pub(crate) fn of_scan(measured: &Mesh, noise: f64, is_visible: bool) -> Self {
        let [least, most] = [LEAST_TOLERANCE, MOST_TOLERANCE]
            .map(|share| share * measured.diagonal() / SIGNIFICANT);
        let noise = match is_visible {
            true => noise.max(least),
            false => (of_facets(measured) / SIGNIFICANT).clamp(least, most).max(noise),
        };
        Goal::of_noise(noise)
    }

    pub(super) fn of(options: &Options, measured: &Mesh, noise: f64, is_visible: bool) -> Self {
        match options.tolerance {
            Some(tolerance) => Goal::named(tolerance, options.outliers),
            None => Goal::of_scan(measured, noise, is_visible),
        }
    }
}

/// The tolerance of which the facets of a clean mesh tell its surface. Sharp edges are in it, too: faces
/// with a smooth transition do not follow them, however many knots they get.
pub(super) fn of_facets(mesh: &Mesh) -> f64 {
    SIGNIFICANT * mesh.mean_chord_error()
}

/// A tolerance that nobody named is no less than this share of the scan's diagonal: a fit that follows
/// a scan better needs more control points than its noise is worth.
const LEAST_TOLERANCE: f64 = 1e-4;

/// Chord errors do not make a tolerance larger than this share of the diagonal: triangles that are
/// farther from a smooth surface stand for an edge, and not for a surface.
const MOST_TOLERANCE: f64 = 1e-3;
