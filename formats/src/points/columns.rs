//! The columns of a text file that a user chooses.

use std::str::FromStr;

/// Which columns of a text file hold x, y and z, and after them perhaps the components of the normal.
///
/// ```
/// use formats::points::{Columns, ReadOptions};
///
/// let columns = "2,3,4".parse::<Columns>().ok();
/// let options = ReadOptions { columns, ..ReadOptions::default() };
/// let text = std::io::Cursor::new("7 0 0 1\n9 1 0 1\n");
/// let cloud = options.read_points_from("scan.xyz".as_ref(), text)?;
/// assert_eq!(cloud.positions, [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]);
/// # Ok::<(), formats::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Columns {
    /// The columns by their numbers, counted from 1: three or six.
    Numbers(Vec<usize>),
    /// Three or six columns by their names in the file's header. Where it has no such names, they say in their
    /// order what the columns of the file hold: `x`, `y`, `z`, perhaps `nx`, `ny`, `nz`, and any other
    /// name for a column that is not read.
    Names(Vec<String>),
}

impl FromStr for Columns {
    type Err = String;

    /// Reads a list as `2,3,4` or `x,y,z,nx,ny,nz`.
    fn from_str(text: &str) -> Result<Columns, String> {
        let wrong = || "not of the form 2,3,4 or x,y,z, with three or six columns".to_owned();
        let words: Vec<&str> = text.split(',').map(str::trim).collect();
        if words.iter().any(|word| word.is_empty()) || words.len() < 3 {
            return Err(wrong());
        }
        let numbers: Option<Vec<usize>> = words.iter().map(|word| word.parse().ok()).collect();
        let Some(numbers) = numbers else {
            return Ok(Columns::Names(words.into_iter().map(str::to_owned).collect()));
        };
        let twice = |i: usize| numbers[..i].contains(&numbers[i]);
        if !matches!(numbers.len(), 3 | 6) {
            return Err(wrong());
        }
        match numbers.contains(&0) || (0..numbers.len()).any(twice) {
            true => Err("columns are counted from 1, and each is named once".into()),
            false => Ok(Columns::Numbers(numbers)),
        }
    }
}
