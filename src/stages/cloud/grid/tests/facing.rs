//! The side of the triangles.

use super::*;

/// The share of triangles that are counter-clockwise seen from a place.
fn seen_from(cloud: &Points, mesh: &GridSurface, place: [f64; 3]) -> f64 {
    let point = |v: VertexId| Point::from(cloud.positions[v.index()]);
    let is_seen = |t: &&[VertexId; 3]| {
        let [a, b, c] = t.map(point);
        (b - a).cross(&(c - a)).dot(&(Point::from(place) - a)) > 0.0
    };
    mesh.mesh.triangles.iter().filter(is_seen).count() as f64 / mesh.mesh.triangles.len() as f64
}

#[test]
fn triangles_face_the_viewpoint() {
    let mut cloud = all_around();
    assert_eq!(seen_from(&cloud, &mesh(&cloud), [0.0; 3]), 1.0);
    // Seen from outside the same grid runs the other way round.
    cloud.scans[0].viewpoint = Some([1e6, 0.0, 0.0]);
    let mirrored = scan(20, 20, |(row, column)| Some([column as f64, row as f64, 0.0]));
    for z in [-50.0, 50.0] {
        let mut cloud = mirrored.clone();
        cloud.scans[0].viewpoint = Some([10.0, 10.0, z]);
        let mesh = mesh(&cloud);
        assert_eq!(mesh.outside, Outside::Viewpoint);
        assert_eq!(seen_from(&cloud, &mesh, [10.0, 10.0, z]), 1.0);
    }
}

#[test]
fn without_a_viewpoint_normals_zero_or_rows_decide() {
    let plain = scan(20, 20, |(row, column)| Some([column as f64, row as f64, 5.0]));
    for side in [-1.0_f32, 1.0] {
        let mut cloud = plain.clone();
        cloud.normals = Some(vec![[0.0, 0.0, side]; 400]);
        let mesh = mesh(&cloud);
        assert_eq!(mesh.outside, Outside::Normals);
        assert_eq!(seen_from(&cloud, &mesh, [0.0, 0.0, 5.0 + 100.0 * f64::from(side)]), 1.0);
    }
    // Too few normals are none.
    let mut few = plain.clone();
    few.normals = Some(vec![[0.0, 0.0, 1.0]; 7]);
    assert_eq!(mesh(&few).outside, Outside::Zero);
    let of_zero = mesh(&plain);
    assert_eq!(of_zero.outside, Outside::Zero);
    assert_eq!(seen_from(&plain, &of_zero, [0.0; 3]), 1.0);
    // The zero is beside this surface, which it sees from both sides.
    let waves = scan(60, 60, |(row, column)| {
        Some([column as f64 + 1.0, row as f64, 10.0 * (column as f64 / 3.0).sin()])
    });
    let of_rows = mesh(&waves);
    assert_eq!(of_rows.outside, Outside::RowOrder);
    assert_eq!(seen_from(&waves, &of_rows, [30.0, 30.0, 1e6]), 1.0);
}
