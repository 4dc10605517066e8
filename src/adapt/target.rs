//! What is fitted: a map's vertices as samples, how far a surface is from them,
//! and their new parameters.

use nalgebra::Matrix3;
use rayon::prelude::*;

use super::correct::{area, corrected, with_skirt};
use super::places::Places;
use super::weights::{CORNER, weights};
use crate::deviation::{Between, Left};
use crate::fit::TangentDistance;
use crate::geometry::{Point, Uv, Vector, VertexId, uv_bounds};
use crate::knots::Miss;
use crate::mesh::Bound;
use crate::mesh::{Outline, Parameterized};
use crate::spline::{Samples, Surface, foot_point_moving, for_many_looks, last_step};

/// What is left of an outlier's weight: nothing that a fit would show.
const OUTLIER_WEIGHT: f64 = 1e-6;

/// The most that a weight grows at a time.
pub(super) const MOST_PRESSURE: f64 = 25.0;

/// A map's vertices as samples.
pub struct Target<'a> {
    pub map: &'a Parameterized,
    /// The numbers of the map's triangles that were measured.
    pub(super) measured_triangles: Vec<usize>,
    /// The map's triangles, and then its skirt's.
    triangles: Vec<[VertexId; 3]>,
    /// Twice their areas in the map as it was made.
    made: Vec<f64>,
    /// Vertices at corners of the domain.
    corners: Vec<usize>,
    /// Vertices on loops and beside them.
    at_loops: Vec<usize>,
    /// Places between vertices.
    pub(super) places: Places,
    /// Points, current parameters, and weights in the next fit: the vertices', then the
    /// places'.
    pub samples: Samples,
    /// The weights that they have where they are no outliers, and those that are.
    pub weights: Vec<f64>,
    pub outliers: Vec<usize>,
}

/// Where on a surface the vertices' nearest points are.
#[derive(Clone)]
pub struct Feet {
    pub uv: Vec<Uv>,
    /// Distances, in mm.
    pub distances: Vec<f64>,
    measured: usize,
}

impl<'a> Target<'a> {
    pub fn new(map: &'a Parameterized) -> Self {
        let corners: Vec<usize> = corners(map).collect();
        let weights = weights(map, |v| corners.contains(&v.index()));
        let points = map.patch.mesh.points.clone();
        let (uv, open) = (map.uv.clone(), map.outline == Outline::Free);
        let triangles = [&map.patch.mesh.triangles[..], &map.skirt.triangles].concat();
        let at = with_skirt(&map.uv, &map.skirt.uv);
        let made = triangles.par_iter().map(|&t| area(&at, t)).collect();
        let samples = Samples { points, uv, weights: weights.clone(), open };
        let at_loops = at_loops(map);
        Target {
            map,
            measured_triangles: map.measured_triangles(),
            triangles,
            made,
            corners,
            at_loops,
            places: Places::default(),
            samples,
            weights,
            outliers: Vec::new(),
        }
    }

    /// Measured vertices.
    pub fn measured(&self) -> usize {
        self.map.patch.measured
    }

    /// The lowest and the highest parameters that samples have.
    pub fn reach(&self) -> [Uv; 2] {
        uv_bounds(&self.samples.uv)
    }

    /// Whether a vertex is a corner of the domain.
    pub fn is_corner(&self, v: usize) -> bool {
        self.corners.contains(&v)
    }

    /// Moves the corners of the net into the corners of the patch, which they all
    /// but meet.
    pub fn pin_corners(&self, surface: &mut Surface) {
        let [m, n] = surface.shape();
        for &v in &self.corners {
            let uv = self.samples.uv[v];
            let (i, j) = (uv.x as usize * (m - 1), uv.y as usize * (n - 1));
            surface.net[i * n + j] = self.samples.points[v].coords;
        }
    }

    /// The vertices' current parameters.
    pub fn uv(&self) -> &[Uv] {
        &self.samples.uv[..self.weights.len()]
    }

