//! What kind of surface a component is.

use std::collections::BTreeMap;

use super::{EdgeMap, Mesh, boundary};
use crate::error::{Error, Result};

/// The topology of a connected surface.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Topology {
    /// Whether it has two sides (a Möbius strip has one).
    pub orientable: bool,
    /// Vertices − edges + triangles.
    pub euler: i64,
    /// How many boundary loops it has.
    pub loops: usize,
}

impl Topology {
    /// Of a connected, edge- and vertex-manifold mesh.
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

    /// The genus: handles of a two-sided surface; of a one-sided one half its
    /// cross-caps (a Möbius strip: 0.5).
    pub fn genus(&self) -> f64 {
        (2 - self.loops as i64 - self.euler) as f64 / 2.0
    }

    /// Whether it is a disk with any number of holes.
    pub fn is_disk(&self) -> bool {
        self.check_disk().is_ok()
    }

    /// An error that says what it is, unless it is a disk with holes.
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

/// Counts loops whose sides need not all run the same way.
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
