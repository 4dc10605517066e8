//! Which columns of a text file hold what.

use crate::points::Column;

/// A normal's length may differ from 1 by so much: components with two digits
/// are off by up to 0.005 each, which changes the length by up to 0.009.
const UNIT: f64 = 0.02;

/// So many rows in 100 must have a normal of unit length. Some programs write
/// zeros where they found none.
const MOST: usize = 90;

/// Which columns of a text file hold what.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    /// The number of columns.
    pub(super) count: usize,
    /// The column of each coordinate.
    pub(super) position: [usize; 3],
    /// The column of each component of the normal.
    pub(super) normal: Option<[usize; 3]>,
    /// What the other columns are called.
    pub(super) others: Vec<String>,
}

impl Layout {
    /// The layout by the names of the columns, if these are such names.
    pub(super) fn by_names<'a>(names: impl Iterator<Item = &'a [u8]>) -> Option<Layout> {
        let names: Vec<String> = names.map(|n| String::from_utf8_lossy(n).into_owned()).collect();
        let columns: Vec<Column> = names.iter().map(|name| Column::named(name)).collect();
        let find = |kind: fn(usize) -> Column| {
            let at = |axis| columns.iter().position(|&column| column == kind(axis));
            Some([at(0)?, at(1)?, at(2)?])
        };
        let position = find(Column::Position)?;
        Some(Layout {
            count: names.len(),
            position,
            normal: find(Column::Normal),
            others: names.into_iter().map(|n| n.trim_matches('"').to_owned()).collect(),
        })
    }

    /// The layout by the custom of programs that write no names. After the
    /// coordinates come a normal if three columns have unit length, an intensity
    /// if there is one column or four, and a colour.
    pub(super) fn by_custom(rows: &[Vec<Option<f64>>]) -> Option<Layout> {
        let count = rows.first()?.len();
        let normal = [3, 6].into_iter().find(|&at| at + 3 <= count && is_unit(rows, at));
        let names: &[&str] = match (count, normal) {
            (4, _) => &["intensity"],
            (6, None) => &["red", "green", "blue"],
            (7, None) => &["intensity", "red", "green", "blue"],
            (9, Some(6)) => &["red", "green", "blue", "nx", "ny", "nz"],
            (9, Some(_)) => &["nx", "ny", "nz", "red", "green", "blue"],
            (_, Some(3)) => &["nx", "ny", "nz"],
            _ => &[],
        };
        let others = (3..count).map(|i| match names.get(i - 3) {
            Some(name) => (*name).to_owned(),
            None if normal.is_some_and(|at| (at..at + 3).contains(&i)) => "nx".to_owned(),
            None => format!("column {}", i + 1),
        });
        let others = others.collect();
        let normal = normal.map(|at| [at, at + 1, at + 2]);
        Some(Layout { count, position: [0, 1, 2], normal, others })
    }
}

/// Whether the three columns from `at` on are normals.
fn is_unit(rows: &[Vec<Option<f64>>], at: usize) -> bool {
    let unit = |row: &&Vec<Option<f64>>| {
        let squares: Option<f64> = row[at..at + 3].iter().map(|x| x.map(|x| x * x)).sum();
        squares.is_some_and(|sum| (sum.sqrt() - 1.0).abs() <= UNIT)
    };
    100 * rows.iter().filter(unit).count() >= MOST * rows.len()
}
