//! Relaxation: moves of single vertices in the parameter plane that reduce the stretch.
//!
//! The energy is the square of the L² stretch (Sander, Snyder, Gortler, Hoppe, "Texture mapping
//! progressive meshes", 2001): ∫ |F|² / det² F over the surface, where F is the derivative of the
//! map to the plane. This energy is not rank-one convex where the map stretches by more than 3.8
//! times as much in one direction as in the other. Its minima form creases there, which the
//! literature calls parameter cracks. A share of ½ |F|⁴ / det³ F is therefore mixed in. This term
//! is polyconvex, equals the first one where the map is conformal, and scales in the same way. Both
//! terms tend to infinity as the area of a triangle tends to zero, and a step that would invert a
//! triangle is not made.

use nalgebra::Matrix2;
use rayon::prelude::*;

use crate::geometry::{NONE, Point, Uv, UvVector};
use crate::mesh::one_rings::OneRings;

/// The directions in which a vertex may move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Freedom {
    /// None: the vertex is a corner.
    None,
    /// Along x: the vertex is on a horizontal side.
    AlongX,
    /// Along y: the vertex is on a vertical side.
    AlongY,
    /// All directions: the vertex is inside.
    Full,
}

/// The data of the energy, apart from the map.
pub(crate) struct StretchEnergy<'a> {
    /// Points in space, one for each vertex.
    pub points: &'a [Point],
    /// The weight of the surface around each vertex.
    pub weights: &'a [f64],
    /// The directions in which each vertex may move.
    pub freedom: &'a [Freedom],
    /// The weight of the convex energy term. With 0.1 the energy is rank-one convex up to a ratio
    /// of stretches of 6; with 0.25 beyond 10.
    pub convex_weight: f64,
}

/// The smallest area with which a triangle enters the energy, as a share of its longest squared
/// side.
const THINNEST: f64 = 0.02;

/// A step may cover at most this share of the way to the place where a triangle would vanish.
const MAX_STEP_SHARE: f64 = 0.8;

/// The over-relaxation factor of a step: it goes half as far again as the minimum of the star.
/// Successive over-relaxation spreads changes faster over the mesh.
const OVER_RELAXATION: f64 = 1.5;

/// The energy of one triangle as a function of the position of one of its corners.
pub(crate) struct CornerTerm {
    /// The squares and the dot product of the two sides at this corner, in space.
    metric: [f64; 3],
    /// The factors of the two terms of the energy.
    factors: [f64; 2],
    a: Uv,
    b: Uv,
}

/// The energy at a position, its gradient and Hessian, and twice the area of the smallest triangle.
struct EnergyAt {
    energy: f64,
    gradient: UvVector,
    hessian: Matrix2<f64>,
    room: f64,
}

/// The measures of one triangle in the plane, for a position of the corner.
struct PlaneTriangle {
    /// Twice the area in the plane.
    twice: f64,
    /// |F|² times the square of twice the area in space, where F is the derivative of the map.
    squares: f64,
    d: UvVector,
    e: UvVector,
}

impl CornerTerm {
    fn flat(&self, q: Uv) -> PlaneTriangle {
        let (d, e) = (self.a - q, self.b - q);
        let [dd, de, ee] = self.metric;
        let squares = ee * d.norm_squared() - 2.0 * de * d.dot(&e) + dd * e.norm_squared();
        PlaneTriangle { twice: d.perp(&e), squares, d, e }
    }

    fn value(&self, &PlaneTriangle { twice, squares, .. }: &PlaneTriangle) -> f64 {
        let [c, k] = self.factors;
        let inverse = 1.0 / twice;
        let value = squares * inverse * inverse * (c + k * squares * inverse);
        if twice > 0.0 { value } else { f64::INFINITY }
    }

