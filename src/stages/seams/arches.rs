//! Facets beside curved faces. Their common edge is an arch: a polynomial over the chord, on the curved face and in the plane that
//! stands on it. So no facet is too flat for its neighbour. The facet becomes a polynomial surface through its edges.

use std::f64::consts::PI;

use formats::brep::{BrepCurve, BrepSurface, EdgeId, EdgeUse, Face, PCurve};
use formats::spline::{SplineCurve, SplineKnots, SplineSurface};
use nalgebra::DMatrix;

use super::chart::array;
use super::curves::{Pair, SPLINE, SeamKind};
use super::faces::FaceBuilder;
use super::network::{Chain, ChainNetwork, ChainUse};
use super::{EXACT, FacetForm, Work};
use crate::geometry::{Point, Vector, VertexId};
use crate::primitives::{Primitive, PrimitiveKind};

/// The most heights of an arch. An arch of a third of a turn needs as many.
const MOST_HEIGHTS: usize = 11;

/// The steps of Newton's method for a height.
const STEPS: usize = 20;

/// The places where an edge is compared with its facet.
const SAMPLES: usize = 8;

/// The edge of a facet beside a curved face.
#[derive(Debug, Clone)]
pub(super) struct Arch {
    ends: [Point; 2],
    /// The unit vector, across the chord, in which the arch leaves it.
    out: Vector,
    /// The heights over the chord at Chebyshev's nodes, each divided by t (1 - t). There are none if the edge is straight.
    heights: Vec<f64>,
}

impl Arch {
    /// The arch of a surface over a chord.
    fn on(surface: &Primitive, [from, to]: [Point; 2]) -> Result<Self, String> {
        let chord = to - from;
        let along = chord.try_normalize(f64::MIN_POSITIVE).ok_or("a border without a length")?;
        let normal = surface.normal(nalgebra::center(&from, &to));
        let out = normal - normal.dot(&along) * along;
        let out = out.try_normalize(EXACT).ok_or("a border across its face")?;
        let mut arch = Arch { ends: [from, to], out, heights: Vec::new() };
        let mut best = (arch.off(surface), arch.clone());
        for count in 1..=MOST_HEIGHTS {
            if best.0 < SPLINE {
                break;
            }
            arch.heights = (0..count).map(|k| arch.height_on(surface, node(k, count))).collect();
            let off = arch.off(surface);
            if off < best.0 {
                best = (off, arch.clone());
            }
        }
        Ok(best.1)
    }

    /// The height at which a surface is, divided by t (1 - t).
    fn height_on(&self, surface: &Primitive, t: f64) -> f64 {
        let foot = self.ends[0] + t * (self.ends[1] - self.ends[0]);
        let mut height = 0.0;
        for _ in 0..STEPS {
            let at = foot + height * self.out;
            let step = surface.distance(at).0 / surface.normal(at).dot(&self.out);
            height -= step;
            if step.abs() < f64::EPSILON * (foot.coords.norm() + height.abs()) {
                break;
            }
        }
        height / (t * (1.0 - t))
    }

    fn off(&self, surface: &Primitive) -> f64 {
        let n = 2 * MOST_HEIGHTS;
        let off = |k: usize| surface.distance(self.point(k as f64 / n as f64)).0.abs();
        // What is not a number is as far off as can be.
        (0..=n).map(off).fold(0.0, |worst, off| if off <= worst { worst } else { off })
    }

    fn is_straight(&self) -> bool {
        self.heights.is_empty()
    }

    fn degree(&self) -> usize {
        if self.is_straight() { 1 } else { self.heights.len() + 1 }
    }

    /// The height divided by t (1 - t).
    fn share(&self, t: f64) -> f64 {
        let count = self.heights.len();
        let (mut above, mut below) = (0.0, 0.0);
        for (k, &height) in self.heights.iter().enumerate() {
            let off = t - node(k, count);
            if off == 0.0 {
                return height;
            }
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            let weight = sign * ((2 * k + 1) as f64 * PI / (2 * count) as f64).sin() / off;
            above += weight * height;
            below += weight;
        }
        if below == 0.0 { 0.0 } else { above / below }
    }

    fn point(&self, t: f64) -> Point {
        let [from, to] = self.ends;
        from + t * (to - from) + t * (1.0 - t) * self.share(t) * self.out
    }

