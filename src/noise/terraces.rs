//! Coordinates in steps, as of a camera that gives depths in whole millimetres.
//!
//! All heights along one axis are multiples of a step, and neighbouring heights differ by few of them. A smooth
//! surface becomes terraces, which look exact and are noise: heights are off by half a step at most, evenly spread.
//! A stereo camera gives whole disparities d, and depths z = k/d. Their reciprocals are even steps apart, and
//! the steps of the depths are z²/k: they grow with the depth.
//! A designed part may have such heights, too. Most have walls that are parallel to the axis, and their surfaces bend
//! one way at most vertices, where terraces bend both ways.

use super::patch::{DEGREES, NoisePatch};
use super::patches;
use crate::geometry::{FEW, Point, SAMPLE, Vector, range};
use crate::mesh::{EdgeMap, Mesh, VertexRings};
use crate::statistics::level;

/// The steps of the heights of a scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Terraces {
    axis: usize,
    /// The distance between neighbouring heights, in the unit of the mesh. Where it grows with the height, that at
    /// the mean height.
    pub step: f64,
    /// The distance between neighbouring reciprocals of heights, if these are in even steps and the heights are not.
    reciprocal: Option<f64>,
}

/// A lattice has at least so many heights: two heights are also those of a plate.
const LEAST_HEIGHTS: usize = 3;

/// Edges climb so many steps on average at most. Steps that are far below the climb are only the rounding of the file.
const MOST_STEPS: f64 = 10.0;

/// Triangles beside an edge are flat if they turn by less than this share of a step. Heights in steps make
/// bends of a whole number of steps over the few triangles across them.
const FLAT: f64 = 0.01;

/// The least share of vertices at which terraces bend both ways, of those at which they bend at all. It is an eighth
/// where terraces are twenty vertices wide, and more than a half where the sensor has noise of its own.
const BOTH_WAYS: f64 = 0.05;

/// Small patches of terraces are rougher than this share of the noise of the steps, even if few patches have the end of a
/// terrace in them. Smooth heights leave rounding errors.
const LEAST_ROUGH: f64 = 0.1;

impl Terraces {
    /// Finds the steps of a mesh, if its heights have some.
    pub(crate) fn of(mesh: &Mesh) -> Option<Self> {
        let found = Self::likely(mesh)?;
        found.is_rough(&patches(mesh, &VertexRings::new(mesh))).then_some(found)
    }

    /// Steps that the heights of a mesh may have.
    pub(super) fn likely(mesh: &Mesh) -> Option<Self> {
        let axis = main_axis(mesh)?;
        let every = mesh.points.len().div_ceil(SAMPLE).max(1);
        let heights: Vec<f64> = mesh.points.iter().step_by(every).map(|p| p[axis]).collect();
        let is_found =
            |found: &Self| found.has_few_for_each_edge(mesh) && found.bends_both_ways(mesh);
        let even = step(heights.clone()).map(|step| Terraces { axis, step, reciprocal: None });
        even.filter(is_found).or_else(|| Self::growing(axis, &heights).filter(is_found))
    }

    /// Steps of heights whose reciprocals are in even steps. The file measures such heights from the camera.
    fn growing(axis: usize, heights: &[f64]) -> Option<Self> {
        let [low, high] = range(heights.iter().copied());
        let away = low > 0.0 || high < 0.0;
        let reciprocal = away.then(|| step(heights.iter().map(|z| 1.0 / z).collect())).flatten()?;
        let mean = heights.iter().sum::<f64>() / heights.len() as f64;
        Some(Terraces { axis, step: reciprocal * mean * mean, reciprocal: Some(reciprocal) })
    }

    /// The step at a height.
    fn step_at(self, height: f64) -> f64 {
        self.reciprocal.map_or(self.step, |step| step * height * height)
    }

    /// The variance of a fit around points that span these heights. Errors cancel only among different steps.
    pub(crate) fn variance(self, heights: impl Iterator<Item = Point>) -> f64 {
        let [low, high] = range(heights.map(|p| p[self.axis]));
        let step = self.step_at(low / 2.0 + high / 2.0);
        (deviation(step) / ((high - low) / step).max(1.0)).powi(2)
    }

    /// The standard deviation of the heights, at the mean height if it grows.
    pub(crate) fn deviation(self) -> f64 {
        deviation(self.step)
    }

