//! The terms of the equations of one round, cell by cell: tangent distances of samples, thin-plate
//! energy, and Jacobian determinants that are too small.

use nalgebra::Matrix3;

use super::jacobian::{ACROSS, JacobianSample, MIN_SPREAD};
use super::system::{CellEquations, StripEquations};
use super::work::Work;
use crate::geometry::Vector;

/// The weight of a Jacobian determinant that is too small, relative to the samples of a mean cell.
const SPREAD: f64 = 3.0;

/// The data that the equations of a round are assembled from.
pub(crate) struct Terms<'a> {
    pub work: &'a Work<'a>,
    /// The weight of the thin-plate energy.
    pub stiffness: f64,
    /// The Jacobian samples whose determinant is too small, strip by strip.
    pub flagged: &'a [JacobianSample],
    /// Which cells move, row by row.
    pub moves: &'a [bool],
    /// The samples in these cells, strip by strip and cell by cell: the cell and the sample.
    pub near: &'a [Vec<(usize, usize)>],
}

impl Terms<'_> {
    /// Adds the terms of a strip.
    pub(crate) fn add(&self, mut strip: StripEquations) {
        let (p, down) = (strip.number, self.work.cells.counts()[1]);
        let moves = &self.moves[p * down..(p + 1) * down];
        let mut near = self.near[p].chunk_by(|a, b| a.0 == b.0).peekable();
        for q in (0..down).filter(|&q| moves[q]) {
            let mut form = QuadraticForm::default();
            for &(_, i) in near.next_if(|of| of[0].0 == q).unwrap_or_default() {
                self.add_sample(&mut form, [p, q], i);
            }
            self.add_plate(&mut form, [p, q]);
            form.put(&mut strip.cell(q));
        }
        let first = self.flagged.partition_point(|jacobian| jacobian.cell[0] < p);
        let flagged = self.flagged[first..].iter().take_while(|jacobian| jacobian.cell[0] == p);
        flagged.for_each(|jacobian| self.add_jacobian(&mut strip.cell(jacobian.cell[1]), jacobian));
    }

    fn add_sample(&self, form: &mut QuadraticForm, [p, q]: [usize; 2], i: usize) {
        let work = self.work;
        let (at, hold) = (work.uv[i], &work.holds[i]);
        let [u, v] = [work.surface.u.basis_in(p + 3, at.x), work.surface.v.basis_in(q + 3, at.y)]
            .map(|basis| basis.derivative[0]);
        let values: [f64; 16] = std::array::from_fn(|k| u[k / 4] * v[k % 4]);
        let eased = work.eased[p * work.cells.counts()[1] + q];
        let metric = work.cells.samples.weights[i] * hold.of(work.stuck[i] && !eased);
        let on: Vector = self.control([p, q]).iter().zip(values).map(|(c, x)| c * x).sum();
        let off = metric * (work.cells.samples.points[i].coords - on);
        form.forces.iter_mut().zip(values).for_each(|(force, x)| *force += off * x);
        let products = COUPLES.map(|(k, l)| values[k] * values[l]);
        for (sums, (x, y)) in form.sums.iter_mut().zip(ENTRIES) {
            let by = metric[(x, y)];
            sums.iter_mut().zip(&products).for_each(|(sum, product)| *sum += by * product);
        }
    }

    /// Adds the thin-plate energy of a cell.
    fn add_plate(&self, form: &mut QuadraticForm, [p, q]: [usize; 2]) {
        let work = self.work;
        let (x, y) = (work.halves[0][p], work.halves[1][q]);
        let weight = self.stiffness * work.weight * x.min(y).powi(4);
        let scales = [x.powi(-4), 2.0 / (x * y).powi(2), y.powi(-4)];
        let (u, v) = (&work.energies[0][p], &work.energies[1][q]);
        let net = self.control([p, q]);
        for (n, (k, l)) in COUPLES.into_iter().enumerate() {
            let of = |n: usize| scales[n] * u[2 - n][k / 4][l / 4] * v[n][k % 4][l % 4];
            let value = weight * (of(0) + of(1) + of(2));
            form.sums[..3].iter_mut().for_each(|sums| sums[n] += value);
            form.forces[k] -= net[l] * value;
            if k < l {
                form.forces[l] -= net[k] * value;
            }
        }
    }

    /// Adds the square by which the Jacobian determinant of a sample falls short of
    /// [`MIN_SPREAD`].
    fn add_jacobian(&self, cell: &mut CellEquations, jacobian: &JacobianSample) {
        let weight = SPREAD * self.work.weight * self.work.area / (ACROSS * ACROSS) as f64;
        let [u, v] = &jacobian.functions;
        let across = jacobian.slopes[1].cross(&jacobian.facing);
        let along = jacobian.facing.cross(&jacobian.slopes[0]);
        let gradient: [Vector; 16] = std::array::from_fn(|k| {
            across * (u[1][k / 4] * v[0][k % 4]) + along * (u[0][k / 4] * v[1][k % 4])
        });
        let missing = MIN_SPREAD - jacobian.spread;
        for (k, x) in gradient.iter().enumerate() {
            cell.pull(k, weight * missing * x);
            let rest = gradient.iter().enumerate().skip(k);
            rest.for_each(|(l, y)| cell.couple(k, l, &(weight * x * y.transpose())));
        }
    }

    /// The control points of a cell row by row.
    fn control(&self, [p, q]: [usize; 2]) -> [Vector; 16] {
        let surface = &self.work.surface;
        std::array::from_fn(|k| surface.net[(p + k / 4) * surface.v.functions() + q + k % 4])
    }
}

/// The pairs of a cell's control points, including the pair of each point with itself.
const COUPLES: [(usize, usize); 136] = couples();

const fn couples() -> [(usize, usize); 136] {
    let mut couples = [(0, 0); 136];
    let mut n = 1;
    while n < couples.len() {
        let (k, l) = couples[n - 1];
        couples[n] = if l == 15 { (k + 1, k + 1) } else { (k, l + 1) };
        n += 1;
    }
    couples
}

/// The entries of a symmetric matrix. Those on the diagonal come first.
const ENTRIES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// A quadratic form in a cell's control points and the forces on them.
struct QuadraticForm {
    /// For each of the [`ENTRIES`], the sums of all [`COUPLES`].
    sums: [[f64; COUPLES.len()]; ENTRIES.len()],
    forces: [Vector; 16],
}

impl Default for QuadraticForm {
    fn default() -> Self {
        QuadraticForm { sums: [[0.0; COUPLES.len()]; ENTRIES.len()], forces: [Vector::zeros(); 16] }
    }
}

impl QuadraticForm {
    fn put(&self, cell: &mut CellEquations) {
        self.forces.iter().enumerate().for_each(|(k, force)| cell.pull(k, *force));
        for (n, (k, l)) in COUPLES.into_iter().enumerate() {
            let [xx, yy, zz, xy, xz, yz] = self.sums.each_ref().map(|sums| sums[n]);
            cell.couple(k, l, &Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz));
        }
    }
}
