//! Edges of a face that cross in its parameter plane, by the rule that modelling kernels check solids with.
//!
//! Two edges may cross beside a common vertex if they run along each other from there to the crossing, to twice the
//! precision of the kernels. Everywhere else their pcurves have no point in common. No pcurve crosses itself, and the loops of a
//! face pass each vertex once but on seams: where they pass it twice, kernels cannot tell which way they go on.

use std::collections::{BTreeMap, BTreeSet};

use formats::Brep;
use formats::brep::{BrepCurve, BrepSurface, Edge, Face, PCurve};

use super::fallback::SeamFault;
use super::network::{Chain, ChainNetwork};
use super::pieces::{CurvePiece, FINE, are_near, halved, pieces, place_of_lines, places_of_ends};
use super::{EXACT, Work};
use crate::geometry::{Point, Uv, segment_distance};
use crate::mesh::Mesh;

/// A crossing this close to a common vertex is the vertex, in mm. Kernels give a vertex a larger radius if its edges are farther from
/// their faces.
const AT_VERTEX: f64 = 1.1 * EXACT;

/// Edges that cross beside a vertex are so close to each other up to there, in mm: kernels allow a fifth of a nanometre.
const TOGETHER: f64 = 2.0 * EXACT;

/// The same if one of them is a spline in the parameter plane. Kernels sample those, and do not find crossings of a quarter of a
/// nanometre, which a real part of 74 faces has.
const SAMPLED: f64 = 3.5 * EXACT;

/// They are also so straight up to there, in mm: kernels find longer slivers between edges.
const STRAIGHT: f64 = 20.0 * EXACT;

/// Lines in the parameter plane cross within their ends, but for rounding of the parameters.
const AT_END: f64 = 1e-9;

/// Two pcurves that are compared at more pairs of pieces run along each other. Those that cross need a few hundred.
const MOST_PAIRS: usize = 20_000;

/// The parts of a piece whose directions are compared, and those of an edge whose distances from its faces are.
const SAMPLES: usize = 4;

/// One use of an edge.
struct UsedEdge<'a> {
    number: usize,
    edge: &'a Edge,
    pcurve: &'a PCurve,
    pieces: Vec<CurvePiece>,
    low: [f64; 2],
    high: [f64; 2],
}

/// Two edges that cross.
struct Crossing {
    edges: [usize; 2],
    at: Point,
}

/// The faults of all faces. Seams have numbers beyond those of chains.
pub(super) fn crossings(
    work: &Work,
    brep: &Brep,
    network: &ChainNetwork,
    patch_of: &[usize],
) -> Vec<SeamFault> {
    let mut faults = Vec::new();
    let radii = radii(brep);
    for (i, face) in brep.faces.iter().enumerate() {
        let vertices = |crossing: &Crossing| -> Vec<u32> {
            let chains = crossing.edges.iter().filter_map(|&edge| network.chains.get(edge));
            chains.flat_map(|chain| beside(work.mesh, chain, crossing.at)).collect()
        };
        for crossing in crossed(brep, face, &radii) {
            let why = "a border that crosses itself";
            let chains = crossing.edges.iter().filter_map(|&edge| network.chains.get(edge));
            let sides = chains.flat_map(|chain| [chain.left, chain.right]);
            let patches: BTreeSet<usize> = sides.chain([patch_of[i]]).collect();
            let patches: Vec<usize> = patches.into_iter().collect();
            faults.push(SeamFault::near(&patches, &vertices(&crossing), why));
        }
        for place in passed_twice(brep, face) {
            let why = "a border that touches itself";
            faults.push(SeamFault::near(&[patch_of[i]], &vertices(&place), why));
        }
    }
    faults
}

/// The ends of the mesh edge of a chain that is closest to a place.
pub(super) fn beside(mesh: &Mesh, chain: &Chain, at: Point) -> Vec<u32> {
    let off = |ends: &&[u32]| {
        let [a, b] = [ends[0], ends[1]].map(|v| mesh.points[v as usize]);
        segment_distance(at, a, b)
    };
    let edges = chain.mesh_vertices.windows(2);
    edges.min_by(|a, b| off(a).total_cmp(&off(b))).map(<[u32]>::to_vec).unwrap_or_default()
}

