//! The stiffness of a smoothing spline, by restricted maximum likelihood (REML).

use std::collections::HashMap;

use faer::Mat;

use super::Energies;
use super::grid::{Grid, ON_CELL, cell_energy, values};
use super::overlaps::{Overlaps, order, runs};
use crate::geometry::{ROUNDING, Uv};
use crate::solve::cholesky::Pattern;

/// λ₂ and λ₄ as exponents of √10, for forms that are scaled to the same trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Exponents(pub i32, pub i32);

impl Exponents {
    /// Where the search begins.
    pub(crate) fn first(energies: Energies) -> Self {
        Exponents(0, if energies == Energies::Both { 2 } else { LOWEST })
    }

    /// The same stiffness on a grid with cells of half the width.
    pub(crate) fn on_half_the_width(self, energies: Energies) -> Self {
        Exponents(self.0 + 2, if energies == Energies::Both { self.1 + 5 } else { LOWEST })
    }

    fn weights(self) -> [f64; 2] {
        [self.0, self.1].map(|e| 10f64.powf(0.5 * f64::from(e)))
    }

    fn moved(self, by: (i32, i32)) -> Self {
        Exponents(self.0 + by.0, self.1 + by.1)
    }

    fn is_searched(self) -> bool {
        [self.0, self.1].iter().all(|x| (LOWEST..=HIGHEST).contains(x))
    }
}

/// The normal equations and the energies, all with one sparsity pattern.
pub(crate) struct PenalizedSystem<const D: usize> {
    pattern: Pattern,
    /// The entries of three forms: the squared distances to the points, J₂ and J₄.
    entries: [Vec<f64>; 3],
    diagonal: Vec<usize>,
    right: Mat<f64>,
    squares: f64,
    /// The dimension of the functions without energy.
    free: f64,
    freedom: f64,
    /// The likelihoods that are known.
    known: HashMap<Exponents, f64>,
    /// The logarithms of the determinant of the energy with λ₂ = 1 that are known, by the
    /// difference of the two exponents.
    priors: HashMap<i32, f64>,
}

/// A point in a cell.
struct PointInCell<const D: usize> {
    cell: usize,
    place: [f64; 2],
    value: [f64; D],
}

/// A quadratic form in the functions of a cell.
type CellForm = [[f64; ON_CELL]; ON_CELL];

/// The least exponent of the search: a stiffness of 1e-9 interpolates.
const LOWEST: i32 = -18;
/// The greatest exponent of the search: a stiffness of 1e6 leaves a plane.
const HIGHEST: i32 = 12;

impl<const D: usize> PenalizedSystem<D> {
    pub(super) fn new(grid: &Grid, points: &[(Uv, [f64; D])]) -> Option<Self> {
        // On each part of the grid the functions without energy are the linear ones.
        let free = 3 * grid.parts();
        let placed = points.iter().filter_map(|(uv, value)| Some((grid.cell_of(*uv)?, value)));
        let mut placed: Vec<_> = placed
            .map(|((cell, place), value)| PointInCell { cell, place, value: *value })
            .collect();
        if placed.len() <= 4 * free {
            return None;
        }
        placed.sort_by_key(|p| p.cell);
        let overlaps = Overlaps::new(grid);
        let Overlaps { starts, rows, .. } = &overlaps;
        let mut equations = PenalizedSystem {
            entries: std::array::from_fn(|_| vec![0.0; rows.len()]),
            diagonal: starts[..grid.count].to_vec(),
            pattern: Pattern::new(starts.clone(), rows.clone(), &order(grid))?,
            right: Mat::zeros(grid.count, D),
            squares: placed.iter().flat_map(|p| p.value).map(|y| y * y).sum(),
            free: free as f64,
            freedom: (placed.len() - free) as f64 * D as f64,
            known: HashMap::new(),
            priors: HashMap::new(),
        };
        let mut placed = placed.chunk_by(|x, y| x.cell == y.cell).peekable();
        let (second, fourth) = (cell_energy(2), cell_energy(4));
        for (cell, functions) in grid.on_cells.iter().enumerate() {
            let here = placed.next_if(|p| p[0].cell == cell).unwrap_or_default();
            let points = equations.add_points(functions, here);
            for (q, run) in runs() {
                let slots = overlaps.slots(functions, q, &run);
                for (entries, form) in equations.entries.iter_mut().zip([&points, &second, &fourth])
                {
                    let entries = entries[slots.clone()].iter_mut();
                    entries.zip(&form[q][run.clone()]).for_each(|(entry, x)| *entry += x);
                }
            }
        }
        equations.scale();
        Some(equations)
    }

    /// Adds the points of one cell to the right-hand side, and returns the upper triangle of
    /// their form in the functions of the cell.
    fn add_points(&mut self, functions: &[u32; ON_CELL], points: &[PointInCell<D>]) -> CellForm {
        let mut sum = [[0.0; ON_CELL]; ON_CELL];
        let mut right = [[0.0; D]; ON_CELL];
        for PointInCell { place, value, .. } in points {
            let b = values(*place);
            for (q, (row, x)) in sum.iter_mut().zip(b).enumerate() {
                row[q..].iter_mut().zip(&b[q..]).for_each(|(entry, y)| *entry += x * y);
            }
            for (sum, x) in right.iter_mut().zip(b) {
                sum.iter_mut().zip(value).for_each(|(entry, y)| *entry += x * y);
            }
        }
        for (&f, sum) in functions.iter().zip(right) {
            (0..D).for_each(|d| self.right[(f as usize, d)] += sum[d]);
        }
        sum
    }

