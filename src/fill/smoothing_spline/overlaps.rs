//! Which functions of a grid share a cell: the pattern of its forms.

use std::ops::Range;

use super::grid::{DEGREE, Grid, ON_CELL, ON_INTERVAL};

/// How far apart in the lattice two functions can be that share a cell, from
/// one to a later one: so many steps.
const STEPS: usize = DEGREE * WIDE + DEGREE + 1;

/// Rows of the lattice that can be reached, ahead and back.
const WIDE: usize = 2 * DEGREE + 1;

/// The step in the lattice from the `q`-th function of a cell to the `p`-th,
/// which is not before it.
const fn step(p: usize, q: usize) -> usize {
    (p / ON_INTERVAL - q / ON_INTERVAL) * WIDE + p % ON_INTERVAL - q % ON_INTERVAL
}

/// For each function the later ones with which it shares a cell, itself first:
/// the lower triangle of a symmetric form, column by column.
pub struct Overlaps {
    /// Where each function's column starts, and the end.
    pub starts: Vec<usize>,
    /// The rows of the columns.
    pub rows: Vec<usize>,
    /// Of each function the place of a step's entry in its column.
    places: Vec<[u8; STEPS]>,
}

impl Overlaps {
    pub fn new(grid: &Grid) -> Self {
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

    /// Where the entries of a run of a cell's functions and its `q`-th are: one
    /// after the other, as the functions are in their column of the lattice.
    pub fn slots(&self, functions: &[u32; ON_CELL], q: usize, run: &Range<usize>) -> Range<usize> {
        let column = functions[q] as usize;
        let first = self.starts[column] + usize::from(self.places[column][step(run.start, q)]);
        first..first + run.len()
    }
}

/// A cell's functions and those of each column of the lattice that are not before
/// them.
pub fn runs() -> impl Iterator<Item = (usize, Range<usize>)> {
    let columns = |q: usize| (q / ON_INTERVAL..ON_INTERVAL).map(|c| c * ON_INTERVAL);
    (0..ON_CELL).flat_map(move |q| columns(q).map(move |c| (q, c.max(q)..c + ON_INTERVAL)))
}

/// Sets of fewer functions are not divided further.
const SMALL: usize = 48;

/// An order of elimination that keeps factors sparse: by nested dissection of
/// the lattice (George 1973), with separators as wide as functions reach.
pub fn order(grid: &Grid) -> Vec<usize> {
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
