//! Columns before the coordinates that number the points: one that counts up, or a row and a column of a raster.

use super::layout::FirstRows;

/// So many rows are needed to tell a number from a coordinate. That so many coordinates without order
/// increase has a chance of 1 in 8! = 40,320.
const LEAST_ROWS: usize = 8;

/// Numbers of so many digits are exact in an `f64`, and count more points than a file has.
const MOST_DIGITS: usize = 15;

/// Steps that differ by less than this part of them are the same step, rounded to the digits of a file.
const SAME_STEP: f64 = 0.01;

/// The number of columns at the beginning of each row that number the points: 0, 1 or 2. Three or more columns
/// follow them.
pub(super) fn columns(rows: &FirstRows) -> usize {
    let width = rows.fields.first().map_or(0, Vec::len);
    if rows.fields.len() < LEAST_ROWS {
        return 0;
    }
    let column = |at: usize| ColumnSamples::new(rows, at);
    if width >= 4 && is_number(&[0, 1, 2, 3].map(column)) {
        return 1;
    }
    if width >= 5 && is_raster(&[0, 1, 2, 3, 4].map(column)) {
        return 2;
    }
    0
}

/// One column of the first rows.
struct ColumnSamples {
    values: Vec<f64>,
    /// Whether all are written as whole numbers without a sign.
    are_whole: bool,
}

impl ColumnSamples {
    fn new(rows: &FirstRows, at: usize) -> ColumnSamples {
        let is_whole =
            |field: &[u8]| field.len() <= MOST_DIGITS && field.iter().all(u8::is_ascii_digit);
        ColumnSamples {
            values: rows.numbers.iter().map(|row| row[at].unwrap_or(f64::NAN)).collect(),
            are_whole: rows.fields.iter().all(|row| is_whole(row[at])),
        }
    }

    fn steps(&self) -> impl Iterator<Item = f64> {
        self.values.windows(2).map(|pair| pair[1] - pair[0])
    }

    fn counts_up(&self) -> bool {
        self.are_whole && self.steps().all(|step| step > 0.0)
    }

    fn is_constant(&self) -> bool {
        self.steps().all(|step| step == 0.0)
    }

    /// Whether all rows have the same step to the next, as along a row of a raster.
    fn is_even(&self) -> bool {
        let mut steps = self.steps();
        let Some(first) = steps.next() else { return false };
        first != 0.0 && steps.all(|step| (step - first).abs() <= SAME_STEP * first.abs())
    }
}

/// Whether the first of four columns numbers the points, and is not the coordinate along a row of a raster.
fn is_number([first, x, y, z]: &[ColumnSamples; 4]) -> bool {
    if !first.counts_up() {
        return false;
    }
    if x.is_constant() {
        // Either a row of a raster at this x, or one at this y whose x has whole numbers.
        return !x.are_whole || y.is_even();
    }
    // With gaps it may also be a sorted coordinate, where all coordinates are whole.
    first.steps().all(|step| step == 1.0) || ![x, y, z].iter().all(|column| column.are_whole)
}

/// Whether the first two of five columns are the place of a point in a raster, in rows or in columns.
fn is_raster([first, second, x, y, z]: &[ColumnSamples; 5]) -> bool {
    let is_walk = |slow: &ColumnSamples, fast: &ColumnSamples| {
        let mut steps = slow.steps().zip(fast.steps());
        let in_order = steps.all(|(slow, fast)| slow > 0.0 || slow == 0.0 && fast > 0.0);
        in_order && fast.steps().any(|step| step == 1.0)
    };
    // Colours and other counts are whole. So are coordinates, perhaps, but these go along the raster.
    let are_coordinates =
        !(y.are_whole && z.are_whole) || [x, y].iter().any(|column| column.is_even());
    first.are_whole
        && second.are_whole
        && are_coordinates
        && (is_walk(first, second) || is_walk(second, first))
}
