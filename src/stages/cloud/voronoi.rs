//! The Voronoi star of every vertex: its cell in its own tangent plane, and the triangles that the
//! corners of the cell are dual to (Gopi, Krishnan, Silva, *Surface reconstruction based on lower
//! dimensional localized Delaunay triangulation*, 2000; Boltcheva, Lévy, *Surface reconstruction by
//! computing restricted Voronoi cells in parallel*, 2017).

use nalgebra::Vector2;
use rayon::prelude::*;
use smallvec::SmallVec;

use super::CHUNK;
use super::layers::AreJoined;
use super::nearest_lists::NearestLists;
use super::project::SurfacePoint;
use crate::geometry::{NONE, Point, SAME_SIDE, plane_axes};
use crate::statistics::median;

/// The number of neighbours that may have a part of the cell's outline. 20 reach beyond the second
/// ring of neighbours.
const NEIGHBOURS: usize = 20;

/// The number of neighbours whose mean distance measures the spacing of vertices: an even sheet has
/// six.
const RING: usize = 6;

/// A cell is clipped to a square of this half side, in spacings.
const HALF_SIDE: f64 = 3.0;

/// The longest edge of a triangle, in spacings. Longer ones would close holes of two missing
/// points, shorter ones would open the cells of uneven sheets.
const LONGEST_EDGE: f64 = 3.0;

/// The stars of all vertices.
pub(super) struct VoronoiStars {
    starts: Vec<usize>,
    /// The neighbours around each vertex, counter-clockwise about its normal. The highest bit
    /// says that the vertex, this neighbour and the next one are a triangle.
    around: Vec<u32>,
}

/// The bit of a neighbour that says that there is a triangle. Points are numbered with the others.
pub(super) const TRIANGLE: u32 = 1 << 31;

impl VoronoiStars {
    /// Computes the stars of all vertices. `are_joined` says whether two of them are in one layer, if there are several.
    pub(super) fn new(vertices: &[SurfacePoint], are_joined: Option<&AreJoined<'_>>) -> Self {
        let places: Vec<Point> = vertices.iter().map(|v| v.place).collect();
        // Sheets of fewer vertices than that may remain of many points.
        let count = NEIGHBOURS.min(places.len().saturating_sub(1));
        let lists = NearestLists::of_joined(&places, count, are_joined);
        let numbers = || (0..places.len()).into_par_iter().with_min_len(CHUNK);
        let spacing: Vec<f64> = numbers().map(|i| ring_distance(i, &places, &lists)).collect();
        let star = |cell: &mut VoronoiCell, i: usize| {
            cell.clip(i, vertices, lists.of(i), spacing[i]);
            cell.star(i, &places, &spacing)
        };
        let stars: Vec<SmallVec<[u32; 8]>> =
            numbers().map_init(VoronoiCell::default, star).collect();
        let mut all = VoronoiStars { starts: vec![0], around: Vec::new() };
        for star in stars {
            all.around.extend(star);
            all.starts.push(all.around.len());
        }
        all
    }

    /// The number of vertices.
    pub(crate) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The pairs of neighbours that make a triangle with vertex `i`, counter-clockwise.
    pub(crate) fn triangles(&self, i: u32) -> impl Iterator<Item = [u32; 2]> + '_ {
        let star = &self.around[self.starts[i as usize]..self.starts[i as usize + 1]];
        let nexts = star.iter().cycle().skip(1);
        let pairs = star.iter().zip(nexts).filter(|(a, _)| **a & TRIANGLE != 0);
        pairs.map(|(a, b)| [a & !TRIANGLE, b & !TRIANGLE])
    }

    /// Whether vertex `i` makes a triangle with these two.
    pub(crate) fn has(&self, i: u32, [a, b]: [u32; 2]) -> bool {
        self.triangles(i).any(|pair| pair == [a, b] || pair == [b, a])
    }
}

