//! The pairs of functions that share a cell: the sparsity pattern of quadratic forms.

use std::ops::Range;

use super::grid::{DEGREE, Grid, ON_CELL, ON_INTERVAL};

/// The number of steps in the lattice from a function to a later one that shares a cell.
const STEPS: usize = DEGREE * WIDE + DEGREE + 1;

/// The rows of the lattice, before and after, that have functions with a common cell.
const WIDE: usize = 2 * DEGREE + 1;

/// The step in the lattice from the `q`-th function of a cell to the `p`-th, for p ≥ q.
const fn step(p: usize, q: usize) -> usize {
    (p / ON_INTERVAL - q / ON_INTERVAL) * WIDE + p % ON_INTERVAL - q % ON_INTERVAL
}

/// For each function itself and the later ones with which it shares a cell: the lower
/// triangle of a symmetric matrix, column by column.
pub(crate) struct Overlaps {
    /// Where the column of each function starts, and where the last one ends.
    pub starts: Vec<usize>,
    /// The rows of the entries.
    pub rows: Vec<usize>,
    /// For each function, where in its column the entry of each step is.
    places: Vec<[u8; STEPS]>,
}

impl Overlaps {
    pub(super) fn new(grid: &Grid) -> Self {
        let mut reached = vec![0u64; grid.count];
        let steps: [u64; ON_CELL] =
            std::array::from_fn(|q| (q..ON_CELL).fold(0, |bits, p| bits | 1 << step(p, q)));
        for functions in &grid.on_cells {
            for (&f, bits) in functions.iter().zip(steps) {
                reached[f as usize] |= bits;
            }
        }
        let mut starts = Vec::with_capacity(grid.count + 1);
        starts.push(0);
        let mut end = 0;
        let column = |bits: &u64| {
            let mut count = 0u8;
            let places = std::array::from_fn(|step| {
                let place = count;
                count += u8::from(bits >> step & 1 == 1);
                place
            });
            end += usize::from(count);
            starts.push(end);
            places
        };
        let places = reached.iter().map(column).collect();
        let mut overlaps = Overlaps { starts, rows: vec![0; end], places };
        for functions in &grid.on_cells {
            for (q, run) in runs() {
                let slots = overlaps.slots(functions, q, &run);
                let rows = overlaps.rows[slots].iter_mut().zip(&functions[run]);
                rows.for_each(|(row, &f)| *row = f as usize);
            }
        }
        overlaps
    }

    /// The entries of the `q`-th function of a cell and a run of its functions. They are
    /// consecutive, as the functions are in their column of the lattice.
    pub(crate) fn slots(
        &self,
        functions: &[u32; ON_CELL],
        q: usize,
        run: &Range<usize>,
    ) -> Range<usize> {
        let column = functions[q] as usize;
        let first = self.starts[column] + usize::from(self.places[column][step(run.start, q)]);
        first..first + run.len()
    }
}

/// For each function of a cell the runs of functions, one a column of the lattice, that are
/// not before it.
pub(super) fn runs() -> impl Iterator<Item = (usize, Range<usize>)> {
    let columns = |q: usize| (q / ON_INTERVAL..ON_INTERVAL).map(|c| c * ON_INTERVAL);
    (0..ON_CELL).flat_map(move |q| columns(q).map(move |c| (q, c.max(q)..c + ON_INTERVAL)))
}

/// Sets of fewer functions are not divided. It changes the time only.
const SMALL: usize = 48;

/// An order of elimination that keeps factors sparse: nested dissection of the lattice
/// (George 1973), with separators as wide as the functions.
pub(crate) fn order(grid: &Grid) -> Vec<usize> {
    let mut functions: Vec<([u32; 2], usize)> = grid.lattice().zip(0..).collect();
    dissect(&mut functions);
    functions.into_iter().map(|f| f.1).collect()
}

fn dissect(functions: &mut [([u32; 2], usize)]) {
    if functions.len() < SMALL {
        return;
    }
    let extent = |axis: usize| {
        let along = || functions.iter().map(|f| f.0[axis]);
        along().max().unwrap_or(0) - along().min().unwrap_or(0)
    };
    let axis = usize::from(extent(1) > extent(0));
    if extent(axis) < 2 * DEGREE as u32 {
        return;
    }
    let mut along: Vec<u32> = functions.iter().map(|f| f.0[axis]).collect();
    let middle = *along.select_nth_unstable(functions.len() / 2).1;
    let first = middle.saturating_sub(DEGREE as u32 / 2);
    let parts = [0..first, first + DEGREE as u32..u32::MAX, first..first + DEGREE as u32];
    let of_part = |part: &Range<u32>| {
        functions.iter().copied().filter(|f| part.contains(&f.0[axis])).collect::<Vec<_>>()
    };
    let parts = parts.each_ref().map(of_part);
    let ends = [parts[0].len(), parts[0].len() + parts[1].len()];
    functions.copy_from_slice(&parts.concat());
    dissect(&mut functions[..ends[0]]);
    dissect(&mut functions[ends[0]..ends[1]]);
}
