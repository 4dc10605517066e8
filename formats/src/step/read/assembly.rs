//! The places of representations: the parts of an assembly.
//!
//! The input is the representations of a file and the relations between them. The output is groups of
//! representations that have the same coordinates, and the places of each group in the model. A group has the places
//! that transformations and mapped items give it. It has a place of its own only if it is no part of another one.
//! So no shape can be reached without its transformations.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::attributes::Attributes;
use super::exchange::Exchange;
use super::geometry::StepGeometry;
use super::units;
use crate::Result;
use crate::cad::CadPlace;
use crate::cad::affine::Affine;

/// The largest number of places of all groups together. It keeps the memory and the time in bounds where assemblies
/// are nested.
const MOST_PLACES: usize = 100_000;

/// A representation: a list of items in one context.
pub(super) struct Representation {
    pub(super) id: u64,
    pub(super) items: Vec<u64>,
    /// The unit of length in mm, and that of angles in radians.
    pub(super) units: [f64; 2],
    group: usize,
}

/// Representations with the same coordinates.
#[derive(Default)]
pub(super) struct Group {
    /// Their numbers.
    pub(super) members: Vec<usize>,
    /// The places in the model.
    pub(super) places: Vec<CadPlace>,
    /// Whether a product has one of them as its shape, or an assembly places it.
    pub(super) is_known: bool,
}

/// The representations of a file.
pub(super) struct PlacedParts {
    pub(super) representations: Vec<Representation>,
    pub(super) groups: Vec<Group>,
    /// Whether the file places some representation in another one.
    pub(super) has_placements: bool,
}

/// A representation that is a part of another one.
struct PartPlacement {
    /// The entity that says so.
    entity: u64,
    child: usize,
    parent: usize,
    place: Affine,
}

/// Whether an entity is a representation of a shape.
fn is_shape(word: &str) -> bool {
    word.ends_with("SHAPE_REPRESENTATION") && word != "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION"
}

/// Reads the representations of a file and their places.
pub(super) fn read(file: &Exchange) -> Result<PlacedParts> {
    let mut reader = AssemblyReader { file, representations: Vec::new(), numbers: HashMap::new() };
    for id in file.all(is_shape).collect::<Vec<_>>() {
        reader.add(id)?;
    }
    let mut placements = reader.mapped()?;
    let mapped: Vec<usize> = placements.iter().map(|placement| placement.child).collect();
    let (same, related) = reader.related()?;
    placements.extend(related);
    reader.join(&same);
    reader.check_usages(&mapped)?;
    let known = reader.known()?;
    let mut groups: Vec<Group> = Vec::new();
    groups.resize_with(reader.representations.len(), Group::default);
    for (number, representation) in reader.representations.iter().enumerate() {
        groups[representation.group].members.push(number);
        groups[representation.group].is_known |= known.contains(&representation.id);
    }
    for placement in &placements {
        groups[reader.representations[placement.child].group].is_known = true;
    }
    let has_placements = !placements.is_empty();
    reader.place(&placements, &mut groups)?;
    Ok(PlacedParts { representations: reader.representations, groups, has_placements })
}

struct AssemblyReader<'f, 'a> {
    file: &'f Exchange<'a>,
    representations: Vec<Representation>,
    /// The number of each representation.
    numbers: HashMap<u64, usize>,
}

impl<'f, 'a> AssemblyReader<'f, 'a> {
    /// Adds a representation and returns its number.
    fn add(&mut self, id: u64) -> Result<usize> {
        if let Some(&known) = self.numbers.get(&id) {
            return Ok(known);
        }
        let mut entity = self.file.entity(id)?;
        let mut attributes = if entity.records.len() > 1 {
            let missing = || self.file.unread(id, "is no representation");
            self.file.part(&mut entity, "REPRESENTATION").ok_or_else(missing)?
        } else {
            self.file.simple(id)?.1
        };
        attributes.skip(1)?;
        let items = attributes.references()?;
        let units = units::of_context(self.file, attributes.reference()?)?;
        let group = self.representations.len();
        self.representations.push(Representation { id, items, units, group });
        self.numbers.insert(id, group);
        Ok(group)
    }

