//! How stiff a smoothing spline is, by restricted likelihood.

use std::collections::HashMap;

use faer::Mat;

use super::grid::{Grid, ON_CELL, cell_energy, values};
use crate::fill::cholesky::Pattern;
use crate::geometry::Uv;

/// Of λ₂ and λ₄, where all forms have the same trace: powers of √10.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Exponents(pub i32, pub i32);

impl Exponents {
    fn weights(self) -> [f64; 2] {
        [self.0, self.1].map(|e| 10f64.powf(0.5 * f64::from(e)))
    }
}

/// The normal equations and the energies, entry by entry of one pattern.
pub struct Equations<const D: usize> {
    pattern: Pattern,
    points: Vec<f64>,
    second: Vec<f64>,
    fourth: Vec<f64>,
    diagonal: Vec<usize>,
    right: Mat<f64>,
    squares: f64,
    /// Dimension of the functions without energy.
    free: f64,
    freedom: f64,
}

/// Dimension of the functions without energy on a part: linear ones.
const FREE: usize = 3;

/// The exponents that are searched, from here …
const LOWEST: i32 = -18;
/// … to here.
const HIGHEST: i32 = 12;

impl<const D: usize> Equations<D> {
    pub fn new(grid: &Grid, points: &[(Uv, [f64; D])]) -> Option<Self> {
        let n = grid.count;
        let free = FREE * grid.parts();
        let placed = points.iter().filter_map(|(uv, value)| Some((grid.cell_of(*uv)?, value)));
        let placed: Vec<_> = placed.collect();
        if placed.len() <= 4 * free {
            return None;
        }
        let columns = columns(grid);
        let starts: Vec<usize> = columns
            .iter()
            .scan(0, |end, c| {
                let start = *end;
                *end += c.len();
                Some(start)
            })
            .collect();
        let entries = columns.iter().map(Vec::len).sum();
        let slot = |i: usize, j: usize| {
            starts[j]
                + columns[j].binary_search(&i).expect("functions on one cell are in the pattern")
        };
        let mut equations = Equations {
            pattern: Pattern::new(&columns)?,
            points: vec![0.0; entries],
            second: vec![0.0; entries],
            fourth: vec![0.0; entries],
            diagonal: starts.clone(),
            right: Mat::zeros(n, D),
            squares: 0.0,
            free: free as f64,
            freedom: (placed.len() - free) as f64 * D as f64,
        };
        let mut sums = vec![[[0.0; ON_CELL]; ON_CELL]; grid.on_cells.len()];
        for ((cell, place), value) in placed {
            let (functions, b) = (&grid.on_cells[cell], values(place));
            for (row, x) in sums[cell].iter_mut().zip(b) {
                for (entry, y) in row.iter_mut().zip(b) {
                    *entry += x * y;
                }
            }
            for (f, x) in functions.iter().zip(b) {
                for (d, y) in value.iter().enumerate() {
                    equations.right[(*f as usize, d)] += x * y;
                }
            }
            equations.squares += value.iter().map(|y| y * y).sum::<f64>();
        }
        let (second, fourth) = (cell_energy(2), cell_energy(4));
        for (functions, sum) in grid.on_cells.iter().zip(&sums) {
            for (p, &i) in functions.iter().enumerate() {
                for (q, &j) in functions.iter().enumerate().filter(|(_, j)| **j <= i) {
                    let at = slot(i as usize, j as usize);
                    equations.points[at] += sum[p][q];
                    equations.second[at] += second[p][q];
                    equations.fourth[at] += fourth[p][q];
                }
            }
        }
        equations.scale();
        Some(equations)
    }

    /// Gives all three forms the trace n.
    fn scale(&mut self) {
        let n = self.diagonal.len() as f64;
        let diagonal = &self.diagonal;
        let trace = |form: &[f64]| diagonal.iter().map(|&d| form[d]).sum::<f64>();
        let by = n / trace(&self.points);
        self.squares *= by;
        self.right *= faer::Scale(by);
        for form in [&mut self.points, &mut self.second, &mut self.fourth] {
            let by = n / trace(form);
            form.iter_mut().for_each(|x| *x *= by);
        }
    }