    /// Adds the energy of the triangle and its derivatives at the position of the corner.
    fn add(&self, q: Uv, here: &mut EnergyAt) {
        let flat = self.flat(q);
        here.energy += self.value(&flat);
        let PlaneTriangle { twice, squares, d, e } = flat;
        here.room = here.room.min(twice);
        let [dd, de, ee] = self.metric;
        // The derivatives of `squares` and `twice`.
        let gs = -2.0 * (ee * d - de * (d + e) + dd * e);
        let hs = 2.0 * (ee - 2.0 * de + dd);
        let gt = UvVector::new(d.y - e.y, e.x - d.x);
        let i = 1.0 / twice;
        let [c, k] = self.factors.map(|f| f * i * i);
        let (k, s) = (k * i, squares);
        here.gradient += (c + 2.0 * k * s) * gs - s * i * (2.0 * c + 3.0 * k * s) * gt;
        let mixed = gs * gt.transpose();
        here.hessian += Matrix2::from_diagonal_element((c + 2.0 * k * s) * hs)
            + 2.0 * k * gs * gs.transpose()
            - i * (2.0 * c + 6.0 * k * s) * (mixed + mixed.transpose())
            + s * i * i * (6.0 * c + 2.0 * 6.0 * k * s) * gt * gt.transpose();
    }
}

/// The triangles around a vertex, and its position.
struct Star<'a> {
    corners: &'a [CornerTerm],
    at: Uv,
}

impl Star<'_> {
    fn energy(&self, q: Uv) -> f64 {
        self.corners.iter().map(|c| c.value(&c.flat(q))).sum()
    }

    fn evaluate(&self) -> EnergyAt {
        let (gradient, hessian) = (UvVector::zeros(), Matrix2::zeros());
        let mut here = EnergyAt { energy: 0.0, gradient, hessian, room: f64::INFINITY };
        self.corners.iter().for_each(|c| c.add(self.at, &mut here));
        here
    }

    /// The largest allowed multiple of a step. The area of a triangle is linear in the position of
    /// one corner.
    fn limit(&self, step: UvVector) -> f64 {
        let room = |c: &CornerTerm| {
            let (d, e) = (c.a - self.at, c.b - self.at);
            let change = step.x * (d.y - e.y) + step.y * (e.x - d.x);
            let twice = d.x * e.y - d.y * e.x;
            if change < 0.0 { MAX_STEP_SHARE * twice / -change } else { OVER_RELAXATION }
        };
        self.corners.iter().map(room).fold(OVER_RELAXATION, f64::min)
    }

    /// The new position of the vertex.
    fn moved(&self, here: &EnergyAt, freedom: Freedom) -> Uv {
        let step = here.step(freedom);
        if !(step.x.is_finite() && step.y.is_finite()) {
            return self.at;
        }
        let mut share = self.limit(step);
        for _ in 0..MAX_SHORTENINGS {
            let there = self.at + share * step;
            if self.energy(there) < here.energy {
                return there;
            }
            share *= 0.4;
        }
        self.at
    }
}

impl EnergyAt {
    /// The Newton step. Negative curvature is replaced by its absolute value.
    fn step(&self, freedom: Freedom) -> UvVector {
        let (g, h) = (self.gradient, self.hessian);
        match freedom {
            Freedom::None => return UvVector::zeros(),
            Freedom::AlongX => return UvVector::new(-g.x / h[(0, 0)].abs(), 0.0),
            Freedom::AlongY => return UvVector::new(0.0, -g.y / h[(1, 1)].abs()),
            Freedom::Full => (),
        }
        let mean = 0.5 * (h[(0, 0)] + h[(1, 1)]);
        let half = 0.5 * (h[(0, 0)] - h[(1, 1)]);
        let radius = (half * half + h[(0, 1)] * h[(0, 1)]).sqrt();
        let least = 1e-3 * (mean.abs() + radius);
        let (low, raise) = (mean - radius, (mean - radius).abs().max(least) - (mean - radius));
        let h = if low < least { h + Matrix2::from_diagonal_element(raise) } else { h };
        let det = h[(0, 0)] * h[(1, 1)] - h[(0, 1)] * h[(0, 1)];
        UvVector::new(h[(0, 1)] * g.y - h[(1, 1)] * g.x, h[(0, 1)] * g.x - h[(0, 0)] * g.y) / det
    }
}

