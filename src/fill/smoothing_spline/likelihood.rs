//! How stiff a smoothing spline is, by restricted likelihood.

use std::collections::HashMap;

use faer::Mat;

use super::Held;
use super::grid::{Grid, ON_CELL, cell_energy, values};
use super::overlaps::{Overlaps, order, runs};
use crate::cholesky::Pattern;
use crate::geometry::Uv;

/// Of λ₂ and λ₄, where all forms have the same trace: powers of √10.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Exponents(pub i32, pub i32);

impl Exponents {
    /// Where to begin to search.
    pub fn first(held: Held) -> Self {
        Exponents(0, if held == Held::Both { 2 } else { LOWEST })
    }

    /// The same stiffness on a grid of half the width.
    pub fn on_half_the_width(self, held: Held) -> Self {
        Exponents(self.0 + 2, if held == Held::Both { self.1 + 5 } else { LOWEST })
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

/// The normal equations and the energies, entry by entry of one pattern.
pub struct Equations<const D: usize> {
    pattern: Pattern,
    /// Of the points, J₂ and J₄.
    entries: [Vec<f64>; FORMS],
    diagonal: Vec<usize>,
    right: Mat<f64>,
    squares: f64,
    /// Dimension of the functions without energy.
    free: f64,
    freedom: f64,
    /// Likelihoods that have been found …
    known: HashMap<Exponents, f64>,
    /// … and, by the difference of the exponents, the logarithms of the
    /// determinants of the energies with λ₂ = 1.
    priors: HashMap<i32, f64>,
}

/// A point in a cell.
struct Placed<const D: usize> {
    cell: usize,
    place: [f64; 2],
    value: [f64; D],
}

/// A form in a cell's functions.
type CellForm = [[f64; ON_CELL]; ON_CELL];

const FORMS: usize = 3;

/// Dimension of the functions without energy on a part: linear ones.
const FREE: usize = 3;

/// The exponents that are searched, from here …
const LOWEST: i32 = -18;
/// … to here.
const HIGHEST: i32 = 12;

impl<const D: usize> Equations<D> {
    pub fn new(grid: &Grid, points: &[(Uv, [f64; D])]) -> Option<Self> {
        let free = FREE * grid.parts();
        let placed = points.iter().filter_map(|(uv, value)| Some((grid.cell_of(*uv)?, value)));
        let mut placed: Vec<_> =
            placed.map(|((cell, place), value)| Placed { cell, place, value: *value }).collect();
        if placed.len() <= 4 * free {
            return None;
        }
        placed.sort_by_key(|p| p.cell);
        let overlaps = Overlaps::new(grid);
        let Overlaps { starts, rows, .. } = &overlaps;
        let mut equations = Equations {
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

    /// The points of one cell: their part of the right-hand side, and the upper
    /// triangle of their form in the cell's functions.
    fn add_points(&mut self, functions: &[u32; ON_CELL], points: &[Placed<D>]) -> CellForm {
        let mut sum = [[0.0; ON_CELL]; ON_CELL];
        let mut right = [[0.0; D]; ON_CELL];
        for Placed { place, value, .. } in points {
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

    /// Gives all forms the trace n.
    fn scale(&mut self) {
        let n = self.diagonal.len() as f64;
        let trace = |form: usize| self.diagonal.iter().map(|&d| self.entries[form][d]).sum::<f64>();
        let by: [f64; FORMS] = std::array::from_fn(|form| n / trace(form));
        self.squares *= by[0];
        self.right *= faer::Scale(by[0]);
        for (entries, by) in self.entries.iter_mut().zip(by) {
            entries.iter_mut().for_each(|x| *x *= by);
        }
    }

    /// A pattern search for the exponents of λ₂ and λ₄, which goes on in a
    /// direction as long as that is better. `None` where there is no solution
    /// for any.
    pub fn most_likely(&mut self, start: Exponents, held: Held) -> Option<Exponents> {
        let mut best = Exponents(start.0.min(HIGHEST), start.1.min(HIGHEST));
        let mut likelihood = self.likelihood(best);
        let mut step = 4;
        let mut directions = vec![(-1, 0), (1, 0)];
        if held == Held::Both {
            directions.extend([(0, -1), (0, 1)]);
        }
        // To a decade: the length over which the spline smooths is known to a
        // third by then.
        while step > 1 {
            let ahead = |by: (i32, i32)| best.moved((step * by.0, step * by.1));
            let tried = directions.iter().map(|&by| self.likelihood(ahead(by))).enumerate();
            let better = { tried }.find(|(_, found)| *found > likelihood);
            match better {
                Some((at, found)) => {
                    (best, likelihood) = (ahead(directions[at]), found);
                    // What was good may be so once more.
                    directions[..=at].rotate_right(1);
                }
                None => step /= 2,
            }
        }
        (likelihood > f64::NEG_INFINITY).then_some(best)
    }

    pub fn coefficients(&mut self, stiffness: Exponents) -> Option<Vec<[f64; D]>> {
        let (_, x, _) = self.solve(stiffness)?;
        Some((0..x.nrows()).map(|i| std::array::from_fn(|d| x[(i, d)])).collect())
    }

    /// Twice the restricted log-likelihood, but for a constant; −∞ where it
    /// cannot be had or is not asked for.
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

    /// The logarithm of the determinant, the solution, and the penalised sum
    /// of squares.
    fn solve(&mut self, place: Exponents) -> Option<(f64, Mat<f64>, f64)> {
        let values = self.form(1.0, place.weights(), 1e-13);
        let mut x = self.right.clone();
        let log = self.pattern.solve(&values, Some(&mut x))?;
        let explained: f64 = (0..D)
            .flat_map(|d| (0..x.nrows()).map(move |i| (i, d)))
            .map(|at| x[at] * self.right[at])
            .sum();
        Some((log, x, (self.squares - explained).max(1e-15 * self.squares)))
    }

    /// The form of the points and λ₂ J₂ + λ₄ J₄, with a share of these on the
    /// diagonal.
    fn form(&self, points: f64, [a, b]: [f64; 2], diagonal: f64) -> Vec<f64> {
        let [known, second, fourth] = &self.entries;
        let energies = second.iter().zip(fourth).map(|(x, y)| a * x + b * y);
        let mut sum: Vec<f64> = known.iter().zip(energies).map(|(p, e)| points * p + e).collect();
        self.diagonal.iter().for_each(|&d| sum[d] += diagonal * (points + a + b));
        sum
    }

    /// The logarithm of the determinant of the energy on what is not free: with
    /// ε on the diagonal it is that of the whole, less that of ε's on the free
    /// functions. It is had from λ₂ = 1.
    fn log_energy(&mut self, place: Exponents) -> Option<f64> {
        const EPSILON: f64 = 1e-11;
        let ratio = place.1 - place.0;
        let log = match self.priors.get(&ratio) {
            Some(log) => *log,
            None => {
                let weights = Exponents(0, ratio).weights();
                let values = self.form(0.0, weights, EPSILON);
                let free = self.free * (EPSILON * (weights[0] + weights[1])).ln();
                let log = self.pattern.solve(&values, None)? - free;
                self.priors.insert(ratio, log);
                log
            }
        };
        let [scale, _] = place.weights();
        Some(log + (self.diagonal.len() as f64 - self.free) * scale.ln())
    }
}
