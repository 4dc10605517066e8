//! A map to a rectangle, from the coarsest mesh of a progressive mesh to the finest.
//!
//! A vertex split finds a place for the new vertex at which no triangle is inverted: all of the fan
//! that replaced the vertex is visible from places near its apex. No map on the way is therefore
//! folded, however far parts of the surface protrude.

use rayon::prelude::*;

use super::relax::{self, Freedom, StretchEnergy};
use super::sweep_mesh::SweepMesh;
use super::weights::Weights;
use super::{mend, solve, stretch};
use crate::error::{Error, Result};
use crate::geometry::{MOST_ROUNDS, Point, Uv, UvVector, orient2d};
use crate::mesh::one_rings::{HalfEdgeCollapse, OneRings};
use crate::mesh::progressive_mesh::ProgressiveMesh;
use crate::progress::Progress;

/// A map to a rectangle with the area of the surface. The boundary is mapped to its sides.
pub(crate) struct RectangleMap<'a> {
    /// Points in space, one for each vertex.
    pub points: &'a [Point],
    /// The weight of the surface around each vertex.
    pub weights: Weights,
    /// The number of vertices on the mesh for which the weights were computed. Vertices that are
    /// added beyond this number take the weight of their neighbours.
    pub weighed: usize,
    /// The directions in which each vertex may move.
    pub freedom: Vec<Freedom>,
    /// The width and the height of the rectangle, in mm.
    pub size: [f64; 2],
    /// The positions of the vertices, in mm from the lower left corner.
    pub at: Vec<Uv>,
    /// The weight of the convex energy term.
    pub convex_weight: ConvexWeight,
}

/// The weight of the convex energy term, depending on the number of vertices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ConvexWeight {
    /// On a coarse mesh. Its triangles span bends and are more strongly stretched in one direction
    /// than the surface requires.
    coarse: f64,
    /// On a finer mesh.
    fine: f64,
}

impl ConvexWeight {
    /// For the maps of most surfaces.
    pub(crate) const USUAL: ConvexWeight = ConvexWeight { coarse: 0.25, fine: 0.1 };

    /// For surfaces that a map to the square stretches far more in one direction than in the other,
    /// such as tubes. With a smaller weight a few triangles would take most of the square.
    pub(crate) const FIRM: ConvexWeight = ConvexWeight { coarse: 0.5, fine: 0.5 };

    fn with(self, vertices: usize) -> f64 {
        if vertices < COARSE_MESH { self.coarse } else { self.fine }
    }
}

