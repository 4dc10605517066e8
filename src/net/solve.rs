//! The control points that fit a scan at given foot points: a linear least-squares problem with
//! sparse normal equations.

use faer::Mat;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::feet::Feet;
use super::{FitTarget, Net};
use crate::cholesky::{Pattern, least_degree};
use crate::error::{Error, Result};
use crate::geometry::{Point, Vector};
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

/// The normal equations of a net. Their pattern is analysed once.
pub(super) struct NetEquations {
    /// Column b has the rows `starts[b]..starts[b + 1]` of `rows`, of the lower triangle.
    starts: Vec<usize>,
    rows: Vec<usize>,
    pattern: Pattern,
    values: Vec<f64>,
    right: Mat<f64>,
}

impl NetEquations {
    pub fn new(net: &Net) -> Result<Self> {
        let count = net.mesh.points.len();
        let mut columns = vec![Vec::new(); count];
        for quad in 0..net.mesh.quads.len() {
            let control = net.surface.control(quad);
            for &b in control {
                let below = control.iter().filter(|&&a| a >= b).map(|&a| a as usize);
                columns[b as usize].extend(below);
            }
        }
        columns.par_iter_mut().for_each(|rows| {
            rows.sort_unstable();
            rows.dedup();
        });
        let mut starts = vec![0];
        starts.extend(columns.iter().scan(0, |end, rows| {
            *end += rows.len();
            Some(*end)
        }));
        let rows = columns.concat();
        let order = least_degree(&starts, &rows).ok_or(Error::Memory("net"))?;
        let pattern = Pattern::new(starts.clone(), rows.clone(), &order);
        let pattern = pattern.ok_or(Error::Memory("net"))?;
        let values = vec![0.0; rows.len()];
        Ok(NetEquations { starts, rows, pattern, values, right: Mat::zeros(count, 3) })
    }

    /// Solves for the control points. The surface is held near the anchors, and where the `firmness` of a
    /// vertex exceeds one, its control point is, too. A net whose control points are the vertices of a
    /// layout without folds hardly folds, and a surface that goes through them may.
    pub fn control_points(
        &mut self,
        net: &Net,
        target: &FitTarget,
        feet: &Feet,
        firmness: &[f64],
        anchors: &[Point],
    ) -> Result<Vec<Point>> {
        let count = net.mesh.points.len();
        self.values.fill(0.0);
        self.right = Mat::zeros(count, 3);
        let members = members(net, feet);
        let sums = members.par_iter().enumerate().map_init(Vec::new, |scratch, (quad, points)| {
            quad_sums(net, target, feet, quad, points, scratch)
        });
        let sums: Vec<QuadSums> = sums.collect();
        for (quad, of_quad) in sums.iter().enumerate() {
            self.add_quad(net.surface.control(quad), of_quad);
        }
        let total: f64 = members.iter().flatten().map(|&i| target.weights[i as usize]).sum();
        let mean = total.max(1.0) / count as f64;
        for (v, anchor) in anchors.iter().enumerate() {
            let weight = ANCHOR * mean;
            self.add_row(&limit_row(net, v), weight, anchor);
            self.add_row(&[(v, 1.0)], weight * (firmness[v] - 1.0), anchor);
            self.add_row(&umbrella(net, v), FAIRING * mean, &Point::origin());
        }
        let solved = self.pattern.solve(&self.values, Some(&mut self.right));
        solved.ok_or(Error::Singular("net"))?;
        let right = &self.right;
        let point = |v: usize| Point::new(right[(v, 0)], right[(v, 1)], right[(v, 2)]);
        Ok((0..count).map(point).collect())
    }

    fn add_quad(&mut self, control: &[u32], sums: &QuadSums) {
        for (i, &a) in control.iter().enumerate() {
            let a = a as usize;
            (0..3).for_each(|k| self.right[(a, k)] += sums.right[i][k]);
            // A control point occurs twice in a quad near a vertex with three quads.
            for (j, &b) in control.iter().enumerate() {
                self.add(a, b as usize, sums.matrix[(i.max(j), i.min(j))]);
            }
        }
    }

    /// Adds that the combination of control points is the target.
    fn add_row(&mut self, row: &[(usize, f64)], weight: f64, target: &Point) {
        for &(a, x) in row {
            (0..3).for_each(|k| self.right[(a, k)] += weight * x * target[k]);
            row.iter().for_each(|&(b, y)| self.add(a, b, weight * x * y));
        }
    }

    /// Adds to an entry if it is in the lower triangle.
    fn add(&mut self, a: usize, b: usize, value: f64) {
        if a >= b && value != 0.0 {
            let column = self.starts[b]..self.starts[b + 1];
            if let Ok(k) = self.rows[column].binary_search(&a) {
                self.values[self.starts[b] + k] += value;
            }
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