/// The mean distance of a vertex from the nearest ones.
fn ring_distance(i: usize, places: &[Point], lists: &NearestLists) -> f64 {
    let ring = &lists.of(i)[..RING.min(lists.count())];
    let sum: f64 = ring.iter().map(|&j| (places[j as usize] - places[i]).norm()).sum();
    sum / ring.len().max(1) as f64
}

/// A convex polygon around a vertex.
#[derive(Default)]
struct VoronoiCell {
    /// The corners, counter-clockwise, each with the neighbour whose bisector the side behind it
    /// is on, or [`NONE`] behind a side of the square.
    corners: Vec<(Vector2<f64>, u32)>,
    old: Vec<(Vector2<f64>, u32)>,
}

impl VoronoiCell {
    fn clip(&mut self, i: usize, vertices: &[SurfacePoint], list: &[u32], spacing: f64) {
        let own = &vertices[i];
        let (x, y) = plane_axes(own.normal);
        let half = HALF_SIDE * spacing;
        self.corners.clear();
        let square = [(-half, -half), (half, -half), (half, half), (-half, half)];
        self.corners.extend(square.map(|(x, y)| (Vector2::new(x, y), NONE)));
        for &j in list {
            let other = &vertices[j as usize];
            let d = other.place - own.place;
            let squared = d.norm_squared();
            let farthest = self.corners.iter().map(|c| c.0.norm_squared()).fold(0.0, f64::max);
            if squared > 4.0 * farthest {
                break;
            }
            // Neighbours whose normals differ by more than 60° are on another sheet.
            if other.normal.dot(&own.normal).abs() < SAME_SIDE {
                continue;
            }
            let flat = Vector2::new(d.dot(&x), d.dot(&y));
            // Laid into the plane at its true distance.
            let Some(direction) = flat.try_normalize(0.0) else { continue };
            self.cut(direction, 0.5 * squared.sqrt(), j);
        }
    }

    /// Cuts away what is farther than `offset` in the `direction` of neighbour `j`.
    fn cut(&mut self, direction: Vector2<f64>, offset: f64, j: u32) {
        let beyond = |p: &Vector2<f64>| p.dot(&direction) - offset;
        if self.corners.iter().all(|c| beyond(&c.0) <= 0.0) {
            return;
        }
        std::mem::swap(&mut self.corners, &mut self.old);
        self.corners.clear();
        let nexts = self.old.iter().cycle().skip(1);
        for (&(p, side), &(q, _)) in self.old.iter().zip(nexts) {
            let (a, b) = (beyond(&p), beyond(&q));
            if a <= 0.0 {
                self.corners.push((p, side));
            }
            if (a <= 0.0) != (b <= 0.0) {
                let crossing = p + (q - p) * (a / (a - b));
                self.corners.push((crossing, if a <= 0.0 { j } else { side }));
            }
        }
    }

    /// The neighbours around the cell, with the bit for triangles.
    fn star(&self, i: usize, places: &[Point], spacing: &[f64]) -> SmallVec<[u32; 8]> {
        let count = self.corners.len();
        let side = |k: usize| self.corners[k % count].1;
        let sides = (0..count).filter(|&k| side(k) != NONE);
        let marked = |k: usize| {
            let (j, next) = (side(k), side(k + 1));
            let is_triangle =
                next != NONE && is_short([i, j as usize, next as usize], places, spacing);
            if is_triangle { j | TRIANGLE } else { j }
        };
        sides.map(marked).collect()
    }
}

/// Whether no edge of a triangle is too long for its corners' spacing. The median of the three is
/// taken, because an outlier beside the sheet has a large spacing.
fn is_short(corners: [usize; 3], places: &[Point], spacing: &[f64]) -> bool {
    let [a, b, c] = corners.map(|v| places[v]);
    let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
    let middle = median(&mut corners.map(|v| spacing[v])).unwrap_or(0.0);
    longest <= (LONGEST_EDGE * middle).powi(2)
}