    /// The parameter of a point of the arch.
    fn place(&self, p: Point) -> f64 {
        let [from, to] = self.ends;
        if p == from {
            return 0.0;
        }
        let chord = to - from;
        if p == to { 1.0 } else { (p - from).dot(&chord) / chord.norm_squared() }
    }

    fn reversed(mut self) -> Self {
        self.ends.reverse();
        self.heights.reverse();
        self
    }

    /// The part of the arch between two points of it.
    pub(super) fn curve(&self, [from, to]: [Point; 2]) -> Result<BrepCurve, String> {
        if self.is_straight() {
            return BrepCurve::line(array(from), array(to));
        }
        let degree = self.degree();
        let [start, end] = [from, to].map(|p| self.place(p));
        let rows: Vec<[f64; 3]> = (0..=degree)
            .map(|k| array(self.point(start + extremum(k, degree) * (end - start))))
            .collect();
        let mut poles = bezier(degree, &rows);
        (poles[0], poles[degree]) = (array(from), array(to));
        SplineCurve::new(degree, clamped(degree, (to - from).norm()), poles, None)
            .map(BrepCurve::Spline)
    }
}

/// Chebyshev's nodes between 0 and 1, where a polynomial through values swings least.
fn node(k: usize, count: usize) -> f64 {
    0.5 - 0.5 * ((2 * k + 1) as f64 * PI / (2 * count) as f64).cos()
}

/// The places from 0 to 1, ends included, where Chebyshev's polynomial of a degree is largest.
fn extremum(k: usize, degree: usize) -> f64 {
    0.5 - 0.5 * (k as f64 * PI / degree as f64).cos()
}

fn clamped(degree: usize, length: f64) -> Vec<f64> {
    [vec![0.0; degree + 1], vec![length; degree + 1]].concat()
}

/// The matrix from values of a polynomial at [`extremum`] to its Bézier points.
fn to_bezier(degree: usize) -> DMatrix<f64> {
    let n = degree + 1;
    let binomial = |j: usize| (0..j).map(|i| (degree - i) as f64 / (i + 1) as f64).product::<f64>();
    let values = DMatrix::from_fn(n, n, |k, j| {
        let t = extremum(k, degree);
        binomial(j) * t.powi(j as i32) * (1.0 - t).powi((degree - j) as i32)
    });
    values.try_inverse().unwrap_or_else(|| DMatrix::identity(n, n))
}

fn bezier(degree: usize, values: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let rows = DMatrix::from_fn(degree + 1, 3, |k, d| values[k][d]);
    let poles = to_bezier(degree) * rows;
    (0..=degree).map(|k| [0, 1, 2].map(|d| poles[(k, d)])).collect()
}

/// A facet with its edges, each from a corner to the next one.
struct BentFacet {
    corners: Vec<VertexId>,
    edges: Vec<Arch>,
}

impl BentFacet {
    /// The parameters of a corner.
    fn corner(&self, k: usize) -> [f64; 2] {
        match (self.edges.len(), k % self.edges.len()) {
            (_, 0) => [0.0, 0.0],
            (_, 1) => [1.0, 0.0],
            (4, 2) => [1.0, 1.0],
            _ => [0.0, 1.0],
        }
    }

    fn at(&self, k: usize) -> Point {
        self.edges[k].ends[0]
    }

    fn bulge(&self, k: usize, t: f64) -> Vector {
        self.edges[k].share(t) * self.edges[k].out
    }

    /// The point of the surface, which is a polynomial in u and v. On each edge it is the arch, as what comes from the others is zero there.
    fn point(&self, u: f64, v: f64) -> Point {
        if self.edges.len() == 3 {
            let shares = [1.0 - u - v, u, v];
            let mut at = Vector::zeros();
            for k in 0..3 {
                let (a, b) = (shares[k], shares[(k + 1) % 3]);
                at += a * self.at(k).coords + a * b * self.bulge(k, 0.5 * (1.0 + b - a));
            }
            return Point::from(at);
        }
        let (x, y) = (1.0 - u, 1.0 - v);
        let flat = x * y * self.at(0).coords
            + u * y * self.at(1).coords
            + u * v * self.at(2).coords
            + x * v * self.at(3).coords;
        let bent = u * x * (y * self.bulge(0, u) + v * self.bulge(2, x))
            + v * y * (u * self.bulge(1, v) + x * self.bulge(3, y));
        Point::from(flat + bent)
    }

