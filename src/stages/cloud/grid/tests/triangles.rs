//! The triangles of grids without and with missing points.

use super::*;

#[test]
fn every_square_has_two_triangles() {
    let cloud = relief([30, 40], 0.0, |x, y| Some(hills(x, y)));
    let mesh = mesh(&cloud);
    assert_eq!(mesh.mesh.triangles.len(), 2 * 29 * 39);
    assert_eq!(mesh.cut, 0);
    assert!((mesh.spacing - 1.0).abs() < 0.1, "{}", mesh.spacing);
}

#[test]
fn a_missing_cell_costs_four_triangles() {
    let flat = |missing: GridCell| {
        relief([9, 9], 0.0, |x, y| ((-y as usize, x as usize) != missing).then_some(0.0))
    };
    // Inside: three of four points make one triangle. In the corner: one triangle is left.
    assert_eq!(mesh(&flat((6, 6))).mesh.triangles.len(), 2 * 64 - 4);
    assert_eq!(mesh(&flat((0, 8))).mesh.triangles.len(), 2 * 64 - 1);
}

#[test]
fn a_point_before_the_surface_is_cut_off() {
    let cloud = relief([15, 15], 0.0, |x, y| Some(if (x, y) == (7.0, -7.0) { 30.0 } else { 0.0 }));
    let mesh = mesh(&cloud);
    assert_eq!(mesh.cut, 4);
    let far = 7 * 15 + 7;
    assert!(mesh.mesh.triangles.iter().flatten().all(|v| v.0 != far));
    assert_eq!(mesh.mesh.triangles.len(), 2 * 14 * 14 - 4);
}

#[test]
fn the_shorter_diagonal_is_taken() {
    // A ridge from one corner to the other is kept only by the diagonals along it.
    let cloud = relief([9, 9], 0.0, |x, y| Some(-(x + y).abs()));
    for [a, b, c] in mesh(&cloud).mesh.triangles {
        let cell = |v: VertexId| (v.0 / 9, v.0 % 9);
        let above = [a, b, c].map(cell).iter().any(|(row, column)| row > column);
        let below = [a, b, c].map(cell).iter().any(|(row, column)| row < column);
        assert!(!(above && below));
    }
}

#[test]
fn a_scan_all_around_is_not_joined_with_itself() {
    let mesh = mesh(&all_around());
    assert_eq!(mesh.mesh.triangles.len(), 2 * 39 * 89);
    let column = |v: &VertexId| v.0 % 90;
    let joins =
        |t: &[VertexId; 3]| t.iter().any(|v| column(v) == 0) && t.iter().any(|v| column(v) == 89);
    assert!(!mesh.mesh.triangles.iter().any(joins));
}

#[test]
fn the_vertices_are_the_points_and_missing_cells_are_closed() {
    let cloud = relief([30, 30], 0.1, |x, y| ((x, y) != (12.0, -12.0)).then(|| hills(x, y)));
    let made = triangulate_grid(&cloud, &Options::default()).unwrap();
    assert_eq!(made.soup.points, cloud.positions);
    assert_eq!(made.soup.polygons.len(), 2 * 29 * 29 - 2);
    assert!(made.vertex_of.iter().enumerate().all(|(i, &vertex)| vertex == i as u32));
    assert_eq!(
        made.report.grid,
        GridUse::Followed { cut: 0, outside: Outside::Viewpoint },
        "{:?}",
        made.report
    );
}

#[test]
fn a_point_without_neighbours_has_no_vertex() {
    let cloud = relief([30, 30], 0.0, |x, y| Some(if (x, y) == (7.0, -7.0) { 30.0 } else { 0.0 }));
    let made = triangulate_grid(&cloud, &Options::default()).unwrap();
    assert_eq!(made.vertex_of.iter().filter(|&&vertex| vertex == LEFT_OUT).count(), 1);
    assert_eq!((made.report.outliers, made.soup.points.len()), (1, 899));
    // The place behind it is closed.
    assert_eq!(made.soup.polygons.len(), 2 * 29 * 29 - 2);
}

#[test]
fn the_unit_and_the_place_do_not_matter() {
    let plain = relief([40, 40], 0.1, |x, y| Some(hills(x, y)));
    let reference = triangulate_grid(&plain, &Options::default()).unwrap();
    for scale in [1e-200, 1e200] {
        let mut cloud = plain.clone();
        cloud.positions.iter_mut().flatten().for_each(|x| *x *= scale);
        cloud.scans[0].viewpoint = plain.scans[0].viewpoint.map(|v| v.map(|x| x * scale));
        let made = triangulate_grid(&cloud, &Options::default()).unwrap();
        assert_eq!(made.soup.polygons, reference.soup.polygons);
        let ratio = made.report.noise / scale / reference.report.noise;
        assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
    }
}
