//! A mesh known to be a disk with holes.

use super::boundary::{self, Loop};
use super::kind::Topology;
use super::{EdgeMap, Mesh};
use crate::error::Result;
use crate::geometry::Point;

/// Which boundary loop is the outer one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Outer {
    /// The longest.
    #[default]
    Longest,
    /// The one with the vertex nearest to this point.
    Near(Point),
}

/// An oriented mesh of genus 0 with at least one boundary loop.
#[derive(Debug, Clone)]
pub struct Disk {
    /// The triangles and points.
    pub mesh: Mesh,
    /// The outer boundary loop, the surface to its left.
    pub outer: Loop,
    /// The rims of the holes, the surface to their left, in the order of
    /// their lowest vertices.
    pub holes: Vec<Loop>,
}

impl Disk {
    /// Checks the topology of a connected, oriented mesh by its Euler
    /// characteristic.
    pub fn new(mesh: Mesh, outer: Outer) -> Result<Self> {
        let edges = EdgeMap::new(&mesh);
        Topology::new(&mesh, &edges, true).check_disk()?;
        let mut loops = boundary::boundary_loops(&mesh, &edges);
        let outer = loops.remove(outer.among(&mesh, &loops));
        Ok(Disk { mesh, outer, holes: loops })
    }

    /// All loops, the outer one first.
    pub fn loops(&self) -> impl Iterator<Item = &Loop> {
        std::iter::once(&self.outer).chain(&self.holes)
    }
}

impl Outer {
    /// The position of the outer loop among all.
    pub fn among(self, mesh: &Mesh, loops: &[Loop]) -> usize {
        let badness = |ring: &Loop| match self {
            Outer::Longest => -boundary::length(mesh, ring),
            Outer::Near(p) => {
                let distances = ring.iter().map(|&v| (mesh.point(v) - p).norm_squared());
                distances.fold(f64::INFINITY, f64::min)
            }
        };
        let badnesses: Vec<f64> = loops.iter().map(badness).collect();
        let best = (0..loops.len()).min_by(|&i, &j| badnesses[i].total_cmp(&badnesses[j]));
        best.unwrap_or(0)
    }
}
