//! Reader of STEP files.
//!
//! The input is the content of a file. The output is the trimmed faces of its shape
//! representations, at their places in the assembly.

mod assembly;
mod attributes;
mod curves;
mod exchange;
mod geometry;
mod items;
mod names;
mod spline;
mod surfaces;
mod text;
mod topology;
mod units;
mod value;

use std::collections::HashSet;
use std::path::Path;

use crate::Result;
use crate::cad::CadModel;
use exchange::Exchange;
use topology::{SeenParts, TopologyReader};

/// Reads the faces of every body in `bytes`, which is the content of the file at `path`.
pub(crate) fn read(path: &Path, bytes: &[u8]) -> Result<CadModel> {
    let file = Exchange::new(path, bytes)?;
    let assembly = assembly::read(&file)?;
    let mut model = CadModel::default();
    let (mut seen, mut seen_items) = (SeenParts::default(), HashSet::new());
    // In an assembly, what nothing places comes last. It may list again what parts have.
    let is_lost = |known: bool| assembly.has_placements && !known;
    for lost in [false, true] {
        for group in assembly.groups.iter().filter(|group| is_lost(group.is_known) == lost) {
            let places = (!lost).then(|| group.shared_places());
            let mut seen_here = HashSet::new();
            for representation in group.members.iter().map(|&n| &assembly.representations[n]) {
                let units = representation.units;
                let mut topology = TopologyReader::new(&file, units, places.clone(), &mut seen);
                for &item in &representation.items {
                    if seen_here.insert(item) && (!lost || seen_items.insert(item)) {
                        seen_items.insert(item);
                        topology.item(item, &mut model)?;
                    }
                }
            }
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
