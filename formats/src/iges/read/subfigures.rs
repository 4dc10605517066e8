//! The places of subfigures (308): instances of them (408), which may be in other subfigures.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::deck::Deck;
use super::geometry::IgesGeometry;
use super::parameters::Parameters;
use crate::Result;
use crate::cad::CadPlace;
use crate::cad::affine::Affine;

/// The largest number of places of all subfigures together. It keeps the memory and the time in bounds where
/// subfigures are nested.
const MOST_PLACES: usize = 100_000;

/// Where the members of subfigures are.
pub(super) struct Subfigures {
    /// The subfigures that each entity is a member of.
    owners: HashMap<i64, Vec<i64>>,
    definitions: HashSet<i64>,
    places: HashMap<i64, Arc<[CadPlace]>>,
    same: Arc<[CadPlace]>,
}

/// An instance of a subfigure.
struct SubfigureInstance {
    pointer: i64,
    subfigure: i64,
    place: Affine,
}

impl Subfigures {
    /// Reads the subfigures and their instances in a file whose unit is `unit_mm`.
    pub(super) fn read(deck: &Deck, unit_mm: f64) -> Result<Self> {
        let entries = || (1..).step_by(2).zip(&deck.directory);
        let mut owners: HashMap<i64, Vec<i64>> = HashMap::new();
        let mut members: HashMap<i64, Vec<i64>> = HashMap::new();
        for (pointer, entry) in entries() {
            let mut p = match entry.kind {
                308 => deck.parameters(pointer)?,
                // What a group holds belongs to the subfigure that has the group.
                402 if matches!(entry.form, 1 | 7 | 14 | 15) => deck.parameters(pointer)?,
                _ => continue,
            };
            if entry.kind == 308 {
                p.skip(2);
            }
            let count = p.count()?;
            members.insert(pointer, p.several(count, Parameters::integer)?);
        }
        for (&owner, members) in &members {
            members.iter().for_each(|&member| owners.entry(member).or_default().push(owner));
        }
        owners.values_mut().for_each(|owners| owners.sort_unstable());
        let geometry = IgesGeometry::new(deck);
        let mut instances = Vec::new();
        for (pointer, _) in entries().filter(|(_, entry)| entry.kind == 408 && entry.visible) {
            let mut p = deck.parameters(pointer)?;
            let (subfigure, shift, scale) = (p.integer()?, p.point()?, p.real()?);
            if deck.entry(subfigure)?.kind != 308 {
                let what = format!("is an instance of entity {subfigure}, which is no subfigure");
                return Err(deck.error(pointer, what));
            }
            // A factor that is left out is 1.
            let scale = if scale == 0.0 { 1.0 } else { scale };
            let own = Affine { shift: shift.map(|x| x / scale), ..Affine::scaling(scale) };
            let place = geometry.place(pointer, &Affine::scaling(1.0))?.compose(&own);
            instances.push(SubfigureInstance { pointer, subfigure, place });
        }
        let in_mm = Affine::scaling(unit_mm);
        let mut found = Subfigures {
            owners,
            definitions: entries().filter(|(_, e)| e.kind == 308).map(|(at, _)| at).collect(),
            places: HashMap::new(),
            same: Arc::new([CadPlace::same()]),
        };
        for (subfigure, places) in found.spread(deck, &members, &instances)? {
            let of_mm = |place: &Affine| CadPlace(in_mm.compose(place).compose(&in_mm.inverse()));
            found.places.insert(subfigure, places.iter().map(of_mm).collect());
        }
        Ok(found)
    }

    /// The places of subfigures and groups, from the outer ones to the inner ones.
    fn spread(
        &self,
        deck: &Deck,
        members: &HashMap<i64, Vec<i64>>,
        instances: &[SubfigureInstance],
    ) -> Result<HashMap<i64, Vec<Affine>>> {
        // What has places: subfigures and groups. Each waits for the instances of it, and for its owners.
        let mut places: HashMap<i64, Vec<Affine>> = HashMap::new();
        let mut waits: HashMap<i64, usize> = members.keys().map(|&at| (at, 0)).collect();
        let mut leads: HashMap<i64, Vec<(i64, Option<&SubfigureInstance>)>> = HashMap::new();
        let mut ready = Vec::new();
        for instance in instances {
            match self.owners.get(&instance.pointer) {
                None => places.entry(instance.subfigure).or_default().push(instance.place),
                Some(owners) => owners.iter().for_each(|&owner| {
                    leads.entry(owner).or_default().push((instance.subfigure, Some(instance)));
                    *waits.entry(instance.subfigure).or_insert(0) += 1;
                }),
            }
        }
        let mut groups: Vec<i64> =
            members.keys().copied().filter(|at| !self.definitions.contains(at)).collect();
        groups.sort_unstable();
        for group in groups {
            match self.owners.get(&group) {
                None => places.entry(group).or_default().push(Affine::scaling(1.0)),
                Some(owners) => owners.iter().for_each(|&owner| {
                    leads.entry(owner).or_default().push((group, None));
                    *waits.entry(group).or_insert(0) += 1;
                }),
            }
        }
        ready.extend(waits.iter().filter(|(_, count)| **count == 0).map(|(&at, _)| at));
        ready.sort_unstable();
        let (mut count, mut done) = (0, 0);
        while let Some(&at) = ready.get(done) {
            done += 1;
            let outer = places.get(&at).cloned().unwrap_or_default();
            for &(inner, instance) in leads.get(&at).into_iter().flatten() {
                count += outer.len();
                if count > MOST_PLACES {
                    let what = format!("makes more than {MOST_PLACES} places of parts");
                    return Err(deck.unread(at, what));
                }
                let place = |outer: &Affine| {
                    instance.map_or(*outer, |instance| outer.compose(&instance.place))
                };
                places.entry(inner).or_default().extend(outer.iter().map(place));
                if let Some(left) = waits.get_mut(&inner) {
                    *left -= 1;
                    if *left == 0 {
                        ready.push(inner);
                    }
                }
            }
        }
        match waits.iter().filter(|(_, left)| **left > 0).map(|(&at, _)| at).min() {
            Some(at) => Err(deck.error(at, "is a subfigure in itself")),
            None => Ok(places),
        }
    }

    /// The places of an entity: those of the subfigures that have it, or the place that it has by itself. There are
    /// none if no instance shows it.
    pub(super) fn places(&self, pointer: i64) -> Arc<[CadPlace]> {
        match self.owners.get(&pointer).map(Vec::as_slice) {
            None => self.same.clone(),
            Some([owner]) => self.places.get(owner).cloned().unwrap_or_default(),
            Some(owners) => {
                let of_owners = owners.iter().filter_map(|owner| self.places.get(owner));
                of_owners.flat_map(|places| places.iter().copied()).collect()
            }
        }
    }

    /// Whether a subfigure has an entity, itself and not in a group.
    pub(super) fn has(&self, pointer: i64) -> bool {
        let mut owners = self.owners.get(&pointer).into_iter().flatten();
        owners.any(|owner| self.definitions.contains(owner))
    }

    /// Whether something is in several places.
    pub(super) fn are_there(&self) -> bool {
        !self.owners.is_empty() && self.places.values().any(|places| places.len() > 1)
    }
}
