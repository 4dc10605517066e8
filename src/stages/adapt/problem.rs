//! What stays the same while knots, parameters and weights change.

use nalgebra::Matrix3;
use rayon::prelude::*;

use super::attempt::FootPoints;
use super::goal::Goal;
use super::moves::correct::{area, movable, with_scaffold};
use super::options::Options;
use super::weights::weights;
use crate::deviation::{MissedTriangle, SurfaceOverMesh};
use crate::geometry::{Point, Uv, Vector, VertexId};
use crate::mesh::{Bound, Outline, Parameterized};
use crate::spline::{Surface, fast_evaluator, foot_point_moving, last_step};
use crate::stages::fit::TangentDistance;

/// A map to fit a surface to, how, and to which goal.
pub(crate) struct Problem<'a> {
    pub map: &'a Parameterized,
    pub options: &'a Options,
    pub goal: &'a Goal,
    /// The numbers of the map's triangles that were measured.
    pub measured_triangles: Vec<usize>,
    /// How many vertices of the scan each measured vertex stands for.
    pub counts: Vec<f64>,
    /// How the vertices hold a surface that slides along them.
    pub holds: Vec<TangentDistance>,
    /// The map's triangles, and then its scaffold's.
    triangles: Vec<[VertexId; 3]>,
    /// Twice their areas in the map as it was made.
    areas: Vec<f64>,
    /// Vertices at corners of the domain.
    corners: Vec<usize>,
    /// Vertices on loops and beside them.
    at_loops: Vec<usize>,
}

impl<'a> Problem<'a> {
    pub(super) fn new(map: &'a Parameterized, options: &'a Options, goal: &'a Goal) -> Self {
        let triangles = [&map.patch.mesh.triangles[..], &map.scaffold.triangles].concat();
        let at = with_scaffold(&map.uv, &map.scaffold.uv);
        let areas = triangles.par_iter().map(|&t| area(&at, t)).collect();
        Problem {
            map,
            options,
            goal,
            measured_triangles: map.measured_triangles(),
            counts: map.patch.counts(),
            holds: holds(map),
            triangles,
            areas,
            corners: corners(map).collect(),
            at_loops: at_loops(map),
        }
    }

    /// How many vertices were measured.
    pub(super) fn measured(&self) -> usize {
        self.map.patch.measured
    }

    /// How many measured points may be beyond the tolerance.
    pub(crate) fn spared(&self) -> usize {
        self.share(self.goal.outliers)
    }

    /// How many points a share of the measured ones is.
    pub(crate) fn share(&self, share: f64) -> usize {
        (share * self.measured() as f64) as usize
    }

    /// Whether samples end inside the domain, and the surface goes on beyond them.
    pub(crate) fn is_open(&self) -> bool {
        self.map.outline == Outline::Free
    }

    /// Whether a vertex is a corner of the domain.
    pub(crate) fn is_corner(&self, v: usize) -> bool {
        self.corners.contains(&v)
    }

    /// The weights that the vertices have before any is raised.
    pub(crate) fn weights(&self) -> Vec<f64> {
        weights(self.map, |v| self.is_corner(v.index()))
    }

    /// Moves the corners of the net to the corners of the patch, which they nearly meet.
    pub(crate) fn pin_corners(&self, surface: &mut Surface) {
        let [m, n] = surface.shape();
        for &v in &self.corners {
            let uv = self.map.uv[v];
            let (i, j) = (uv.x as usize * (m - 1), uv.y as usize * (n - 1));
            surface.net[i * n + j] = self.map.patch.mesh.points[v].coords;
        }
    }

    /// The vertices' foot points on a surface, found from the parameters `starts`. If the
    /// patch's sides are the outer boundary, corners have theirs in the corner and the other
    /// boundary vertices on their side.
    pub(crate) fn foot_points(&self, surface: &Surface, starts: &[Uv]) -> FootPoints {
        let last = last_step(surface);
        let surface = fast_evaluator(surface);
        let foot_point = |(&uv, &p): (&Uv, &Point)| {
            foot_point_moving(&*surface, p, uv, on_sides(self.map, uv).map(|side| !side), last)
        };
        let at = starts.par_iter().zip(&self.map.patch.mesh.points);
        let (uv, distances) = at.map(foot_point).unzip();
        FootPoints { uv, distances, measured: self.measured() }
    }

