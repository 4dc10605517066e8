//! Flips and splits of the edges of a base.

use super::base::{Base, Flat, TrianglePlace};
use super::coarsen::{faces_scan, is_shaped};
use super::ground::Ground;
use crate::geometry::Uv;

/// Flips edges where that makes the valences more even and no triangle worse than allowed. Returns the
/// number of flips.
pub(super) fn flip(base: &mut Base, spread: f64) -> usize {
    let mut count = 0;
    let mut t = 0;
    while t < base.triangles.len() {
        for k in 0..3 {
            if base.alive[t] && flip_gain(base, t, k) > 0 && flip_side(base, spread, t, k) {
                count += 1;
            }
        }
        t += 1;
    }
    count
}

/// By how much a flip lowers the sum of squares of valences minus six.
fn flip_gain(base: &Base, t: usize, k: usize) -> i64 {
    let Some((_, d)) = base.across(t, k) else { return 0 };
    let corners = base.triangles[t];
    let [a, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
    let square = |v: u32, by: i64| (base.valence(v) as i64 + by - 6).pow(2);
    let before = square(a, 0) + square(b, 0) + square(c, 0) + square(d, 0);
    before - square(a, -1) - square(b, -1) - square(c, 1) - square(d, 1)
}

/// Two triangles (a, b, c) and (b, a, d) in a plane, unfolded about their common edge: the places of a, b,
/// c and d, and the triangles in a record.
fn unfolded(base: &Base, triangles: [u32; 2], names: [u32; 4]) -> Option<([Uv; 4], Vec<Flat>)> {
    let [a, b, c, d] = names.map(|v| base.point(v));
    let length = (b - a).norm();
    (length > 0.0).then_some(())?;
    let place = |p: crate::geometry::Point, side: f64| {
        let along = (p - a).dot(&(b - a)) / length;
        let off = ((p - a).norm_squared() - along * along).max(0.0).sqrt();
        Uv::new(along / length, side * off / length)
    };
    let places = [Uv::origin(), Uv::new(1.0, 0.0), place(c, 1.0), place(d, -1.0)];
    let place_of = |v: u32| names.iter().position(|&w| w == v).map_or(places[0], |k| places[k]);
    let flat = |t: u32| (t, base.triangles[t as usize].map(place_of));
    Some((places, triangles.map(flat).to_vec()))
}

/// Flips side `k` of a triangle if this is legal.
pub(super) fn flip_side(base: &mut Base, spread: f64, t: usize, k: usize) -> bool {
    let Some((other, d)) = base.across(t, k) else { return false };
    let corners = base.triangles[t];
    let [a, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
    let joined = base.around[c as usize].iter().any(|&o| base.triangles[o as usize].contains(&d));
    if c == d || joined || base.valence(a) < 5 || base.valence(b) < 5 {
        return false;
    }
    let Some(([fa, fb, fc, fd], old)) = unfolded(base, [t as u32, other], [a, b, c, d]) else {
        return false;
    };
    let new: Vec<Flat> = vec![(0, [fc, fa, fd]), (0, [fd, fb, fc])];
    let made = [[c, a, d], [d, b, c]];
    if !is_shaped(base, &old, &new, &made) {
        return false;
    }
    let members = base.moved_members(&old, &new, None);
    if !made.iter().zip(&members).all(|(t, m)| faces_scan(base, spread, *t, m)) {
        return false;
    }
    base.replace(old, new, &made, members);
    true
}

/// Flips an edge opposite to a vertex, so that the vertex gets a triangle more: the one that is opposite
/// to the vertex with the fewest triangles. Returns whether one could be flipped. The spread of the
/// scan's normals does not count here.
pub(super) fn flip_link(base: &mut Base, v: u32) -> bool {
    let Some(ring) = base.ring(v) else { return false };
    let mut sides: Vec<(usize, usize, usize)> = ring
        .iter()
        .filter_map(|&(_, t)| {
            let t = t as usize;
            let k = (base.triangles[t].iter().position(|&w| w == v)? + 1) % 3;
            let (_, apex) = base.across(t, k)?;
            Some((base.valence(apex), t, k))
        })
        .collect();
    sides.sort_unstable();
    sides.into_iter().any(|(_, t, k)| flip_side(base, -1.0, t, k))
}

/// Splits side `k` of a triangle in its middle. Returns whether it could be split.
pub(super) fn split_side(base: &mut Base, ground: &Ground, t: usize, k: usize) -> bool {
    let Some((other, d)) = base.across(t, k) else { return false };
    let [a, b, c] = [0, 1, 2].map(|i| base.triangles[t][(k + i) % 3]);
    let names = [a, b, c, d];
    let Some((places, old)) = unfolded(base, [t as u32, other], names) else { return false };
    let mut weights = [0.5; 3];
    weights[(k + 2) % 3] = 0.0;
    let on_scan = base.on_scan(TrianglePlace { triangle: t as u32, weights });
    let w = base.add_vertex(ground.point(&on_scan), ground.normal(&on_scan), a);
    let middle = nalgebra::center(&places[0], &places[1]);
    let fan = [[0, 3], [3, 1], [1, 2], [2, 0]];
    let new: Vec<Flat> = fan.map(|[x, y]| (0, [middle, places[x], places[y]])).to_vec();
    let corners = fan.map(|[x, y]| [w, names[x], names[y]]);
    let members = base.moved_members(&old, &new, None);
    base.replace(old, new, &corners, members);
    true
}

/// Splits the longest side opposite to a vertex, so that the vertex gets a triangle more.
pub(super) fn split_link(base: &mut Base, ground: &Ground, v: u32) -> bool {
    let sides = base.around[v as usize].iter().filter_map(|&t| {
        let t = t as usize;
        let k = (base.triangles[t].iter().position(|&w| w == v)? + 1) % 3;
        Some((base.side_length(t, k), t, k))
    });
    let longest = sides.max_by(|x, y| x.0.total_cmp(&y.0).then((y.1, y.2).cmp(&(x.1, x.2))));
    longest.is_some_and(|(_, t, k)| split_side(base, ground, t, k))
}
