//! The surface that the points around a hole make likely: a smoothing spline
//! over a chart.
//!
//! It minimises Σ |f(uᵢ) − pᵢ|² + λ₂ J₂(f) + λ₄ J₄(f), where Jₘ is the integral
//! over the chart of the squared m-th derivatives: the thin-plate energies of
//! second order, which holds wide holes flat, and of fourth, by which the
//! curvature goes on across them. How stiff
//! it is, is not set but found: λ₂ and λ₄ are those of greatest restricted
//! likelihood (REML; Wahba 1985, "A comparison of GCV and GML for choosing the
//! smoothing parameter", and Patterson & Thompson 1971), which takes f for a
//! random function and the deviations for independent. On clean points it
//! interpolates, on noisy ones it averages over as many as the shape allows.
//!
//! f is a quartic tensor-product B-spline on a uniform grid, only as wide as
//! the points and the hole.

use std::collections::{BTreeMap, HashMap, HashSet};

use faer::Mat;

use super::cholesky::Pattern;
use crate::geometry::{Uv, UvVector};

const DEGREE: usize = 4;
/// B-splines that do not vanish on an interval; squared, on a cell.
const ON_INTERVAL: usize = DEGREE + 1;
const ON_CELL: usize = ON_INTERVAL * ON_INTERVAL;

/// The widest grid, in cells.
const MOST_CELLS: f64 = 4e6;

/// A grid of more functions than this is not made finer.
const MOST_FUNCTIONS: usize = 4000;

/// A grid of more functions than this is judged by a sample …
const SAMPLE: usize = 700;

/// … of square blocks, so many cells wide.
const BLOCK: usize = 12;

/// An energy of at least this exponent smooths over what a grid's cells cannot
/// show.
const FREE_OF_GRID: i32 = -8;

/// A smoothing spline with `D` components.
pub struct SmoothingSpline<const D: usize> {
    grid: Grid,
    /// Coefficients of the grid's functions.
    coefficients: Vec<[f64; D]>,
}

impl<const D: usize> SmoothingSpline<D> {
    /// Fits `points` on a grid of about `cell` wide cells, which reaches
    /// over them and where `also` says. The grid shall not be what smooths: it
    /// is made finer, down to `narrowest` cells, until the energies do. `None`
    /// where the points are too few.
    pub fn fit(
        points: &[(Uv, [f64; D])],
        also: impl Fn(Uv) -> bool,
        mut cell: f64,
        narrowest: f64,
    ) -> Option<Self> {
        let mut start = Exponents(0, 2);
        loop {
            let grid = Grid::new(points, &also, cell)?;
            let mut equations = Equations::new(&grid, points)?;
            let stiffness = match grid.sample() {
                Some(part) => Equations::new(&part, points)?.most_likely(start)?,
                None => equations.most_likely(start)?,
            };
            let finer = (0.5 * cell).max(narrowest);
            let is_free = stiffness.0.max(stiffness.1) >= FREE_OF_GRID;
            if is_free || finer > 0.99 * cell || 4 * grid.count > MOST_FUNCTIONS {
                let coefficients = equations.coefficients(stiffness)?;
                return Some(SmoothingSpline { grid, coefficients });
            }
            // The same stiffness, on a grid of half the width.
            start = Exponents(stiffness.0 + 2, stiffness.1 + 5);
            cell = finer;
        }
    }

    /// The value at `uv`; `None` outside of the grid.
    pub fn at(&self, uv: Uv) -> Option<[f64; D]> {
        let (functions, values) = self.grid.functions(uv)?;
        let mut sum = [0.0; D];
        for (f, value) in functions.iter().zip(values) {
            for (s, c) in sum.iter_mut().zip(self.coefficients[*f as usize]) {
                *s += value * c;
            }
        }
        Some(sum)
    }
}

/// The cells that the spline lives on, and its functions by cell.
struct Grid {
    low: Uv,
    cell: f64,
    /// Of each cell of the bounding rectangle, by columns of `height` cells,
    /// where in `functions` its own begin.
    cells: Vec<Option<u32>>,
    height: usize,
    /// The functions on each live cell.
    on_cells: Vec<[u32; ON_CELL]>,
    /// How many functions there are.
    count: usize,
}

