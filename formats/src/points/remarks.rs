//! What a user should know about how a cloud was read, in words.

use super::{Lost, Points};
use crate::words::{grouped, plural};

/// A remark names at most so many columns that are not used.
const MOST_COLUMNS: usize = 5;

impl Points {
    /// What was left out of the cloud, and what its reader decided: one sentence each, without a
    /// full stop.
    pub fn remarks(&self) -> Vec<String> {
        let notes = self.notes.iter().map(ToString::to_string);
        self.lost.remarks().chain(notes).collect()
    }
}

impl Lost {
    /// The number of points that are not valid.
    pub fn points(&self) -> u64 {
        let kinds = [self.not_finite, self.at_zero, self.marked, self.noise, self.unreadable_lines];
        kinds.into_iter().sum()
    }

    fn remarks(&self) -> impl Iterator<Item = String> {
        let points = [
            (self.not_finite, ["left out", "point", " without finite coordinates"]),
            (
                self.at_zero,
                ["left out", "point", " at exactly 0 0 0, where the scanner saw nothing"],
            ),
            (self.marked, ["left out", "point", " that the file marks as invalid or withheld"]),
            (self.noise, ["left out", "point", " of the classes of noise, 7 and 18"]),
            (self.filtered, ["left out", "point", " because of the options"]),
            (self.unreadable_lines, ["left out", "line", " without a point"]),
            (self.colours, ["not used", "colour", ""]),
            (self.intensities, ["not used", "intensity value", ""]),
        ];
        let shown = &self.columns[..self.columns.len().min(MOST_COLUMNS)];
        let more = (self.columns.len() - shown.len()) as u64 + self.more_columns;
        let columns = match (shown, more) {
            ([], _) => None,
            (columns, 0) => Some(format!("not used: the columns {}", columns.join(", "))),
            (columns, more) => {
                let more = grouped(more);
                Some(format!("not used: the columns {} and {more} more", columns.join(", ")))
            }
        };
        let counted = points.into_iter().filter(|(count, _)| *count > 0);
        let remark = |(count, [fate, name, which]): (u64, [&str; 3])| {
            format!("{fate}: {}{which}", plural(count, name))
        };
        counted.map(remark).chain(columns)
    }
}
