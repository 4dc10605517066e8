//! A mesh known to be a disk with holes.

use super::boundary::{self, Loop};
use super::{EdgeMap, Mesh};
use crate::error::{Error, Result};

/// An oriented mesh of genus 0 with at least one boundary loop.
#[derive(Debug, Clone)]
pub struct Disk {
    /// The triangles and points.
    pub mesh: Mesh,
    /// The longest boundary loop, the surface to its left.
    pub outer: Loop,
    /// The rims of the holes, the surface to their left, in the order of
    /// their lowest vertices.
    pub holes: Vec<Loop>,
}

impl Disk {
    /// Checks the topology of a connected mesh by its Euler characteristic.
    pub fn new(mesh: Mesh) -> Result<Self> {
        let edges = EdgeMap::new(&mesh);
        let mut loops = boundary::boundary_loops(&mesh, &edges);
        let open = edges.open_sides().count();
        let edge_count = (3 * mesh.triangles.len() + open) / 2;
        let euler = (mesh.points.len() + mesh.triangles.len()) as i64 - edge_count as i64;
        let genus = (2 - loops.len() as i64 - euler).max(0) as usize / 2;
        if genus > 0 || loops.is_empty() {
            return Err(Error::NotADisk { genus, loops: loops.len() });
        }
        let longest = longest(&mesh, &loops);
        let outer = loops.remove(longest);
        Ok(Disk { mesh, outer, holes: loops })
    }

    /// All loops, the outer one first.
    pub fn loops(&self) -> impl Iterator<Item = &Loop> {
        std::iter::once(&self.outer).chain(&self.holes)
    }
}

fn longest(mesh: &Mesh, loops: &[Loop]) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (i, ring) in loops.iter().enumerate() {
        let length = boundary::length(mesh, ring);
        if length > best.1 {
            best = (i, length);
        }
    }
    best.0
}