impl Grid {
    /// The cells in which a point lies, or whose centre is one of `also`, and
    /// their neighbours.
    fn new<const D: usize>(
        points: &[(Uv, [f64; D])],
        also: impl Fn(Uv) -> bool,
        cell: f64,
    ) -> Option<Self> {
        let (mut low, mut high) = (Uv::new(f64::MAX, f64::MAX), Uv::new(f64::MIN, f64::MIN));
        for (p, _) in points {
            (low, high) = (low.inf(p), high.sup(p));
        }
        let size = high - low;
        if !(size.x > 0.0 && size.y > 0.0 && cell > 0.0 && (size.x * size.y).is_finite()) {
            return None;
        }
        let cell = cell.max((size.x * size.y / MOST_CELLS).sqrt());
        // A margin, so that every place has neighbours.
        low -= UvVector::repeat(1.5 * cell);
        let [width, height] = [size.x, size.y].map(|s| (s / cell).ceil() as usize + 4);
        let mut own = vec![false; width * height];
        for (p, _) in points {
            let d = (p - low) / cell;
            own[d.x as usize * height + d.y as usize] = true;
        }
        let (mut live, inner) = (own.clone(), |k: usize| 1..k - 1);
        for (i, j) in inner(width).flat_map(|i| inner(height).map(move |j| (i, j))) {
            let centre = low + cell * UvVector::new(i as f64 + 0.5, j as f64 + 0.5);
            if own[i * height + j] || also(centre) {
                for k in [i - 1, i, i + 1] {
                    live[k * height + j - 1..=k * height + j + 1].fill(true);
                }
            }
        }
        let mut grid =
            Grid { low, cell, cells: vec![None; live.len()], height, on_cells: vec![], count: 0 };
        grid.number(&live);
        Some(grid)
    }

    fn number(&mut self, live: &[bool]) {
        let rows = self.height + DEGREE;
        let mut numbers: HashMap<usize, u32> = HashMap::new();
        for (at, _) in live.iter().enumerate().filter(|l| *l.1) {
            let (i, j) = (at / self.height, at % self.height);
            self.cells[at] = Some(self.on_cells.len() as u32);
            let mut number = |k: usize| {
                let key = (i + k / ON_INTERVAL) * rows + j + k % ON_INTERVAL;
                let next = numbers.len() as u32;
                *numbers.entry(key).or_insert(next)
            };
            self.on_cells.push(std::array::from_fn(&mut number));
        }
        self.count = numbers.len();
    }

    /// Of a large grid some blocks, spread over it, from which to tell how stiff
    /// the whole shall be.
    fn sample(&self) -> Option<Grid> {
        if self.count <= SAMPLE {
            return None;
        }
        let block = |at: usize| (at / self.height / BLOCK, at % self.height / BLOCK);
        let mut blocks: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        let live = |at: &usize| self.cells[*at].is_some();
        for at in (0..self.cells.len()).filter(live) {
            *blocks.entry(block(at)).or_default() += 1;
        }
        let average = self.on_cells.len() / blocks.len();
        blocks.retain(|_, cells| 2 * *cells >= average);
        // A block of cells has about twice as many functions.
        let step = (2 * self.on_cells.len()).div_ceil(SAMPLE).min(blocks.len());
        let chosen: HashSet<_> = blocks.into_keys().skip(step / 2).step_by(step).collect();
        let own = |at: usize| live(&at) && chosen.contains(&block(at));
        let mut part =
            Grid { cells: vec![None; self.cells.len()], on_cells: Vec::new(), count: 0, ..*self };
        part.number(&(0..self.cells.len()).map(own).collect::<Vec<_>>());
        Some(part)
    }

