//! From elected triangles to an oriented mesh with one fan at each vertex.

use foldhash::HashSet;
use rayon::prelude::*;

use super::close;
use super::project::SurfacePoint;
use crate::geometry::sets::Sets;
use crate::geometry::{Point, VertexId};
use crate::mesh::{Mesh, VertexRings, orient};

/// A component with less than this share of all triangles is dust. Points beside the surface make
/// such components; an island in a hole is larger.
const DUST: f64 = 0.01;

/// A mesh of elected triangles, and what was dropped from it.
pub(super) struct ManifoldMesh {
    pub mesh: Mesh,
    /// The number of triangles in small components.
    pub dust: usize,
    /// The number of triangles at which the surface was cut, because it has one side only.
    pub one_sided: usize,
}

impl ManifoldMesh {
    /// Makes the mesh. Small loops are closed.
    pub(super) fn new(vertices: &[SurfacePoint], triangles: &[[u32; 3]]) -> Self {
        let points: Vec<Point> = vertices.iter().map(|v| v.place).collect();
        let triangles = triangles.iter().map(|t| t.map(VertexId)).collect();
        let mut made = ManifoldMesh::with_all_pieces(Mesh { points, triangles });
        made.drop_dust();
        made
    }

    /// Makes the mesh of triangles over all its points. Small loops are closed, but small
    /// components stay.
    pub(crate) fn with_all_pieces(mesh: Mesh) -> Self {
        let mut made = ManifoldMesh { mesh, dust: 0, one_sided: 0 };
        made.make_manifold();
        let reopened = close::small_loops(&mut made.mesh);
        if !reopened.is_empty() {
            made.make_manifold();
            close::reopened_loops(&mut made.mesh, &reopened);
        }
        made
    }

    /// Leaves one fan at each vertex, and turns triangles so that neighbours agree.
    fn make_manifold(&mut self) {
        loop {
            while keep_one_fan(&mut self.mesh) {}
            let against = orient(&mut self.mesh);
            if against.is_empty() {
                return;
            }
            self.one_sided += against.len();
            retain(&mut self.mesh, |t| against.binary_search(&t).is_err());
        }
    }

    /// Drops small components.
    fn drop_dust(&mut self) {
        let mesh = &mut self.mesh;
        let mut sets = Sets::new(mesh.points.len());
        for t in &mesh.triangles {
            sets.join(t[0].index(), t[1].index());
            sets.join(t[1].index(), t[2].index());
        }
        let mut size = vec![0usize; mesh.points.len()];
        mesh.triangles.iter().for_each(|t| size[sets.find(t[0].index())] += 1);
        let before = mesh.triangles.len();
        let least = DUST * before as f64;
        mesh.triangles.retain(|t| size[sets.find(t[0].index())] as f64 >= least);
        self.dust = before - mesh.triangles.len();
    }
}

/// Keeps the triangles with the numbers for which `stays` holds.
pub(super) fn retain(mesh: &mut Mesh, stays: impl Fn(usize) -> bool) {
    let mut t = 0;
    mesh.triangles.retain(|_| {
        t += 1;
        stays(t - 1)
    });
}

/// Where a vertex has several fans of triangles, the largest stays. Returns whether there was one.
fn keep_one_fan(mesh: &mut Mesh) -> bool {
    let rings = VertexRings::new(mesh);
    let vertices = (0..mesh.points.len()).into_par_iter();
    let dropped: HashSet<usize> =
        vertices.flat_map_iter(|v| lesser_fans(mesh, &rings, VertexId::from(v))).collect();
    retain(mesh, |t| !dropped.contains(&t));
    !dropped.is_empty()
}

/// The triangles of all fans at a vertex but the largest. The first one counts as the largest of
/// equal ones.
fn lesser_fans(mesh: &Mesh, rings: &VertexRings, v: VertexId) -> Vec<usize> {
    let around = rings.triangles(v);
    let corners = |a: usize| mesh.triangles[around[a] as usize];
    let share_edge = |a, b| corners(a).iter().any(|w| *w != v && corners(b).contains(w));
    // Triangles in the order of their fans; a fan grows until nothing is next to it.
    let mut left: Vec<usize> = (0..around.len()).collect();
    let mut fans: Vec<Vec<usize>> = Vec::new();
    while let Some(first) = (!left.is_empty()).then(|| left.remove(0)) {
        let mut fan = vec![first];
        let mut done = 0;
        while let Some(&a) = fan.get(done) {
            done += 1;
            left.retain(|&b| {
                let joins = share_edge(a, b);
                if joins {
                    fan.push(b);
                }
                !joins
            });
        }
        fans.push(fan);
    }
    let most = fans.iter().map(Vec::len).max();
    if let Some(largest) = fans.iter().position(|fan| Some(fan.len()) == most) {
        fans.remove(largest);
    }
    fans.into_iter().flatten().map(|a| around[a] as usize).collect()
}
