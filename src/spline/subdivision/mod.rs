//! Catmull–Clark subdivision surfaces.
//!
//! A closed mesh of quads with control points at its vertices goes in. Points and derivatives of
//! the limit surface come out, as combinations of control points (Catmull and Clark, "Recursively
//! generated B-spline surfaces on arbitrary topological meshes", 1978). On a quad whose four
//! vertices have four quads each the limit surface is a uniform bicubic polynomial.

mod rings;
mod table;

use std::collections::BTreeMap;
use std::f64::consts::PI;

use crate::geometry::{Point, Quarter, Uv, Vector, VertexId};
use rings::HalfEdges;
pub(crate) use table::REGULAR;
use table::Table;

/// The structure of a subdivision surface: which control points each place depends on, and with
/// which weights. The control points are kept apart, so that a fit can change them.
#[derive(Debug, Clone)]
pub struct SubdivisionSurface {
    edges: HalfEdges,
    tables: BTreeMap<usize, Table>,
    /// For each quad its origin, which is the corner with another number of quads than four if there
    /// is one, and the valence there.
    origins: Vec<(u8, usize)>,
    /// The control points of quad `q` are at `starts[q]..starts[q + 1]`.
    starts: Vec<usize>,
    control: Vec<u32>,
    /// For each vertex a half-edge that leaves it.
    spokes: Vec<usize>,
}

/// A place of the surface: a quad, and a point of its unit square. Corner 0 of the quad is at
/// (0, 0), corner 1 at (1, 0), and corner 3 at (0, 1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuadPlace {
    /// The number of the quad.
    pub quad: usize,
    /// The place on the quad.
    pub at: Uv,
}

impl SubdivisionSurface {
    /// The surface over closed, oriented quads. Returns `None` if they are not closed, or if a quad
    /// has several corners with other than four quads.
    pub fn new(quads: &[[VertexId; 4]]) -> Option<Self> {
        let edges = HalfEdges::new(quads)?;
        let count = quads.iter().flatten().map(|v| v.index() + 1).max()?;
        let mut spokes = vec![usize::MAX; count];
        for h in (0..4 * quads.len()).rev() {
            spokes[quads[h / 4][h % 4].index()] = h;
        }
        let valence: Vec<usize> =
            spokes.iter().map(|&h| if h == usize::MAX { 0 } else { edges.valence(h) }).collect();
        let mut origins = Vec::with_capacity(quads.len());
        let mut starts = vec![0];
        let mut control = Vec::new();
        for (q, quad) in quads.iter().enumerate() {
            let irregular = (0..4).filter(|&k| valence[quad[k].index()] != 4);
            let irregular: Vec<usize> = irregular.collect();
            let origin = match irregular[..] {
                [] => 0,
                [k] => k,
                _ => return None,
            };
            edges.control(4 * q + origin, &mut control);
            starts.push(control.len());
            origins.push((origin as u8, valence[quad[origin].index()]));
        }
        let valences = origins.iter().map(|o| o.1);
        let tables = valences.map(|n| (n, ())).collect::<BTreeMap<_, _>>();
        let tables = tables.into_keys().map(|n| (n, Table::new(n))).collect();
        Some(SubdivisionSurface { edges, tables, origins, starts, control, spokes })
    }

    /// The numbers of the control points that a quad depends on.
    pub(crate) fn control(&self, quad: usize) -> &[u32] {
        &self.control[self.starts[quad]..self.starts[quad + 1]]
    }

    /// Whether all four vertices of a quad have four quads.
    pub fn is_regular(&self, quad: usize) -> bool {
        self.origins[quad].1 == 4
    }

    /// Puts the value and the derivatives in u and v of each basis function at a place into `out`,
    /// in the order of [`SubdivisionSurface::control`].
    pub(crate) fn basis(&self, place: QuadPlace, out: &mut Vec<[f64; 3]>) {
        let (origin, valence) = self.origins[place.quad];
        let origin = Quarter(usize::from(origin));
        let [u, v] = origin.turned_back(1.0, place.at.into());
        out.clear();
        if let Some(table) = self.tables.get(&valence) {
            table.basis(u, v, out);
        }
        for weight in out {
            let [value, du, dv] = *weight;
            let [du, dv] = origin.turned(0.0, [du, dv]);
            *weight = [value, du, dv];
        }
    }

    /// The point and the derivatives in u and v at a place. `scratch` is working memory.
    pub fn jet(
        &self,
        control: &[Vector],
        place: QuadPlace,
        scratch: &mut Vec<[f64; 3]>,
    ) -> [Vector; 3] {
        self.basis(place, scratch);
        let mut sums = [Vector::zeros(); 3];
        for (&v, weight) in self.control(place.quad).iter().zip(scratch.iter()) {
            let p = control[v as usize];
            sums.iter_mut().zip(weight).for_each(|(sum, w)| *sum += p * *w);
        }
        sums
    }

    /// The quad on the other side of side `k` of a quad, and the number of the side there.
    pub(crate) fn across(&self, quad: usize, k: usize) -> (usize, usize) {
        let twin = self.edges.twin(4 * quad + k);
        (twin / 4, twin % 4)
    }

    /// The vertex and its ring around corner `k` of a quad: the vertex, then counter-clockwise from
    /// the side that leaves the corner a neighbour and the opposite corner of a quad, in turn.
    pub fn ring(&self, quad: usize, k: usize) -> Vec<u32> {
        let mut ring = Vec::new();
        self.edges.ring(4 * quad + k, &mut ring);
        ring
    }