    /// Takes the parameters `uv` of vertices on loops and beside them as if they were their foot
    /// points. Trim loops run where these vertices may go, and a foot point that a vertex may
    /// not go to can be beyond a loop.
    pub(crate) fn stay_at_loops(&self, surface: &Surface, uv: &[Uv], foot_points: &mut FootPoints) {
        for &v in &self.at_loops {
            foot_points.uv[v] = uv[v];
            let off = surface.point(uv[v]) - self.map.patch.mesh.points[v];
            foot_points.distances[v] = off.norm();
        }
    }

    /// The parameters that vertices at `now` may move to, towards the `wanted` ones, while every
    /// triangle keeps the share `least_area` of its area on the map. The scaffold's triangles count,
    /// too, because an outer boundary inside the domain might otherwise come to cross itself.
    pub(crate) fn corrected(&self, now: Vec<Uv>, wanted: Vec<Uv>, least_area: f64) -> Vec<Uv> {
        movable(&self.triangles, &self.areas, least_area, now, wanted, &self.map.scaffold.uv)
    }

    /// Which vertices at `uv` do not slide: those that are not at their foot points, and those of
    /// an outer boundary inside the domain, along which the face is cut.
    pub(crate) fn stuck(&self, uv: &[Uv], foot_points: &FootPoints) -> Vec<bool> {
        let at = uv.par_iter().zip(&foot_points.uv);
        let mut stuck: Vec<bool> = at.map(|(at, foot_point)| at != foot_point).collect();
        if self.is_open() {
            let outer = self.map.patch.loop_of(Bound::Outer);
            outer.iter().for_each(|v| stuck[v.index()] = true);
        }
        stuck
    }

    /// The measured triangles that a surface leaves by more than such a `share` of the
    /// tolerance and what a flat triangle misses itself, with the vertices at `uv`.
    pub(crate) fn left(&self, surface: &Surface, uv: &[Uv], share: f64) -> Vec<MissedTriangle> {
        let mesh = &self.map.patch.mesh;
        let between = SurfaceOverMesh::new(mesh, &self.measured_triangles, uv, surface);
        between.missed(self.goal.tolerance, share)
    }
}

/// How the vertices hold a surface that slides along them: across their normals, the outer
/// boundary on the domain's sides across its course, too, and the corners in all directions.
fn holds(map: &Parameterized) -> Vec<TangentDistance> {
    let patch = &map.patch;
    let normals = patch.mesh.vertex_normals();
    let mut along: Vec<Option<Vector>> = vec![None; normals.len()];
    let before = patch.outer.iter().cycle().skip(patch.outer.len().saturating_sub(1));
    for ((a, v), b) in before.zip(&patch.outer).zip(patch.outer.iter().cycle().skip(1)) {
        along[v.index()] = (patch.mesh.point(*b) - patch.mesh.point(*a)).try_normalize(0.0);
    }
    let hold = |((uv, normal), along): ((&Uv, Vector), Option<Vector>)| {
        let moves = on_sides(map, *uv).map(|on_side| !on_side);
        let metric = match moves {
            [true, true] => normal * normal.transpose(),
            [false, false] => Matrix3::identity(),
            _ => along.map_or(Matrix3::identity(), |t| Matrix3::identity() - t * t.transpose()),
        };
        TangentDistance { normal, metric, moves }
    };
    map.uv.par_iter().zip(normals).zip(along).map(hold).collect()
}

/// The vertices on loops and beside them.
fn at_loops(map: &Parameterized) -> Vec<usize> {
    let patch = &map.patch;
    let islands = patch.islands.iter().map(|island| &island.rim);
    let loops = std::iter::once(patch.loop_of(Bound::Outer)).chain(&patch.rims).chain(islands);
    let mut on_loop = vec![false; patch.mesh.points.len()];
    loops.flat_map(|of| of.iter()).for_each(|v| on_loop[v.index()] = true);
    let mut near = on_loop.clone();
    for triangle in &patch.mesh.triangles {
        if triangle.iter().any(|v| on_loop[v.index()]) {
            triangle.iter().for_each(|v| near[v.index()] = true);
        }
    }
    (0..near.len()).filter(|&v| near[v]).collect()
}

/// Whether u and whether v put a vertex on a side of the domain that is the outer boundary, on
/// which it stays.
fn on_sides(map: &Parameterized, uv: Uv) -> [bool; 2] {
    let sides = map.outline == Outline::Sides;
    [uv.x, uv.y].map(|t| sides && (t == 0.0 || t == 1.0))
}

/// The vertices that are corners of the domain: of a patch whose sides are its outer
/// boundary.
fn corners(map: &Parameterized) -> impl Iterator<Item = usize> + '_ {
    let outer = map.patch.outer.iter().map(|v| v.index());
    outer.filter(|v| on_sides(map, map.uv[*v]) == [true; 2])
}