/// The number of shorter steps that are tried if a step does not reduce the energy.
const MAX_SHORTENINGS: usize = 4;

/// The new position of vertex `v`, and whether it moved far. `at` gives the present positions of
/// the vertex and its neighbours. `corners` is working memory.
// Without this attribute the function is not inlined, because it has two callers. It then takes a
// tenth longer.
#[inline(always)]
pub(crate) fn moved(
    energy: &StretchEnergy,
    rings: &OneRings,
    v: u32,
    at: impl Fn(u32) -> Uv,
    corners: &mut Vec<CornerTerm>,
) -> (Uv, bool) {
    let p = energy.points[v as usize];
    let corner = |(a, b): (u32, u32)| {
        let (d, e) = (energy.points[a as usize] - p, energy.points[b as usize] - p);
        let metric = [d.norm_squared(), d.dot(&e), e.norm_squared()];
        let longest = metric[0].max(metric[2]).max((e - d).norm_squared());
        let area = d.cross(&e).norm().max(THINNEST * longest).max(f64::MIN_POSITIVE);
        let weights = [a, b, v].map(|w| energy.weights[w as usize]);
        let least = weights.iter().copied().fold(f64::INFINITY, f64::min);
        // A triangle of the scaffold has the weight of the scaffold's vertices.
        let weight = if least < 1.0 { 3.0 * least } else { weights.iter().sum() };
        let factors =
            [(1.0 - energy.convex_weight) * weight * area, 0.5 * energy.convex_weight * weight];
        CornerTerm { metric, factors, a: at(a), b: at(b) }
    };
    corners.clear();
    corners.extend(rings.sides(v).map(corner));
    let star = Star { corners, at: at(v) };
    let here = star.evaluate();
    let place = star.moved(&here, energy.freedom[v as usize]);
    (place, (place - star.at).norm_squared() > FAR_MOVE * FAR_MOVE * here.room)
}

/// A move is far if it exceeds this share of the square root of twice the area of the smallest
/// triangle.
const FAR_MOVE: f64 = 0.05;

/// Divides vertices into groups without neighbours (graph colouring). The vertices of one group can
/// move at the same time.
pub(crate) fn groups(rings: &OneRings, vertices: impl IntoIterator<Item = u32>) -> Vec<Vec<u32>> {
    let mut group = vec![NONE; rings.len()];
    let mut groups: Vec<Vec<u32>> = Vec::new();
    // For each group, the last vertex that has a neighbour in it.
    let mut beside: Vec<u32> = Vec::new();
    for v in vertices {
        for &w in rings.ring(v) {
            if let Some(last) = beside.get_mut(group[w as usize] as usize) {
                *last = v;
            }
        }
        let g = beside.iter().position(|&last| last != v).unwrap_or(groups.len());
        if g == groups.len() {
            groups.push(Vec::new());
            beside.push(NONE);
        }
        group[v as usize] = g as u32;
        groups[g].push(v);
    }
    groups
}

/// Moves every vertex of every group once. Returns the vertices that moved far relative to the size
/// of their triangles.
pub(crate) fn sweep(
    energy: &StretchEnergy,
    rings: &OneRings,
    groups: &[Vec<u32>],
    at: &mut [Uv],
) -> Vec<u32> {
    let mut far = Vec::new();
    for group in groups {
        let shown: &[Uv] = at;
        let places: Vec<(Uv, bool)> = group
            .par_iter()
            .with_min_len(256)
            .map_init(Vec::new, |corners, &v| {
                let at = |w: u32| shown[w as usize];
                moved(energy, rings, v, at, corners)
            })
            .collect();
        for (&v, (place, is_far)) in group.iter().zip(places) {
            at[v as usize] = place;
            if is_far {
                far.push(v);
            }
        }
    }
    far
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_in_different_groups_however_many_there_are() {
        // All vertices are neighbours of each other. No mesh is like this.
        let rings = OneRings::joined(100);
        let groups = groups(&rings, 0..100);
        assert_eq!(groups, (0..100).map(|v| vec![v]).collect::<Vec<_>>());
    }
}
