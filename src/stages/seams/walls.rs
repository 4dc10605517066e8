//! Walls: surfaces that stand on the faces of an open shell along its rims. A free edge is the seam of its face and a wall.
//! Walls have no triangles, and become no faces.

use super::network::{Chain, ChainNetwork, ChainUse};
use super::rims::OFF_RIM;
use super::stretches::{RimStretches, WallKind};
use super::{FacePatch, FacetForm, Work};
use crate::geometry::{Point, Vector, plane_axes};
use crate::primitives::Primitive;

impl Work<'_> {
    /// Whether the mesh has boundary loops.
    pub(super) fn is_open(&self) -> bool {
        !self.stretches.kinds.is_empty()
    }

    /// Divides the rims of an open mesh.
    pub(super) fn find_stretches(&mut self) {
        let Work { mesh, edges, errors, patches, of_triangle, .. } = &*self;
        self.stretches = RimStretches::of(mesh, edges, errors, patches, of_triangle);
    }

    /// Stands for the wall of a boundary side before there are walls: beyond the numbers of all patches.
    pub(super) fn stretch_across(&self, side: usize) -> usize {
        self.stretches.of_side.get(&side).map_or(usize::MAX, |stretch| usize::MAX - 1 - stretch)
    }

    /// Whether a patch is a wall.
    pub(super) fn is_wall(&self, patch: usize) -> bool {
        self.patches[patch].triangles.is_empty()
    }

    /// Gives each free chain a wall.
    pub(super) fn add_walls(&mut self, network: &mut ChainNetwork) {
        for chain in &mut network.chains {
            if chain.right < self.patches.len() {
                continue;
            }
            let stretch = usize::MAX - 1 - chain.right;
            let kind = self.stretches.kinds.get(stretch).copied().unwrap_or(WallKind::Bow);
            let surface = self.wall(kind, chain, &chain.points);
            chain.right = self.patches.len();
            let triangles = Vec::new();
            self.patches.push(FacePatch {
                surface,
                side: 1.0,
                is_facet: true,
                form: FacetForm::Flat,
                triangles,
            });
            self.tries.push(0);
            self.walls.push(kind);
        }
        network.loops.resize(self.patches.len(), Vec::new());
    }

    /// Takes the walls away.
    pub(super) fn drop_walls(&mut self) {
        self.walls.clear();
        let mut is_face = self.patches.iter().map(|patch| !patch.triangles.is_empty());
        self.tries.retain(|_| is_face.next().unwrap_or(true));
        self.patches.retain(|patch| !patch.triangles.is_empty());
    }

    /// The free chains, each with what its wall is.
    fn free_chains<'a>(
        &self,
        network: &'a ChainNetwork,
    ) -> impl Iterator<Item = (&'a Chain, WallKind)> + use<'a, '_> {
        let first = self.patches.len() - self.walls.len();
        let kind = move |of: &Chain| of.right.checked_sub(first).map(|k| self.walls[k]);
        network.chains.iter().filter_map(move |of| Some((of, kind(of)?)))
    }

    /// Adds the planes of rims to the patches that hold their vertices.
    pub(super) fn hold_at_rims(&self, network: &ChainNetwork, around: &mut [Vec<usize>]) {
        for (chain, kind) in self.free_chains(network) {
            for vertex in chain.ends.into_iter().flatten() {
                let own = &mut around[network.junctions[vertex] as usize];
                // All walls of a flat rim have its plane.
                if matches!(kind, WallKind::Planar(_)) && !own.iter().any(|&i| self.is_wall(i)) {
                    own.push(chain.right);
                }
            }
        }
    }

    /// Lays the walls through the places of their vertices.
    pub(super) fn fit_walls(&mut self, network: &ChainNetwork) {
        let lay = |(chain, kind): (&Chain, WallKind)| {
            let place = |&v: &u32| self.mesh.points[v as usize];
            let mut points: Vec<Point> = chain.mesh_vertices.iter().map(place).collect();
            if let Some([start, end]) = chain.ends {
                let last = points.len() - 1;
                points[0] = network.vertices[start];
                points[last] = network.vertices[end];
            }
            (chain.right, self.wall(kind, chain, &points))
        };
        let laid: Vec<(usize, Primitive)> = self.free_chains(network).map(lay).collect();
        laid.into_iter().for_each(|(i, surface)| self.patches[i].surface = surface);
    }

    /// The wall of a free chain through some points.
    fn wall(&self, kind: WallKind, chain: &Chain, points: &[Point]) -> Primitive {
        let face = &self.patches[chain.left];
        match kind {
            WallKind::Planar(plane) => plane,
            WallKind::Arc(cylinder) if !face.is_facet => through_ends(&cylinder, points),
            _ => plane_through(&face.surface, points, OFF_RIM * chain.error),
        }
    }

    /// A loop of a face of an open shell. Where a rim touches the border of a flat face, the loop touches itself, and falls
    /// into an outer loop and holes.
    pub(super) fn simple_rings(
        &self,
        network: &ChainNetwork,
        patch: usize,
        ring: Vec<ChainUse>,
    ) -> Vec<Vec<ChainUse>> {
        let FacePatch { surface: Primitive::Plane { normal, .. }, side, .. } = self.patches[patch]
        else {
            return vec![ring];
        };
        if !self.is_open() {
            return vec![ring];
        }
        let parts = network.parts_of(&ring);
        let is_outer = |ring: &&Vec<ChainUse>| {
            let points = network.ring_points(ring);
            let spokes = points.windows(2);
            let area: Vector = spokes.map(|w| (w[0] - points[0]).cross(&(w[1] - points[0]))).sum();
            side * area.dot(&normal) > 0.0
        };
        // Several outer loops would be several faces.
        if parts.iter().filter(is_outer).count() > 1 { vec![ring] } else { parts }
    }
}