impl RectangleMap<'_> {
    /// Maps the present mesh by mean value coordinates. If rounding folds this map, even weights
    /// are used instead. The boundary vertices must already be in place.
    ///
    /// # Errors
    /// [`Error::Singular`] if this map is folded as well.
    pub(crate) fn solve(&mut self, hierarchy: &ProgressiveMesh) -> Result<()> {
        let inner = |v: &u32| self.freedom[*v as usize] == Freedom::Full;
        let inner: Vec<u32> = hierarchy.remaining.iter().copied().filter(inner).collect();
        let rings = &hierarchy.rings;
        let unfolded =
            |at: &[Uv]| mend::inverted(triangles(rings, &hierarchy.remaining), at).is_empty();
        let by_mean_value = solve::mean_value(self.points, rings, &inner, &mut self.at);
        if by_mean_value.is_ok() && unfolded(&self.at) {
            return Ok(());
        }
        solve::even(rings, &inner, &mut self.at)?;
        if unfolded(&self.at) { Ok(()) } else { Err(Error::Singular("parameterization")) }
    }

    /// Undoes all collapses and relaxes the vertices to reduce the stretch.
    pub(crate) fn refine(
        &mut self,
        hierarchy: &mut ProgressiveMesh,
        progress: &mut Progress,
    ) -> Result<()> {
        let mut relaxed = 0;
        loop {
            let n = hierarchy.remaining.len();
            progress(n as f64 / self.at.len() as f64)?;
            let (growth, sweeps) =
                EFFORT.iter().find(|e| n <= e.0).map_or((2.0, 2), |e| (e.1, e.2));
            if n as f64 >= growth * relaxed as f64 {
                self.relax(hierarchy, sweeps);
                relaxed = n;
            }
            let mut split = Vec::new();
            if !hierarchy.refine(|pass| {
                // The vertices of one pass are not neighbours, so they form one group.
                self.place_pass(pass, n < self.weighed);
                split = pass.iter().map(|collapse| collapse.vertex).collect();
            }) {
                break;
            }
            self.propagate(&hierarchy.rings, vec![split], n);
        }
        self.relax(hierarchy, LAST_SWEEPS);
        Ok(())
    }

    /// Places the vertices of a pass and sets their weights.
    fn place_pass(&mut self, pass: &[HalfEdgeCollapse], weighed: bool) {
        // No vertex of a pass is in the ring of another one.
        let places: Vec<Uv> =
            pass.par_iter().with_min_len(64).map(|collapse| self.visible_place(collapse)).collect();
        pass.iter().zip(places).for_each(|(r, place)| self.at[r.vertex as usize] = place);
        if weighed {
            pass.iter().rev().for_each(|collapse| self.weights.unlump(collapse));
        } else {
            self.weights.follow(pass);
        }
    }

    /// Moves the vertices of the given groups. Vertices that moved far and their neighbours are
    /// moved again, until none moves far or [`MAX_MOVES`] moves per vertex were made.
    fn propagate(&mut self, rings: &OneRings, mut groups: Vec<Vec<u32>>, count: usize) {
        let mut moves = 0;
        while !groups.is_empty() && moves < MAX_MOVES * count {
            moves += groups.iter().map(Vec::len).sum::<usize>();
            let (points, weights, freedom) = (self.points, &self.weights.of, &self.freedom);
            let energy =
                StretchEnergy { points, weights, freedom, convex_weight: self.convex_weight.fine };
            let far = relax::sweep(&energy, rings, &groups, &mut self.at);
            let mut vertices: Vec<u32> = far
                .par_iter()
                .flat_map_iter(|&v| rings.ring(v).iter().copied())
                .chain(far.par_iter().copied())
                .collect();
            vertices.par_sort_unstable();
            vertices.dedup();
            groups = relax::groups(rings, vertices);
        }
    }

    fn relax(&mut self, hierarchy: &ProgressiveMesh, sweeps: usize) {
        let convex_weight = self.convex_weight.with(hierarchy.remaining.len());
        let (points, weights, freedom) = (self.points, &self.weights.of, &self.freedom);
        let energy = StretchEnergy { points, weights, freedom, convex_weight };
        let sweeping = SweepMesh::new(&energy, &hierarchy.rings, &hierarchy.remaining, &self.at);
        let mut far = Vec::new();
        for _ in 0..sweeps {
            far = sweeping.sweep();
        }
        sweeping.put_back(&mut self.at);
        let groups = relax::groups(&hierarchy.rings, far);
        self.propagate(&hierarchy.rings, groups, hierarchy.remaining.len());
        self.turn_to_best_aspect(hierarchy);
    }

    /// Scales the rectangle, with constant area, to the aspect ratio with the least stretch.
    fn turn_to_best_aspect(&mut self, hierarchy: &ProgressiveMesh) {
        let of =
            |remaining| without_scaffold(&self.weights, triangles(&hierarchy.rings, remaining));
        let w = stretch::best_width(
            self.points,
            &self.at,
            stretch::blocks(&hierarchy.remaining).map(of),
        );
        if !(w.is_finite() && w > 0.0) {
            return;
        }
        for &v in &hierarchy.remaining {
            let at = &mut self.at[v as usize];
            *at = Uv::new(at.x * w, at.y / w);
        }
        self.size = [self.size[0] * w, self.size[1] / w];
    }

    /// A place for a new vertex at which no triangle is inverted.
    fn visible_place(&self, collapse: &HalfEdgeCollapse) -> Uv {
        let (apex, path) = collapse.fan();
        let corner = self.at[apex as usize];
        let inner = self.freedom[collapse.vertex as usize] == Freedom::Full;
        let ring: Vec<Uv> = collapse.ring.iter().map(|&w| self.at[w as usize]).collect();
        let mut sides: Vec<(Uv, Uv)> = ring.windows(2).map(|w| (w[0], w[1])).collect();
        if inner {
            sides.push((ring[ring.len() - 1], ring[0]));
        }
        let sees_all = |q: Uv| sides.iter().all(|&(a, b)| orient2d(q, a, b) > 0.0);
        let wish = self.mean_place(collapse, inner);
        if sees_all(wish) {
            return wish;
        }
        let ends = [path[0], path[path.len() - 1]].map(|w| self.at[w as usize] - corner);
        let towards = if inner { bisector(ends) } else { wish - corner };
        let mut q = corner + towards;
        for _ in 0..MOST_ROUNDS {
            if sees_all(q) {
                break;
            }
            q = nalgebra::center(&q, &corner);
        }
        q
    }

    /// The position of a vertex by mean value coordinates in its ring. A vertex on a side is placed
    /// by chord length.
    fn mean_place(&self, collapse: &HalfEdgeCollapse, inner: bool) -> Uv {
        let p = self.points[collapse.vertex as usize];
        let shares: Vec<(u32, f64)> = if inner {
            solve::shares(p, &collapse.ring, self.points)
        } else {
            let ends = [collapse.ring[0], collapse.ring[collapse.ring.len() - 1]];
            let far = ends.map(|w| (self.points[w as usize] - p).norm().max(f64::MIN_POSITIVE));
            vec![(ends[0], 1.0 / far[0]), (ends[1], 1.0 / far[1])]
        };
        let total: f64 = shares.iter().map(|s| s.1).sum();
        let sum = shares.iter().map(|&(w, share)| share * self.at[w as usize].coords);
        let mut place = Uv::from(sum.sum::<UvVector>() / total);
        // The vertex must lie exactly on its side.
        match self.freedom[collapse.vertex as usize] {
            Freedom::AlongX => place.y = self.at[collapse.ring[0] as usize].y,
            Freedom::AlongY => place.x = self.at[collapse.ring[0] as usize].x,
            _ => (),
        }
        place
    }
}

