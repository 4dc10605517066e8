//! What a user should know about how a cloud was read, in words.

use super::{Lost, Points};

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
            (self.not_finite, "points without finite coordinates are left out"),
            (self.at_zero, "points at exactly 0 0 0, where the scanner saw nothing, are left out"),
            (self.marked, "points that the file marks as invalid or withheld are left out"),
            (self.noise, "points of the classes of noise, 7 and 18, are left out"),
            (self.filtered, "points are left out because of the options"),
            (self.unreadable_lines, "lines without a point are left out"),
            (self.colours, "colours are not used"),
            (self.intensities, "intensities are not used"),
        ];
        let columns = match self.columns.as_slice() {
            [] => None,
            columns => Some(format!("these columns are not used: {}", columns.join(", "))),
        };
        let counted = points.into_iter().filter(|(count, _)| *count > 0);
        counted.map(|(count, what)| format!("{count} {what}")).chain(columns)
    }
}
