//! Removal of ragged rims: triangles that share only one side with the rest of the mesh.
//!
//! Scanners leave such teeth where their view ends. Smoothing would pull the tip of a tooth back
//! through its own base, so teeth are removed before the boundary is smoothed.

use foldhash::{HashSet, HashSetExt};

use super::{Disk, EdgeMap, Mesh, Outer};
use crate::error::Result;

/// A triangle at the outer boundary whose tip has at least this angle is kept, because it may be a
/// corner of the object. The value is 75° in radians.
const MIN_CORNER_ANGLE: f64 = 75.0 * std::f64::consts::PI / 180.0;

/// A tooth may consist of several triangles; this many are removed at most, one in each round.
const MAX_ROUNDS: usize = 3;

/// Removes hanging triangles from a disk with these edges. Returns the disk and the number of removed triangles.
pub(super) fn trim_hanging(
    mut disk: Disk,
    mut edges: EdgeMap,
    outer: Outer,
) -> Result<(Disk, usize)> {
    let mut trimmed = 0;
    for _ in 0..MAX_ROUNDS {
        let dropped = hanging(&disk);
        if dropped.is_empty() || 2 * dropped.len() > disk.mesh.triangles.len() {
            break;
        }
        trimmed += dropped.len();
        let all = 0..disk.mesh.triangles.len();
        let kept: Vec<usize> = all.filter(|&t| !dropped.contains(&(t as u32))).collect();
        let (mesh, _) = disk.mesh.part(kept.iter().copied());
        edges = edges.part(&kept);
        disk = Disk::new(mesh, &edges, outer)?;
    }
    Ok((disk, trimmed))
}

/// For each vertex the number of its triangle, if it has exactly one.
fn single_triangles(mesh: &Mesh) -> Vec<Option<u32>> {
    let mut last = vec![(0, 0); mesh.points.len()];
    for (t, v) in (0..).zip(&mesh.triangles).flat_map(|(t, corners)| corners.map(|v| (t, v))) {
        last[v.index()] = (last[v.index()].0 + 1, t);
    }
    last.into_iter().map(|(count, t)| (count == 1).then_some(t)).collect()
}

/// The triangles with a tip that no other triangle uses.
fn hanging(disk: &Disk) -> HashSet<u32> {
    let single_triangles = single_triangles(&disk.mesh);
    let mut dropped = HashSet::new();
    let loops = std::iter::once((&disk.outer, true)).chain(disk.holes.iter().map(|h| (h, false)));
    for (ring, outer) in loops {
        // Two hanging triangles may share an end of their bases. A ring of three or fewer of them
        // would vanish.
        for (i, &tip) in ring.iter().enumerate().filter(|_| ring.len() > 4) {
            let before = ring[(i + ring.len() - 1) % ring.len()];
            let after = ring[(i + 1) % ring.len()];
            let is_corner = outer && disk.mesh.angle(before, tip, after) >= MIN_CORNER_ANGLE;
            dropped.extend(single_triangles[tip.index()].filter(|_| !is_corner));
        }
    }
    dropped
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, VertexId};

    #[test]
    fn a_tooth_goes_and_the_corners_stay() {
        let mut mesh = Mesh::default();
        for i in 0..25 {
            mesh.points.push(Point::new(f64::from(i % 5), f64::from(i / 5), 0.0));
        }
        let v = VertexId;
        for i in (0..20).filter(|i| i % 5 < 4) {
            mesh.triangles.push([v(i), v(i + 1), v(i + 6)]);
            mesh.triangles.push([v(i), v(i + 6), v(i + 5)]);
        }
        let clean = mesh.triangles.len();
        mesh.points.push(Point::new(2.5, -1.0, 0.0));
        mesh.triangles.push([v(3), v(2), v(25)]);
        let edges = EdgeMap::new(&mesh);
        let disk = Disk::new(mesh, &edges, Outer::Auto).unwrap();
        let (disk, trimmed) = trim_hanging(disk, edges, Outer::Auto).unwrap();
        assert_eq!((trimmed, disk.mesh.triangles.len(), disk.mesh.points.len()), (1, clean, 25));
    }
}