    /// The unit normal of the limit surface at corner `k` of a quad. `control` has the control points. It is
    /// zero if the two tangents there are parallel.
    pub(crate) fn limit_normal(&self, quad: usize, k: usize, control: &[Vector]) -> Vector {
        let tangent = |quad, k| limit_tangent(&self.ring(quad, k), control);
        // The second tangent leaves the corner along the previous side, which ends there.
        let (other, side) = self.across(quad, (k + 3) % 4);
        tangent(quad, k).cross(&tangent(other, side)).try_normalize(0.0).unwrap_or_default()
    }

    /// A quad at a vertex, and the number of the corner there.
    pub fn corner(&self, v: VertexId) -> (usize, usize) {
        let h = self.spokes[v.index()];
        (h / 4, h % 4)
    }
}

/// The weights of the control points of a ring in the point of the limit surface at its centre
/// (Halstead, Kass, DeRose, "Efficient, fair interpolation using Catmull-Clark surfaces", 1993).
/// `length` is the number of points of the ring.
pub(crate) fn limit_weights(length: usize) -> impl Iterator<Item = f64> {
    let n = (length / 2) as f64;
    let all = n * (n + 5.0);
    (0..length).map(move |k| match k {
        0 => n * n / all,
        k if k % 2 == 1 => 4.0 / all,
        _ => 1.0 / all,
    })
}

/// The point of the limit surface at the centre of a ring.
pub fn limit_point(ring: &[u32], control: &[Vector]) -> Point {
    let terms = ring.iter().zip(limit_weights(ring.len()));
    Point::from(terms.map(|(&v, weight)| weight * control[v as usize]).sum::<Vector>())
}

/// A tangent of the limit surface at the centre of a ring, in the direction in which the first
/// spoke of the ring leaves it. Its length has no meaning.
pub(crate) fn limit_tangent(ring: &[u32], control: &[Vector]) -> Vector {
    let n = ring.len() / 2;
    let turn = 2.0 * PI / n as f64;
    let half = (0.5 * turn).cos();
    let weight = 1.0 + turn.cos() + half * (2.0 * (9.0 + turn.cos())).sqrt();
    let each = (0..n).map(|k| {
        let [here, next] = [k, k + 1].map(|k| (k as f64 * turn).cos());
        let at = |k: usize| control[ring[k] as usize];
        weight * here * at(1 + 2 * k) + (here + next) * at(2 + 2 * k)
    });
    each.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube whose sides are grids of `n` × `n` quads.
    fn cube(n: usize) -> (Vec<[VertexId; 4]>, Vec<Vector>) {
        let mut numbers = BTreeMap::new();
        let mut points = Vec::new();
        let mut quads = Vec::new();
        for axis in 0..3 {
            for (side, far) in [(0, 0), (1, n)] {
                let mut at = |a: usize, b: usize| {
                    let mut p = [0; 3];
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (far, a, b);
                    let next = VertexId::from(points.len());
                    *numbers.entry(p).or_insert_with(|| {
                        points.push(Vector::from(p.map(|x| x as f64)));
                        next
                    })
                };
                for (a, b) in (0..n * n).map(|k| (k % n, k / n)) {
                    let mut quad =
                        [(a, b), (a + 1, b), (a + 1, b + 1), (a, b + 1)].map(|(a, b)| at(a, b));
                    if side == 0 {
                        quad.reverse();
                    }
                    quads.push(quad);
                }
            }
        }
        (quads, points)
    }

    #[test]
    fn neighbouring_quads_agree_along_their_side() {
        let (quads, control) = cube(3);
        let surface = SubdivisionSurface::new(&quads).unwrap();
        let mut scratch = Vec::new();
        // Places on side k of a quad, from its start to its end.
        let on = |k: usize, t: f64| Quarter(k).turned(1.0, [t, 0.0]).into();
        for (quad, k) in (0..4 * quads.len()).map(|h| (h / 4, h % 4)) {
            let (other, side) = surface.across(quad, k);
            for t in [0.1, 0.37, 0.8] {
                let here = surface.jet(&control, QuadPlace { quad, at: on(k, t) }, &mut scratch);
                let there = QuadPlace { quad: other, at: on(side, 1.0 - t) };
                let there = surface.jet(&control, there, &mut scratch);
                assert!((here[0] - there[0]).norm() < 1e-12);
                let [n, m] = [here, there].map(|jet| jet[1].cross(&jet[2]).normalize());
                assert!((n - m).norm() < 1e-10, "{quad} {k} {t}");
                assert!(
                    n.dot(&(here[0] - Vector::repeat(1.5))) > 0.0,
                    "the normal points outwards"
                );
            }
        }
    }

    #[test]
    fn limits_at_vertices_are_those_of_the_surface_near_them() {
        let (quads, control) = cube(2);
        let surface = SubdivisionSurface::new(&quads).unwrap();
        let mut scratch = Vec::new();
        for (quad, k) in (0..4 * quads.len()).map(|h| (h / 4, h % 4)) {
            let ring = surface.ring(quad, k);
            let e = 1e-7;
            let near = QuadPlace { quad, at: Quarter(k).turned(1.0, [e, 0.0]).into() };
            let jet = surface.jet(&control, near, &mut scratch);
            let off = jet[0] - limit_point(&ring, &control).coords;
            assert!(off.norm() < 1e-3);
            let along = [jet[1], jet[2], -jet[1], -jet[2]][k].normalize();
            let tangent = limit_tangent(&ring, &control).normalize();
            assert!((along - tangent).norm() < 1e-3, "{quad} {k}: {along} {tangent}");
        }
    }
}
