//! Refinement of a triangulation to given edge lengths. All operations work in space, because there
//! is no parameter plane yet.

use foldhash::{HashMap, HashSet};
use smallvec::SmallVec;

use super::flips::{EdgeFlip, Sides, flip};
use super::{FLAT, FOLDED, Sizes, TOO_LONG};
use crate::geometry::{MOST_ROUNDS, Point, Vector, VertexId, unit_normal};

/// The triangulation has at most this multiple of the number of rim corners.
const MAX_POINTS_RATIO: usize = 40;

/// A triangulation over the corners of rims, which stay in place. The other points follow them.
pub(crate) struct RimTriangulation {
    pub points: Vec<Point>,
    pub triangles: Vec<[usize; 3]>,
    /// The number of rim corners.
    pub rim: usize,
    /// The unit normals of the surface beyond the sides of the rims. The keys are the sides in the
    /// direction of this triangulation's triangles.
    pub beside: HashMap<(usize, usize), Vector>,
}

impl RimTriangulation {
    /// Divides edges, flips them and moves points until all edges are short enough. Corners that
    /// are `joined` outside this triangulation are not joined by a flip.
    pub(crate) fn refine(&mut self, sizes: &Sizes, joined: impl Fn(usize, usize) -> bool) {
        for _ in 0..MOST_ROUNDS {
            let divided = self.divide(sizes);
            self.flip(&joined);
            self.smooth_points();
            if !divided {
                break;
            }
        }
    }

    /// Divides long edges, as [`divide`] does.
    fn divide(&mut self, sizes: &Sizes) -> bool {
        let most = MAX_POINTS_RATIO * self.rim;
        !divide(&mut self.points, &mut self.triangles, |at| sizes.at(at), most).is_empty()
    }

    /// Flips edges where both new triangles face about the same way as the old ones.
    fn flip(&mut self, joined: impl Fn(usize, usize) -> bool) {
        let points = &self.points;
        let may = |edge: &EdgeFlip| {
            let [old, new] = [edge.old, edge.new].map(|pair| pair.map(|t| normal(points, t)));
            let facing = |n: &Vector| n.dot(&(old[0] + old[1])) > 0.0;
            new[0].dot(&new[1]) >= old[0].dot(&old[1]).min(FLAT) && new.iter().all(facing)
        };
        let mut sides = Sides::of(&self.triangles);
        flip(points, &mut self.triangles, &mut sides, joined, may);
    }

    /// Divides inner sides until no two sides join the same two vertices. They can if several rim corners are
    /// the same vertex. `vertices` has the vertex of each rim corner.
    pub(crate) fn divide_doubled(&mut self, vertices: &[VertexId]) {
        let joined = |corners: [usize; 2]| {
            let [v, w] = corners.map(|corner| vertices.get(corner).copied().ok_or(corner));
            (v.min(w), v.max(w))
        };
        loop {
            let sides = Sides::of(&self.triangles);
            let mut taken: HashSet<_> = sides.outer().map(joined).collect();
            let doubled: Vec<_> =
                sides.inner().filter(|&(ends, _)| !taken.insert(joined(ends))).collect();
            if doubled.is_empty() {
                return;
            }
            divide_sides(&mut self.points, &mut self.triangles, doubled, usize::MAX);
        }
    }

    /// Moves points near folded sides until nothing folds or the points stop moving.
    pub(crate) fn unfold(&mut self, joined: impl Fn(usize, usize) -> bool) {
        for _ in 0..MOST_ROUNDS {
            let before = self.points.clone();
            self.flip(&joined);
            self.smooth_points();
            if self.points == before {
                break;
            }
        }
    }

    /// Moves each inner point towards the mean of its neighbours. A move is kept if no triangle
    /// turns far by it, or if it reduces the number of folded sides.
    fn smooth_points(&mut self) {
        let mut facets = Facets::new(self);
        let mut around: Vec<SmallVec<[usize; 8]>> = vec![SmallVec::new(); self.points.len()];
        for (number, t) in self.triangles.iter().enumerate() {
            t.iter().filter(|v| **v >= self.rim).for_each(|&v| around[v].push(number));
        }
        for (v, around) in around.iter().enumerate().skip(self.rim) {
            if around.is_empty() {
                continue;
            }
            let corners = || around.iter().flat_map(|&t| self.triangles[t]).filter(|w| *w != v);
            let sum: Vector = corners().map(|w| self.points[w].coords).sum();
            let (old, mean) = (self.points[v], Point::from(sum / corners().count() as f64));
            let before: SmallVec<[Vector; 8]> = around.iter().map(|&t| facets.normals[t]).collect();
            let folds = facets.folds(around);
            let is_good = |facets: &Facets| {
                let pairs = || around.iter().zip(&before);
                let turned = || pairs().any(|(&t, n)| n.dot(&facets.normals[t]) < 0.5);
                let now = facets.folds(around);
                now < folds || (now == folds && !turned())
            };
            for share in [1.0, 0.3] {
                self.points[v] = old + share * (mean - old);
                for &t in around {
                    facets.normals[t] = normal(&self.points, self.triangles[t]);
                }
                if is_good(&facets) {
                    break;
                }
                self.points[v] = old;
                around.iter().zip(&before).for_each(|(&t, n)| facets.normals[t] = *n);
            }
        }
    }
}

