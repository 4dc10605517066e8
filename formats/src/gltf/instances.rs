//! The instances of a node (`EXT_mesh_gpu_instancing`).

use super::scene::bad;
use super::{Gear, accessor, transform};
use crate::Result;
use crate::scene::{MOST_NODES, Placement};

/// The places of the instances of node `index`, relative to the node. `None` if it has no such extension.
pub(super) fn read(gear: &mut Gear<'_>, index: usize) -> Result<Option<Vec<Placement>>> {
    let Some(attributes) = gear.extras.instances.get(&index).cloned() else { return Ok(None) };
    let named = |name: &str| attributes.get(name).copied();
    let [moved, turned, scaled] = ["TRANSLATION", "ROTATION", "SCALE"].map(named);
    let counts = [moved, turned, scaled].into_iter().flatten();
    let mut counts = counts.map(|at| accessor::count(gear, at).unwrap_or(0));
    let Some(count) = counts.next() else { return Ok(None) };
    if counts.any(|other| other != count) {
        return Err(bad(gear, "node", index, "has instances whose attributes differ in count"));
    }
    if count > MOST_NODES as u64 {
        return Err(bad(gear, "node", index, "has more than 100,000 instances"));
    }
    let count = count as usize;
    let moved = moved.map_or(Ok(vec![[0.0; 3]; count]), |at| accessor::positions(gear, at))?;
    let turned =
        turned.map_or(Ok(vec![[0.0, 0.0, 0.0, 1.0]; count]), |at| accessor::rotations(gear, at))?;
    let scaled = scaled.map_or(Ok(vec![[1.0; 3]; count]), |at| accessor::positions(gear, at))?;
    let places = moved.into_iter().zip(turned).zip(scaled);
    let places: Vec<Placement> = places
        .map(|((moved, turned), scaled)| transform::of_parts(moved, turned, scaled))
        .collect();
    match places.iter().all(Placement::is_finite) {
        true => Ok(Some(places)),
        false => {
            Err(bad(gear, "node", index, "has an instance that is scaled or moved to infinity"))
        }
    }
}
