//! Reader of STEP files.
//!
//! The input is the content of a file. The output is the trimmed faces of its shape
//! representations.

mod attributes;
mod exchange;
mod geometry;
mod spline;
mod text;
mod topology;
mod value;

use std::collections::HashSet;
use std::path::Path;

use crate::Result;
use crate::cad::CadModel;
use exchange::Exchange;
use topology::TopologyReader;

/// Reads the faces of every body in `bytes`, which is the content of the file at `path`.
pub(crate) fn read(path: &Path, bytes: &[u8]) -> Result<CadModel> {
    let file = Exchange::new(path, bytes)?;
    check_placements(&file)?;
    let mut model = CadModel::default();
    let mut seen = HashSet::new();
    let holds_shapes = |word: &str| {
        word.ends_with("SHAPE_REPRESENTATION") && word != "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION"
    };
    for representation in file.all(holds_shapes) {
        let mut attributes = file.simple(representation)?.1;
        attributes.skip(1)?;
        let items = attributes.references()?;
        let unit = unit_mm(&file, attributes.reference()?)?;
        let mut topology = TopologyReader::new(&file, unit, &mut seen);
        for item in items {
            topology.item(item, &mut model)?;
        }
    }
    if let Some(product) = file.all(|word| word == "PRODUCT").next() {
        let mut attributes = file.of_type(product, "PRODUCT")?;
        model.name = attributes.text()?;
        let label = attributes.text()?;
        if model.name.is_empty() {
            model.name = label;
        }
    }
    Ok(model)
}

/// The unit of length of a representation's context in mm. It is 1 if there is none, as in other
/// programs.
fn unit_mm(file: &Exchange, context: u64) -> Result<f64> {
    let mut entity = file.entity(context)?;
    let Some(mut assigned) = file.part(&mut entity, "GLOBAL_UNIT_ASSIGNED_CONTEXT") else {
        return Ok(1.0);
    };
    for unit in assigned.references()? {
        if let Some(metres) = length_unit(file, unit, 0)? {
            return Ok(1000.0 * metres);
        }
    }
    Ok(1.0)
}

/// The length of a unit in metres. `None` if it is not a unit of length.
fn length_unit(file: &Exchange, id: u64, depth: usize) -> Result<Option<f64>> {
    let mut entity = file.entity(id)?;
    if file.part(&mut entity, "LENGTH_UNIT").is_none() {
        return Ok(None);
    }
    let bad = |what: &str| file.error(id, format!("is a unit of length {what}"));
    if let Some(mut si) = file.part(&mut entity, "SI_UNIT") {
        let (prefix, name) = (si.word()?, si.word()?);
        let found = PREFIXES.iter().find(|(known, _)| *known == prefix);
        return match found {
            Some((_, factor)) if name == "METRE" => Ok(Some(*factor)),
            _ => Err(bad("that is unknown")),
        };
    }
    let Some(mut conversion) = file.part(&mut entity, "CONVERSION_BASED_UNIT") else {
        return Err(bad("without a length"));
    };
    conversion.skip(1)?;
    let measure = conversion.reference()?;
    let mut measure = file.entity(measure)?;
    let mut measure = ["LENGTH_MEASURE_WITH_UNIT", "MEASURE_WITH_UNIT"]
        .iter()
        .find_map(|name| file.part(&mut measure, name))
        .ok_or_else(|| bad("that is unknown"))?;
    let (factor, base) = (measure.real()?, measure.reference()?);
    if depth > 4 {
        return Err(bad("that is defined by itself"));
    }
    match length_unit(file, base, depth + 1)? {
        Some(metres) if factor > 0.0 => Ok(Some(factor * metres)),
        _ => Err(bad("that is unknown")),
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

/// Checks that no part has a placement. Faces are read in their own coordinates.
fn check_placements(file: &Exchange) -> Result<()> {
    for id in file.all(|word| word == "ITEM_DEFINED_TRANSFORMATION") {
        let mut attributes = file.of_type(id, "ITEM_DEFINED_TRANSFORMATION")?;
        attributes.skip(2)?;
        let from = placement(file, attributes.reference()?)?;
        let to = placement(file, attributes.reference()?)?;
        if from.iter().zip(&to).any(|(a, b)| (a - b).abs() > 1e-9) {
            return Err(file.unread(id, "gives a part a placement, which is not supported"));
        }
    }
    Ok(())
}

/// The coordinates of a placement's point and directions.
fn placement(file: &Exchange, id: u64) -> Result<Vec<f64>> {
    let mut attributes = file.of_type(id, "AXIS2_PLACEMENT_3D")?;
    attributes.skip(1)?;
    let mut numbers = Vec::new();
    for _ in 0..3 {
        if let Some(part) = attributes.option()? {
            let mut coordinates = file.simple(part)?.1;
            coordinates.skip(1)?;
            numbers.extend(coordinates.reals()?);
        }
    }
    Ok(numbers)
}