    /// Into how many parts without a common function the grid falls.
    fn parts(&self) -> usize {
        let mut root: Vec<u32> = (0..self.count as u32).collect();
        fn find(root: &mut [u32], mut i: u32) -> u32 {
            while root[i as usize] != i {
                root[i as usize] = root[root[i as usize] as usize];
                i = root[i as usize];
            }
            i
        }
        for functions in &self.on_cells {
            let first = find(&mut root, functions[0]);
            for &f in functions {
                let other = find(&mut root, f);
                root[other as usize] = first;
            }
        }
        (0..self.count).filter(|&i| root[i] == i as u32).count()
    }

    /// The cell of a place, and the place in it from 0 to 1.
    fn cell_of(&self, uv: Uv) -> Option<(usize, [f64; 2])> {
        let d = (uv - self.low) / self.cell;
        let inside = d.x >= 0.0 && d.y >= 0.0 && d.y < self.height as f64;
        if !inside {
            return None;
        }
        let (i, j) = (d.x as usize, d.y as usize);
        let live = (*self.cells.get(i * self.height + j)?)?;
        Some((live as usize, [d.x - i as f64, d.y - j as f64]))
    }

    /// The functions that do not vanish at a place, and their values.
    fn functions(&self, uv: Uv) -> Option<(&[u32; ON_CELL], [f64; ON_CELL])> {
        let (cell, [s, t]) = self.cell_of(uv)?;
        let (a, b) = (basis(s, DEGREE), basis(t, DEGREE));
        Some((
            &self.on_cells[cell],
            std::array::from_fn(|k| a[k / ON_INTERVAL] * b[k % ON_INTERVAL]),
        ))
    }
}

/// The uniform B-splines of a degree on [0, 1], the one that ends there first.
fn basis(t: f64, degree: usize) -> [f64; ON_INTERVAL] {
    let mut b = [0.0; ON_INTERVAL];
    b[0] = 1.0;
    for d in 1..=degree {
        let scale = 1.0 / d as f64;
        for j in (0..=d).rev() {
            let below = if j > 0 { (t + (d - j) as f64) * b[j - 1] } else { 0.0 };
            let own = if j < d { (j as f64 + 1.0 - t) * b[j] } else { 0.0 };
            b[j] = scale * (below + own);
        }
    }
    b
}

/// Their derivatives of order `m`: differences of the splines of degree − m.
fn derivatives(t: f64, m: usize) -> [f64; ON_INTERVAL] {
    let mut b = basis(t, DEGREE - m);
    for _ in 0..m {
        for j in (0..ON_INTERVAL).rev() {
            b[j] = if j > 0 { b[j - 1] } else { 0.0 } - b[j];
        }
    }
    b
}

/// Nodes and weights of Gauss's quadrature on [0, 1], exact to degree 9.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_5),
    (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
    (0.953_089_922_969_332, 0.118_463_442_528_094_5),
];

/// The energy of order `m` of a cell, as a form in its functions' coefficients.
fn cell_energy(m: usize) -> [[f64; ON_CELL]; ON_CELL] {
    let along = |k: usize| {
        let mut sum = [[0.0; ON_INTERVAL]; ON_INTERVAL];
        for (t, weight) in GAUSS {
            let d = derivatives(t, k);
            for (row, a) in sum.iter_mut().zip(d) {
                for (entry, b) in row.iter_mut().zip(d) {
                    *entry += weight * a * b;
                }
            }
        }
        sum
    };
    let mut energy = [[0.0; ON_CELL]; ON_CELL];
    let mut binomial = 1.0;
    for k in 0..=m {
        let (a, b) = (along(k), along(m - k));
        for (p, row) in energy.iter_mut().enumerate() {
            for (q, entry) in row.iter_mut().enumerate() {
                let (i, j) = (ON_INTERVAL, ON_INTERVAL);
                *entry += binomial * a[p / i][q / i] * b[p % j][q % j];
            }
        }
        binomial *= (m - k) as f64 / (k + 1) as f64;
    }
    energy
}

/// Of λ₂ and λ₄, where all forms have the same trace: powers of √10.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Exponents(i32, i32);

impl Exponents {
    fn weights(self) -> [f64; 2] {
        [self.0, self.1].map(|e| 10f64.powf(0.5 * f64::from(e)))
    }
}