/// The radius of each vertex in mm: how far it and its edges are from their faces. Kernels do not look how far an edge is off a plane.
fn radii(brep: &Brep) -> Vec<f64> {
    let mut radii = vec![AT_VERTEX; brep.vertices.len()];
    for face in &brep.faces {
        let surface = &brep.surfaces[face.surface.0];
        let is_plane = matches!(surface, BrepSurface::Plane { .. });
        for of in face.loops.iter().flatten() {
            let edge = &brep.edges[of.edge.0];
            let [start, end] = edge.curve.range().into();
            let apart = |p: [f64; 3], q: [f64; 3]| (Point::from(p) - Point::from(q)).norm();
            let off = |k: usize| {
                let t = start + (end - start) * k as f64 / SAMPLES as f64;
                let [u, v] = of.pcurve.point(t);
                let (foot, at) = (surface.point(u, v), edge.curve.point(t));
                let vertex = match k {
                    0 => brep.vertices[edge.ends[0].0],
                    SAMPLES => brep.vertices[edge.ends[1].0],
                    _ => at,
                };
                let off = apart(vertex, at);
                if is_plane { off } else { off.max(apart(foot, at)).max(apart(vertex, foot)) }
            };
            let off = (0..=SAMPLES).map(off).fold(0.0, f64::max);
            edge.ends.iter().for_each(|end| radii[end.0] = radii[end.0].max(off));
        }
    }
    radii
}

/// The pairs of edges of a face that cross. `radii` are those of the vertices.
fn crossed(brep: &Brep, face: &Face, radii: &[f64]) -> Vec<Crossing> {
    let uses = face.loops.iter().flatten();
    let mut sides: Vec<UsedEdge> =
        uses.map(|of| UsedEdge::new(of.edge.0, &brep.edges[of.edge.0], &of.pcurve)).collect();
    sides.sort_by(|a, b| a.low[0].total_cmp(&b.low[0]));
    let mut found = Vec::new();
    for (n, a) in sides.iter().enumerate() {
        let beside = sides[n + 1..].iter().take_while(|b| b.low[0] <= a.high[0]);
        for b in beside.filter(|b| b.low[1] <= a.high[1] && a.low[1] <= b.high[1]) {
            if a.number == b.number {
                continue;
            }
            if let Some(at) = a.crossing(b, brep, radii) {
                found.push(Crossing { edges: [a.number, b.number], at });
            }
        }
        found.extend(a.own_crossing().map(|at| Crossing { edges: [a.number; 2], at }));
    }
    found
}

/// The vertices that the loops of a face pass more than once, each with the edges that begin there. Those on seams are passed twice.
fn passed_twice(brep: &Brep, face: &Face) -> Vec<Crossing> {
    let uses = || face.loops.iter().flatten();
    let mut edges: Vec<usize> = uses().map(|of| of.edge.0).collect();
    edges.sort_unstable();
    let seams = edges.windows(2).filter(|pair| pair[0] == pair[1]);
    let on_seams: BTreeSet<usize> =
        seams.flat_map(|pair| brep.edges[pair[0]].ends.map(|end| end.0)).collect();
    let mut first: BTreeMap<usize, usize> = BTreeMap::new();
    let mut found = Vec::new();
    for of in uses() {
        let vertex = brep.edges[of.edge.0].ends[usize::from(!of.forward)];
        if let Some(before) = first.insert(vertex.0, of.edge.0)
            && !on_seams.contains(&vertex.0)
        {
            let at = Point::from(brep.vertices[vertex.0]);
            found.push(Crossing { edges: [before, of.edge.0], at });
        }
    }
    found
}