    /// The samples that are vertices, and how these hold a surface.
    pub fn vertices<'h>(&self, holds: &'h [TangentDistance]) -> (Samples, &'h [TangentDistance]) {
        let count = self.weights.len();
        let Samples { points, uv, weights, open } = &self.samples;
        let samples = Samples {
            points: points[..count].to_vec(),
            uv: uv[..count].to_vec(),
            weights: weights[..count].to_vec(),
            open: *open,
        };
        (samples, &holds[..count])
    }

    /// The measured triangles that a surface leaves by more than such a `share` of the
    /// tolerance and what a flat triangle misses itself, with the vertices at `uv`.
    pub fn left(&self, surface: &Surface, uv: &[Uv], tolerance: f64, share: f64) -> Vec<Left> {
        let mesh = &self.map.patch.mesh;
        Between::new(mesh, &self.measured_triangles, uv, surface).left(tolerance, share)
    }

    /// Gives the vertices these parameters, and the places those between.
    pub fn set_uv(&mut self, uv: Vec<Uv>) {
        self.samples.uv = self.with_places(uv);
    }

    /// The parameters of vertices, and after them those of the places between.
    pub fn with_places(&self, mut uv: Vec<Uv>) -> Vec<Uv> {
        uv.truncate(self.weights.len());
        let between: Vec<Uv> = self.places.all.iter().map(|place| place.uv(&uv)).collect();
        uv.extend(between);
        uv
    }

    /// The vertices' feet on a surface. Where the patch's sides are the outer
    /// boundary, corners have theirs in the corner and its other vertices on their
    /// side.
    pub fn feet(&self, surface: &Surface) -> Feet {
        self.feet_from(surface, self.uv())
    }

    /// The same, looked for from the given parameters.
    pub fn feet_from(&self, surface: &Surface, starts: &[Uv]) -> Feet {
        let last = last_step(surface);
        let surface = for_many_looks(surface);
        let foot = |(&uv, &p): (&Uv, &Point)| {
            foot_point_moving(&*surface, p, uv, held(self.map, uv).map(|held| !held), last)
        };
        let at = starts.par_iter().zip(&self.samples.points);
        let (uv, distances) = at.map(foot).unzip();
        Feet { uv, distances, measured: self.measured() }
    }

    /// Takes the given parameters of vertices on loops and beside them as if they were their
    /// feet: trim loops run where these may go, and a foot that one may not go to can be
    /// beyond a loop.
    pub fn stay_at_loops(&self, surface: &Surface, uv: &[Uv], feet: &mut Feet) {
        for &v in &self.at_loops {
            feet.uv[v] = uv[v];
            feet.distances[v] = (surface.point(uv[v]) - self.samples.points[v]).norm();
        }
    }

    /// How the vertices hold a surface that slides along them: by their normals, the
    /// outer boundary on the domain's sides across its course, too, and the corners
    /// altogether.
    pub fn holds(&self) -> Vec<TangentDistance> {
        let patch = &self.map.patch;
        let normals = patch.mesh.vertex_normals();
        let mut along: Vec<Option<Vector>> = vec![None; normals.len()];
        let before = patch.outer.iter().cycle().skip(patch.outer.len().saturating_sub(1));
        for ((a, v), b) in before.zip(&patch.outer).zip(patch.outer.iter().cycle().skip(1)) {
            along[v.index()] = (patch.mesh.point(*b) - patch.mesh.point(*a)).try_normalize(0.0);
        }
        let hold = |((uv, normal), along): ((&Uv, Vector), Option<Vector>)| {
            let moves = held(self.map, *uv).map(|held| !held);
            let metric = match moves {
                [true, true] => normal * normal.transpose(),
                [false, false] => Matrix3::identity(),
                _ => along.map_or(Matrix3::identity(), |t| Matrix3::identity() - t * t.transpose()),
            };
            TangentDistance { normal, metric, moves }
        };
        self.uv().par_iter().zip(normals).zip(along).map(hold).collect()
    }

    /// Gives the samples the parameters of their feet, as far as every triangle keeps the
    /// share `least` of the area it was made with; a skirt's, too, or an outer boundary
    /// inside the domain might come to cross itself.
    pub fn correct(&mut self, feet: &Feet, least: f64) {
        self.set_uv(self.corrected(self.uv().to_vec(), feet.uv.clone(), least));
    }

    /// Which samples are not at their feet, or are to stay where they are: those of an
    /// outer boundary inside the domain, which the face is cut along.
    pub fn stuck(&self, feet: &Feet) -> Vec<bool> {
        let at = self.uv().par_iter().zip(&feet.uv);
        let mut stuck: Vec<bool> = at.map(|(at, foot)| at != foot).collect();
        stuck.resize(self.samples.len(), false);
        if self.map.outline == Outline::Free {
            let outer = self.map.patch.loop_of(Bound::Outer);
            outer.iter().for_each(|v| stuck[v.index()] = true);
        }
        stuck
    }

    /// The parameters that the vertices may move to from those they have.
    pub fn corrected(&self, now: Vec<Uv>, wanted: Vec<Uv>, least: f64) -> Vec<Uv> {
        corrected(&self.triangles, &self.made, least, now, wanted, &self.map.skirt.uv)
    }

    /// The same of vertices and places, which go where their vertices do.
    pub fn slid(&self, mut now: Vec<Uv>, mut wanted: Vec<Uv>, least: f64) -> Vec<Uv> {
        now.truncate(self.weights.len());
        wanted.truncate(self.weights.len());
        self.with_places(self.corrected(now, wanted, least))
    }

    /// Root mean square of the measured vertices' distances, but for outliers.
    pub fn rms(&self, feet: &Feet) -> f64 {
        let all: f64 = feet.measured().map(|d| d * d).sum();
        let outliers: f64 = self.outliers.iter().map(|&v| feet.distances[v].powi(2)).sum();
        let count = feet.measured - self.outliers.len();
        ((all - outliers).max(0.0) / count.max(1) as f64).sqrt()
    }

    /// Gives weight to measured samples that are farther than `limit` (Lawson's
    /// iteration towards the smallest maximum).
    pub fn press(&mut self, feet: &Feet, limit: f64) {
        let weights = self.weights.iter_mut().zip(&feet.distances);
        for (weight, d) in weights.take(feet.measured).filter(|(_, d)| **d > limit) {
            *weight = (*weight * (d / limit).powi(2).min(MOST_PRESSURE)).min(CORNER);
        }
        self.give_weights();
    }

    /// Makes samples of places.
    pub fn take(&mut self, places: Places) {
        self.places = places;
        self.samples.points.truncate(self.weights.len());
        self.samples.points.extend(self.places.all.iter().map(|place| place.point));
        self.set_uv(self.uv().to_vec());
        self.give_weights();
    }

    /// Gives the samples their weights, outliers next to none.
    pub fn give_weights(&mut self) {
        self.samples.weights.clone_from(&self.weights);
        self.samples.weights.extend(self.places.all.iter().map(|place| place.weight));
        self.outliers.iter().for_each(|&v| self.samples.weights[v] *= OUTLIER_WEIGHT);
    }

    /// Places that miss a target, in mm, and by how much.
    pub fn misses(&self, feet: &Feet, target: f64) -> Vec<Miss> {
        let measured = feet.measured().zip(&self.samples.uv);
        measured.filter(|(d, _)| *d > target).map(|(d, &uv)| (uv, d / target)).collect()
    }

    /// The squares of all distances, of a variance, where the points are; none of outliers.
    pub fn squares(&self, feet: &Feet, deviation: f64) -> Vec<Miss> {
        let squares = feet.squares(deviation).zip(&self.samples.uv);
        let mut all: Vec<Miss> = squares.map(|(square, &uv)| (uv, square)).collect();
        self.outliers.iter().for_each(|&v| all[v].1 = 0.0);
        all
    }
}

