//! Which functions of a grid share a cell: the pattern of its forms.

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
            for (q, p) in pairs() {
                let slot = overlaps.slot(functions, p, q);
                overlaps.rows[slot] = functions[p] as usize;
            }
        }
        overlaps
    }

    /// Where the entry of the `p`-th and the `q`-th function of a cell is, the
    /// first of which is not before the second.
    pub fn slot(&self, functions: &[u32; ON_CELL], p: usize, q: usize) -> usize {
        let column = functions[q] as usize;
        self.starts[column] + usize::from(self.places[column][step(p, q)])
    }
}

/// A cell's functions q and p, p not before q.
pub fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..ON_CELL).flat_map(|q| (q..ON_CELL).map(move |p| (q, p)))
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
    let half = functions.len() / 2;
    let middle = functions.select_nth_unstable_by_key(half, |f| (f.0[axis], f.1)).1.0[axis];
    let first = middle.saturating_sub(DEGREE as u32 / 2);
    let part = |f: &([u32; 2], usize)| match f.0[axis] {
        x if x < first => 0,
        x if x >= first + DEGREE as u32 => 1,
        _ => 2,
    };
    functions.sort_unstable_by_key(|f| (part(f), f.1));
    let ends = [0, 1].map(|side| functions.partition_point(|f| part(f) <= side));
    dissect(&mut functions[..ends[0]]);
    dissect(&mut functions[ends[0]..ends[1]]);
}
