//! Regions of made scans: bodies that are seen from their middle, with noise, and without a vertex on an edge.

use std::collections::BTreeMap;

use nalgebra::Rotation3;

use super::{ScanNoise, find_scanned};
use crate::geometry::random::scattered;
use crate::geometry::{NONE, Point, Vector, VertexId};
use crate::mesh::Mesh;
use crate::primitives::{Primitive, PrimitiveKind};
use crate::stages::regions::Regions;

/// The cells across each side of the cube whose points give the directions.
const CELLS: usize = 44;

/// The noise as a share of the mean edge.
const NOISE: f64 = 0.07;

/// A scan of the body in which `height` is negative. All points of it are seen from the origin.
fn scan(height: impl Fn(Vector) -> f64) -> Mesh {
    let mut mesh = Mesh::default();
    let mut numbers = BTreeMap::new();
    let turn = Rotation3::from_euler_angles(0.3, 0.5, 0.7);
    for axis in 0..3 {
        for side in [0, CELLS] {
            let mut vertex = |i: usize, j: usize| {
                let mut place = [0; 3];
                (place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3]) = (side, i, j);
                *numbers.entry(place).or_insert_with(|| {
                    let at = place.map(|k| 2.0 * k as f64 / CELLS as f64 - 1.0);
                    let direction = (turn * Vector::from(at)).normalize();
                    mesh.points.push(Point::from(seen(&height, direction)));
                    VertexId::from(mesh.points.len() - 1)
                })
            };
            let mut triangles = Vec::new();
            for (i, j) in (0..CELLS).flat_map(|i| (0..CELLS).map(move |j| (i, j))) {
                let [a, b] = [vertex(i, j), vertex(i + 1, j)];
                let [c, d] = [vertex(i + 1, j + 1), vertex(i, j + 1)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
            if side == 0 {
                triangles.iter_mut().for_each(|t| t.swap(1, 2));
            }
            mesh.triangles.extend(triangles);
        }
    }
    let sigma = NOISE * mesh.mean_edge();
    for (v, p) in mesh.points.iter_mut().enumerate() {
        let slope = |axis: usize| {
            let step = 1e-6 * Vector::ith(axis, 1.0);
            height(p.coords + step) - height(p.coords - step)
        };
        let normal = Vector::new(slope(0), slope(1), slope(2)).normalize();
        *p += sigma * normal_error(v as u64) * normal;
    }
    mesh
}

/// Where a ray leaves the body.
fn seen(height: &impl Fn(Vector) -> f64, direction: Vector) -> Vector {
    let (mut low, mut high) = (0.0, 10.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if height(middle * direction) < 0.0 { low = middle } else { high = middle }
    }
    low * direction
}

/// A normal error of standard deviation 1 (Box and Muller).
fn normal_error(v: u64) -> f64 {
    let uniform = |k: u64| (scattered(k) as f64 + 0.5) / 2f64.powi(64);
    (-2.0 * uniform(2 * v).ln()).sqrt() * (std::f64::consts::TAU * uniform(2 * v + 1)).cos()
}

fn regions(mesh: &Mesh) -> Regions {
    find_scanned(mesh, &ScanNoise::of(mesh))
}

fn count(regions: &Regions, kind: PrimitiveKind) -> usize {
    regions.regions.iter().filter(|r| r.surface.kind() == kind).count()
}

fn block(p: Vector) -> f64 {
    (p.x.abs() - 1.0).max(p.y.abs() - 0.8).max(p.z.abs() - 0.6)
}

#[test]
fn a_box_has_six_planes() {
    let mesh = scan(block);
    let found = regions(&mesh);
    assert_eq!([found.regions.len(), count(&found, PrimitiveKind::Plane)], [6, 6]);
    assert!(found.of_triangle.iter().all(|&r| r != NONE));
    for region in &found.regions {
        let Primitive::Plane { origin, normal } = region.surface else { panic!("a plane") };
        let outward = region.side * normal;
        let axis = outward.iamax();
        assert!(outward[axis].abs() > 0.9999 && outward[axis] * origin[axis] > 0.0);
        let off = region
            .surface
            .distance(Point::from([1.0, 0.8, 0.6][axis] * Vector::ith(axis, outward[axis])))
            .0;
        assert!(off.abs() < 0.004, "{off}");
        // The deviation of the place is that of the mean of a thousand vertices.
        let deviation = region.covariance[(2, 2)].sqrt();
        assert!((1e-5..1e-3).contains(&deviation), "{deviation}");
    }
}

#[test]
fn a_disc_has_two_planes_and_a_cylinder_with_an_honest_radius() {
    let found = regions(&scan(|p| (p.xy().norm() - 0.9).max(p.z.abs() - 0.5)));
    assert_eq!([found.regions.len(), count(&found, PrimitiveKind::Plane)], [3, 2]);
    let round = found.regions.iter().find(|r| r.surface.kind() == PrimitiveKind::Cylinder);
    let round = round.expect("a cylinder");
    let Primitive::Cylinder { radius, .. } = round.surface else { panic!("a cylinder") };
    let deviation = round.covariance[(4, 4)].sqrt();
    assert!((radius - 0.9).abs() < 4.0 * deviation, "{radius} ± {deviation}");
    assert!(round.side > 0.0 && deviation < 1e-3);
}

#[test]
fn a_ball_is_a_sphere_and_a_cone_is_a_cone() {
    let ball = regions(&scan(|p| p.norm() - 1.0));
    assert_eq!([ball.regions.len(), count(&ball, PrimitiveKind::Sphere)], [1, 1]);
    // Half angle 30°.
    let cone = regions(&scan(|p| (p.xy().norm() * 0.866 + p.z * 0.5 - 0.6).max(p.z.abs() - 0.6)));
    assert_eq!(count(&cone, PrimitiveKind::Cone), 1);
    assert_eq!(count(&cone, PrimitiveKind::Plane), 2);
}

#[test]
fn a_thin_blend_is_found_on_its_edge() {
    // The radius is two edges of the scan.
    let radius = 0.09;
    let found = regions(&scan(|p| {
        let [x, y] = [p.x - 1.0 + radius, p.y - 0.8 + radius];
        if x > 0.0 && y > 0.0 { (x.hypot(y) - radius).max(p.z.abs() - 0.6) } else { block(p) }
    }));
    assert_eq!(count(&found, PrimitiveKind::Plane), 6);
    let round = found.regions.iter().find(|r| r.surface.kind() == PrimitiveKind::Cylinder);
    let measured = round.and_then(|r| r.surface.radius()).expect("a cylinder");
    assert!((measured - radius).abs() < 0.2 * radius, "{measured}");
}

#[test]
fn a_smooth_body_has_no_faces() {
    let found = regions(&scan(|p| {
        let q = p.normalize();
        p.norm() - 1.0 - 0.15 * (3.0 * q.x).sin() * (2.0 * q.y + 0.5).cos() - 0.1 * q.z * q.z * q.x
    }));
    assert!(found.explained < 0.02, "{}", found.explained);
}

#[test]
fn nothing_has_no_regions() {
    assert!(regions(&Mesh::default()).regions.is_empty());
    let triangle = Mesh {
        points: vec![Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(0.0, 1.0, 0.0)],
        triangles: vec![[0, 1, 2].map(VertexId)],
    };
    assert!(regions(&triangle).regions.is_empty());
}
