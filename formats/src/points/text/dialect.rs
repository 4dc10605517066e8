//! How a text file separates its numbers, and how it writes decimals.

use crate::token::plain_number;

/// How the columns of a text file are told apart. White space always separates,
/// and one more character may.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Dialect {
    /// Ends a field even if nothing is in it.
    separator: Option<u8>,
    pub(super) decimal_commas: bool,
}

impl Dialect {
    /// The dialect of a file that has `lines` of numbers.
    ///
    /// Semicolons and bars are always separators, and commas beside them are
    /// decimal ones. Without them commas are decimal ones if white space already
    /// separates three or more numbers, none of which has two commas, and each
    /// comma stands between digits.
    pub(super) fn of<'a>(lines: impl Iterator<Item = &'a [u8]> + Clone) -> Dialect {
        let has = |byte: u8| lines.clone().any(|line| line.contains(&byte));
        let separator = [b';', b'|'].into_iter().find(|&byte| has(byte));
        if separator.is_some() {
            return Dialect { separator, decimal_commas: has(b',') };
        }
        if !has(b',') {
            return Dialect { separator: None, decimal_commas: false };
        }
        let decimal_commas = lines.clone().all(has_decimal_commas);
        Dialect { separator: (!decimal_commas).then_some(b','), decimal_commas }
    }

    /// Whether commas separate the numbers, but seem to be decimal ones as well:
    /// no number has a decimal point, and one begins with a zero as fractions do.
    pub(super) fn mixes_commas<'a>(&self, mut lines: impl Iterator<Item = &'a [u8]>) -> bool {
        let is_fraction = |field: &[u8]| {
            field.len() > 1 && field[0] == b'0' && field.iter().all(u8::is_ascii_digit)
        };
        let mut found = false;
        let no_points = lines.all(|line| {
            found |= self.fields(line).any(is_fraction);
            !line.contains(&b'.')
        });
        self.has_comma_columns() && no_points && found
    }

    /// Whether commas separate the columns.
    pub(super) fn has_comma_columns(&self) -> bool {
        self.separator == Some(b',')
    }

    /// The fields of a line, some of which may be empty.
    pub(super) fn fields<'a>(&self, line: &'a [u8]) -> impl Iterator<Item = &'a [u8]> + Clone {
        let separator = self.separator;
        let line = line.trim_ascii();
        // Many programs end each line with a separator.
        let last = line.last().copied();
        let line = if last.is_some() && last == separator { &line[..line.len() - 1] } else { line };
        line.split(move |&byte| Some(byte) == separator).flat_map(|piece| {
            let piece = piece.trim_ascii();
            let words = piece.split(u8::is_ascii_whitespace);
            words.filter(move |word| !word.is_empty() || piece.is_empty())
        })
    }

    /// What stands between the separators of a line of names, blanks included. Empty without a separator.
    pub(super) fn names(&self, line: &[u8]) -> Vec<String> {
        let line = super::unmarked(line);
        let cells = line.split(|&byte| Some(byte) == self.separator);
        let name = |cell| String::from_utf8_lossy(cell).trim().trim_matches('"').to_owned();
        self.separator.map_or_else(Vec::new, |_| cells.map(name).collect())
    }

    /// The number in a field, which may not be finite.
    pub(super) fn number(&self, field: &[u8]) -> Option<f64> {
        let text = std::str::from_utf8(field).ok()?.trim_matches('"');
        if self.decimal_commas && text.contains(',') {
            return parse(&text.replacen(',', ".", 1));
        }
        parse(text)
    }
}

fn parse(text: &str) -> Option<f64> {
    text.parse().ok().or_else(|| plain_number(text).parse().ok())
}

/// Whether commas in this line can only be decimal ones.
fn has_decimal_commas(line: &[u8]) -> bool {
    let words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let inner = |word: &[u8]| {
        let mut commas = word.iter().enumerate().filter(|(_, b)| **b == b',');
        let Some((at, _)) = commas.next() else { return true };
        let is_digit = |i: usize| word.get(i).is_some_and(u8::is_ascii_digit);
        commas.next().is_none() && at > 0 && is_digit(at - 1) && is_digit(at + 1)
    };
    words.clone().count() >= 3 && words.clone().all(inner)
}
