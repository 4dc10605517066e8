//! Faults of a fill: edges at which it folds over itself or over the measured surface, and
//! triangles that intersect each other or measured ones.

use foldhash::{HashMap, HashMapExt, HashSet, HashSetExt};
use rayon::prelude::*;

use super::CELL;
use super::box_grid::BoxGrid;
use super::front::{Fill, Surroundings};
use crate::geometry::{Point, Vector, VertexId, unit_normal};
use crate::mesh::Mesh;
use crate::mesh::crossings::{BoxBlock, BoxBlocks, NumberedBox, cut, extent, overlap};
use crate::mesh::remesh::FOLDED;

/// The faults of a fill.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Faults {
    /// Edges at which it folds, inside or at its rims: the normals of the two triangles differ
    /// by more than 107°.
    pub folds: usize,
    /// Pairs of triangles that intersect. At least one of each pair is in the fill.
    pub cuts: usize,
}

impl Faults {
    /// The number of all faults.
    pub fn count(self) -> usize {
        self.folds + self.cuts
    }
}

/// The measured triangles, which a fill must not intersect.
pub(crate) struct Obstacles(BoxGrid);

impl Obstacles {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let side = |t: &[VertexId; 3]| (mesh.point(t[1]) - mesh.point(t[0])).norm();
        let mean = mesh.triangles.iter().map(side).sum::<f64>() / mesh.triangles.len() as f64;
        let extents = mesh.triangles.par_iter().map(|t| extent(t.map(|v| mesh.point(v))));
        Obstacles(BoxGrid::new(extents.collect(), CELL * mean.max(f64::MIN_POSITIVE)))
    }
}

/// The faults of a fill.
pub(crate) fn find(around: &Surroundings, fill: &Fill) -> Faults {
    let at = |v: VertexId| place(around.mesh, &fill.points, v);
    let finder = FaultFinder { around, fill, at: &at };
    Faults { folds: finder.folds(), cuts: finder.cuts() }
}

/// The position of a vertex of a mesh, or of one of those that are added to it.
pub(crate) fn place(mesh: &Mesh, added: &[Point], v: VertexId) -> Point {
    match v.index().checked_sub(mesh.points.len()) {
        None => mesh.point(v),
        Some(new) => added[new],
    }
}

/// Whether an edge of a fill exists already, in another of its triangles or in the mesh (but
/// for the rims). With such an edge the result is not a manifold.
pub(crate) fn joins_twice(around: &Surroundings, fill: &Fill, rims: &[&[VertexId]]) -> bool {
    // The hole is to the right of its rims.
    let along = |rim: &&[VertexId]| {
        let next = rim.iter().cycle().skip(1);
        next.copied().zip(rim.iter().copied()).collect::<Vec<_>>()
    };
    let rims: HashSet<(VertexId, VertexId)> = rims.iter().flat_map(along).collect();
    let mut sides = HashSet::with_capacity(3 * fill.triangles.len());
    let mut all = fill.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    all.any(|(v, w)| !sides.insert((v, w)) || (!rims.contains(&(v, w)) && around.joined(v, w)))
}

struct FaultFinder<'a> {
    around: &'a Surroundings<'a>,
    fill: &'a Fill,
    at: &'a dyn Fn(VertexId) -> Point,
}