impl<'a> UsedEdge<'a> {
    fn new(number: usize, edge: &'a Edge, pcurve: &'a PCurve) -> Self {
        let pieces = pieces(pcurve);
        let mut side =
            UsedEdge { number, edge, pcurve, pieces, low: [f64::MAX; 2], high: [f64::MIN; 2] };
        for piece in &side.pieces {
            for k in 0..2 {
                for end in piece.ends {
                    side.low[k] = side.low[k].min(end[k] - piece.sagitta);
                    side.high[k] = side.high[k].max(end[k] + piece.sagitta);
                }
            }
        }
        side
    }

    /// A place where two edges cross and must not.
    fn crossing(&self, other: &UsedEdge, brep: &Brep, radii: &[f64]) -> Option<Point> {
        let common: Vec<Common> = self.common(other, brep, radii);
        let mut left: Vec<(CurvePiece, CurvePiece)> = Vec::new();
        for a in &self.pieces {
            let near = other.pieces.iter().filter(|b| are_near(a, b));
            left.extend(near.map(|b| (*a, *b)));
        }
        if let Some(cusp) = common.iter().find(|of| of.is_cusp(self, other)) {
            return Some(cusp.at);
        }
        let mut count = 0;
        while let Some((a, b)) = left.pop() {
            count += 1;
            if count > MOST_PAIRS {
                return Some(self.at(a.range[0]));
            }
            if common.iter().any(|of| of.holds(self, other, [a.range, b.range])) {
                continue;
            }
            if let Some(pairs) = halved([&a, &b], [self.pcurve, other.pcurve]) {
                left.extend(pairs);
                continue;
            }
            let is_held = |[s, t]: &[f64; 2]| {
                common.iter().any(|of| of.holds(self, other, [[*s; 2], [*t; 2]]))
            };
            let mut places =
                place_of_lines(&a, &b, AT_END).into_iter().chain(places_of_ends(&a, &b));
            if let Some([s, _]) = places.find(|place| !is_held(place)) {
                return Some(self.at(s));
            }
        }
        None
    }

    /// A place where the pcurve turns back or crosses itself.
    fn own_crossing(&self) -> Option<Point> {
        if !matches!(self.pcurve, PCurve::Spline(_)) {
            return None;
        }
        let breaks = self.pcurve.breaks();
        let within = |span: &[f64]| {
            let [start, end] = [span[0], span[1]];
            (0..SAMPLES).map(move |k| start + (end - start) * k as f64 / SAMPLES as f64)
        };
        let mut samples: Vec<f64> = breaks.windows(2).flat_map(within).collect();
        samples.extend(breaks.last());
        let points: Vec<Uv> = samples.iter().map(|&t| Uv::from(self.pcurve.point(t))).collect();
        let turn = points.windows(3).position(|p| (p[1] - p[0]).dot(&(p[2] - p[1])) < 0.0);
        if let Some(turn) = turn {
            return Some(self.at(samples[turn + 1]));
        }
        let is_beside = |a: &CurvePiece, b: &CurvePiece| a.touches(b) || b.touches(a);
        let pairs = self.pieces.iter().enumerate().flat_map(|(n, a)| {
            self.pieces[n + 1..].iter().filter(|b| !is_beside(a, b)).map(move |b| (*a, *b))
        });
        let mut left: Vec<(CurvePiece, CurvePiece)> =
            pairs.filter(|(a, b)| are_near(a, b)).collect();
        let mut count = 0;
        while let Some((a, b)) = left.pop() {
            count += 1;
            match halved([&a, &b], [self.pcurve; 2]) {
                Some(pairs) if count <= MOST_PAIRS => left.extend(pairs),
                _ => return Some(self.at(a.range[0])),
            }
        }
        None
    }

    fn at(&self, t: f64) -> Point {
        Point::from(self.edge.curve.point(t))
    }

    /// Points of the edge from one parameter to another one.
    fn samples(&self, from: f64, to: f64) -> [Point; 9] {
        std::array::from_fn(|k| self.at(from + (to - from) * k as f64 / 8.0))
    }

