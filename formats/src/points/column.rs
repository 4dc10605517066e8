//! What the columns of a cloud hold, by their names.

use super::Lost;

/// So many names of lost columns are kept. No scanner writes more, and a hostile
/// file may have any number.
const MOST_NAMES: usize = 100;

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Column {
    /// A coordinate, by its axis.
    Position(usize),
    /// A component of the normal, by its axis.
    Normal(usize),
    Colour,
    Intensity,
    Other,
}

impl Column {
    /// What a column of this name holds. Quotes, units in brackets and the case
    /// of the letters do not matter.
    pub(crate) fn named(name: &str) -> Column {
        let name = plain_name(name);
        let name = name.strip_prefix("scalar_").unwrap_or(&name);
        let axis = |of: [&[&str]; 3]| of.iter().position(|names| names.contains(&name));
        if let Some(axis) = axis([
            &["x", "pos_x", "posx", "position_x", "easting", "east", "points:0"],
            &["y", "pos_y", "posy", "position_y", "northing", "north", "points:1"],
            &["z", "pos_z", "posz", "position_z", "elevation", "height", "points:2"],
        ]) {
            return Column::Position(axis);
        }
        if let Some(axis) = axis([
            &["nx", "n_x", "normal_x", "normalx", "normals_x"],
            &["ny", "n_y", "normal_y", "normaly", "normals_y"],
            &["nz", "n_z", "normal_z", "normalz", "normals_z"],
        ]) {
            return Column::Normal(axis);
        }
        let channel = name.strip_prefix("diffuse_").unwrap_or(name);
        match channel {
            "r" | "g" | "b" | "red" | "green" | "blue" | "alpha" | "rgb" | "rgba" => Column::Colour,
            "i" | "intensity" | "reflectance" | "reflectivity" | "amplitude" => Column::Intensity,
            _ => Column::Other,
        }
    }

    /// The axis of a column of longitudes or latitudes, by its name.
    pub(crate) fn degrees(name: &str) -> Option<usize> {
        match plain_name(name).as_str() {
            "lon" | "long" | "lng" | "longitude" => Some(0),
            "lat" | "latitude" => Some(1),
            _ => None,
        }
    }
}

/// The name of a column in small letters, without quotes and without a unit in brackets.
pub(crate) fn plain_name(name: &str) -> String {
    let name = name.trim_matches(['"', '\'']).trim().to_ascii_lowercase();
    name.split(['(', '[']).next().unwrap_or_default().trim_end().to_owned()
}

impl Lost {
    /// Counts what `points` points had in columns of these names.
    pub(crate) fn count<'a>(&mut self, names: impl Iterator<Item = &'a str>, points: u64) {
        for name in names {
            match Column::named(name) {
                Column::Position(_) | Column::Normal(_) => {}
                Column::Colour => self.colours = points,
                Column::Intensity => self.intensities = points,
                Column::Other if self.columns.len() < MOST_NAMES => {
                    self.columns.push(crate::token::excerpt(name.as_bytes()));
                }
                Column::Other => self.more_columns += 1,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Column;

    #[test]
    fn longitudes_and_latitudes_are_known() {
        for (name, axis) in [("Lon", Some(0)), ("\"latitude (deg)\"", Some(1)), ("latch", None)] {
            assert_eq!(Column::degrees(name), axis, "{name}");
        }
    }

    #[test]
    fn names_are_known_in_any_spelling() {
        for (name, column) in [
            ("X", Column::Position(0)),
            ("\"y\"", Column::Position(1)),
            ("Z [m]", Column::Position(2)),
            ("Northing", Column::Position(1)),
            ("normal_y", Column::Normal(1)),
            ("Nz", Column::Normal(2)),
            ("diffuse_red", Column::Colour),
            ("Scalar_Intensity", Column::Intensity),
            ("label", Column::Other),
            ("", Column::Other),
        ] {
            assert_eq!(Column::named(name), column, "{name}");
        }
    }
}