/// Divides edges that are longer than wanted, the longest first, and at most one for each triangle.
/// `length` gives the wanted length at a place. There are at most `most` points afterwards. Returns
/// the two triangles at each divided edge. Each division adds a triangle for the first one of them,
/// and then a triangle for the second one.
pub(crate) fn divide(
    points: &mut Vec<Point>,
    triangles: &mut Vec<[usize; 3]>,
    length: impl Fn(Point) -> f64,
    most: usize,
) -> Vec<[usize; 2]> {
    let sides = Sides::of(triangles);
    let mut long: Vec<(f64, [usize; 2], [usize; 2])> = sides
        .inner()
        .map(|(ends, beside)| {
            let [p, q] = ends.map(|v| points[v]);
            ((q - p).norm() / length(nalgebra::center(&p, &q)), ends, beside)
        })
        .filter(|edge| edge.0 > TOO_LONG)
        .collect();
    long.sort_unstable_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
    let long = long.into_iter().map(|(_, ends, beside)| (ends, beside));
    divide_sides(points, triangles, long, most)
}

/// Divides sides, each given by its ends and the triangles beside it, and at most one for each triangle. There
/// are at most `most` points afterwards. Returns the triangles at each divided side.
fn divide_sides(
    points: &mut Vec<Point>,
    triangles: &mut Vec<[usize; 3]>,
    sides: impl IntoIterator<Item = ([usize; 2], [usize; 2])>,
    most: usize,
) -> Vec<[usize; 2]> {
    let mut divided = Vec::new();
    let mut changed = vec![false; triangles.len()];
    for ([a, b], [s, t]) in sides {
        if changed[s] || changed[t] || points.len() >= most {
            continue;
        }
        let new = points.len();
        points.push(nalgebra::center(&points[a], &points[b]));
        divided.push([s, t]);
        for (number, from, to) in [(s, a, b), (t, b, a)] {
            changed[number] = true;
            let own = triangles[number];
            let with = |old: usize| own.map(|v| if v == old { new } else { v });
            triangles[number] = with(to);
            triangles.push(with(from));
        }
    }
    divided
}

/// What lies across a side of a triangle.
#[derive(Clone, Copy)]
enum Across {
    /// Another triangle.
    Triangle(usize),
    /// The surface beyond a rim, with its normal.
    Rim(Vector),
    Nothing,
}

/// The normals of the triangles, and what lies across their sides.
struct Facets {
    normals: Vec<Vector>,
    across: Vec<[Across; 3]>,
}

impl Facets {
    fn new(surface: &RimTriangulation) -> Self {
        let sides = Sides::of(&surface.triangles);
        let across = |&t: &[usize; 3]| {
            [0, 1, 2].map(|k| {
                let (v, w) = (t[k], t[(k + 1) % 3]);
                match sides.get(w, v) {
                    Some(other) => Across::Triangle(other),
                    None => {
                        surface.beside.get(&(v, w)).map_or(Across::Nothing, |n| Across::Rim(*n))
                    }
                }
            })
        };
        Facets {
            normals: surface.triangles.iter().map(|&t| normal(&surface.points, t)).collect(),
            across: surface.triangles.iter().map(across).collect(),
        }
    }

    /// The number of folded sides of some triangles. A side between two of them counts twice.
    fn folds(&self, triangles: &[usize]) -> usize {
        let at = |&t: &usize| {
            let folds = |across: &&Across| match across {
                Across::Triangle(other) => self.normals[*other].dot(&self.normals[t]) < FOLDED,
                Across::Rim(normal) => normal.dot(&self.normals[t]) < FOLDED,
                Across::Nothing => false,
            };
            self.across[t].iter().filter(folds).count()
        };
        triangles.iter().map(at).sum()
    }
}

fn normal(points: &[Point], t: [usize; 3]) -> Vector {
    unit_normal(t.map(|v| points[v])).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_sides_join_the_same_vertices_at_a_bridge() {
        // The loop passes the bridge between vertices 1 and 2 in both directions.
        let vertices = [0, 1, 2, 3, 4, 2, 1].map(VertexId::from);
        let rim = vertices.len();
        let at = |k: usize| Point::new(k as f64, (k * k) as f64, 0.0);
        let fan = (0..rim).map(|k| [k, (k + 1) % rim, rim]).collect();
        let points = (0..=rim).map(at).collect();
        let beside = HashMap::default();
        let mut surface = RimTriangulation { points, triangles: fan, rim, beside };
        surface.divide_doubled(&vertices);
        assert_eq!((surface.points.len(), surface.triangles.len()), (rim + 3, 7 + 4));
        let vertex = |v: usize| vertices.get(v).map_or(v + 100, |v| v.index());
        let sides = surface.triangles.iter().flat_map(|t| (0..3).map(|k| [t[k], t[(k + 1) % 3]]));
        let mut seen = HashSet::default();
        for side in sides {
            assert!(seen.insert(side.map(vertex)), "{side:?} comes twice");
        }
    }
}
