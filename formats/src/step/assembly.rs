//! Writer of assemblies: groups, and where they place their members (ISO 10303-44, clause 5; ISO 10303-43, clause 4).
//!
//! Each product has one shape representation. That of a group has a placement for each member. A member is a
//! `NEXT_ASSEMBLY_USAGE_OCCURRENCE` of its product, with the map from the origin of the member to its placement in the group.

use std::collections::{BTreeMap, BTreeSet};
use std::io;

use super::part21::{Id, List, Part21, Text, add};
use super::product::{ProductEntity, ProductNames, ProductWriter};
use super::shape::{self, ShapeEntity, StepColours};
use super::style;
use super::{Options, Schema};
use crate::assembly::{Assembly, AssemblyGroup, Member, Product};
use crate::number::StepReal;
use crate::scene::Placement;

/// A product and its shape.
type Written = (ProductEntity, ShapeEntity);

/// Writes all parts, then all groups.
pub(super) fn write(
    file: &mut Part21<'_>,
    assembly: &Assembly,
    options: &Options,
) -> io::Result<()> {
    let products = ProductWriter::begin(file, options)?;
    let mut ids = Identifiers::default();
    let mut parts = Vec::with_capacity(assembly.parts.len());
    for part in &assembly.parts {
        let brep = &part.brep;
        let id = ids.of(&brep.name);
        let names = ProductNames { id: &id, name: &brep.name, description: &brep.description };
        let product = products.write(file, &names)?;
        let colours = match options.schema {
            // It has no colours.
            Schema::Ap203 => StepColours::default(),
            _ => StepColours { part: part.colour, faces: &part.face_colours },
        };
        let shape = shape::write(file, brep, (product.shape, colours))?;
        parts.push((product, shape));
    }
    let space = shape::space(file, assembly.uncertainty_mm())?;
    let mut groups: Vec<Written> = Vec::with_capacity(assembly.groups.len());
    let mut occurrences = 0;
    for group in &assembly.groups {
        let id = ids.of(&group.name);
        let names = ProductNames { id: &id, name: &group.name, description: &group.description };
        let product = products.write(file, &names)?;
        let (shape, places) = group_shape(file, group, (product, space))?;
        for (member, place) in group.members.iter().zip(places) {
            let (inner, of_inner) = match member.product {
                Product::Part(part) => &parts[part],
                Product::Group(inner) => &groups[inner],
            };
            occurrences += 1;
            let used = add!(
                file,
                "NEXT_ASSEMBLY_USAGE_OCCURRENCE('{occurrences}',{},'',{},{},$)",
                Text(&member.name),
                product.definition,
                inner.definition
            )?;
            let colour = member.colour.filter(|_| options.schema != Schema::Ap203);
            occurrence(file, used, (&shape, place), (of_inner, colour))?;
        }
        groups.push((product, shape));
    }
    Ok(())
}

/// Writes the representation of a group: its origin and the placements of its members, which are returned.
fn group_shape(
    file: &mut Part21<'_>,
    group: &AssemblyGroup,
    (product, space): (ProductEntity, Id),
) -> io::Result<(ShapeEntity, Vec<Id>)> {
    let origin = shape::origin(file)?;
    let mut places = Vec::with_capacity(group.members.len());
    for Member { placement, .. } in &group.members {
        places.push(place(file, placement)?);
    }
    let items: Vec<Id> = std::iter::once(origin).chain(places.iter().copied()).collect();
    let name = Text(&group.name);
    let representation = add!(file, "SHAPE_REPRESENTATION({name},{},{space})", List(&items))?;
    add!(file, "SHAPE_DEFINITION_REPRESENTATION({},{representation})", product.shape)?;
    Ok((ShapeEntity { representation, origin, coloured: Vec::new(), space }, places))
}

/// Writes an `AXIS2_PLACEMENT_3D`.
fn place(file: &mut Part21<'_>, placement: &Placement) -> io::Result<Id> {
    let [x, _, z] = placement.axes;
    let triple = |v: [f64; 3]| {
        let [x, y, z] = v.map(StepReal);
        format!("({x},{y},{z})")
    };
    let point = add!(file, "CARTESIAN_POINT('',{})", triple(placement.translation))?;
    let z = add!(file, "DIRECTION('',{})", triple(z))?;
    let x = add!(file, "DIRECTION('',{})", triple(x))?;
    add!(file, "AXIS2_PLACEMENT_3D('',{point},{z},{x})")
}

/// Writes where a member is: the map of its origin to a placement of the group. If its colour there is another one, that
/// overrides those of its items.
fn occurrence(
    file: &mut Part21<'_>,
    used: Id,
    (group, place): (&ShapeEntity, Id),
    (member, colour): (&ShapeEntity, Option<[u8; 3]>),
) -> io::Result<()> {
    let shape = add!(file, "PRODUCT_DEFINITION_SHAPE('Placement','Placement of an item',{used})")?;
    let map = add!(file, "ITEM_DEFINED_TRANSFORMATION('','',{},{place})", member.origin)?;
    let relation = add!(
        file,
        "(REPRESENTATION_RELATIONSHIP('','',{},{})\n\
         REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({map})\n\
         SHAPE_REPRESENTATION_RELATIONSHIP())",
        member.representation,
        group.representation
    )?;
    add!(file, "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({relation},{shape})")?;
    let Some(colour) = colour.filter(|_| !member.coloured.is_empty()) else { return Ok(()) };
    let own = add!(file, "SHAPE_REPRESENTATION('',({place}),{})", member.space)?;
    add!(file, "SHAPE_DEFINITION_REPRESENTATION({shape},{own})")?;
    style::override_at(file, &member.coloured, (colour, own, member.space))
}

/// Identifiers of products: their names, with a number where a name comes again.
#[derive(Default)]
struct Identifiers {
    taken: BTreeSet<String>,
    /// The last number of each name.
    numbers: BTreeMap<String, u64>,
}

impl Identifiers {
    fn of(&mut self, name: &str) -> String {
        let number = self.numbers.entry(name.to_owned()).or_insert(0);
        loop {
            *number += 1;
            let id = if *number == 1 { name.to_owned() } else { format!("{name} ({number})") };
            if self.taken.insert(id.clone()) {
                return id;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Identifiers;

    #[test]
    fn each_product_has_its_identifier() {
        let mut ids = Identifiers::default();
        let made = ["a", "a (2)", "a", "", "a", ""].map(|name| ids.of(name));
        assert_eq!(made, ["a", "a (2)", "a (3)", "", "a (4)", " (2)"]);
    }
}
