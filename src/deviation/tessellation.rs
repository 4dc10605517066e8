//! The faces of a network as triangles, and faces that go through each other.

use rayon::prelude::*;

use crate::geometry::{Point, Uv, Vector, VertexId};
use crate::mesh::Mesh;
use crate::mesh::crossings::crossings;
use crate::spline::{KeptPlaces, Network};

/// The longest step in u and in v, in quads. With half as long ones the triangles of neighbouring
/// faces are a quarter as far from the faces.
const STEP: f64 = 0.5;

/// A closed mesh on the faces of a network, and for each triangle its face and the parameter point of its
/// middle.
pub fn tessellation(network: &Network) -> (Mesh, Vec<(usize, Uv)>) {
    let mut mesh = Mesh { points: network.corners.clone(), triangles: Vec::new() };
    let Some(first) = network.surfaces.first() else { return (mesh, Vec::new()) };
    let at = steps(&first.u.breaks());
    let last = at.len() - 1;
    let inner = |from: usize, k: usize, i: usize| from + k * (last - 1) + i - 1;
    let on_tracks = mesh.points.len();
    for track in &network.tracks {
        mesh.points.extend(at[1..last].iter().map(|&t| Point::from(track.curve.point(t))));
    }
    let in_faces = mesh.points.len();
    let points_of = |surface: &crate::spline::Surface| -> Vec<Point> {
        let places = at[1..last].iter().flat_map(|&v| at[1..last].iter().map(move |&u| (u, v)));
        places.map(|(u, v)| surface.jet(Uv::new(u, v)).s).collect()
    };
    let points: Vec<Vec<Point>> = network.surfaces.par_iter().map(points_of).collect();
    mesh.points.extend(points.into_iter().flatten());
    let mut faces = Vec::new();
    for (face, sides) in network.sides.iter().enumerate() {
        // The vertex at step i along side k, counter-clockwise.
        let on_side = |k: usize, i: usize| {
            let track = &network.tracks[sides[k].track];
            let i = if sides[k].forward { i } else { last - i };
            match i {
                0 => track.ends[0],
                i if i == last => track.ends[1],
                i => inner(on_tracks, sides[k].track, i),
            }
        };
        let vertex = |i: usize, j: usize| {
            VertexId::from(match (i, j) {
                (i, 0) => on_side(0, i),
                (i, j) if i == last => on_side(1, j),
                (i, j) if j == last => on_side(2, last - i),
                (0, j) => on_side(3, last - j),
                (i, j) => inner(in_faces, face * (last - 1) + j - 1, i),
            })
        };
        for (i, j) in (0..last * last).map(|k| (k % last, k / last)) {
            let [a, b] = [vertex(i, j), vertex(i + 1, j)];
            let [c, d] = [vertex(i + 1, j + 1), vertex(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
            // The triangles are above and below the diagonal.
            let place = |share: f64| {
                let along = |i: usize, share: f64| at[i] + share * (at[i + 1] - at[i]);
                (face, Uv::new(along(i, share), along(j, 1.0 - share)))
            };
            faces.extend([place(2.0 / 3.0), place(1.0 / 3.0)]);
        }
    }
    (mesh, faces)
}

/// Parameters from the first break to the last: the breaks, and steps between them.
fn steps(breaks: &[f64]) -> Vec<f64> {
    let mut steps = vec![breaks[0]];
    for span in breaks.windows(2) {
        let count = ((span[1] - span[0]) / STEP).ceil().max(1.0);
        steps
            .extend((1..=count as usize).map(|i| span[0] + (span[1] - span[0]) * i as f64 / count));
    }
    steps
}

/// The faces of a network that go through other faces or through themselves, each with a place. Only
/// kept places count.
pub fn crossing_faces(network: &Network, kept: &KeptPlaces) -> Vec<(usize, Point)> {
    let (mesh, faces) = tessellation(network);
    let is_kept = |&t: &usize| kept.contains(faces[t].0, faces[t].1);
    let pairs = crossings(&mesh).into_iter().filter(|pair| pair.iter().all(is_kept));
    let place = |t: usize| {
        let corners = mesh.corners(mesh.triangles[t]);
        (faces[t].0, Point::from(corners.iter().map(|p| p.coords).sum::<Vector>() / 3.0))
    };
    let mut found: Vec<(usize, Point)> = pairs.flatten().map(place).collect();
    found.sort_by_key(|f| f.0);
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_end_at_breaks() {
        let all = steps(&[0.0, 0.25, 1.0, 2.0]);
        assert_eq!(all, [0.0, 0.25, 0.625, 1.0, 1.5, 2.0]);
    }
}