/// The effort by mesh size. For meshes of at most `.0` vertices, `.2` sweeps are made whenever the
/// number of vertices has grown by the factor `.1` since the last ones.
const EFFORT: [(usize, f64, usize); 3] = [(500, 1.0, 40), (5_000, 1.3, 20), (50_000, 1.6, 10)];

/// The number of sweeps over the whole mesh.
const LAST_SWEEPS: usize = 2;

/// A mesh with fewer vertices counts as coarse.
const COARSE_MESH: usize = 5_000;

/// The largest number of moves in [`RectangleMap::propagate`], as a multiple of the number of
/// vertices.
const MAX_MOVES: usize = 2;

/// The bisector of the counter-clockwise angle from the first direction to the second. It is not
/// longer than these.
fn bisector([a, b]: [UvVector; 2]) -> UvVector {
    let angle = a.perp(&b).atan2(a.dot(&b)).rem_euclid(std::f64::consts::TAU);
    let turned = nalgebra::Rotation2::new(0.5 * angle) * a;
    turned * (0.5 * a.norm().min(b.norm()) / a.norm().max(f64::MIN_POSITIVE))
}

/// The triangles that are not part of the scaffold.
pub(crate) fn without_scaffold<'a>(
    weights: &'a Weights,
    triangles: impl Iterator<Item = [u32; 3]> + 'a,
) -> impl Iterator<Item = [u32; 3]> + 'a {
    triangles.filter(|t| !t.iter().any(|&v| weights.is_light(v)))
}

/// The triangles between the remaining vertices.
pub(crate) fn triangles<'a>(
    rings: &'a OneRings,
    remaining: &'a [u32],
) -> impl Iterator<Item = [u32; 3]> + 'a {
    let first = |v: u32| rings.sides(v).filter(move |s| v < s.0 && v < s.1);
    remaining.iter().flat_map(move |&v| first(v).map(move |(a, b)| [v, a, b]))
}