    fn surface(&self) -> Result<SplineSurface, String> {
        let degree = self.edges.iter().map(Arch::degree).max().unwrap_or(1);
        let n = degree + 1;
        let change = to_bezier(degree);
        let net = [0, 1, 2].map(|d| {
            let value = |i, j| self.point(extremum(i, degree), extremum(j, degree))[d];
            &change * DMatrix::from_fn(n, n, value) * change.transpose()
        });
        let pole = |at: usize| [0, 1, 2].map(|d| net[d][(at / n, at % n)]);
        let poles = (0..n * n).map(pole).collect();
        let knots = || SplineKnots::new(degree, clamped(degree, 1.0), n);
        SplineSurface::new(knots()?, knots()?, poles, None)
    }

    /// The edge of a chain, and its ends there.
    fn place(&self, chain: &Chain) -> Option<(usize, [[f64; 2]; 2])> {
        let n = self.corners.len();
        let is_end = |v: VertexId| chain.mesh_vertices.contains(&v.0);
        let k = (0..n).find(|&k| is_end(self.corners[k]) && is_end(self.corners[(k + 1) % n]))?;
        let [from, to] = [self.corner(k), self.corner(k + 1)];
        let uv = |p: Point| {
            let t = self.edges[k].place(p);
            if t == 1.0 { to } else { [0, 1].map(|d| from[d] + t * (to[d] - from[d])) }
        };
        let ends = [chain.points[0], *chain.points.last()?];
        Some((k, ends.map(uv)))
    }
}