/// Squared distances, of the variance, count no more than this: few points that are
/// farther are not the shape's.
const MOST_SQUARE: f64 = 25.0;

impl Feet {
    /// The distances of the measured vertices.
    fn measured(&self) -> impl Iterator<Item = f64> + '_ {
        self.distances[..self.measured].iter().copied()
    }

    /// Their squares, of the variance that a standard `deviation` in mm has.
    pub fn squares(&self, deviation: f64) -> impl Iterator<Item = f64> + '_ {
        self.measured().map(move |d| (d / deviation).powi(2).min(MOST_SQUARE))
    }

    /// How many measured vertices are farther than `limit`, and the farthest.
    pub fn beyond(&self, limit: f64) -> (usize, f64) {
        let beyond = self.measured().filter(|d| *d > limit).count();
        (beyond, self.measured().fold(0.0, f64::max))
    }
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

/// Which parameters of a vertex stay on the side of the domain that is the outer
/// boundary.
fn held(map: &Parameterized, uv: Uv) -> [bool; 2] {
    let sides = map.outline == Outline::Sides;
    [uv.x, uv.y].map(|t| sides && (t == 0.0 || t == 1.0))
}

/// The vertices that are corners of the domain: of a patch whose sides are its outer
/// boundary.
fn corners(map: &Parameterized) -> impl Iterator<Item = usize> + '_ {
    let outer = map.patch.outer.iter().map(|v| v.index());
    outer.filter(|v| held(map, map.uv[*v]) == [true; 2])
}
