//! Solids that are built by hand from B-spline faces.

use std::f64::consts::PI;

use formats::Brep;
use formats::brep::{BrepCurve, BrepSurface, Face, Shell, ShellId, Solid, VertexId};
use formats::spline::{SplineCurve, SplineKnots, SplineSurface};

use super::model::{against, along, bezier, bezier_curve};

pub fn empty(name: &str) -> Brep {
    Brep { name: name.into(), uncertainty_mm: 1e-7, ..Brep::default() }
}

/// Adds a closed shell around a box: six bilinear faces whose normals point outwards, or inwards if
/// the box is `hollow`.
pub fn add_box(brep: &mut Brep, low: [f64; 3], high: [f64; 3], hollow: bool) -> ShellId {
    let corner = |k: usize| [0, 1, 2].map(|i| if k >> i & 1 == 1 { high[i] } else { low[i] });
    let vertices: Vec<VertexId> = (0..8).map(|k| brep.add_vertex(corner(k))).collect();
    let mut edges = std::collections::HashMap::new();
    for (a, b) in (0..8).flat_map(|a| (0..3).map(move |i| (a, a | 1 << i))).filter(|(a, b)| a != b)
    {
        let curve = BrepCurve::Spline(bezier_curve(vec![corner(a), corner(b)]));
        edges.insert((a, b), brep.add_edge(curve, [vertices[a], vertices[b]]));
    }
    // The corners of each side, counter-clockwise seen from outside.
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut faces = Vec::new();
    for mut side in sides {
        if hollow {
            side.reverse();
        }
        let plane = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let of_loop = (0..4).map(|k| {
            let (from, to, start, end) = (side[k], side[(k + 1) % 4], plane[k], plane[(k + 1) % 4]);
            match edges.get(&(from, to)) {
                Some(&edge) => along(edge, bezier_curve(vec![start, end])),
                None => against(edges[&(to, from)], bezier_curve(vec![end, start])),
            }
        });
        let loops = vec![of_loop.collect()];
        let poles = [side[0], side[3], side[1], side[2]].map(corner).to_vec();
        let knots = SplineKnots::new(1, bezier(1), 2).unwrap();
        let surface = SplineSurface::new(knots.clone(), knots, poles, None).unwrap();
        let surface = brep.add_surface(BrepSurface::Spline(surface));
        faces.push(brep.add_face(Face { surface, forward: true, loops }));
    }
    brep.add_shell(Shell { faces, closed: true })
}

pub fn cube(name: &str) -> Brep {
    let mut brep = empty(name);
    let outer = add_box(&mut brep, [0.0; 3], [30.0, 20.0, 10.0], false);
    brep.solids.push(Solid { outer, voids: Vec::new() });
    brep
}

/// A box inside a box. The material is between them.
pub fn hollow(name: &str) -> Brep {
    let mut brep = cube(name);
    let void = add_box(&mut brep, [5.0; 3], [25.0, 15.0, 8.0], true);
    brep.solids[0].voids.push(void);
    brep
}

pub fn two_bodies(name: &str) -> Brep {
    let mut brep = cube(name);
    let outer = add_box(&mut brep, [40.0, 0.0, 0.0], [45.0, 5.0, 5.0], false);
    brep.solids.push(Solid { outer, voids: Vec::new() });
    brep
}

pub const RADII: [f64; 2] = [40.0, 15.0];

/// The poles and weights of a semicircle of radius 1 from the angle `start`, which is 0 or π, as a
/// rational cubic without inner knots.
fn half_circle(start: f64) -> Vec<([f64; 2], f64)> {
    let side = start.cos();
    let poles =
        [([1.0, 0.0], 1.0), ([1.0, 2.0], 1.0 / 3.0), ([-1.0, 2.0], 1.0 / 3.0), ([-1.0, 0.0], 1.0)];
    poles.map(|([x, y], weight)| ([side * x, side * y], weight)).to_vec()
}

/// A torus of four faces as exact rational surfaces. Each face covers half of both circles. The
/// torus has four vertices and eight shared edges.
pub fn torus(name: &str) -> Brep {
    let mut brep = empty(name);
    let [large, small] = RADII;
    let poles = |around: f64, across: f64| {
        let (turn, tube) = (half_circle(around), half_circle(across));
        let each = turn.iter().flat_map(|t| tube.iter().map(move |s| (*t, *s)));
        let pole = |(([x, y], w), ([r, z], v)): (([f64; 2], f64), ([f64; 2], f64))| {
            let reach = large + small * r;
            ([reach * x, reach * y, small * z], w * v)
        };
        each.map(pole).unzip::<_, _, Vec<_>, Vec<_>>()
    };
    let at = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    // Vertex (i, j) is at the angle i π around the axis and j π around the tube.
    let vertices: Vec<VertexId> = (0..4)
        .map(|k| brep.add_vertex([at(k / 2) * (large + small * at(k % 2)), 0.0, 0.0]))
        .collect();
    let curve = |poles: Vec<[f64; 3]>, weights: Vec<f64>| {
        BrepCurve::Spline(SplineCurve::new(3, bezier(3), poles, Some(weights)).unwrap())
    };
    // The semicircles around the axis at each j, from each i, and the semicircles around the tube
    // at each i, from each j.
    let mut turns = Vec::new();
    let mut tubes = Vec::new();
    for k in 0..4 {
        let (i, j) = (k / 2, k % 2);
        let (net, weights) = poles(i as f64 * PI, j as f64 * PI);
        let turn = (0..4).map(|n| (net[4 * n], weights[4 * n])).unzip::<_, _, Vec<_>, Vec<_>>();
        let tube = (net[..4].to_vec(), weights[..4].to_vec());
        let [next_i, next_j] = [2 * (1 - i) + j, 2 * i + 1 - j];
        turns.push(brep.add_edge(curve(turn.0, turn.1), [vertices[k], vertices[next_i]]));
        tubes.push(brep.add_edge(curve(tube.0, tube.1), [vertices[k], vertices[next_j]]));
    }
    let mut faces = Vec::new();
    for k in 0..4 {
        let (i, j) = (k / 2, k % 2);
        let (net, weights) = poles(i as f64 * PI, j as f64 * PI);
        let knots = SplineKnots::new(3, bezier(3), 4).unwrap();
        let surface = SplineSurface::new(knots.clone(), knots, net, Some(weights)).unwrap();
        let surface = brep.add_surface(BrepSurface::Spline(surface));
        let line = |from, to| bezier_curve(vec![from, to]);
        let outer = vec![
            along(turns[k], line([0.0, 0.0], [1.0, 0.0])),
            along(tubes[2 * (1 - i) + j], line([1.0, 0.0], [1.0, 1.0])),
            against(turns[2 * i + 1 - j], line([0.0, 1.0], [1.0, 1.0])),
            against(tubes[k], line([0.0, 0.0], [0.0, 1.0])),
        ];
        faces.push(brep.add_face(Face { surface, forward: true, loops: vec![outer] }));
    }
    let outer = brep.add_shell(Shell { faces, closed: true });
    brep.solids.push(Solid { outer, voids: Vec::new() });
    brep
}

/// The name, the model and the volume.
pub fn all() -> [(&'static str, Brep, f64); 4] {
    let [large, small] = RADII;
    let torus_volume = 2.0 * PI * PI * large * small * small;
    [
        ("torus", torus("torus"), torus_volume),
        ("cube", cube("cube"), 6000.0),
        ("hollow", hollow("hollow"), 6000.0 - 20.0 * 10.0 * 3.0),
        ("bodies", two_bodies("bodies"), 6000.0 + 125.0),
    ]
}