impl Work<'_> {
    /// Whether a patch is a facet whose surface is laid through its edges.
    pub(super) fn is_bent(&self, i: usize) -> bool {
        let patch = &self.patches[i];
        patch.is_facet && (patch.triangles.len() == 1 || !matches!(patch.form, FacetForm::Flat))
    }

    /// Whether the edges of a patch lie on its surface.
    pub(super) fn holds_edges(&self, i: usize) -> bool {
        !self.is_wall(i) && !self.is_bent(i)
    }

    /// The surfaces of a chain. At an arch they are the curved one and the plane that stands on it.
    pub(super) fn pair<'a>(&'a self, chain: &'a Chain) -> Pair<'a> {
        let sides = [chain.left, chain.right];
        let [a, b] = sides.map(|i| &self.patches[i].surface);
        let kind = if chain.touches { SeamKind::Touches } else { SeamKind::Crosses };
        let most_sagitta = self.most_sagitta;
        if sides.iter().any(|&i| self.is_free(i)) {
            return match sides.into_iter().find(|&i| self.holds_edges(i)) {
                Some(i) => {
                    let only = &self.patches[i].surface;
                    Pair { a: only, b: only, kind: SeamKind::Follows, most_sagitta }
                }
                None => Pair { a, b, kind: SeamKind::Loose, most_sagitta },
            };
        }
        match (&chain.upright, self.is_bent(chain.left)) {
            (None, _) => Pair { a, b, kind, most_sagitta },
            (Some(plane), true) => Pair { a: b, b: plane, kind: SeamKind::Crosses, most_sagitta },
            (Some(plane), false) => Pair { a, b: plane, kind: SeamKind::Crosses, most_sagitta },
        }
    }

    /// The surfaces of the faces that hold the edge of a chain. How far a free edge is from its wall is of no importance.
    pub(super) fn pair_of_faces(&self, chain: &Chain) -> Option<Pair<'_>> {
        let sides = [chain.left, chain.right];
        let mut held = sides.into_iter().filter(|&i| self.holds_edges(i));
        let a = held.next()?;
        let b = held.next().unwrap_or(a);
        let [a, b] = [a, b].map(|i| &self.patches[i].surface);
        let kind = if chain.touches { SeamKind::Touches } else { SeamKind::Crosses };
        Some(Pair { a, b, kind, most_sagitta: None })
    }

    /// Gives the chains between facets and curved faces their arches.
    pub(super) fn raise_arches(&self, network: &mut ChainNetwork) {
        for chain in &mut network.chains {
            let sides = [chain.left, chain.right];
            let curved = sides.into_iter().find(|&i| {
                self.holds_edges(i) && self.patches[i].surface.kind() != PrimitiveKind::Plane
            });
            let (Some(curved), Some(ends)) = (curved, chain.ends) else { continue };
            let is_bent = |&i: &usize| self.is_bent(i) && !self.is_free(i);
            if !sides.iter().any(is_bent) || chain.mesh_vertices.len() != 2 {
                continue;
            }
            let [from, to] = ends.map(|end| network.vertices[end]);
            if let Ok(arch) = Arch::on(&self.patches[curved].surface, [from, to]) {
                let across = (to - from).cross(&arch.out).try_normalize(f64::MIN_POSITIVE);
                let normal = across.unwrap_or_else(Vector::z);
                chain.upright = Some(Primitive::Plane { origin: from, normal });
                chain.arch = Some(arch);
            }
        }
    }

    /// The corners of a bent facet, counterclockwise.
    fn corners(&self, i: usize) -> Vec<VertexId> {
        let triangles = &self.patches[i].triangles;
        let first = 3 * triangles[0] as usize;
        let shared = (first..first + 3).find(|&side| {
            let twin = self.edges.across(side);
            triangles.len() == 2 && twin.is_some_and(|twin| twin / 3 == triangles[1] as usize)
        });
        let own = |side: usize| self.mesh.side(side).0;
        match shared.and_then(|side| Some((side, self.edges.across(side)?))) {
            None => self.mesh.triangles[triangles[0] as usize].to_vec(),
            Some((side, twin)) => {
                let after = |side: usize, by: usize| own(3 * (side / 3) + (side + by) % 3);
                vec![after(side, 1), after(side, 2), own(side), after(twin, 2)]
            }
        }
    }

    /// A facet with its arches, unless it is flat.
    fn bent(&self, i: usize, network: &ChainNetwork) -> Option<BentFacet> {
        if !self.is_bent(i) || self.is_free(i) {
            return None;
        }
        let corners = self.corners(i);
        let n = corners.len();
        let mut edges: Vec<Option<Arch>> = vec![None; n];
        for &(chain, _) in network.loops[i].iter().flatten() {
            let of = &network.chains[chain];
            let [first, last] = [of.mesh_vertices[0], of.mesh_vertices[of.mesh_vertices.len() - 1]];
            let k = (0..n).find(|&k| {
                let (a, b) = (corners[k].0, corners[(k + 1) % n].0);
                [a, b] == [first, last] || [b, a] == [first, last]
            })?;
            let mut arch = of.arch.clone().unwrap_or_else(|| Arch {
                ends: [of.points[0], of.points[of.points.len() - 1]],
                out: Vector::zeros(),
                heights: Vec::new(),
            });
            // An arch runs like the chain did when it was raised.
            let start = network.junction_place(corners[k])?;
            if arch.ends[0] != start {
                arch = arch.reversed();
            }
            edges[k] = Some(arch);
        }
        let edges: Vec<Arch> = edges.into_iter().collect::<Option<_>>()?;
        let plane = &self.patches[i].surface;
        let is_flat = edges
            .iter()
            .all(|edge| edge.is_straight() && plane.distance(edge.ends[0]).0.abs() < SPLINE);
        (!is_flat).then_some(BentFacet { corners, edges })
    }
}

