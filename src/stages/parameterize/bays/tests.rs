use super::*;
use crate::geometry::unit_normal;
use crate::mesh::{EdgeMap, Mesh, VertexRings, boundary};

/// A sheet of n × n squares over a surface, some of them left out.
fn sheet(
    n: usize,
    is_there: impl Fn(usize, usize) -> bool,
    at: impl Fn(f64, f64) -> [f64; 3],
) -> Mesh {
    let mut ids = HashMap::default();
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        if is_there(i, j) {
            let mut id = |i: usize, j: usize| {
                *ids.entry((i, j)).or_insert_with(|| {
                    points.push(Point::from(at(i as f64, j as f64)));
                    VertexId::from(points.len() - 1)
                })
            };
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Mesh { points, triangles }
}

/// A mesh and the triangles that close its bays.
fn closed(mesh: &Mesh) -> (Mesh, Option<BayClosure>) {
    closed_on(mesh, None)
}

/// The same with bays found on a map.
fn closed_on(mesh: &Mesh, map: Option<&[Uv]>) -> (Mesh, Option<BayClosure>) {
    let outer = boundary::boundary_loops(mesh, &EdgeMap::new(mesh)).remove(0);
    let rings = VertexRings::new(mesh);
    let bays = closing(Adjacency { mesh, rings: &rings }, &outer, map);
    let mut whole = mesh.clone();
    if let Some(bays) = &bays {
        whole.points.extend(&bays.points);
        whole.triangles.extend(&bays.triangles);
    }
    (whole, bays)
}

/// Whether a mesh is a disk with the loop as its boundary.
fn is_disk(mesh: &Mesh, outer: &Loop) -> bool {
    let loops = boundary::boundary_loops(mesh, &EdgeMap::new(mesh));
    let start = loops[0].iter().position(|v| *v == outer[0]).unwrap_or(0);
    let turned = [&loops[0][start..], &loops[0][..start]].concat();
    turned == *outer && Patch { outer: outer.clone(), ..Patch::closed(mesh.clone()) }.is_disk()
}

#[test]
fn a_combs_gaps_are_closed_flat() {
    // Teeth of four squares with gaps of three.
    let is_there = |i: usize, j: usize| j < 8 || i % 7 < 4;
    let (whole, bays) = closed(&sheet(32, is_there, |x, y| [x, y, 0.0]));
    let bays = bays.expect("bays");
    assert_eq!(bays.count, 4);
    assert!(is_disk(&whole, &bays.outer));
    let normal = |t: &[VertexId; 3]| unit_normal(whole.corners(*t)).expect("an area");
    assert!(whole.triangles.iter().all(|t| normal(t).z > 0.999));
    let twice: f64 = whole.triangles.iter().map(|t| whole.area_vector(*t).z).sum();
    assert!((twice / 2.0 / (32.0 * 32.0) - 1.0).abs() < 0.01);
    assert!(boundary::length(&whole, &bays.outer) < 1.01 * 128.0);
}

#[test]
fn straight_and_wide_boundaries_have_no_bays() {
    let flat = |x: f64, y: f64| [x, y, 0.0];
    assert!(closed(&sheet(20, |_, _| true, flat)).1.is_none());
    // The same holds for a sheet bent to three quarters of a tube whose ends have teeth.
    let bent = |x: f64, y: f64| {
        let angle = 0.1 * x;
        [10.0 * angle.cos(), y, -10.0 * angle.sin()]
    };
    let teeth = |i: usize, j: usize| j > 0 || i.is_multiple_of(2);
    let (whole, bays) = closed(&sheet(47, teeth, bent));
    let bays = bays.expect("the gaps between the teeth");
    assert!(is_disk(&whole, &bays.outer));
    let off = |p: &Point| (p.x.hypot(p.z) - 10.0).abs();
    assert!(bays.points.iter().map(off).fold(0.0, f64::max) < 0.2);
    assert!(bays.points.iter().all(|p| p.y < 1.5));
}

#[test]
fn a_bay_in_a_bent_sheet_is_closed_beside_it() {
    let bent = |x: f64, y: f64| [x, y, 2.0 * (0.2 * x).sin()];
    let is_there = |i: usize, j: usize| !(12..20).contains(&i) || j < 10;
    let (whole, bays) = closed(&sheet(32, is_there, bent));
    let bays = bays.expect("a bay");
    assert_eq!(bays.count, 1);
    assert!(is_disk(&whole, &bays.outer));
    assert!(bays.points.iter().all(|p| (p.z - 2.0 * (0.2 * p.x).sin()).abs() < 1.5));
}

/// A sheet of n × n squares over a surface, some of them left out, and its flat map.
fn mapped(
    n: usize,
    is_there: impl Fn(usize, usize) -> bool,
    at: impl Fn(f64, f64) -> [f64; 3],
) -> (Mesh, Vec<Uv>) {
    let flat = sheet(n, &is_there, |x, y| [x, y, 0.0]);
    (sheet(n, is_there, at), flat.points.iter().map(|p| Uv::new(p.x, p.y)).collect())
}

#[test]
fn a_slit_whose_bank_hangs_over_is_closed_if_it_is_deep() {
    // The part to the right of the slit leans over the part to its left, increasingly outwards.
    let slit = |from: f64, steep: f64| {
        let over = move |x: f64, y: f64| {
            let out = if x > 15.5 { (y - from).max(0.0) } else { 0.0 };
            [x - steep * out, y, 0.4 * out]
        };
        let (mesh, map) = mapped(32, move |i, j| i != 15 || (j as f64) < from, over);
        closed_on(&mesh, Some(&map))
    };
    let (whole, bays) = slit(8.0, 0.6);
    let bays = bays.expect("a bay");
    assert_eq!(bays.count, 1);
    assert!(is_disk(&whole, &bays.outer));
    let is_open = |p: Point| 1.0 < p.x && p.x < 20.0 && 7.0 < p.y && p.y < 25.0;
    assert!(!bays.outer.iter().any(|&v| is_open(whole.point(v))));
    assert!(slit(30.0, 3.0).1.is_none());
}

#[test]
fn on_a_map_ears_are_not_closed_over_a_tongue_between_them() {
    // A bay with a tongue in it. The regions beside the tongue are closed first, then the region
    // above it.
    let is_there = |i: usize, j: usize| j < 8 || !(8..24).contains(&i) || i == 14 && j < 20;
    let (mesh, map) = mapped(32, is_there, |x, y| [x, y, 0.0]);
    let (whole, bays) = closed_on(&mesh, Some(&map));
    let bays = bays.expect("a bay");
    assert!(is_disk(&whole, &bays.outer));
    let doubled = |t: &[VertexId; 3]| {
        let [a, b, c] = whole.corners(*t);
        (b - a).cross(&(c - a)).z
    };
    assert!(whole.triangles.iter().all(|t| doubled(t) > 0.0));
    let area: f64 = whole.triangles.iter().map(doubled).sum();
    assert!((0.5 * area - 1024.0).abs() < 1e-6, "{area}");
}

/// Bays that the angles along the boundary suggest are opened again if the map does not show them.
#[test]
fn a_map_without_bays_opens_those_that_were_closed() {
    let is_there = |i: usize, j: usize| j < 8 || i % 7 < 4;
    let mesh = sheet(32, is_there, |x, y| [x, y, 0.0]);
    let outer = boundary::boundary_loops(&mesh, &EdgeMap::new(&mesh)).remove(0);
    let patch = Patch { outer, ..Patch::closed(mesh) };
    let (closed, bays) = close(patch.clone(), None);
    assert!(bays.count == 4 && bays.added_triangles > 0);
    // On the map the boundary is a circle.
    let count = patch.outer.len() as f64;
    let mut map = vec![Uv::new(0.5, 0.5); closed.mesh.points.len()];
    for (k, v) in patch.outer.iter().enumerate() {
        let angle = std::f64::consts::TAU * k as f64 / count;
        map[v.index()] = Uv::new(0.5 + 0.4 * angle.cos(), 0.5 + 0.4 * angle.sin());
    }
    let (opened, bays) = close(closed.without_bays().expect("it has bays"), Some(&map));
    assert_eq!(bays, Bays::default());
    assert_eq!((opened.outer, opened.measured_outer), (patch.outer, None));
    assert!(opened.origin.iter().all(|origin| *origin == FaceOrigin::Measured));
}
