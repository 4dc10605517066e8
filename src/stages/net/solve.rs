//! The control points that fit a scan at given foot points: a linear least-squares problem with
//! sparse normal equations.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::feet::Feet;
use super::{FitTarget, Net};
use crate::error::{Error, Result};
use crate::geometry::{Point, Vector};
use crate::solve::least_squares::SparseNormal;
use crate::spline::subdivision::limit_weights;

/// The weight of fairing, beside the mean weight of the points of a control point. Larger weights
/// flatten the shape, and smaller ones let the net fold where it has few points.
const FAIRING: f64 = 1e-3;

/// The weight of anchors, beside the mean weight of the points of a control point. Larger weights keep
/// the surface from the points, and without anchors quads slide along the surface until they fold.
const ANCHOR: f64 = 0.03;

/// The lower triangle of the part of the normal matrix that belongs to one quad, and the right side.
struct QuadSums {
    matrix: DMatrix<f64>,
    right: Vec<Vector>,
}

/// The normal equations of a net.
pub(super) struct NetEquations(SparseNormal);

impl NetEquations {
    pub(super) fn new(net: &Net) -> Result<Self> {
        let mut columns = vec![Vec::new(); net.mesh.points.len()];
        for quad in 0..net.mesh.quads.len() {
            let control = net.surface.control(quad);
            for &b in control {
                let below = control.iter().filter(|&&a| a >= b).map(|&a| a as usize);
                columns[b as usize].extend(below);
            }
        }
        SparseNormal::new(columns).map(NetEquations).ok_or(Error::Memory("net"))
    }

    /// Solves for the control points. The surface is held near the anchors, and where the `firmness` of a
    /// vertex exceeds one, its control point is, too. A net whose control points are the vertices of a
    /// layout without folds hardly folds, and a surface that goes through them may.
    pub(crate) fn control_points(
        &mut self,
        net: &Net,
        target: &FitTarget,
        feet: &Feet,
        firmness: &[f64],
        anchors: &[Point],
    ) -> Result<Vec<Point>> {
        let equations = &mut self.0;
        equations.clear();
        let members = members(net, feet);
        let sums = members.par_iter().enumerate().map_init(Vec::new, |scratch, (quad, points)| {
            quad_sums(net, target, feet, quad, points, scratch)
        });
        let sums: Vec<QuadSums> = sums.collect();
        for (quad, of_quad) in sums.iter().enumerate() {
            add_quad(equations, net.surface.control(quad), of_quad);
        }
        let total: f64 = members.iter().flatten().map(|&i| target.weights[i as usize]).sum();
        let mean = total.max(1.0) / anchors.len() as f64;
        for (v, anchor) in anchors.iter().enumerate() {
            let (weight, anchor) = (ANCHOR * mean, anchor.coords);
            equations.add_row(&limit_row(net, v), weight, anchor);
            equations.add_row(&[(v, 1.0)], weight * (firmness[v] - 1.0), anchor);
            equations.add_row(&umbrella(net, v), FAIRING * mean, Vector::zeros());
        }
        let solved = equations.solve().ok_or(Error::Singular("net"))?;
        Ok(solved.into_iter().map(Point::from).collect())
    }
}

fn add_quad(equations: &mut SparseNormal, control: &[u32], sums: &QuadSums) {
    for (i, &a) in control.iter().enumerate() {
        let a = a as usize;
        equations.add_right(a, sums.right[i]);
        // A control point occurs twice in a quad near a vertex with three quads.
        for (j, &b) in control.iter().enumerate() {
            equations.add(a, b as usize, sums.matrix[(i.max(j), i.min(j))]);
        }
    }
}

/// The points whose foot points lie on each quad.
fn members(net: &Net, feet: &Feet) -> Vec<Vec<u32>> {
    let mut members = vec![Vec::new(); net.mesh.quads.len()];
    for (i, foot) in feet.feet.iter().enumerate() {
        if let Some(foot) = foot {
            members[foot.place.quad].push(i as u32);
        }
    }
    members
}

fn quad_sums(
    net: &Net,
    target: &FitTarget,
    feet: &Feet,
    quad: usize,
    points: &[u32],
    scratch: &mut Vec<[f64; 3]>,
) -> QuadSums {
    let size = net.surface.control(quad).len();
    let mut matrix = DMatrix::zeros(size, size);
    let mut right = vec![Vector::zeros(); size];
    for &i in points {
        let i = i as usize;
        let Some(foot) = feet.feet[i] else { continue };
        net.surface.basis(foot.place, scratch);
        let w = target.weights[i];
        for (a, x) in scratch.iter().enumerate() {
            right[a] += w * x[0] * target.points[i].coords;
            for (b, y) in scratch[..=a].iter().enumerate() {
                matrix[(a, b)] += w * x[0] * y[0];
            }
        }
    }
    QuadSums { matrix, right }
}

/// The umbrella operator at a vertex: its control point minus the mean of its neighbours.
fn umbrella(net: &Net, v: usize) -> Vec<(usize, f64)> {
    let (quad, k) = net.surface.corner(v.into());
    let ring = net.surface.ring(quad, k);
    let n = (ring.len() / 2) as f64;
    let spokes = ring.iter().skip(1).step_by(2).map(|&w| (w as usize, -1.0 / n));
    std::iter::once((v, 1.0)).chain(spokes).collect()
}

/// The point of the limit surface at a vertex.
fn limit_row(net: &Net, v: usize) -> Vec<(usize, f64)> {
    let (quad, k) = net.surface.corner(v.into());
    let ring = net.surface.ring(quad, k);
    let weights = limit_weights(ring.len());
    ring.iter().map(|&w| w as usize).zip(weights).collect()
}
