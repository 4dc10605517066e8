//! More knots in single faces of a network.
//!
//! A network of faces goes in, with the points of the scan and their places on the faces. The same network
//! comes out, with other control points and more knots inside those faces that miss the tolerance. The two
//! outer rows of control points stay on each side of a face. They alone say where its sides are and how its
//! tangent planes turn along them, so neighbours still share their edges and meet at the same angles.
//!
//! Each face is fitted by itself (`fit.rs`) with the knots of `halves.rs`.

mod fit;
mod halves;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::spline::{Network, Samples, Surface};
use fit::FaceFit;

/// The options of the refinement.
#[derive(Debug, Clone)]
pub struct Options {
    /// The distance in mm that points may have from the faces.
    pub tolerance: f64,
    /// The share of the points of a face that may exceed the tolerance.
    pub outliers: f64,
    /// The largest number of control points of a face.
    pub max_control: usize,
}

/// The results of the refinement.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Report {
    /// The numbers of the faces that were fitted again, in ascending order.
    pub faces: Vec<usize>,
}

/// The weight of a measured point. The tolerance holds for these only.
const MEASURED: f64 = 1.0;

/// The most times that the knot spans of a face are halved. A span is then an eighth as long as one of the
/// whole network, which has two points of the scan or more.
const HALVINGS: usize = 3;

/// Fits the faces again that miss the tolerance. `samples` has the points of each face. Those with a weight of
/// at least one were measured.
///
/// # Errors
/// [`Error::Input`] if there are not as many lists of points as faces.
pub fn refine(
    network: &Network,
    samples: &[Samples],
    options: &Options,
) -> Result<(Network, Report)> {
    if samples.len() != network.surfaces.len() {
        return Err(Error::Input("a network has not one list of points for each face"));
    }
    let faces = network.surfaces.par_iter().zip(samples);
    let again: Vec<Option<Surface>> =
        faces.map(|(surface, samples)| again(surface, samples, options)).collect();
    let mut network = network.clone();
    let mut report = Report::default();
    for (face, surface) in again.into_iter().enumerate() {
        if let Some(surface) = surface {
            network.surfaces[face] = surface;
            report.faces.push(face);
        }
    }
    Ok((network, report))
}

/// The face with as few more knots as it needs, or `None` if it keeps the tolerance or no fit is nearer to it.
fn again(surface: &Surface, samples: &Samples, options: &Options) -> Option<Surface> {
    let measured = samples.weights.iter().filter(|&&weight| weight >= MEASURED).count();
    let may_miss = (options.outliers * measured as f64) as usize;
    let most = options.max_control.min(measured);
    let mut best = FaceFit::of(surface.clone(), samples, options.tolerance);
    let before = best.beyond;
    for halving in 0..=HALVINGS {
        if best.beyond <= may_miss {
            break;
        }
        // At first the same knots have to do.
        let knots = match halving {
            0 => [best.surface.u.clone(), best.surface.v.clone()],
            _ => match halves::halved(&best, most) {
                Some(knots) => knots,
                None => break,
            },
        };
        let Some(next) = best.again(knots, samples, options.tolerance) else { break };
        if next.beyond < best.beyond {
            best = next;
        } else if halving > 0 {
            break;
        }
    }
    (best.beyond < before).then_some(best.surface)
}
