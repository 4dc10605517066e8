//! Removal of caps: triangles without area whose corners are three different vertices on one line.
//! Dropping a cap would leave a slit. Flipping its longest side instead gives two triangles that
//! have the vertex on this side as a corner.

use foldhash::{HashSet, HashSetExt};
use rayon::prelude::*;

use super::build::{Build, count};
use super::{EdgeMap, Mesh, VertexRings};
use crate::geometry::{ROUNDING, VertexId};

/// A triangle is a cap if its height is below this share of its longest side. The value is far
/// below the resolution of single precision.
const FLAT: f64 = 1e-9;

/// Flips caps away. A cap whose longest side is on the boundary is dropped instead; a cap that can
/// be neither flipped nor dropped stays. Returns whether the mesh changed.
pub(super) fn flip(build: &mut Build) -> bool {
    let mut gone = 0;
    loop {
        let Build { mesh, edges, .. } = build;
        let (flipped, dropped) = round(mesh, edges, FLAT, |_, _| true);
        build.drop_triangles(&dropped);
        let changed = dropped.len() + flipped.len();
        if changed == 0 {
            break;
        }
        gone += changed;
        build.edges = EdgeMap::new(&build.mesh);
    }
    count(&mut build.repairs, "degenerate_faces", gone);
    gone > 0
}

/// Flips caps of which no two share a triangle or a neighbour. `may` tells whether a cap may be flipped with the triangle at its
/// longest side. Returns the triangles of the flipped pairs, and the caps at the boundary, which can go.
pub(crate) fn round(
    mesh: &mut Mesh,
    edges: &EdgeMap,
    share: f64,
    may: impl Fn(usize, usize) -> bool,
) -> (Vec<[usize; 2]>, HashSet<usize>) {
    let (whole, triangles) = (&*mesh, mesh.triangles.par_iter());
    let flat: Vec<Option<usize>> = triangles.map(|&t| longest_if_flat(whole, t, share)).collect();
    let mut flipped = Vec::new();
    let mut dropped = HashSet::new();
    if flat.iter().all(Option::is_none) {
        return (flipped, dropped);
    }
    let rings = VertexRings::new(mesh);
    let mut touched = HashSet::new();
    for (t, k) in flat.iter().enumerate().filter_map(|(t, k)| k.map(|k| (t, k))) {
        let corners = mesh.triangles[t];
        let [p, q, r] = [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]];
        let Some(other) = edges.across(3 * t + k) else {
            if touched.insert(t) {
                dropped.insert(t);
            }
            continue;
        };
        let (o, j) = (other / 3, other % 3);
        let facing = mesh.triangles[o];
        let d = facing[(j + 2) % 3];
        // Two caps back to back get sides outside in exchange, each shorter.
        let is_fit = flat[o].is_none_or(|longest| longest == j);
        let sound = is_fit && facing[j] == q && d != r && may(t, o);
        let news = sound && !rings.neighbours(mesh, r).any(|v| v == d);
        let apart = [t, o]
            .iter()
            .chain(&around(edges, t))
            .chain(&around(edges, o))
            .all(|t| !touched.contains(t));
        if news && apart {
            mesh.triangles[t] = [p, d, r];
            mesh.triangles[o] = [q, r, d];
            touched.extend([t, o]);
            flipped.push([t, o]);
        }
    }
    (flipped, dropped)
}

/// The triangles that share a side with `t`.
fn around(edges: &EdgeMap, t: usize) -> Vec<usize> {
    (3 * t..3 * t + 3).filter_map(|side| edges.across(side)).map(|side| side / 3).collect()
}

/// The longest side of the triangle, if the triangle is a cap. A triangle whose third corner
/// coincides with an end of this side is not a cap, because a flip would not improve it.
fn longest_if_flat(mesh: &Mesh, t: [VertexId; 3], share: f64) -> Option<usize> {
    let [a, b, c] = mesh.corners(t);
    let squares = [(b - a).norm_squared(), (c - b).norm_squared(), (a - c).norm_squared()];
    let long = squares[0].max(squares[1]).max(squares[2]);
    let short = squares[0].min(squares[1]).min(squares[2]);
    let is_flat = (b - a).cross(&(c - a)).norm_squared() <= (share * long).powi(2);
    (is_flat && short > ROUNDING * long).then(|| squares.iter().position(|&s| s == long))?
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    /// A square with a vertex in the middle of its lower side. Only a flat triangle joins this
    /// vertex to the rest.
    fn square_with_cap(outside: bool) -> Build {
        let mut points = vec![[0., 0., 0.], [2., 0., 0.], [2., 2., 0.], [0., 2., 0.], [1., 0., 0.]];
        let mut triangles = vec![[0, 1, 2], [0, 2, 3], [1, 0, 4]];
        if outside {
            points.push([1., -1., 0.]);
            triangles.extend([[0, 5, 4], [4, 5, 1]]);
        }
        let place = (0..points.len() as u32).collect();
        let points = points.into_iter().map(Point::from).collect();
        let triangles = triangles.into_iter().map(|t| t.map(VertexId)).collect();
        Build::new(Mesh { points, triangles }, place, 1.0)
    }

    #[test]
    fn an_inner_cap_is_flipped() {
        let mut build = square_with_cap(true);
        let before = build.mesh.triangles.len();
        assert!(flip(&mut build));
        assert_eq!(build.mesh.triangles.len(), before);
        assert_eq!(build.edges.open_sides().count(), 5);
        assert!(build.mesh.triangles.iter().all(|&t| build.mesh.area_vector(t).z > 0.1));
    }

    #[test]
    fn two_caps_back_to_back_are_flipped() {
        let mut points = vec![[0., 0., 0.], [3., 0., 0.], [1., 0., 0.], [2., 0., 0.]];
        points.extend([[1.5, 1., 0.], [1.5, -1., 0.]]);
        let triangles = [[0, 1, 2], [1, 0, 3], [2, 4, 0], [1, 4, 2], [0, 5, 3], [3, 5, 1]];
        let place = (0..points.len() as u32).collect();
        let points = points.into_iter().map(Point::from).collect();
        let triangles = triangles.into_iter().map(|t| t.map(VertexId)).collect();
        let mut build = Build::new(Mesh { points, triangles }, place, 1.0);
        assert!(flip(&mut build));
        let is_flat = |&t: &[VertexId; 3]| build.mesh.area_vector(t).norm() < 0.1;
        assert!(!build.mesh.triangles.iter().any(is_flat), "{:?}", build.mesh.triangles);
    }

    #[test]
    fn a_cap_on_the_boundary_goes() {
        let mut build = square_with_cap(false);
        let flat: Vec<_> =
            build.mesh.triangles.iter().map(|&t| longest_if_flat(&build.mesh, t, FLAT)).collect();
        assert_eq!(flat, [None, None, Some(0)]);
        assert!(flip(&mut build));
        assert!(build.mesh.triangles.iter().all(|&t| build.mesh.area_vector(t).z > 0.1));
    }
}
