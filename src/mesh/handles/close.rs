//! The cut along a loop inside a component, and the caps on both sides of it.

use std::collections::{HashMap, HashSet};

use super::mean;
use crate::geometry::{Point, VertexId};
use crate::mesh::build::Build;
use crate::mesh::{EdgeMap, Mesh};

/// Cuts a component along loops without common vertices and closes both rims of each.
pub(super) fn cut_and_close(build: &mut Build, rings: &[Vec<VertexId>]) {
    let on_rings: HashSet<VertexId> = rings.iter().flatten().copied().collect();
    let mut side_of = HashMap::new();
    for side in 0..3 * build.mesh.triangles.len() {
        let t = build.mesh.triangles[side / 3];
        let ends = (t[side % 3], t[(side % 3 + 1) % 3]);
        if on_rings.contains(&ends.0) && on_rings.contains(&ends.1) {
            side_of.insert(ends, side);
        }
    }
    let moved: Vec<_> = rings.iter().map(|ring| right_corners(build, &side_of, ring)).collect();
    for (ring, corners) in rings.iter().zip(moved) {
        let copies: Vec<VertexId> =
            ring.iter().map(|&v| add_vertex(build, build.mesh.point(v))).collect();
        for (side, i) in corners {
            build.mesh.triangles[side / 3][side % 3] = copies[i];
        }
        let backwards: Vec<VertexId> = ring.iter().rev().copied().collect();
        let rims = [close(build, backwards), close(build, copies)];
        retract(&mut build.mesh, &rims);
    }
    build.edges = EdgeMap::new(&build.mesh);
}

/// The corners to the right of a loop, each with the position of its vertex in the loop.
fn right_corners(
    build: &Build,
    side_of: &HashMap<(VertexId, VertexId), usize>,
    ring: &[VertexId],
) -> Vec<(usize, usize)> {
    let n = ring.len();
    let mut corners = Vec::new();
    for i in 0..n {
        let (before, v, after) = (ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]);
        // Counter-clockwise from the triangle to the right of the side that arrives.
        let mut corner = side_of.get(&(v, before)).copied();
        while let Some(side) = corner {
            corners.push((side, i));
            let arrives = side / 3 * 3 + (side % 3 + 2) % 3;
            let from = build.mesh.triangles[side / 3][(side % 3 + 2) % 3];
            corner = if from == after { None } else { build.edges.across(arrives) };
        }
    }
    corners
}

/// The number of steps in which a stump is drawn back. It is then a hundredth as long, or shorter.
const RETRACTIONS: usize = 12;

/// Draws the stump of a handle back to where the handle began. The other rim, which moves less when it
/// is drawn to its neighbours, belongs to the surface and stays.
fn retract(mesh: &mut Mesh, rims: &[Vec<VertexId>; 2]) {
    let drawn = rims.each_ref().map(|rim| {
        let mut neighbours: HashMap<VertexId, Vec<VertexId>> = HashMap::new();
        for t in &mesh.triangles {
            for k in (0..3).filter(|&k| rim.contains(&t[k])) {
                neighbours.entry(t[k]).or_default().extend([t[(k + 1) % 3], t[(k + 2) % 3]]);
            }
        }
        let mut at: HashMap<VertexId, Point> = HashMap::new();
        for _ in 0..RETRACTIONS {
            let place = |v: &VertexId| at.get(v).copied().unwrap_or_else(|| mesh.point(*v));
            let moved = |v: &VertexId| {
                let around: Vec<Point> = neighbours.get(v)?.iter().map(place).collect();
                Some((*v, Point::from(mean(&around))))
            };
            at = rim.iter().filter_map(moved).collect();
        }
        let off: f64 = at.iter().map(|(&v, p)| (p - mesh.point(v)).norm()).sum();
        (off, at)
    });
    let stump = usize::from(drawn[1].0 > drawn[0].0);
    for (v, &p) in &drawn[stump].1 {
        mesh.points[v.index()] = p;
    }
}

/// Adds a vertex at a place of its own.
fn add_vertex(build: &mut Build, p: Point) -> VertexId {
    let place = build.place.iter().max().map_or(0, |&last| last + 1);
    build.mesh.points.push(p);
    build.place.push(place);
    VertexId::from(build.mesh.points.len() - 1)
}

/// Closes a rim with a triangle, or with a fan around its middle. Returns the corners.
fn close(build: &mut Build, mut rim: Vec<VertexId>) -> Vec<VertexId> {
    if let [a, b, c] = rim[..] {
        build.mesh.triangles.push([a, b, c]);
        return rim;
    }
    let points: Vec<Point> = rim.iter().map(|&v| build.mesh.point(v)).collect();
    let middle = add_vertex(build, Point::from(mean(&points)));
    for (i, &v) in rim.iter().enumerate() {
        build.mesh.triangles.push([v, rim[(i + 1) % rim.len()], middle]);
    }
    rim.push(middle);
    rim
}