/// The normal equations and the energies, entry by entry of one pattern.
struct Equations<const D: usize> {
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
    fn new(grid: &Grid, points: &[(Uv, [f64; D])]) -> Option<Self> {
        let n = grid.count;
        let free = FREE * grid.parts();
        let inside = |p: &&(Uv, [f64; D])| grid.cell_of(p.0).is_some();
        let count = points.iter().filter(inside).count();
        if count <= 4 * free {
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
            freedom: (count - free) as f64 * D as f64,
        };
        let mut sums = vec![[[0.0; ON_CELL]; ON_CELL]; grid.on_cells.len()];
        for (uv, value) in points {
            let Some((cell, _)) = grid.cell_of(*uv) else { continue };
            let (functions, b) = grid.functions(*uv)?;
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
    fn most_likely(&mut self, start: Exponents) -> Option<Exponents> {
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

    fn coefficients(&mut self, stiffness: Exponents) -> Option<Vec<[f64; D]>> {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(f: impl Fn(f64, f64) -> f64) -> Vec<(Uv, [f64; 1])> {
        let grid = (-40..=40).flat_map(|i| (-40..=40).map(move |j| (i, j)));
        let places = grid.map(|(i, j)| Uv::new(f64::from(i) / 20.0, f64::from(j) / 20.0));
        places.filter(|p| p.coords.norm() > 1.0).map(|p| (p, [f(p.x, p.y)])).collect()
    }

    fn inside() -> Vec<Uv> {
        let angle = |k: i32| 0.1 * f64::from(k);
        let at = |k: i32| Uv::new(angle(k).cos(), angle(k).sin()) * (0.016 * f64::from(k));
        (0..60).map(at).collect()
    }

    #[test]
    fn the_basis_adds_to_one_and_its_derivatives_to_nothing() {
        for t in [0.0, 0.3, 1.0] {
            assert!((basis(t, DEGREE).iter().sum::<f64>() - 1.0).abs() < 1e-14);
            for m in 1..=DEGREE {
                assert!(derivatives(t, m).iter().sum::<f64>().abs() < 1e-13);
            }
            let slope = derivatives(t, 1);
            let (above, below) = (basis(t + 1e-6, DEGREE), basis(t - 1e-6, DEGREE));
            for j in 0..ON_INTERVAL {
                assert!((slope[j] - (above[j] - below[j]) / 2e-6).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn a_clean_surface_goes_on_over_the_hole() {
        let f = |x: f64, y: f64| (1.3 * x).sin() * (0.8 * y).cos();
        let spline = SmoothingSpline::fit(&ring(f), |p| p.coords.norm() < 1.0, 0.3, 0.1).unwrap();
        for p in inside() {
            let [z] = spline.at(p).unwrap();
            assert!((z - f(p.x, p.y)).abs() < 2e-3, "{p} {z} {}", f(p.x, p.y));
        }
    }

    #[test]
    fn noise_is_known_for_what_it_is() {
        let mut state = 7u64;
        let mut noise = || {
            let uniform = (0..12).map(|_| {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                (state >> 33) as f64 / (1u64 << 31) as f64
            });
            0.05 * (uniform.sum::<f64>() - 6.0)
        };
        let f = |x: f64, y: f64| 0.3 * x * x - 0.2 * x * y;
        let mut points = ring(f);
        points.iter_mut().for_each(|p| p.1[0] += noise());
        let spline = SmoothingSpline::fit(&points, |p| p.coords.norm() < 1.0, 0.3, 0.1).unwrap();
        let squares = points.iter().map(|(p, z)| (spline.at(*p).unwrap()[0] - z[0]).powi(2));
        let deviation = (squares.sum::<f64>() / points.len() as f64).sqrt();
        assert!((deviation - 0.05).abs() < 0.005, "{deviation}");
        for p in inside() {
            let [z] = spline.at(p).unwrap();
            assert!((z - f(p.x, p.y)).abs() < 0.03, "{p} {z} {}", f(p.x, p.y));
        }
    }
}
