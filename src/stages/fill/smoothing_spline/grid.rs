//! The grid of a smoothing spline: its quartic B-splines, and their thin-plate energies.

use std::collections::{BTreeMap, HashSet};

use crate::geometry::sets::Sets;
use crate::geometry::{Uv, UvVector};

/// The degree of the B-splines. The energy of fourth order needs fourth derivatives.
pub(crate) const DEGREE: usize = 4;
/// The number of B-splines that are not zero on an interval.
pub(crate) const ON_INTERVAL: usize = DEGREE + 1;
/// The number of products of two that are not zero on a cell.
pub(crate) const ON_CELL: usize = ON_INTERVAL * ON_INTERVAL;

/// The most cells of a grid, which bounds its memory to some 100 MB. Wider grids get larger
/// cells.
const MOST_CELLS: f64 = 4e6;

/// The stiffness for a grid of more functions than this is found on a sample of about so many.
const SAMPLE: usize = 700;

/// The sample consists of square blocks of cells, with this many cells along each side.
const BLOCK: usize = 12;

/// The live cells, on which the spline is defined, and the functions on each.
pub(crate) struct Grid {
    low: Uv,
    cell: f64,
    /// The index in `on_cells` of each cell of the bounding rectangle, in columns of `height`
    /// cells. `None` for a cell that is not live.
    cells: Vec<Option<u32>>,
    height: usize,
    /// The functions on each live cell, in ascending order.
    pub on_cells: Vec<[u32; ON_CELL]>,
    /// The place of each function in the lattice of the whole rectangle, column by column, in
    /// ascending order.
    places: Vec<u32>,
    /// The number of functions.
    pub count: usize,
}

impl Grid {
    /// The cells that have a point, those for whose centre and width `also` is true, and the
    /// neighbours of both. Without the neighbours the energy would end where the points end,
    /// and would not hold the functions there.
    pub(super) fn new<const D: usize>(
        points: &[(Uv, [f64; D])],
        also: impl Fn(Uv, f64) -> bool,
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
        // A margin, so that every cell with a point has neighbours.
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
            if own[i * height + j] || also(centre, cell) {
                for k in [i - 1, i, i + 1] {
                    live[k * height + j - 1..=k * height + j + 1].fill(true);
                }
            }
        }
        let mut grid = Grid {
            low,
            cell,
            cells: vec![None; live.len()],
            height,
            on_cells: vec![],
            places: vec![],
            count: 0,
        };
        grid.number(&live);
        Some(grid)
    }

    fn number(&mut self, live: &[bool]) {
        let rows = self.height + DEGREE;
        let live = || live.iter().enumerate().filter(|l| *l.1).map(|l| l.0);
        let first = |at: usize| at / self.height * rows + at % self.height;
        let place = |k: usize| k / ON_INTERVAL * rows + k % ON_INTERVAL;
        let mut numbers = vec![None; rows * (self.cells.len() / self.height + DEGREE)];
        for at in live().map(first) {
            (0..ON_CELL).for_each(|k| numbers[at + place(k)] = Some(0));
        }
        self.places = Vec::new();
        for (place, number) in numbers.iter_mut().enumerate().filter(|n| n.1.is_some()) {
            *number = Some(self.places.len() as u32);
            self.places.push(place as u32);
        }
        for (number, at) in live().enumerate() {
            self.cells[at] = Some(number as u32);
            let first = first(at);
            self.on_cells.push(std::array::from_fn(|k| numbers[first + place(k)].unwrap_or(0)));
        }
        self.count = self.places.len();
    }

    /// The column and row of each function in the lattice.
    pub(crate) fn lattice(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        let rows = (self.height + DEGREE) as u32;
        self.places.iter().map(move |place| [place / rows, place % rows])
    }

    /// Some blocks of a large grid, spread over it, on which to find the stiffness. `None` for
    /// a small grid.
    pub(crate) fn sample(&self) -> Option<Grid> {
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
        // Blocks have about twice as many functions as cells, because of their borders.
        let step = (2 * self.on_cells.len()).div_ceil(SAMPLE).min(blocks.len());
        let chosen: HashSet<_> = blocks.into_keys().skip(step / 2).step_by(step).collect();
        let own = |at: usize| live(&at) && chosen.contains(&block(at));
        let mut part = Grid {
            cells: vec![None; self.cells.len()],
            on_cells: Vec::new(),
            places: Vec::new(),
            count: 0,
            ..*self
        };
        part.number(&(0..self.cells.len()).map(own).collect::<Vec<_>>());
        Some(part)
    }

    /// The number of parts of the grid that have no function in common.
    pub(crate) fn parts(&self) -> usize {
        let mut sets = Sets::new(self.count);
        for functions in &self.on_cells {
            functions.iter().for_each(|&f| sets.join(functions[0] as usize, f as usize));
        }
        (0..self.count).filter(|&i| sets.find(i) == i).count()
    }

    /// The live cell at `uv`, and the place in it from 0 to 1.
    pub(crate) fn cell_of(&self, uv: Uv) -> Option<(usize, [f64; 2])> {
        let d = (uv - self.low) / self.cell;
        let inside = d.x >= 0.0 && d.y >= 0.0 && d.y < self.height as f64;
        if !inside {
            return None;
        }
        let (i, j) = (d.x as usize, d.y as usize);
        let live = (*self.cells.get(i * self.height + j)?)?;
        Some((live as usize, [d.x - i as f64, d.y - j as f64]))
    }

    /// The functions that are not zero at `uv`, and their values.
    pub(crate) fn functions(&self, uv: Uv) -> Option<(&[u32; ON_CELL], [f64; ON_CELL])> {
        let (cell, place) = self.cell_of(uv)?;
        Some((&self.on_cells[cell], values(place)))
    }
}

/// The values of the functions of a cell at a place in it.
pub(crate) fn values([s, t]: [f64; 2]) -> [f64; ON_CELL] {
    let (a, b) = (basis(s, DEGREE), basis(t, DEGREE));
    std::array::from_fn(|k| a[k / ON_INTERVAL] * b[k % ON_INTERVAL])
}

/// The uniform B-splines of a degree that are not zero on [0, 1], by where they end.
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

/// Their derivatives of order `m`: differences of the splines of degree `DEGREE − m`.
fn derivatives(t: f64, m: usize) -> [f64; ON_INTERVAL] {
    let mut b = basis(t, DEGREE - m);
    for _ in 0..m {
        for j in (0..ON_INTERVAL).rev() {
            b[j] = if j > 0 { b[j - 1] } else { 0.0 } - b[j];
        }
    }
    b
}

/// Nodes and weights of Gauss's quadrature on [0, 1], exact up to degree 9.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_5),
    (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
    (0.953_089_922_969_332, 0.118_463_442_528_094_5),
];

/// The energy of order `m` of a cell, as a quadratic form in the coefficients of its functions.
pub(crate) fn cell_energy(m: usize) -> [[f64; ON_CELL]; ON_CELL] {
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