impl FaceBuilder<'_> {
    /// Adds the face of a bent facet. Returns false if the patch is none.
    pub(super) fn bent_face(&mut self, i: usize) -> Result<bool, String> {
        let Some(facet) = self.work.bent(i, self.network) else { return Ok(false) };
        let [ring] = &self.network.loops[i][..] else {
            return Err("a facet with several loops".into());
        };
        let spline = facet.surface()?;
        let uses = ring.iter().map(|&of| self.bent_use(&facet, &spline, of));
        let found = uses.collect::<Result<Vec<_>, String>>()?;
        self.gap = found.iter().map(|of| of.1).fold(self.gap, f64::max);
        let loops = vec![found.into_iter().map(|of| of.0).collect()];
        let surface = self.brep.add_surface(BrepSurface::Spline(spline));
        self.brep.add_face(Face { surface, forward: true, loops });
        self.patch_of.push(i);
        self.triangles.push(self.work.patches[i].triangles.clone());
        Ok(true)
    }

    /// The use of a chain by a bent facet, and how far it is from it.
    fn bent_use(
        &self,
        facet: &BentFacet,
        spline: &SplineSurface,
        (chain, forward): ChainUse,
    ) -> Result<(EdgeUse, f64), String> {
        let (_, uv) = facet.place(&self.network.chains[chain]).ok_or("an edge of another facet")?;
        let curve = &self.brep.edges[chain].curve;
        let (start, end) = curve.range();
        let pcurve = PCurve::line(uv[0], uv[1], (start, end))?;
        let off = |k: usize| {
            let t = start + (end - start) * k as f64 / SAMPLES as f64;
            let [u, v] = pcurve.point(t);
            (Point::from(spline.point(u, v)) - Point::from(curve.point(t))).norm()
        };
        let gap = (0..=SAMPLES).map(off).fold(0.0, f64::max);
        if gap.is_nan() || gap > self.work.limit {
            return Err(format!("an edge is {gap:.1e} mm off its facet"));
        }
        Ok((EdgeUse { edge: EdgeId(chain), forward, pcurve }, gap))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYLINDER: Primitive = Primitive::Cylinder {
        origin: Point::new(0.0, 0.0, 0.0),
        axis: Vector::new(0.0, 0.0, 1.0),
        radius: 5.0,
    };

    fn on_cylinder(angle: f64, z: f64) -> Point {
        Point::new(5.0 * angle.cos(), 5.0 * angle.sin(), z)
    }

    fn samples(curve: &BrepCurve) -> impl Iterator<Item = Point> + '_ {
        let (start, end) = curve.range();
        (0..=20).map(move |k| Point::from(curve.point(start + (end - start) * f64::from(k) / 20.0)))
    }

    #[test]
    fn an_arch_lies_on_its_surface_and_so_do_its_parts() {
        let ends = [on_cylinder(0.1, 0.0), on_cylinder(0.7, 1.0)];
        let arch = Arch::on(&CYLINDER, ends).expect("an arch");
        assert!(!arch.is_straight());
        let middle = arch.point(0.4);
        for ends in [ends, [ends[0], middle], [middle, ends[1]]] {
            let curve = arch.curve(ends).expect("a curve");
            assert_eq!(curve.ends().map(Point::from), ends);
            assert!(samples(&curve).all(|p| CYLINDER.distance(p).0.abs() < EXACT));
        }
        let back = arch.clone().reversed();
        assert!((back.point(0.6) - middle).norm() < 1e-14);
    }

    #[test]
    fn an_edge_along_the_axis_is_straight() {
        let ends = [on_cylinder(0.3, 0.0), on_cylinder(0.3, 2.0)];
        let arch = Arch::on(&CYLINDER, ends).expect("an arch");
        assert!(arch.is_straight());
        assert!(Arch::on(&CYLINDER, [ends[0]; 2]).is_err());
    }

    #[test]
    fn a_bent_facet_runs_through_its_edges() {
        let far = Point::new(9.0, 1.0, 0.5);
        let straight = |ends| Arch { ends, out: Vector::zeros(), heights: Vec::new() };
        let [a, b, c] = [on_cylinder(0.0, 0.0), on_cylinder(0.4, 0.0), on_cylinder(0.4, 2.0)];
        let d = on_cylinder(0.0, 2.0);
        let arch = |ends| Arch::on(&CYLINDER, ends).expect("an arch");
        let triangle = vec![arch([a, b]), straight([b, far]), straight([far, a])];
        let quadrangle = vec![arch([a, b]), straight([b, c]), arch([c, d]), straight([d, a])];
        for edges in [triangle, quadrangle] {
            let corners = (0..edges.len() as u32).map(VertexId).collect();
            let facet = BentFacet { corners, edges };
            let surface = facet.surface().expect("a surface");
            for (k, edge) in facet.edges.iter().enumerate() {
                let [from, to] = [facet.corner(k), facet.corner(k + 1)];
                for n in 0..=10 {
                    let t = f64::from(n) / 10.0;
                    let [u, v] = [0, 1].map(|d| from[d] + t * (to[d] - from[d]));
                    let off = (Point::from(surface.point(u, v)) - edge.point(t)).norm();
                    assert!(off < 1e-12, "edge {k} at {t}: {off}");
                }
            }
        }
    }
}