    /// The vertices that two edges have in common, for each of their ends there.
    fn common(&self, other: &UsedEdge, brep: &Brep, radii: &[f64]) -> Vec<Common> {
        let mut found = Vec::new();
        for (k, vertex) in self.edge.ends.iter().enumerate() {
            for (j, _) in other.edge.ends.iter().enumerate().filter(|end| end.1 == vertex) {
                let of = |curve: &BrepCurve, k: usize| <[f64; 2]>::from(curve.range())[k];
                let at = Point::from(brep.vertices[vertex.0]);
                let parameters = [of(&self.edge.curve, k), of(&other.edge.curve, j)];
                found.push(Common { at, radius: radii[vertex.0], parameters });
            }
        }
        found
    }
}

/// A vertex of two edges, and their parameters there.
struct Common {
    at: Point,
    radius: f64,
    parameters: [f64; 2],
}

impl Common {
    /// Whether two arcs leave this vertex so nearly in one direction that they are not apart where they leave its radius.
    fn is_cusp(&self, a: &UsedEdge, b: &UsedEdge) -> bool {
        let is_arc = |of: &UsedEdge| matches!(of.pcurve, PCurve::Ellipse(_));
        if !(is_arc(a) && is_arc(b)) {
            return false;
        }
        let [out, other] = [(a, 0), (b, 1)].map(|(side, k)| {
            let (start, _) = side.pcurve.range();
            let along = nalgebra::Vector2::from(side.pcurve.speed(self.parameters[k]));
            if self.parameters[k] == start { along } else { -along }
        });
        out.angle(&other) * self.radius < FINE
    }

    /// Whether two edges may cross within some ranges, because they run along each other from this vertex on.
    fn holds(&self, a: &UsedEdge, b: &UsedEdge, ranges: [[f64; 2]; 2]) -> bool {
        let far = |k: usize| {
            let ([start, end], from) = (ranges[k], self.parameters[k]);
            if (start - from).abs() > (end - from).abs() { start } else { end }
        };
        let is_sampled = [a, b].iter().any(|side| matches!(side.pcurve, PCurve::Spline(_)));
        let together = if is_sampled { SAMPLED } else { TOGETHER };
        let [a, b] = [(a, 0), (b, 1)].map(|(side, k)| side.samples(self.parameters[k], far(k)));
        if a.iter().chain(&b).all(|p| (p - self.at).norm() <= self.radius) {
            return true;
        }
        let is_straight =
            |of: &[Point; 9]| of.iter().all(|p| segment_distance(*p, of[0], of[8]) <= STRAIGHT);
        let off = |p: &Point| {
            let parts = b.windows(2).map(|ends| segment_distance(*p, ends[0], ends[1]));
            parts.fold(f64::INFINITY, f64::min)
        };
        is_straight(&a) && is_straight(&b) && a.iter().all(|p| off(p) <= together)
    }
}

#[cfg(test)]
mod tests {
    use formats::brep::{EdgeUse, Frame, VertexId};
    use formats::spline::SplineCurve;

    use super::*;

