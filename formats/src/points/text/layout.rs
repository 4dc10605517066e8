//! Which columns of a text file hold what.

use super::numbering;
use crate::points::{Column, Columns};
use crate::words::plural;

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
    /// So many columns at the beginning number the points.
    pub(super) numbering: usize,
    /// What the columns that are not read are called.
    pub(super) others: Vec<String>,
}

/// The first rows of a file, all with the same number of columns.
pub(super) struct FirstRows<'a> {
    pub(super) fields: Vec<Vec<&'a [u8]>>,
    pub(super) numbers: Vec<Vec<Option<f64>>>,
}

impl Layout {
    /// The layout by the names of the columns, if these are such names.
    pub(super) fn by_names(names: &[String]) -> Option<Layout> {
        let columns: Vec<Column> = names.iter().map(|name| Column::named(name)).collect();
        let find = |kind: fn(usize) -> Column| {
            let at = |axis| columns.iter().position(|&column| column == kind(axis));
            Some([at(0)?, at(1)?, at(2)?])
        };
        let position = find(Column::Position)?;
        let is_other = |column: &Column| !matches!(column, Column::Position(_) | Column::Normal(_));
        let others = names.iter().zip(&columns).filter(|(_, column)| is_other(column));
        Some(Layout {
            count: names.len(),
            position,
            normal: find(Column::Normal),
            numbering: 0,
            others: others.map(|(name, _)| name.clone()).collect(),
        })
    }

    /// The layout by the custom of programs that write no names. Before the coordinates may stand a number of
    /// the point, or two. After them come a normal if three columns have unit length, an intensity
    /// if there is one column or four, and a colour.
    pub(super) fn by_custom(rows: &FirstRows, names: Option<&[String]>) -> Option<Layout> {
        let count = rows.numbers.first()?.len();
        let normal_after = |skipped: usize| {
            let mut places = [skipped + 3, skipped + 6].into_iter();
            places.find(|&at| at + 3 <= count && is_unit(&rows.numbers, at))
        };
        let numbering = match normal_after(0) {
            Some(_) => 0,
            None => numbering::columns(rows, names),
        };
        let first = numbering + 3;
        let normal = normal_after(numbering);
        let names: &[&str] = match (count - numbering, normal.map(|at| at - first)) {
            (4, _) => &["intensity"],
            (6, None) => &["red", "green", "blue"],
            (7, None) => &["intensity", "red", "green", "blue"],
            (9, Some(3)) => &["red", "green", "blue"],
            (9, Some(_)) => &["", "", "", "red", "green", "blue"],
            _ => &[],
        };
        let is_other = |i: &usize| !normal.is_some_and(|at| (at..at + 3).contains(i));
        let others = (first..count).filter(is_other).map(|i| match names.get(i - first) {
            Some(name) => (*name).to_owned(),
            None => unnamed(i),
        });
        Some(Layout {
            count,
            position: [numbering, numbering + 1, numbering + 2],
            normal: normal.map(|at| [at, at + 1, at + 2]),
            numbering,
            others: others.collect(),
        })
    }

    /// The layout that a user chose for a file with so many columns, and perhaps with names in a header.
    ///
    /// # Errors
    /// What is wrong with the choice, as the end of a sentence about the file.
    pub(super) fn chosen(
        columns: &Columns,
        names: Option<&[String]>,
        count: usize,
    ) -> Result<Layout, String> {
        let places = match columns {
            Columns::Numbers(numbers) => numbers.iter().map(|number| number - 1).collect(),
            Columns::Names(wanted) => match names.and_then(|names| places(wanted, names)) {
                Some(places) => places,
                None => by_order(wanted, count)?,
            },
        };
        if let Some(last) = places.iter().max().filter(|&&last| last >= count) {
            return Err(format!("has {}, and no column {}", plural(count, "column"), last + 1));
        }
        let name = |i: usize| names.map_or_else(|| unnamed(i), |names| names[i].clone());
        let others = (0..count).filter(|i| !places.contains(i)).map(name).collect();
        let (position, normal) = match places[..] {
            [x, y, z] => ([x, y, z], None),
            [x, y, z, nx, ny, nz] => ([x, y, z], Some([nx, ny, nz])),
            _ => return Err("needs three or six columns".to_owned()),
        };
        Ok(Layout { count, position, normal, numbering: 0, others })
    }
}

/// What a column without a name is called.
fn unnamed(column: usize) -> String {
    format!("column {}", column + 1)
}

/// The columns that have the wanted names in a header, or names of the same kinds.
fn places(wanted: &[String], names: &[String]) -> Option<Vec<usize>> {
    let place = |wanted: &String| {
        let same = names.iter().position(|name| name.trim().eq_ignore_ascii_case(wanted));
        let kind = Column::named(wanted);
        let is_kind = |name: &String| kind != Column::Other && Column::named(name) == kind;
        same.or_else(|| names.iter().position(is_kind))
    };
    let places: Vec<usize> = wanted.iter().map(place).collect::<Option<_>>()?;
    matches!(places.len(), 3 | 6).then_some(places)
}

/// The columns of x, y, z and perhaps nx, ny, nz, where the user names what the file's columns hold in their order.
fn by_order(names: &[String], count: usize) -> Result<Vec<usize>, String> {
    let Some(layout) = Layout::by_names(names) else {
        return Err(format!("has no columns of the names {}", names.join(", ")));
    };
    if names.len() > count {
        return Err(format!("has {}, and {} are named", plural(count, "column"), names.len()));
    }
    Ok(layout.position.into_iter().chain(layout.normal.into_iter().flatten()).collect())
}

/// Whether the three columns from `at` on are normals.
fn is_unit(rows: &[Vec<Option<f64>>], at: usize) -> bool {
    let unit = |row: &&Vec<Option<f64>>| {
        let squares: Option<f64> = row[at..at + 3].iter().map(|x| x.map(|x| x * x)).sum();
        squares.is_some_and(|sum| (sum.sqrt() - 1.0).abs() <= UNIT)
    };
    100 * rows.iter().filter(unit).count() >= MOST * rows.len()
}
