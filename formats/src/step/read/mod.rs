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
mod units;
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
        let units = units::of_context(&file, attributes.reference()?)?;
        let mut topology = TopologyReader::new(&file, units, &mut seen);
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