    /// A face of the xy plane whose loop runs along lines from point to point.
    fn polygon(points: &[[f64; 2]]) -> (Brep, Face) {
        let mut brep = Brep::default();
        let mut vertices: Vec<([f64; 2], VertexId)> = Vec::new();
        for &[x, y] in points {
            if !vertices.iter().any(|of| of.0 == [x, y]) {
                vertices.push(([x, y], brep.add_vertex([x, y, 0.0])));
            }
        }
        let number = |p: [f64; 2]| vertices.iter().find(|of| of.0 == p).expect("a vertex").1;
        let mut uses = Vec::new();
        for (k, &a) in points.iter().enumerate() {
            let b = points[(k + 1) % points.len()];
            let curve = BrepCurve::line([a[0], a[1], 0.0], [b[0], b[1], 0.0]).expect("a line");
            let range = curve.range();
            let edge = brep.add_edge(curve, [number(a), number(b)]);
            let pcurve = PCurve::line(a, b, range).expect("a line");
            uses.push(EdgeUse { edge, forward: true, pcurve });
        }
        let frame = Frame::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]).expect("a frame");
        let surface = brep.add_surface(formats::brep::BrepSurface::Plane { frame });
        (brep, Face { surface, forward: true, loops: vec![uses] })
    }

    #[test]
    fn loops_pass_each_vertex_once() {
        let (brep, face) = polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        assert!(
            passed_twice(&brep, &face).is_empty()
                && crossed(&brep, &face, &radii(&brep)).is_empty()
        );
        let bow = [[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [2.0, 2.0], [0.0, 2.0], [1.0, 1.0]];
        let (brep, face) = polygon(&bow);
        let found = passed_twice(&brep, &face);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].at, Point::new(1.0, 1.0, 0.0));
    }

    #[test]
    fn a_vertex_is_as_large_as_its_edges_are_off() {
        let (mut brep, face) = polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        brep.add_face(face);
        brep.vertices[1][2] += 1e-6;
        let found = radii(&brep);
        assert!((found[1] - 1e-6).abs() < 1e-12, "{found:?}");
        // Both edges of a vertex hold it, so those beside it are as large.
        assert_eq!(found[3], AT_VERTEX);
    }

    #[test]
    fn a_vertex_on_another_edge_is_a_crossing() {
        let (brep, face) =
            polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.0, 0.0], [1.0, 2.0], [0.0, 2.0]]);
        assert!(!crossed(&brep, &face, &radii(&brep)).is_empty());
    }

    #[test]
    fn two_arcs_that_leave_a_vertex_in_one_direction_are_a_crossing() {
        // Two arcs beside each other that are half circles but for a turn at their ends.
        let face = |turn: f64| {
            let mut brep = Brep::default();
            let ends =
                [[-2.0, 0.0], [0.0, 0.0], [2.0, 0.0]].map(|[x, y]| brep.add_vertex([x, y, 0.0]));
            let arc = |x: f64| {
                // The centre is below the chord, so that the arc is lower than half a circle.
                let [sin, cos] = [turn.sin(), turn.cos()];
                let radius = 1.0 / cos;
                let centre = [x, -radius * sin, 0.0];
                let start = [1.0, -centre[1], 0.0];
                let frame = Frame::new(centre, [0.0, 0.0, 1.0], start).expect("a frame");
                BrepCurve::arc(&frame, radius, std::f64::consts::PI - 2.0 * turn).expect("an arc")
            };
            let plane = Frame::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]).expect("a frame");
            let mut uses = Vec::new();
            for (k, x) in [(1, 1.0), (0, -1.0)] {
                let curve = arc(x);
                let pcurve = PCurve::on_plane(&plane, &curve).expect("an arc");
                let edge = brep.add_edge(curve, [ends[k + 1], ends[k]]);
                uses.push(EdgeUse { edge, forward: true, pcurve });
            }
            let surface = brep.add_surface(BrepSurface::Plane { frame: plane });
            let face = Face { surface, forward: true, loops: vec![uses] };
            let radii = vec![AT_VERTEX; brep.vertices.len()];
            crossed(&brep, &face, &radii).len()
        };
        assert_eq!(face(2e-4), 1);
        assert_eq!(face(2e-2), 0);
    }

    #[test]
    fn a_pcurve_that_turns_back_is_a_crossing() {
        let own = |poles: Vec<[f64; 2]>| {
            let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
            let spatial = poles.iter().map(|p| [p[0], p[1], 0.0]).collect();
            let curve = SplineCurve::new(3, knots.clone(), spatial, None).expect("a curve");
            let edge = Edge { curve: BrepCurve::Spline(curve), ends: [VertexId(0), VertexId(1)] };
            let pcurve = PCurve::Spline(SplineCurve::new(3, knots, poles, None).expect("a curve"));
            UsedEdge::new(0, &edge, &pcurve).own_crossing()
        };
        assert_eq!(own(vec![[0.0, 0.0], [1.0, 0.5], [2.0, 0.5], [3.0, 0.0]]), None);
        assert!(own(vec![[0.0, 0.0], [4.0, 0.0], [4.0, 0.0], [3.0, 0.0]]).is_some());
        assert!(own(vec![[0.0, 0.0], [4.0, 3.0], [-2.0, 3.0], [2.0, 0.0]]).is_some());
    }
}
