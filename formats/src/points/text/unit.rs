//! The unit of length that a header names beside its columns, as in "x [m], y [m], z [m]".

use super::words;
use crate::LengthUnit;
use crate::points::Column;

/// The unit of the coordinates in a header. `None` if it names none, or not one for all three.
pub(super) fn of_header(line: &[u8]) -> Option<LengthUnit> {
    let mut units = [None; 3];
    let mut axis = None;
    for word in words(line) {
        let word = std::str::from_utf8(word).ok()?;
        // A unit in brackets stands at the end of a column's name, or is the word after it.
        let (name, unit) = word.split_once(['[', '(']).map_or((word, None), |(n, u)| (n, Some(u)));
        if !name.is_empty() {
            let name = name.trim_start_matches(['#', '/', '%', '!']);
            axis = match Column::named(name) {
                Column::Position(axis) => Some(axis),
                _ => None,
            };
        }
        if let (Some(axis), Some(unit)) = (axis, unit) {
            units[axis] = LengthUnit::by_symbol(unit.trim_end_matches([']', ')']));
        }
    }
    units[0].filter(|_| units[0] == units[1] && units[0] == units[2])
}

#[cfg(test)]
mod tests {
    use super::of_header;
    use crate::LengthUnit::{Inch, Metre, Millimetre};

    #[test]
    fn a_header_names_the_unit_of_its_coordinates() {
        for (line, unit) in [
            ("x[m],y[m],z[m]", Some(Metre)),
            ("\"X (mm)\";\"Y (mm)\";\"Z (mm)\";Intensity", Some(Millimetre)),
            ("#id t[s] x [in] y [in] z [in]", Some(Inch)),
            ("x[m],y[m],z[mm]", None),
            ("x[m],y,z", None),
            ("x[parsec] y[parsec] z[parsec]", None),
            ("x y z", None),
        ] {
            assert_eq!(of_header(line.as_bytes()), unit, "{line}");
        }
    }
}
