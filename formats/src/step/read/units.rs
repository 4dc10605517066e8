//! Reader of units of length and of plane angles.

use super::exchange::Exchange;
use crate::Result;

/// The units of a representation's context: the unit of length in mm, and that of angles in
/// radians. They are 1 if there is none, as in other programs.
pub(super) fn of_context(file: &Exchange, context: u64) -> Result<[f64; 2]> {
    let mut units = [1.0; 2];
    let mut entity = file.entity(context)?;
    let Some(mut assigned) = file.part(&mut entity, "GLOBAL_UNIT_ASSIGNED_CONTEXT") else {
        return Ok(units);
    };
    // The first unit of each kind counts.
    let mut found = [false; 2];
    for id in assigned.references()? {
        for (k, kind) in [LENGTH, ANGLE].iter().enumerate() {
            if let (false, Some(size)) = (found[k], kind.size(file, id, 0)?) {
                units[k] = kind.scale * size;
                found[k] = true;
            }
        }
    }
    Ok(units)
}

/// A kind of units.
struct UnitKind {
    /// The type of its units.
    name: &'static str,
    /// What it measures, for messages.
    measures: &'static str,
    /// The fault of a unit without a size, for messages.
    missing: &'static str,
    /// The name of the SI unit.
    si: &'static str,
    /// The types that state the size of other units.
    sizes: [&'static str; 2],
    /// The SI unit in our units.
    scale: f64,
}

const LENGTH: UnitKind = UnitKind {
    name: "LENGTH_UNIT",
    measures: "length",
    missing: "without a length",
    si: "METRE",
    sizes: ["LENGTH_MEASURE_WITH_UNIT", "MEASURE_WITH_UNIT"],
    scale: 1000.0,
};

const ANGLE: UnitKind = UnitKind {
    name: "PLANE_ANGLE_UNIT",
    measures: "angle",
    missing: "without an angle",
    si: "RADIAN",
    sizes: ["PLANE_ANGLE_MEASURE_WITH_UNIT", "MEASURE_WITH_UNIT"],
    scale: 1.0,
};

impl UnitKind {
    /// The size of a unit in SI units. `None` if it is of another kind.
    fn size(&self, file: &Exchange, id: u64, depth: usize) -> Result<Option<f64>> {
        let mut entity = file.entity(id)?;
        if file.part(&mut entity, self.name).is_none() {
            return Ok(None);
        }
        let bad = |what: &str| file.error(id, format!("is a unit of {} {what}", self.measures));
        if let Some(mut si) = file.part(&mut entity, "SI_UNIT") {
            let (prefix, name) = (si.word()?, si.word()?);
            let found = PREFIXES.iter().find(|(known, _)| *known == prefix);
            return match found {
                Some((_, factor)) if name == self.si => Ok(Some(*factor)),
                _ => Err(bad("that is unknown")),
            };
        }
        let Some(mut conversion) = file.part(&mut entity, "CONVERSION_BASED_UNIT") else {
            return Err(bad(self.missing));
        };
        conversion.skip(1)?;
        let measure = conversion.reference()?;
        let mut measure = file.entity(measure)?;
        let mut measure = (self.sizes.iter())
            .find_map(|name| file.part(&mut measure, name))
            .ok_or_else(|| bad("that is unknown"))?;
        let (factor, base) = (measure.real()?, measure.reference()?);
        if depth > 4 {
            return Err(bad("that is defined by itself"));
        }
        match self.size(file, base, depth + 1)? {
            Some(size) if factor > 0.0 => Ok(Some(factor * size)),
            _ => Err(bad("that is unknown")),
        }
    }
}

const PREFIXES: [(&str, f64); 8] = [
    ("", 1.0),
    ("MILLI", 1e-3),
    ("CENTI", 1e-2),
    ("DECI", 1e-1),
    ("KILO", 1e3),
    ("MICRO", 1e-6),
    ("NANO", 1e-9),
    ("HECTO", 1e2),
];
