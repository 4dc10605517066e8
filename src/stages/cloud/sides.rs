//! Which side of the surface is outside: the one that the scanner saw.

use formats::Points;
use rayon::prelude::*;

use super::order::Ordered;
use super::quadric::PrincipalPlane;
use crate::geometry::sets::Sets;
use crate::geometry::{SAME_SIDE, Vector};
use crate::mesh::{Mesh, Neighbours};

/// Turns each component of a mesh so that most of its vertices face the place of their scanner or,
/// without one, agree with the normals of the file. Vertex `v` stands for the point
/// `cloud_point[kept[v]]` of the cloud.
pub(super) fn face_scanner(mesh: &mut Mesh, cloud: &Points, cloud_point: &[u32], kept: &[u32]) {
    let outward = |v: usize| outward(cloud, cloud_point[kept[v] as usize] as usize);
    let mut sets = Sets::new(mesh.points.len());
    for t in &mesh.triangles {
        sets.join(t[0].index(), t[1].index());
        sets.join(t[1].index(), t[2].index());
    }
    let mut agreed = vec![0i64; mesh.points.len()];
    for (v, normal) in mesh.vertex_normals().into_iter().enumerate() {
        let Some(side) = outward(v) else { continue };
        let side = side.dot(&normal);
        agreed[sets.find(v)] += i64::from(side > 0.0) - i64::from(side < 0.0);
    }
    for t in &mut mesh.triangles {
        if agreed[sets.find(t[0].index())] < 0 {
            t.swap(1, 2);
        }
    }
}

/// The direction that each point faces: the file's normal, or else the normal of the `count` nearest points on the side
/// of the scanner. It is zero where a scanner looked along the surface. `None` if the file has no normals, and one
/// scanner has seen all.
pub(super) fn facing(
    cloud: &Points,
    ordered: &Ordered,
    near: &Neighbours,
    count: usize,
) -> Option<Vec<Vector>> {
    if let Some(normals) = &cloud.normals {
        let of = |&first: &u32| {
            let normal = normals.get(first as usize).copied().unwrap_or_default();
            Vector::from(normal.map(f64::from)).try_normalize(0.0).unwrap_or_else(Vector::zeros)
        };
        return Some(ordered.first.iter().map(of).collect());
    }
    if !are_known(cloud) {
        return None;
    }
    let of = |found: &mut Vec<(u32, f64)>, i: usize| {
        let scanner = outward(cloud, ordered.first[i] as usize)
            .and_then(|to_scanner| to_scanner.try_normalize(0.0))
            .unwrap_or_else(Vector::zeros);
        let own = ordered.points[i];
        near.nearest_n(own, count + 1, found);
        let around = found.iter().map(|&(j, _)| (1.0, ordered.points[j as usize] - own));
        let normal = PrincipalPlane::fit(around).normal;
        let side = normal.dot(&scanner);
        if side.abs() < SAME_SIDE { Vector::zeros() } else { side.signum() * normal }
    };
    Some((0..ordered.points.len()).into_par_iter().map_init(Vec::new, of).collect())
}

/// Whether points of two sides of a sheet can be told: by their normals, or because several scanners saw them.
pub(super) fn are_known(cloud: &Points) -> bool {
    let viewpoints = || cloud.scans.iter().filter(|scan| scan.viewpoint.is_some());
    cloud.normals.is_some() || viewpoints().count() > 1
}

/// A direction on the outer side of the surface at a point, if the cloud tells one.
pub(super) fn outward(cloud: &Points, point: usize) -> Option<Vector> {
    let scan = cloud.scans.iter().find(|scan| scan.points.contains(&point));
    let scanner = scan.and_then(|scan| scan.viewpoint);
    let to_scanner = scanner.map(|s| Vector::from(s) - Vector::from(cloud.positions[point]));
    to_scanner.or_else(|| Some(Vector::from(cloud.normals.as_ref()?.get(point)?.map(f64::from))))
}
