//! The topology of a component: orientability, Euler characteristic and number of boundary loops.

use std::collections::BTreeMap;

use super::{EdgeMap, Mesh, boundary};
use crate::error::{Error, Result};

/// The topology of a connected surface.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Topology {
    /// Whether the surface has two sides. A Möbius strip has one.
    pub orientable: bool,
    /// Vertices − edges + triangles.
    pub euler: i64,
    /// The number of boundary loops.
    pub loops: usize,
}

impl Topology {
    /// The topology of a connected mesh that is edge- and vertex-manifold.
    pub(super) fn new(mesh: &Mesh, edges: &EdgeMap, orientable: bool) -> Self {
        let open = edges.open_sides().count();
        let edge_count = (3 * mesh.triangles.len() + open) / 2;
        let euler = (mesh.points.len() + mesh.triangles.len()) as i64 - edge_count as i64;
        let loops = if orientable {
            boundary::boundary_loops(mesh, edges).len()
        } else {
            unoriented_loops(mesh, edges)
        };
        Topology { orientable, euler, loops }
    }

    /// The genus. For a two-sided surface it is the number of handles. For a one-sided surface it
    /// is half the number of cross-caps, so a Möbius strip has 0.5.
    pub fn genus(&self) -> f64 {
        (2 - self.loops as i64 - self.euler) as f64 / 2.0
    }

    /// Whether the surface is a disk with any number of holes.
    pub fn is_disk(&self) -> bool {
        self.check_disk().is_ok()
    }

    /// Succeeds for a disk with any number of holes.
    ///
    /// # Errors
    /// [`Error::NotOrientable`] for a one-sided surface, [`Error::NotADisk`] for a closed surface
    /// or one with handles.
    pub fn check_disk(&self) -> Result<()> {
        if !self.orientable {
            return Err(Error::NotOrientable);
        }
        if self.genus() > 0.0 || self.loops == 0 {
            return Err(Error::NotADisk { genus: self.genus() as usize, loops: self.loops });
        }
        Ok(())
    }
}

/// Counts boundary loops of a mesh whose triangles are not consistently oriented.
fn unoriented_loops(mesh: &Mesh, edges: &EdgeMap) -> usize {
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for side in edges.open_sides() {
        let t = mesh.triangles[side / 3];
        let (a, b) = (t[side % 3].0, t[(side % 3 + 1) % 3].0);
        next.entry(a).or_default().push(b);
        next.entry(b).or_default().push(a);
    }
    let mut loops = 0;
    while let Some((_, mut front)) = next.pop_first() {
        loops += 1;
        while let Some(v) = front.pop() {
            front.extend(next.remove(&v).into_iter().flatten());
        }
    }
    loops
}