    /// The places that mapped items give representations.
    fn mapped(&mut self) -> Result<Vec<PartPlacement>> {
        let mut placements = Vec::new();
        let mut parent = 0;
        while parent < self.representations.len() {
            for item in self.representations[parent].items.clone() {
                if !self.file.is_a(item, "MAPPED_ITEM") {
                    continue;
                }
                let mut attributes = self.file.of_type(item, "MAPPED_ITEM")?;
                attributes.skip(1)?;
                let (map, target) = (attributes.reference()?, attributes.reference()?);
                let mut map = self.file.of_type(map, "REPRESENTATION_MAP")?;
                let (origin, mapped) = (map.reference()?, map.reference()?);
                let child = self.add(mapped)?;
                let place = self.transform(origin, child, target, parent)?;
                placements.push(PartPlacement { entity: item, child, parent, place });
            }
            parent += 1;
        }
        Ok(placements)
    }

    /// The pairs of representations with the same coordinates, and the places that relationships give
    /// representations.
    fn related(&self) -> Result<(Vec<[usize; 2]>, Vec<PartPlacement>)> {
        let (mut same, mut placements) = (Vec::new(), Vec::new());
        let is_relation = |word: &str| {
            matches!(
                word,
                "REPRESENTATION_RELATIONSHIP"
                    | "SHAPE_REPRESENTATION_RELATIONSHIP"
                    | "REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION"
            )
        };
        for id in self.file.all(is_relation) {
            let mut entity = self.file.entity(id)?;
            let with = "REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION";
            let (ends, operator) = if entity.records.len() > 1 {
                let missing = || self.file.error(id, "relates no representations");
                let base = self.file.part(&mut entity, "REPRESENTATION_RELATIONSHIP");
                let ends = self.ends(&mut base.ok_or_else(missing)?)?;
                let operator = self.file.part(&mut entity, with);
                (ends, operator.map(|mut part| part.reference()).transpose()?)
            } else {
                let (kind, mut attributes) = self.file.simple(id)?;
                let ends = self.ends(&mut attributes)?;
                (ends, if kind == with { Some(attributes.reference()?) } else { None })
            };
            // Others relate drawings and views.
            let [Some(first), Some(second)] = ends else { continue };
            match operator {
                None => same.push([first, second]),
                Some(operator) => placements.push(self.placement(id, [first, second], operator)?),
            }
        }
        Ok((same, placements))
    }

    /// The two representations of a relationship, if they are of shapes.
    fn ends(&self, attributes: &mut Attributes) -> Result<[Option<usize>; 2]> {
        attributes.skip(2)?;
        let ends = [attributes.reference()?, attributes.reference()?];
        Ok(ends.map(|id| self.numbers.get(&id).copied()))
    }

    /// The place that a transformation gives the first of two representations in the second one.
    fn placement(
        &self,
        entity: u64,
        [child, parent]: [usize; 2],
        operator: u64,
    ) -> Result<PartPlacement> {
        let place = if self.file.is_a(operator, "ITEM_DEFINED_TRANSFORMATION") {
            let mut attributes = self.file.of_type(operator, "ITEM_DEFINED_TRANSFORMATION")?;
            attributes.skip(2)?;
            let (from, to) = (attributes.reference()?, attributes.reference()?);
            self.transform(from, child, to, parent)?
        } else {
            self.geometry(parent).operator(operator)?
        };
        Ok(PartPlacement { entity, child, parent, place })
    }

    fn geometry(&self, representation: usize) -> StepGeometry<'f, 'a> {
        let [unit, angle] = self.representations[representation].units;
        StepGeometry::new(self.file, angle).scaled(unit)
    }

    /// The map that takes an item of one representation to an item of another one.
    fn transform(&self, from: u64, child: usize, to: u64, parent: usize) -> Result<Affine> {
        let from = self.geometry(child).operator(from)?;
        Ok(self.geometry(parent).operator(to)?.compose(&from.inverse()))
    }

    /// Puts representations with the same coordinates into one group. The group has the number of its first member.
    fn join(&mut self, same: &[[usize; 2]]) {
        let mut heads: Vec<usize> = (0..self.representations.len()).collect();
        fn head(heads: &mut [usize], mut at: usize) -> usize {
            while heads[at] != at {
                heads[at] = heads[heads[at]];
                at = heads[at];
            }
            at
        }
        for &[a, b] in same {
            let (a, b) = (head(&mut heads, a), head(&mut heads, b));
            heads[a.max(b)] = a.min(b);
        }
        for number in 0..heads.len() {
            self.representations[number].group = head(&mut heads, number);
        }
    }