    /// A pattern search for the exponents of λ₂ and λ₄. `None` where there is
    /// no solution for any.
    pub fn most_likely(&mut self, start: Exponents) -> Option<Exponents> {
        let mut known = HashMap::new();
        let mut best = Exponents(start.0.min(HIGHEST), start.1.min(HIGHEST));
        let mut likelihood = self.likelihood(best, &mut known);
        let mut step = 4;
        // To a decade: the length over which the spline smooths is known to a
        // third by then.
        while step > 1 {
            let around = [(step, 0), (-step, 0), (0, step), (0, -step)];
            let next = around.map(|(x, y)| Exponents(best.0 + x, best.1 + y));
            let within = |e: &Exponents| [e.0, e.1].iter().all(|x| (LOWEST..=HIGHEST).contains(x));
            let tried = next.into_iter().filter(within);
            let tried: Vec<_> = tried.map(|e| (self.likelihood(e, &mut known), e)).collect();
            match tried.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((value, place)) if value > likelihood => (likelihood, best) = (value, place),
                _ => step /= 2,
            }
        }
        (likelihood > f64::NEG_INFINITY).then_some(best)
    }

    pub fn coefficients(&mut self, stiffness: Exponents) -> Option<Vec<[f64; D]>> {
        let (_, x, _) = self.solve(stiffness)?;
        Some((0..x.nrows()).map(|i| std::array::from_fn(|d| x[(i, d)])).collect())
    }

    /// Twice the restricted log-likelihood, but for a constant; −∞ where it
    /// cannot be had.
    fn likelihood(&mut self, place: Exponents, known: &mut HashMap<Exponents, f64>) -> f64 {
        if let Some(value) = known.get(&place) {
            return *value;
        }
        let value = self.evaluate(place).unwrap_or(f64::NEG_INFINITY);
        known.insert(place, value);
        value
    }

    fn evaluate(&mut self, place: Exponents) -> Option<f64> {
        let (log, _, squares) = self.solve(place)?;
        let prior = self.log_energy(place)?;
        Some(D as f64 * (prior - log) - self.freedom * squares.ln())
    }

    /// The logarithm of the determinant, the solution, and the penalised sum
    /// of squares.
    fn solve(&mut self, place: Exponents) -> Option<(f64, Mat<f64>, f64)> {
        let mut values = self.energy(place, 1e-13);
        values.iter_mut().zip(&self.points).for_each(|(v, p)| *v += p);
        let mut x = self.right.clone();
        let log = self.pattern.solve(&values, Some(&mut x))?;
        let explained: f64 = (0..D)
            .flat_map(|d| (0..x.nrows()).map(move |i| (i, d)))
            .map(|at| x[at] * self.right[at])
            .sum();
        Some((log, x, (self.squares - explained).max(1e-15 * self.squares)))
    }

    /// λ₂ J₂ + λ₄ J₄, and a little on the diagonal.
    fn energy(&self, place: Exponents, diagonal: f64) -> Vec<f64> {
        let [a, b] = place.weights();
        let mut sum: Vec<f64> =
            self.second.iter().zip(&self.fourth).map(|(x, y)| a * x + b * y).collect();
        self.diagonal.iter().for_each(|&d| sum[d] += diagonal * (1.0 + a + b));
        sum
    }

    /// The logarithm of the determinant of the energy on what is not free: with
    /// ε on the diagonal it is that of the whole, less that of ε's on the free
    /// functions.
    fn log_energy(&mut self, place: Exponents) -> Option<f64> {
        const EPSILON: f64 = 1e-11;
        let values = self.energy(place, EPSILON);
        let [a, b] = place.weights();
        let free = self.free * (EPSILON * (1.0 + a + b)).ln();
        Some(self.pattern.solve(&values, None)? - free)
    }
}

/// For each function those, from itself on, with which it shares a cell.
fn columns(grid: &Grid) -> Vec<Vec<usize>> {
    let mut columns = vec![Vec::new(); grid.count];
    for functions in &grid.on_cells {
        for &j in functions {
            let rows = functions.iter().filter(|i| **i >= j).map(|i| *i as usize);
            columns[j as usize].extend(rows);
        }
    }
    for column in &mut columns {
        column.sort_unstable();
        column.dedup();
    }
    columns
}
