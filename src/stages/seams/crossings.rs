//! Loops that cross themselves or each other in the parameter plane.

use std::collections::BTreeSet;

use formats::Brep;
use formats::brep::{BrepSurface, EdgeUse, Face, PCurve};

use super::fallback::SeamFault;
use super::network::ChainNetwork;

/// The chords of a curve. Curves that cross between neighbouring chords nearly touch.
const CHORDS: usize = 24;

/// Chords that meet this close to their ends, as a share of their lengths, share a vertex.
const AT_END: f64 = 1e-6;

/// Ends of pcurves that are so close are one: vertices are exact to less, at a pole angles are farther apart.
const JOINED: f64 = 1e-6;

/// A chord of a pcurve: its ends, its place in its loop, and the edge.
struct Chord {
    ends: [[f64; 2]; 2],
    ring: usize,
    order: usize,
    edge: usize,
    /// The distance of the curve's middle from the chord's.
    sagitta: f64,
}

/// The faults of all faces. Seams have numbers beyond those of chains.
pub(super) fn crossings(brep: &Brep, network: &ChainNetwork, patch_of: &[usize]) -> Vec<SeamFault> {
    let mut faults = Vec::new();
    for (i, face) in brep.faces.iter().enumerate() {
        let edges = crossed(face, &brep.surfaces[face.surface.0]);
        if edges.is_empty() {
            continue;
        }
        let why = "a border that crosses itself";
        let chains: Vec<_> = edges.iter().filter_map(|&edge| network.chains.get(edge)).collect();
        if chains.is_empty() {
            faults.push(SeamFault::new(&[patch_of[i]], why));
            continue;
        }
        let sides = chains.iter().flat_map(|chain| [chain.left, chain.right]);
        let patches: BTreeSet<usize> = sides.chain([patch_of[i]]).collect();
        let patches: Vec<usize> = patches.into_iter().collect();
        let vertices: Vec<u32> =
            chains.iter().flat_map(|chain| chain.mesh_vertices.iter().copied()).collect();
        faults.push(SeamFault::near(&patches, &vertices, why));
    }
    faults
}

/// The edges of a face that cross others.
fn crossed(face: &Face, surface: &BrepSurface) -> BTreeSet<usize> {
    let mut chords = Vec::new();
    let mut lengths = Vec::new();
    for (ring, uses) in face.loops.iter().enumerate() {
        let first = chords.len();
        for of_loop in uses {
            add_chords(of_loop, ring, &mut chords);
        }
        chords[first..].iter_mut().enumerate().for_each(|(n, chord)| chord.order = n);
        lengths.push(chords.len() - first);
    }
    let low = |chord: &Chord| chord.ends[0][0].min(chord.ends[1][0]);
    let high = |chord: &Chord| chord.ends[0][0].max(chord.ends[1][0]);
    chords.sort_by(|a, b| low(a).total_cmp(&low(b)));
    let is_plane = matches!(surface, BrepSurface::Plane { .. });
    let mut found = BTreeSet::new();
    for (n, a) in chords.iter().enumerate() {
        for b in chords[n + 1..].iter().take_while(|b| low(b) <= high(a)) {
            let apart = a.order.abs_diff(b.order);
            let is_next = a.ring == b.ring && (apart == 1 || apart + 1 == lengths[a.ring]);
            // Beside a pole two curves are not joined.
            if !(is_next && (is_plane || a.edge == b.edge || meet(a, b))) && cross(a, b) {
                found.extend([a.edge, b.edge]);
            }
        }
    }
    found
}

fn meet(a: &Chord, b: &Chord) -> bool {
    let near = |p: &[f64; 2], q: &[f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]) < JOINED;
    a.ends.iter().any(|p| b.ends.iter().any(|q| near(p, q)))
}

fn add_chords(of_loop: &EdgeUse, ring: usize, chords: &mut Vec<Chord>) {
    let n = if matches!(of_loop.pcurve, PCurve::Line(_)) { 1 } else { CHORDS };
    let (start, end) = of_loop.pcurve.range();
    let at = |k: usize| of_loop.pcurve.point(start + (end - start) * k as f64 / n as f64);
    let middle = |k: usize| {
        let [a, b] = [at(k), at(k + 1)];
        let p = of_loop.pcurve.point(start + (end - start) * (k as f64 + 0.5) / n as f64);
        (p[0] - 0.5 * (a[0] + b[0])).hypot(p[1] - 0.5 * (a[1] + b[1]))
    };
    let edge = of_loop.edge.0;
    let chord = |k| Chord { ends: [at(k), at(k + 1)], ring, order: 0, edge, sagitta: middle(k) };
    let mut own: Vec<Chord> = (0..n).map(chord).collect();
    if !of_loop.forward {
        own.reverse();
    }
    chords.append(&mut own);
}

/// Whether two chords cross inside of both, and not only because curves that touch have chords.
fn cross(a: &Chord, b: &Chord) -> bool {
    let minus = |p: [f64; 2], q: [f64; 2]| [p[0] - q[0], p[1] - q[1]];
    let wedge = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
    let (d, e) = (minus(a.ends[1], a.ends[0]), minus(b.ends[1], b.ends[0]));
    let between = minus(b.ends[0], a.ends[0]);
    let area = wedge(d, e);
    if area == 0.0 {
        return false;
    }
    let inside = AT_END..=1.0 - AT_END;
    let heights = |of: &Chord, from: [f64; 2], along: [f64; 2]| {
        let height = |end: [f64; 2]| wedge(along, minus(end, from)).abs();
        of.ends.map(height).iter().copied().fold(0.0, f64::max) / along[0].hypot(along[1])
    };
    let deep = heights(b, a.ends[0], d).max(heights(a, b.ends[0], e));
    inside.contains(&(wedge(between, e) / area))
        && inside.contains(&(wedge(between, d) / area))
        && deep > 2.0 * (a.sagitta + b.sagitta)
}