    /// The standard deviation at each point, if it grows with the height.
    pub(super) fn deviations(self, points: &[Point]) -> Option<Vec<f32>> {
        let at = |p: &Point| deviation(self.step_at(p[self.axis])) as f32;
        self.reciprocal.map(|_| points.iter().map(at).collect())
    }

    /// Whether heights are off smooth surfaces, as those of a grid of x y are not.
    pub(super) fn is_rough(self, patches: &[NoisePatch]) -> bool {
        let squares = patches.iter().map(|patch| patch.fits[DEGREES - 1].mean_square());
        let sum: f64 = squares.filter(|square| square.is_finite()).sum();
        sum > patches.len() as f64 * (LEAST_ROUGH * self.deviation()).powi(2)
    }

    /// Whether edges climb by few steps, and none is a wall.
    fn has_few_for_each_edge(self, mesh: &Mesh) -> bool {
        let sides = 3 * mesh.triangles.len();
        let climb = |side: usize| {
            let (a, b) = mesh.side(side);
            let along = mesh.point(b) - mesh.point(a);
            let climb = along[self.axis].abs();
            let steps = climb / self.step_at(mesh.point(a)[self.axis]);
            let is_wall = steps > 0.5 && climb > (1.0 - FLAT) * along.norm();
            (!is_wall).then_some(steps)
        };
        let sum = (0..sides).map(climb).sum::<Option<f64>>();
        sum.is_some_and(|sum| sum > 0.0 && sum <= MOST_STEPS * sides as f64)
    }

    /// Whether the mesh bends both ways at many of the vertices at which it bends.
    fn bends_both_ways(self, mesh: &Mesh) -> bool {
        let edges = EdgeMap::new(mesh);
        let mut bends = vec![[false; 2]; mesh.points.len()];
        for side in 0..3 * mesh.triangles.len() {
            let Some(other) = edges.across(side).filter(|&other| side < other) else { continue };
            let (a, b) = mesh.side(side);
            let third = mesh.triangles[other / 3][(other % 3 + 2) % 3];
            let normal = mesh.area_vector(mesh.triangles[side / 3]);
            let off = normal.dot(&(mesh.point(third) - mesh.point(a)));
            if off.abs() > FLAT * self.step_at(mesh.point(a)[self.axis]) * normal.norm() {
                for v in [a, b] {
                    bends[v.index()][usize::from(off > 0.0)] = true;
                }
            }
        }
        let bent = bends.iter().filter(|of| of.contains(&true)).count();
        let both = bends.iter().filter(|&&of| of == [true; 2]).count();
        both >= FEW && both as f64 >= BOTH_WAYS * bent as f64
    }
}

/// The axis along which a mesh is a field of heights: most of its area faces it.
fn main_axis(mesh: &Mesh) -> Option<usize> {
    let size = |t| mesh.area_vector(t).abs();
    let sums: Vector = mesh.triangles.iter().map(|&t| size(t)).sum();
    (0..3).max_by(|&i, &j| sums[i].total_cmp(&sums[j])).filter(|&i| sums[i] > 0.0)
}

/// The largest number of which all differences of heights are multiples, if the rounding of numbers does not explain
/// them.
fn step(mut heights: Vec<f64>) -> Option<f64> {
    heights.sort_unstable_by(f64::total_cmp);
    // Of two numbers of single precision, each may be off by half of its last place.
    let slack =
        f64::from(f32::EPSILON) * heights.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let mut step = 0.0;
    let mut count = 1;
    for pair in heights.windows(2) {
        let gap = pair[1] - pair[0];
        if gap > slack {
            count += 1;
            // The remainder of a gap of up to three steps adds up their errors and its own.
            step = common_divisor(gap, step, 4.0 * slack);
        }
    }
    (count >= LEAST_HEIGHTS && step * level() > slack).then_some(step)
}

/// The standard deviation of heights that are spread evenly over a step.
fn deviation(step: f64) -> f64 {
    step / 12f64.sqrt()
}

/// Euclid's greatest common divisor of two numbers that are `slack` off.
fn common_divisor(mut a: f64, mut b: f64, slack: f64) -> f64 {
    while b > slack {
        (a, b) = (b, (a - (a / b).round() * b).abs());
    }
    a
}