impl FaultFinder<'_> {
    fn normal(&self, t: [VertexId; 3]) -> Vector {
        unit_normal(t.map(self.at)).unwrap_or_default()
    }

    fn folds(&self) -> usize {
        let mut sides = HashMap::with_capacity(3 * self.fill.triangles.len());
        for &t in &self.fill.triangles {
            let normal = self.normal(t);
            (0..3).for_each(|k| _ = sides.insert((t[k], t[(k + 1) % 3]), normal));
        }
        let is_folded = |(&(v, w), normal): (&(VertexId, VertexId), &Vector)| {
            let beside = match sides.get(&(w, v)) {
                // Count an inner edge once.
                Some(_) if v > w => return false,
                Some(beside) => Some(*beside),
                None => self.around.normal_at(v, w),
            };
            beside.is_some_and(|beside| beside.dot(normal) < FOLDED)
        };
        sides.iter().filter(|side| is_folded(*side)).count()
    }

    fn cuts(&self) -> usize {
        let own = &self.fill.triangles;
        let extents = (0..).zip(own.iter().map(|t| extent(t.map(self.at))));
        let fill = BoxBlocks::new(extents.collect());
        let mut count = 0;
        fill.pairs(|s, t| count += usize::from(self.cut(own[s as usize], own[t as usize])));
        count + fill.blocks.iter().map(|block| self.cuts_of_measured(block)).sum::<usize>()
    }

    /// The number of pairs of a triangle in a block of the fill and a measured one that
    /// intersect.
    fn cuts_of_measured(&self, block: &BoxBlock) -> usize {
        let (mesh, own) = (self.around.mesh, &self.fill.triangles);
        let near = self.around.obstacles.0.overlapping(block.extent);
        let cut_by = |(number, place): NumberedBox| {
            let met = block.members.iter().filter(|m| overlap(&place, &m.1));
            let other = mesh.triangles[number as usize];
            met.filter(|m| self.cut(own[m.0 as usize], other)).count()
        };
        near.map(cut_by).sum()
    }

    fn cut(&self, s: [VertexId; 3], t: [VertexId; 3]) -> bool {
        cut([s, t], [s.map(self.at), t.map(self.at)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::VertexRings;
    use crate::mesh::mls::Cloud;

    /// The faults of a fill beside some measured triangles.
    fn faults(points: &[[f64; 3]], measured: &[[u32; 3]], triangles: &[[u32; 3]]) -> Faults {
        let ids = |t: &[u32; 3]| t.map(VertexId);
        let points: Vec<Point> = points.iter().map(|p| Point::from(*p)).collect();
        let mesh = Mesh { points, triangles: measured.iter().map(ids).collect() };
        let rings = VertexRings::new(&mesh);
        let cloud = Cloud::of(&mesh, &rings);
        let obstacles = Obstacles::new(&mesh);
        let around =
            Surroundings { mesh: &mesh, rings: &rings, cloud: &cloud, obstacles: &obstacles };
        let triangles = triangles.iter().map(ids).collect();
        let fill = Fill { points: vec![], triangles, wide_ears: 0 };
        find(&around, &fill)
    }

    const SQUARE: [[f64; 3]; 4] =
        [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]];

    #[test]
    fn a_triangle_folded_over_its_neighbour_is_found() {
        let faults = |corner: [f64; 3]| {
            let points = [&SQUARE[..], &[corner]].concat();
            [
                faults(&points, &[[0, 1, 2]], &[[0, 2, 4]]).folds,
                faults(&points, &[[0, 3, 1]], &[[0, 1, 2], [0, 2, 4]]).folds,
            ]
        };
        assert_eq!(faults([0.0, 4.0, 0.0]), [0, 1]);
        assert_eq!(faults([3.0, 0.5, 0.1]), [1, 2]);
    }

    #[test]
    fn triangles_intersect_where_a_side_goes_through() {
        let more = [[3.0, 1.0, -1.0], [3.0, 1.0, 1.0], [9.0, 5.0, 1.0], [9.0, 9.0, 0.0]];
        let points = [&SQUARE[..], &more].concat();
        let cuts = |measured: &[[u32; 3]], fill: &[[u32; 3]]| faults(&points, measured, fill).cuts;
        assert_eq!(cuts(&[[4, 5, 6]], &[[0, 1, 2]]), 1);
        assert_eq!(cuts(&[[1, 2, 7]], &[[0, 1, 2], [4, 5, 6]]), 2);
        // Neighbours that share a side or a corner do not intersect.
        assert_eq!(cuts(&[[1, 7, 2]], &[[0, 1, 2], [0, 4, 1]]), 0);
        // They share a corner, and the opposite side goes through.
        assert_eq!(cuts(&[[0, 4, 5]], &[[0, 1, 2]]), 1);
    }
}