/// The plane through the ends of a stretch and the point that is farthest from their line. It stands on the face if none is
/// farther than `straight`.
fn plane_through(face: &Primitive, points: &[Point], straight: f64) -> Primitive {
    let (origin, last) = (points[0], points[points.len() - 1]);
    let along = (last - origin).try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vector::zeros);
    let off = |p: &Point| (p - origin) - (p - origin).dot(&along) * along;
    let offs = points.iter().map(off);
    let farthest = offs.max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
    let out = farthest.filter(|off| off.norm() > straight).unwrap_or_else(|| face.normal(origin));
    let normal = along.cross(&out).try_normalize(f64::MIN_POSITIVE);
    Primitive::Plane { origin, normal: normal.unwrap_or_else(|| plane_axes(face.normal(origin)).0) }
}

/// A cylinder moved so that it has the ends of a stretch, and the points between as well as it can.
fn through_ends(cylinder: &Primitive, points: &[Point]) -> Primitive {
    let Primitive::Cylinder { axis, .. } = *cylinder else { return *cylinder };
    let (first, last) = (points[0], points[points.len() - 1]);
    let flat = |v: Vector| v - v.dot(&axis) * axis;
    let middle = nalgebra::center(&first, &last);
    let half = 0.5 * flat(last - first);
    let Some(across) = axis.cross(&half).try_normalize(f64::MIN_POSITIVE) else { return *cylinder };
    // The centre is middle + t · across. A point q from the middle is on the circle if 2 t (q · across) = q² - half².
    let (mut sum, mut squares) = (0.0, 0.0);
    for p in points {
        let q = flat(p - middle);
        let slope = 2.0 * q.dot(&across);
        sum += slope * (q.norm_squared() - half.norm_squared());
        squares += slope * slope;
    }
    if squares == 0.0 {
        return *cylinder;
    }
    let origin = middle + sum / squares * across;
    Primitive::Cylinder { origin, axis, radius: flat(first - origin).norm() }
}
