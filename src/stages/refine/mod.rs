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
use crate::geometry::{Point, Uv};
use crate::spline::{Network, Samples, Surface};
use fit::{FaceFit, FaceTarget};
use halves::ControlRoom;

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
    /// The number of measured points.
    pub measured: usize,
    /// The number of those that exceeded the tolerance before.
    pub beyond_before: usize,
    /// The number of those that exceed the tolerance.
    pub beyond: usize,
}

/// The weight of a measured point. The tolerance holds for these only.
const MEASURED: f64 = 1.0;

/// The most times that the knot spans of a face are halved. A span is then an eighth as long as one of the
/// whole network. Faces seldom have enough points for more.
const HALVINGS: usize = 3;

/// The factor by which a face becomes firmer. It is that of a net.
const FIRMER: f64 = 8.0;

/// A refined network, whose faces can be fitted again.
#[derive(Debug)]
pub struct Refinement<'a> {
    /// The refined network.
    pub network: Network,
    before: &'a Network,
    options: &'a Options,
    /// The points of each face, and at their end those that were added.
    samples: Vec<Samples>,
    /// The number of points of each face that were not added.
    given: Vec<usize>,
    /// How firmly each face is held to the face before.
    firmness: Vec<f64>,
    /// Whether each face has another shape than before.
    is_refined: Vec<bool>,
    /// The number of given points of each face that exceed the tolerance, before and now.
    beyond: Vec<[usize; 2]>,
}

/// Fits the faces again that miss the tolerance. `samples` has the points of each face. Those with a weight of
/// at least one were measured.
///
/// # Errors
/// [`Error::Input`] if there are not as many lists of points as faces.
pub fn refine<'a>(
    network: &'a Network,
    samples: Vec<Samples>,
    options: &'a Options,
) -> Result<Refinement<'a>> {
    let count = network.surfaces.len();
    if samples.len() != count {
        return Err(Error::Input("a network has not one list of points for each face"));
    }
    let mut refinement = Refinement {
        network: network.clone(),
        before: network,
        options,
        given: samples.iter().map(Samples::len).collect(),
        samples,
        firmness: vec![1.0; count],
        is_refined: vec![false; count],
        beyond: vec![[0; 2]; count],
    };
    refinement.fit(&(0..count).collect::<Vec<_>>());
    Ok(refinement)
}

impl Refinement<'_> {
    /// What was done.
    pub fn report(&self) -> Report {
        let faces = (0..self.is_refined.len()).filter(|&face| self.is_refined[face]);
        let [beyond_before, beyond] = [0, 1].map(|k| self.beyond.iter().map(|of| of[k]).sum());
        let given = self.samples.iter().zip(&self.given);
        let weights = given.flat_map(|(samples, &given)| &samples.weights[..given]);
        let measured = weights.filter(|&&weight| weight >= MEASURED).count();
        Report { faces: faces.collect(), measured, beyond_before, beyond }
    }

    /// Fits faces again, and holds them more firmly.
    pub(crate) fn hold(&mut self, faces: &[usize]) {
        faces.iter().for_each(|&face| self.firmness[face] *= FIRMER);
        self.fit(faces);
    }

    /// Fits faces again that shall be near more points: each has its face and the place there.
    pub(crate) fn follow(&mut self, points: &[(usize, Uv, Point)]) {
        let mut faces = Vec::new();
        for &(face, at, point) in points {
            let samples = &mut self.samples[face];
            samples.points.push(point);
            samples.uv.push(at);
            samples.weights.push(MEASURED);
            faces.push(face);
        }
        faces.sort_unstable();
        faces.dedup();
        self.fit(&faces);
    }

    /// Gives faces back the shape that they had.
    pub fn put_back(&mut self, faces: &[usize]) {
        for &face in faces {
            self.is_refined[face] = false;
            self.beyond[face][1] = self.beyond[face][0];
            self.network.surfaces[face].clone_from(&self.before.surfaces[face]);
        }
    }

    fn fit(&mut self, faces: &[usize]) {
        let all: Vec<FittedFace> = faces.par_iter().map(|&face| self.fitted(face)).collect();
        for (&face, fitted) in faces.iter().zip(all) {
            self.beyond[face] = fitted.beyond;
            self.is_refined[face] = fitted.is_refined;
            self.network.surfaces[face] = fitted.surface;
        }
    }

    /// The face with as few more knots as it needs. At first it may have an inner control point for each measured
    /// point, and if this does not suffice, one more for each.
    fn fitted(&self, face: usize) -> FittedFace {
        let samples = &self.samples[face];
        let measured = samples.weights.iter().filter(|&&weight| weight >= MEASURED).count();
        let may_miss = (self.options.outliers * measured as f64) as usize;
        let (firmness, tolerance) = (self.firmness[face], self.options.tolerance);
        let target = FaceTarget { samples, firmness, tolerance };
        let before = FaceFit::of(self.before.surfaces[face].clone(), &target);
        let (misses, given) = (before.beyond.len(), self.given[face]);
        let given_misses = before.beyond_of(given);
        let rooms = [measured, before.inner() + measured];
        let rooms = rooms.map(|inner| ControlRoom { inner, all: self.options.max_control });
        let knots = [before.surface.u.clone(), before.surface.v.clone()];
        // At first the same knots have to do.
        let mut knots = if misses <= may_miss { None } else { Some(knots) };
        let mut best = before;
        for halving in 0..=HALVINGS {
            let Some(next) = knots.and_then(|knots| best.again(knots, &target)) else { break };
            if next.beyond.len() < best.beyond.len() {
                best = next;
            } else if halving > 0 {
                break;
            }
            let is_near = best.beyond.len() <= may_miss;
            knots = if is_near { None } else { rooms.iter().find_map(|room| room.halved(&best)) };
        }
        FittedFace {
            is_refined: best.beyond.len() < misses,
            beyond: [given_misses, best.beyond_of(given)],
            surface: best.surface,
        }
    }
}

/// A face after its fit.
struct FittedFace {
    surface: Surface,
    /// Whether it has another shape than before. It has not if it kept the tolerance or no fit is nearer to it.
    is_refined: bool,
    /// The number of given points that exceed the tolerance, before and now.
    beyond: [usize; 2],
}