    /// The representations that are the shapes of products.
    fn known(&self) -> Result<Vec<u64>> {
        let ids = self.file.all(|word| word == "SHAPE_DEFINITION_REPRESENTATION");
        let representation = |id| {
            let mut attributes = self.file.of_type(id, "SHAPE_DEFINITION_REPRESENTATION")?;
            attributes.skip(1)?;
            attributes.reference()
        };
        let mut known: Vec<u64> = ids.map(representation).collect::<Result<_>>()?;
        known.sort_unstable();
        known.dedup();
        Ok(known)
    }

    /// Checks that each use of a product with a shape in another product has a place. Representations that are `mapped`
    /// have one.
    fn check_usages(&self, mapped: &[usize]) -> Result<()> {
        let file = self.file;
        // What each PRODUCT_DEFINITION_SHAPE is the shape of.
        let mut subjects = HashMap::new();
        for id in file.all(|word| word == "PRODUCT_DEFINITION_SHAPE") {
            let mut attributes = file.of_type(id, "PRODUCT_DEFINITION_SHAPE")?;
            attributes.skip(2)?;
            subjects.insert(id, attributes.reference()?);
        }
        let mut groups: HashMap<u64, Vec<usize>> = HashMap::new();
        for id in file.all(|word| word == "SHAPE_DEFINITION_REPRESENTATION") {
            let mut attributes = file.of_type(id, "SHAPE_DEFINITION_REPRESENTATION")?;
            let (shape, representation) = (attributes.reference()?, attributes.reference()?);
            if let (Some(&product), Some(&number)) =
                (subjects.get(&shape), self.numbers.get(&representation))
            {
                groups.entry(product).or_default().push(self.representations[number].group);
            }
        }
        let mut placed: HashSet<u64> = HashSet::new();
        for id in file.all(|word| word == "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION") {
            let mut attributes = file.of_type(id, "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION")?;
            let (_, shape) = (attributes.reference()?, attributes.reference()?);
            placed.extend(subjects.get(&shape));
        }
        let mapped: HashSet<usize> =
            mapped.iter().map(|&number| self.representations[number].group).collect();
        for id in file.all(|word| word == "NEXT_ASSEMBLY_USAGE_OCCURRENCE") {
            let mut attributes = file.of_type(id, "NEXT_ASSEMBLY_USAGE_OCCURRENCE")?;
            attributes.skip(4)?;
            let part = attributes.reference()?;
            let groups = groups.get(&part).into_iter().flatten();
            if !placed.contains(&id) && groups.copied().any(|group| !mapped.contains(&group)) {
                return Err(file.unread(id, "puts a part into an assembly without a place"));
            }
        }
        Ok(())
    }

    /// Computes the places of the groups, from the assemblies down to the parts.
    fn place(&self, placements: &[PartPlacement], groups: &mut [Group]) -> Result<()> {
        let of = |number: usize| self.representations[number].group;
        let mut waiting = vec![0; groups.len()];
        let mut within: Vec<Vec<&PartPlacement>> = vec![Vec::new(); groups.len()];
        for placement in placements {
            waiting[of(placement.child)] += 1;
            within[of(placement.parent)].push(placement);
        }
        let mut ready: Vec<usize> = (0..groups.len()).filter(|&g| waiting[g] == 0).collect();
        ready.iter().for_each(|&group| groups[group].places.push(CadPlace::same()));
        let (mut count, mut done) = (0, 0);
        while let Some(&group) = ready.get(done) {
            done += 1;
            for placement in &within[group] {
                let child = of(placement.child);
                count += groups[group].places.len();
                if count > MOST_PLACES {
                    let what = format!("makes more than {MOST_PLACES} places of parts");
                    return Err(self.file.unread(placement.entity, what));
                }
                let place = |outer: &CadPlace| CadPlace(outer.0.compose(&placement.place));
                let places: Vec<CadPlace> = groups[group].places.iter().map(place).collect();
                groups[child].places.extend(places);
                waiting[child] -= 1;
                if waiting[child] == 0 {
                    ready.push(child);
                }
            }
        }
        match placements.iter().find(|placement| waiting[of(placement.child)] > 0) {
            Some(placement) => {
                Err(self.file.error(placement.entity, "puts an assembly into itself"))
            }
            None => Ok(()),
        }
    }
}

impl Group {
    /// The places as the faces of the group share them.
    pub(super) fn shared_places(&self) -> Arc<[CadPlace]> {
        self.places.as_slice().into()
    }
}