    /// Scales all forms to the trace n.
    fn scale(&mut self) {
        let n = self.diagonal.len() as f64;
        let trace = |form: usize| self.diagonal.iter().map(|&d| self.entries[form][d]).sum::<f64>();
        let by: [f64; 3] = std::array::from_fn(|form| n / trace(form));
        self.squares *= by[0];
        self.right *= faer::Scale(by[0]);
        for (entries, by) in self.entries.iter_mut().zip(by) {
            entries.iter_mut().for_each(|x| *x *= by);
        }
    }

    /// The exponents of greatest likelihood, by a pattern search that goes on in a direction as
    /// long as the likelihood grows. `None` if no stiffness has a solution.
    pub(crate) fn most_likely(
        &mut self,
        start: Exponents,
        energies: Energies,
    ) -> Option<Exponents> {
        let mut best = Exponents(start.0.min(HIGHEST), start.1.min(HIGHEST));
        let mut likelihood = self.likelihood(best);
        let mut step = 4;
        let mut directions = vec![(-1, 0), (1, 0)];
        if energies == Energies::Both {
            directions.extend([(0, -1), (0, 1)]);
        }
        // Steps of a decade suffice: the length over which the spline smooths is then known
        // to a third.
        while step > 1 {
            let ahead = |by: (i32, i32)| best.moved((step * by.0, step * by.1));
            let tried = directions.iter().map(|&by| self.likelihood(ahead(by))).enumerate();
            let better = { tried }.find(|(_, found)| *found > likelihood);
            match better {
                Some((at, found)) => {
                    (best, likelihood) = (ahead(directions[at]), found);
                    // Try this direction first next time.
                    directions[..=at].rotate_right(1);
                }
                None => step /= 2,
            }
        }
        (likelihood > f64::NEG_INFINITY).then_some(best)
    }

    pub(crate) fn coefficients(&mut self, stiffness: Exponents) -> Option<Vec<[f64; D]>> {
        let (_, x, _) = self.solve(stiffness)?;
        Some((0..x.nrows()).map(|i| std::array::from_fn(|d| x[(i, d)])).collect())
    }

    /// Twice the restricted log-likelihood, up to a constant. −∞ outside of the range of the
    /// search, and where the equations have no solution.
    fn likelihood(&mut self, place: Exponents) -> f64 {
        if !place.is_searched() {
            return f64::NEG_INFINITY;
        }
        if let Some(value) = self.known.get(&place) {
            return *value;
        }
        let value = self.evaluate(place).unwrap_or(f64::NEG_INFINITY);
        self.known.insert(place, value);
        value
    }

    fn evaluate(&mut self, place: Exponents) -> Option<f64> {
        let (log, _, squares) = self.solve(place)?;
        let prior = self.log_energy(place)?;
        Some(D as f64 * (prior - log) - self.freedom * squares.ln())
    }

    /// The logarithm of the determinant, the solution, and the penalized sum of squares.
    fn solve(&mut self, place: Exponents) -> Option<(f64, Mat<f64>, f64)> {
        let values = self.form(1.0, place.weights(), ROUNDING);
        let mut x = self.right.clone();
        let log = self.pattern.solve(&values, Some(&mut x))?;
        let explained: f64 = (0..D)
            .flat_map(|d| (0..x.nrows()).map(move |i| (i, d)))
            .map(|at| x[at] * self.right[at])
            .sum();
        Some((log, x, (self.squares - explained).max(f64::EPSILON * self.squares)))
    }

    /// `points` times the form of the points, plus λ₂ J₂ + λ₄ J₄, plus `diagonal` times the
    /// sum of these weights on the diagonal.
    fn form(&self, points: f64, [a, b]: [f64; 2], diagonal: f64) -> Vec<f64> {
        let [known, second, fourth] = &self.entries;
        let energies = second.iter().zip(fourth).map(|(x, y)| a * x + b * y);
        let mut sum: Vec<f64> = known.iter().zip(energies).map(|(p, e)| points * p + e).collect();
        self.diagonal.iter().for_each(|&d| sum[d] += diagonal * (points + a + b));
        sum
    }

    /// The logarithm of the determinant of the energy on the functions that have energy. With
    /// ε on the diagonal it is that of all functions minus that of ε on the free ones. It is
    /// computed for λ₂ = 1 and scaled.
    fn log_energy(&mut self, place: Exponents) -> Option<f64> {
        let ratio = place.1 - place.0;
        let log = match self.priors.get(&ratio) {
            Some(log) => *log,
            None => {
                let weights = Exponents(0, ratio).weights();
                let values = self.form(0.0, weights, ROUNDING);
                let free = self.free * (ROUNDING * (weights[0] + weights[1])).ln();
                let log = self.pattern.solve(&values, None)? - free;
                self.priors.insert(ratio, log);
                log
            }
        };
        let [scale, _] = place.weights();
        Some(log + (self.diagonal.len() as f64 - self.free) * scale.ln())
    }
}
