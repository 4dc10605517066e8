//! Which side of the surface is outside: the one that the scanner saw.

use formats::Points;

use crate::geometry::Vector;
use crate::geometry::sets::Sets;
use crate::mesh::Mesh;

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

/// A direction on the outer side of the surface at a point, if the cloud tells one.
fn outward(cloud: &Points, point: usize) -> Option<Vector> {
    let scan = cloud.scans.iter().find(|scan| scan.points.contains(&point));
    let scanner = scan.and_then(|scan| scan.viewpoint);
    let to_scanner = scanner.map(|s| Vector::from(s) - Vector::from(cloud.positions[point]));
    to_scanner.or_else(|| Some(Vector::from(cloud.normals.as_ref()?.get(point)?.map(f64::from))))
}
