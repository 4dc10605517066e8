//! Columns before the coordinates that number the points: one that counts up, the times of the points, or a row and
//! a column of a raster.

use super::layout::FirstRows;
use crate::points::column::plain_name;

/// So many rows are needed to tell a number from a coordinate. That so many coordinates without order
/// increase has a chance of 1 in 8! = 40,320.
pub(super) const LEAST_ROWS: usize = 8;

/// Numbers of so many digits are exact in an `f64`, and count more points than a file has.
const MOST_DIGITS: usize = 15;

/// Steps that differ by less than this part of them are the same step, rounded to the digits of a file.
const SAME_STEP: f64 = 0.01;

/// Times are counted from a day or from an epoch, and not from where the coordinates are: the first of them is so
/// many times beyond all coordinates, as a cloud that far from zero is in no frame of its own.
const BEYOND: f64 = 100.0;

/// Names of columns that number the points or have their times.
const NAMES: [&str; 15] = [
    "t",
    "time",
    "timestamp",
    "time_stamp",
    "gps_time",
    "gpstime",
    "gps time",
    "seconds",
    "sec",
    "id",
    "index",
    "point_id",
    "pointid",
    "number",
    "nr",
];

/// The number of columns at the beginning of each row that number the points: 0, 1 or 2. Three or more columns
/// follow them. The columns may have names, although they are not x, y and z.
pub(super) fn columns(rows: &FirstRows, names: Option<&[String]>) -> usize {
    let width = rows.fields.first().map_or(0, Vec::len);
    let first = names.and_then(|names| names.first());
    if width >= 4 && first.is_some_and(|name| NAMES.contains(&plain_name(name).as_str())) {
        return 1;
    }
    if rows.fields.len() < LEAST_ROWS {
        return 0;
    }
    let column = |at: usize| ColumnSamples::new(rows, at);
    let first_four = (width >= 4).then(|| [0, 1, 2, 3].map(column));
    if first_four.is_some_and(|columns| is_number(&columns) || is_time(&columns)) {
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
    /// The most digits that one has after its decimal mark.
    digits: usize,
}

impl ColumnSamples {
    fn new(rows: &FirstRows, at: usize) -> ColumnSamples {
        let is_whole =
            |field: &[u8]| field.len() <= MOST_DIGITS && field.iter().all(u8::is_ascii_digit);
        ColumnSamples {
            values: rows.numbers.iter().map(|row| row[at].unwrap_or(f64::NAN)).collect(),
            are_whole: rows.fields.iter().all(|row| is_whole(row[at])),
            digits: rows.fields.iter().map(|row| digits(row[at])).max().unwrap_or(0),
        }
    }

    fn steps(&self) -> impl Iterator<Item = f64> {
        self.values.windows(2).map(|pair| pair[1] - pair[0])
    }

    fn counts_up(&self) -> bool {
        self.are_whole && self.steps().all(|step| step > 0.0)
    }

    /// Whether it never falls, and rises in most rows. Several echoes of a pulse have the same time.
    fn rises(&self) -> bool {
        self.steps().all(|step| step >= 0.0)
            && 2 * self.steps().filter(|&step| step > 0.0).count() >= self.values.len()
    }

    /// Whether it is a coordinate that stays along most rows and then goes on in one direction, as from one line of
    /// a scan to the next.
    fn is_staircase(&self) -> bool {
        let rises = self.steps().filter(|&step| step > 0.0).count();
        let falls = self.steps().filter(|&step| step < 0.0).count();
        rises.min(falls) == 0 && rises != falls && 2 * (rises + falls) < self.values.len()
    }

    fn reach(&self) -> f64 {
        self.values.iter().fold(0.0, |reach, x| x.abs().max(reach))
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

/// Whether the first of four columns has the times of the points. One that rises without steps may also be x of
/// a sorted cloud or of a profile, with y, z and an intensity after it. But an intensity seldom has the digits of y and z,
/// and x would fall back at the end of each line of a scan. So the three columns must have the same digits, and two
/// of them show the lines of a scan while the times rise, or the times are far beyond all coordinates.
fn is_time([first, coordinates @ ..]: &[ColumnSamples; 4]) -> bool {
    let digits = coordinates[0].digits;
    let are_alike = digits > 0 && coordinates.iter().all(|column| column.digits == digits);
    let reach = coordinates.iter().map(ColumnSamples::reach).fold(0.0, f64::max);
    let are_in_lines = || {
        let mut stairs = coordinates.iter().filter(|column| column.is_staircase());
        stairs.any(|stair| coordinates.iter().any(|along| has_lines(stair, along)))
    };
    first.rises() && are_alike && (are_in_lines() || first.values[0] > BEYOND * reach)
}

/// Whether one coordinate goes on one way along each line of a scan, and comes back from one line to the next or along
/// the next one. The other one stays in a line.
fn has_lines(stair: &ColumnSamples, along: &ColumnSamples) -> bool {
    let mut before = 0.0;
    let goes_one_way = stair.steps().zip(along.steps()).all(|(to_next_line, along)| {
        let goes_on = to_next_line != 0.0 || along * before > 0.0 || before == 0.0 && along != 0.0;
        before = if to_next_line == 0.0 { along } else { 0.0 };
        goes_on
    });
    let comes_back = along.steps().any(|step| step > 0.0) && along.steps().any(|step| step < 0.0);
    goes_one_way && comes_back
}

/// Whether the first two of five columns are the place of a point in a raster, in rows or in columns.
fn is_raster([first, second, x, y, z]: &[ColumnSamples; 5]) -> bool {
    let is_walk = |slow: &ColumnSamples, fast: &ColumnSamples| {
        let mut steps = slow.steps().zip(fast.steps());
        let in_order = steps.all(|(slow, fast)| slow > 0.0 || slow == 0.0 && fast > 0.0);
        in_order && fast.steps().any(|step| step == 1.0)
    };
    // Colours, classes and other counts are whole. So are coordinates, perhaps, but these go along the raster, or
    // have digits where the others have some, which an intensity seldom shares with a height.
    let along = |column: &ColumnSamples| is_along(first, column) || is_along(second, column);
    let are_alike = x.digits > 0 && x.digits == y.digits && x.digits == z.digits;
    let are_coordinates =
        are_alike || [x, y].into_iter().any(|c| c.is_even() || !z.are_whole && along(c));
    first.are_whole
        && second.are_whole
        && are_coordinates
        && (is_walk(first, second) || is_walk(second, first))
}

/// Whether a coordinate rises or falls in all steps along the lines of a raster, as x or y does.
fn is_along(place: &ColumnSamples, coordinate: &ColumnSamples) -> bool {
    let steps = place.steps().zip(coordinate.steps());
    let steps: Vec<f64> = steps.filter(|(place, _)| *place > 0.0).map(|(_, step)| step).collect();
    let is_one_way = steps.iter().all(|&step| step > 0.0) || steps.iter().all(|&step| step < 0.0);
    // From one line to the next there are few steps.
    2 * steps.len() >= place.values.len() && is_one_way
}

/// How many digits a number has after its decimal mark, and before an exponent.
fn digits(field: &[u8]) -> usize {
    let mark = field.iter().position(|byte| matches!(byte, b'.' | b','));
    mark.map_or(0, |mark| field[mark + 1..].iter().take_while(|b| b.is_ascii_digit()).count())
}
