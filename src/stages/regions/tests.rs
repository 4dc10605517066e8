//! Regions of small parts with known faces.

use std::f64::consts::{PI, TAU};

use nalgebra::Rotation3;

use super::*;
use crate::geometry::{Point, Vector, VertexId};
use crate::mesh::Mesh;
use crate::primitives::{Primitive, PrimitiveKind};

/// A closed prism over a regular polygon of `n` corners.
fn prism(n: usize, radius: f64, height: f64) -> Mesh {
    let mut mesh = Mesh::default();
    for z in [0.0, height] {
        for k in 0..n {
            let angle = TAU * k as f64 / n as f64;
            mesh.points.push(Point::new(radius * angle.cos(), radius * angle.sin(), z));
        }
    }
    close_prism(&mut mesh);
    mesh
}

/// The triangles of a prism whose points are those of its floor and of its ceiling. The first corner of each sees it as a whole.
fn close_prism(mesh: &mut Mesh) {
    let n = mesh.points.len() / 2;
    let v = |level: usize, k: usize| VertexId::from(level * n + k % n);
    for k in 0..n {
        mesh.triangles.push([v(0, k), v(0, k + 1), v(1, k + 1)]);
        mesh.triangles.push([v(0, k), v(1, k + 1), v(1, k)]);
    }
    for k in 1..n - 1 {
        mesh.triangles.push([v(0, 0), v(0, k + 1), v(0, k)]);
        mesh.triangles.push([v(1, 0), v(1, k), v(1, k + 1)]);
    }
}

/// A closed surface of rings: the torus of a number of steps around each circle.
fn torus(major: f64, minor: f64, around: usize, across: usize) -> Mesh {
    let surface = Primitive::Torus { centre: Point::origin(), axis: Vector::z(), major, minor };
    let mut mesh = Mesh::default();
    for i in 0..around {
        for j in 0..across {
            let angle = |k: usize, n: usize| TAU * k as f64 / n as f64;
            let uv = crate::geometry::Uv::new(angle(i, around), angle(j, across));
            mesh.points.push(surface.point_at(uv));
        }
    }
    let v = |i: usize, j: usize| VertexId::from(i % around * across + j % across);
    for i in 0..around {
        for j in 0..across {
            mesh.triangles.push([v(i, j), v(i + 1, j), v(i + 1, j + 1)]);
            mesh.triangles.push([v(i, j), v(i + 1, j + 1), v(i, j + 1)]);
        }
    }
    mesh
}

/// A closed surface of revolution about z: rings at radii and heights, each of so many vertices. Every second one is turned by a share
/// of a step. The first and the last one are closed by flat fans.
fn turned(rings: &[[f64; 2]], around: usize, share: f64) -> Mesh {
    let mut mesh = Mesh::default();
    for (k, &[radius, z]) in rings.iter().enumerate() {
        for i in 0..around {
            let angle = TAU * (i as f64 + share * (k % 2) as f64) / around as f64;
            mesh.points.push(Point::new(radius * angle.cos(), radius * angle.sin(), z));
        }
    }
    let v = |k: usize, i: usize| VertexId::from(k * around + i % around);
    for (a, b) in (1..rings.len()).map(|k| (k - 1, k)) {
        for i in 0..around {
            if a % 2 == 0 {
                mesh.triangles.push([v(a, i), v(a, i + 1), v(b, i)]);
                mesh.triangles.push([v(a, i + 1), v(b, i + 1), v(b, i)]);
            } else {
                mesh.triangles.push([v(a, i), v(b, i + 1), v(b, i)]);
                mesh.triangles.push([v(a, i), v(a, i + 1), v(b, i + 1)]);
            }
        }
    }
    let last = rings.len() - 1;
    for i in 1..around - 1 {
        mesh.triangles.push([v(0, 0), v(0, i + 1), v(0, i)]);
        mesh.triangles.push([v(last, 0), v(last, i), v(last, i + 1)]);
    }
    mesh
}

/// The mesh turned, shifted, scaled and rounded to 32 bits, and the errors of its vertices.
fn exported(mut mesh: Mesh, turn: Vector, shift: Vector, scale: f64) -> (Mesh, Vec<f64>) {
    let turn = Rotation3::new(turn);
    for p in &mut mesh.points {
        *p = (scale * (turn * *p + shift)).map(|x| f64::from(x as f32));
    }
    let numbers: Vec<[f64; 3]> = mesh.points.iter().map(|p| [p.x, p.y, p.z]).collect();
    let rounding = FileRounding::of(&numbers);
    let diagonal = mesh.diagonal();
    let errors = numbers.iter().map(|&p| rounding.error(p, diagonal)).collect();
    (mesh, errors)
}

fn regions(mesh: &Mesh, errors: &[f64]) -> Regions {
    find(&Tessellation::new(mesh, errors), &Options::default())
}

fn kinds(found: &Regions, kind: PrimitiveKind) -> usize {
    let is = |r: &&FaceRegion| r.origin != RegionOrigin::Facet && r.surface.kind() == kind;
    found.regions.iter().filter(is).count()
}

const NOWHERE: Vector = Vector::new(0.0, 0.0, 0.0);

#[test]
fn prisms_of_up_to_eight_sides_stay_flat_and_others_become_round() {
    for n in 3..40 {
        let (mesh, errors) = exported(prism(n, 5.0, 8.0), NOWHERE, NOWHERE, 1.0);
        let found = regions(&mesh, &errors);
        let (flat, round) = if n <= 8 { (n + 2, 0) } else { (2, 1) };
        assert_eq!(kinds(&found, PrimitiveKind::Plane), flat, "{n} sides");
        assert_eq!(kinds(&found, PrimitiveKind::Cylinder), round, "{n} sides");
        assert_eq!(found.explained, 1.0, "{n} sides");
    }
}

#[test]
fn a_cylinder_is_found_turned_far_away_and_in_any_unit() {
    let (turn, far) = (Vector::new(0.3, 1.1, -0.7), Vector::new(120.0, -90.0, 40.0));
    for scale in [1.0, 0.001, 1.0 / 25.4, 25.4] {
        let (mesh, errors) = exported(prism(24, 5.0, 8.0), turn, far, scale);
        let found = regions(&mesh, &errors);
        assert_eq!(kinds(&found, PrimitiveKind::Cylinder), 1, "scale {scale}");
        let curved = found.regions.iter().find(|r| r.origin == RegionOrigin::Curved).unwrap();
        let radius = curved.surface.radius().unwrap() / scale;
        assert!((radius - 5.0).abs() < 1e-4, "{radius}");
        assert_eq!(curved.side, 1.0);
    }
}

#[test]
fn snapped_values_are_the_designers() {
    let (mesh, errors) = exported(prism(24, 5.0, 8.0), NOWHERE, Vector::new(3.0, 4.0, 0.0), 1.0);
    let found = regions(&mesh, &errors);
    let curved = found.regions.iter().find(|r| r.origin == RegionOrigin::Curved).unwrap();
    let Primitive::Cylinder { origin, axis, radius } = curved.surface else {
        panic!("no cylinder")
    };
    assert_eq!((origin.x, origin.y, axis.z.abs(), radius), (3.0, 4.0, 1.0, 5.0));
    assert!(found.snaps.iter().all(|snap| snap.before != snap.after));
}

#[test]
fn a_torus_is_one_region_and_not_its_rings() {
    let (mesh, errors) = exported(torus(10.0, 3.0, 40, 20), NOWHERE, NOWHERE, 1.0);
    let found = regions(&mesh, &errors);
    assert_eq!(found.regions.len(), 1);
    assert_eq!(kinds(&found, PrimitiveKind::Torus), 1);
}

/// Meshers cut tori askew where their border is complicated: corners on the surface, but triangles that turn far from it.
#[test]
fn triangles_that_are_cut_askew_belong_to_the_surface_of_their_corners() {
    let (around, across) = (40, 20);
    let mut mesh = torus(10.0, 3.0, around, across);
    let v = |i: usize, j: usize| VertexId::from(i % around * across + j % across);
    // Two fans over a column of two quadrangles, which turn by 36 degrees.
    let column = 5..7;
    let is_in = |t: &[VertexId; 3]| {
        let place = t.map(|v| (v.index() / across, v.index() % across));
        place.iter().all(|&(i, j)| (7..=8).contains(&i) && (column.start..=column.end).contains(&j))
    };
    mesh.triangles.retain(|t| !is_in(t));
    for j in column.clone() {
        mesh.triangles.push([v(8, column.start), v(7, j + 1), v(7, j)]);
        mesh.triangles.push([v(7, column.end), v(8, j), v(8, j + 1)]);
    }
    let (mesh, errors) = exported(mesh, NOWHERE, NOWHERE, 1.0);
    let found = regions(&mesh, &errors);
    assert_eq!(found.regions.len(), 1);
}

/// The edges of a fillet are off it, as modelling kernels allow.
#[test]
fn a_loose_fillet_touches_the_planes_beside_it() {
    let bumps = [0.0, 5e-4, -5e-4, 4e-4, 5e-4, -5e-4, -3e-4, 5e-4, 0.0];
    let mut mesh = Mesh::default();
    for z in [0.0, 30.0] {
        mesh.points.push(Point::new(0.0, 0.0, z));
        mesh.points.push(Point::new(40.0, 0.0, z));
        for (k, bump) in bumps.iter().enumerate() {
            let (sin, cos) = (0.25 * TAU * k as f64 / (bumps.len() - 1) as f64).sin_cos();
            let r = 5.0 + if z > 0.0 { *bump } else { bumps[bumps.len() - 1 - k] };
            mesh.points.push(Point::new(35.0 + r * cos, 25.0 + r * sin, z));
        }
        mesh.points.push(Point::new(0.0, 30.0, z));
    }
    close_prism(&mut mesh);
    let (mesh, errors) = exported(mesh, NOWHERE, NOWHERE, 1.0);
    let found = regions(&mesh, &errors);
    let curved: Vec<_> =
        found.regions.iter().filter(|r| r.origin == RegionOrigin::Curved).collect();
    let [Primitive::Cylinder { origin, axis, radius }] =
        curved.iter().map(|r| r.surface).collect::<Vec<_>>()[..]
    else {
        panic!("{curved:?}")
    };
    assert!((radius - 5.0).abs() < 1e-3, "{radius}");
    assert!(axis.z.abs() > 1.0 - 1e-12, "{axis}");
    // The planes beside it are x = 40 and y = 30.
    assert!((origin.x + radius - 40.0).abs() < 1e-7, "{origin} {radius}");
    assert!((origin.y + radius - 30.0).abs() < 1e-7, "{origin} {radius}");
}

#[test]
fn a_rough_surface_is_no_clean_mesh_and_has_no_curved_face() {
    let mut mesh = torus(10.0, 3.0, 40, 20);
    for (k, p) in mesh.points.iter_mut().enumerate() {
        let noise =
            (crate::geometry::random::scattered(k as u64) >> 11) as f64 / (1u64 << 53) as f64;
        *p += 0.02 * (noise - 0.5) * (*p - Point::origin()).normalize();
    }
    let (mesh, errors) = exported(mesh, NOWHERE, NOWHERE, 1.0);
    assert_ne!(FlatPairs::of(&Tessellation::new(&mesh, &errors)).is_clean(), Some(true));
    let found = regions(&mesh, &errors);
    assert!(found.regions.iter().all(|r| r.origin != RegionOrigin::Curved));
}

#[test]
fn decimals_count_as_rounding_only_if_chance_uses_their_last_digit() {
    let round: Vec<[f64; 3]> = (0..100).map(|k| [f64::from(k % 4) * 10.0, 20.0, 5.0]).collect();
    assert!(FileRounding::of(&round).decimals.is_empty());
    let scattered = |k: usize| {
        let x = (crate::geometry::random::scattered(k as u64) >> 11) as f64 / (1u64 << 53) as f64;
        (1e3 * (10.0 + 80.0 * x)).round() / 1e3
    };
    let cut: Vec<[f64; 3]> =
        (0..300).map(|k| [scattered(k), scattered(k + 1000), scattered(k + 2000)]).collect();
    assert_eq!(FileRounding::of(&cut).decimals, [(1, 3)]);
}

#[test]
fn few_numbers_with_three_decimals_show_their_rounding_by_their_fives() {
    // The corners of a rounded edge among the round numbers of a profile.
    let round = [[3.0, 30.0, 4.0], [30.0, 4.0, 3.0], [4.0, 3.0, 30.0], [0.5, 2.0, 15.0]];
    let arc = (1..20).map(|k| {
        let angle = f64::from(k) * TAU / 83.0;
        [4.0 - angle.cos(), 4.0 - angle.sin(), 30.0].map(|x: f64| (1e3 * x).round() / 1e3)
    });
    let points: Vec<[f64; 3]> = round.into_iter().chain(arc).collect();
    assert!(FileRounding::of(&points).decimals.iter().all(|&(_, places)| places == 3));
    assert!(!FileRounding::of(&points).decimals.is_empty());
    let inches: Vec<[f64; 3]> = (1..60).map(|k| [f64::from(k) * 0.125, 1.0, 2.0]).collect();
    assert!(FileRounding::of(&inches).decimals.is_empty());
}

#[test]
fn a_part_is_significant_and_a_smooth_or_rough_surface_is_not() {
    let (mesh, errors) = exported(prism(24, 5.0, 8.0), NOWHERE, NOWHERE, 1.0);
    assert!(regions(&mesh, &errors).is_significant());
    let (mesh, errors) = exported(torus(10.0, 3.0, 40, 20), NOWHERE, NOWHERE, 1.0);
    assert!(regions(&mesh, &errors).is_significant());
    let mut smooth = torus(10.0, 3.0, 80, 40);
    for p in &mut smooth.points {
        *p += 0.3 * Vector::new((p.y * 0.7).sin(), (p.z + 0.4 * p.x).cos(), (p.x * 0.5).sin());
    }
    let (mesh, errors) = exported(smooth, NOWHERE, NOWHERE, 1.0);
    assert!(!regions(&mesh, &errors).is_significant());
}

#[test]
fn a_fine_grid_in_coarse_steps_is_not_significant() {
    let n = 60;
    let mut mesh = Mesh::default();
    for k in 0..n * n {
        let (x, y) = ((k % n) as f64, (k / n) as f64);
        let height = 4.0 * (0.3 * x).sin() * (0.2 * y).cos();
        mesh.points.push(Point::new(x, y, height.round()));
    }
    for k in (0..n * (n - 1)).filter(|k| k % n + 1 < n) {
        let v = |k: usize| VertexId::from(k);
        mesh.triangles.push([v(k), v(k + 1), v(k + n)]);
        mesh.triangles.push([v(k + 1), v(k + n + 1), v(k + n)]);
    }
    let errors = vec![0.75f64.sqrt(); mesh.points.len()];
    assert!(!regions(&mesh, &errors).is_significant());
}

#[test]
fn no_mesh_makes_the_search_panic() {
    let mut random = 1;
    let mut next = |most: usize| {
        random += 1;
        crate::geometry::random::scattered(random) as usize % most
    };
    for round in 0..60 {
        let mut mesh = Mesh::default();
        let points = 3 + next(30);
        for _ in 0..points {
            // Few places, so that many triangles are degenerate, doubled or coplanar.
            let p = [0; 3].map(|_| next(3 + round % 4) as f64);
            mesh.points.push(Point::new(p[0], p[1], p[2]));
        }
        for _ in 0..next(80) {
            let corners = [0; 3].map(|_| VertexId::from(next(points)));
            if corners[0] != corners[1] && corners[1] != corners[2] && corners[0] != corners[2] {
                mesh.triangles.push(corners);
            }
        }
        let errors = vec![[1e-7, 1e-3, 0.3][round % 3]; points];
        let found = regions(&mesh, &errors);
        assert_eq!(found.of_triangle.len(), mesh.triangles.len());
        let all: usize = found.regions.iter().map(|r| r.triangles.len()).sum();
        assert_eq!(all, mesh.triangles.len());
    }
}

/// Points of an arc in the plane of radius and height, from one angle to another.
fn arc(centre: [f64; 2], radius: f64, from: f64, to: f64, steps: usize) -> Vec<[f64; 2]> {
    let at = |k: usize| (from + (to - from) * k as f64 / steps as f64).sin_cos();
    (0..=steps).map(at).map(|(s, c)| [centre[0] + radius * c, centre[1] + radius * s]).collect()
}

fn radii(found: &Regions, kind: PrimitiveKind) -> Vec<[f64; 2]> {
    let curved = found.regions.iter().filter(|r| r.surface.kind() == kind);
    let of = |surface: &Primitive| match *surface {
        Primitive::Torus { major, minor, .. } => [major, minor],
        _ => [surface.radius().unwrap(), 0.0],
    };
    curved.map(|r| of(&r.surface)).collect()
}

/// The fillet at the shoulder of a shaft. A mesher has cut some of its columns askew: chords along the shaft are further inside than
/// the next ring is away, so triangles lean by far more than the surface turns.
#[test]
fn a_thin_fillet_around_a_thick_shaft_is_one_torus() {
    let (around, steps) = (48, 12);
    let mut rings = vec![[30.0, 0.0], [30.0, 9.0]];
    rings.extend(arc([25.0, 11.0], 1.0, -0.5 * PI, -PI, steps));
    rings.push([24.0, 30.0]);
    let mut mesh = turned(&rings, around, 0.0);
    let (bottom, top, middle) = (2, 2 + steps, 2 + steps / 2);
    let v = |k: usize, i: usize| VertexId::from(k * around + i % around);
    for i in (0..around).step_by(3) {
        let column = |v: &VertexId| {
            (bottom..=top).contains(&(v.index() / around))
                && [i, i + 1].contains(&(v.index() % around))
        };
        mesh.triangles.retain(|t| !t.iter().all(column));
        for k in bottom..top {
            mesh.triangles.push([v(k, i), v(middle, i + 1), v(k + 1, i)]);
            let end = if k < middle { bottom } else { top };
            mesh.triangles.push([v(k, i + 1), v(k + 1, i + 1), v(end, i)]);
        }
    }
    let (mesh, errors) = exported(mesh, NOWHERE, NOWHERE, 1.0);
    let found = regions(&mesh, &errors);
    assert_eq!(radii(&found, PrimitiveKind::Torus), [[25.0, 1.0]]);
    assert_eq!(kinds(&found, PrimitiveKind::Cylinder), 2);
    assert_eq!(found.regions.len(), 6);
}

/// OpenCASCADE fillets beside a cone are splines that come within 1e-5 of the torus. Their borders cut the cone and the cylinder beside
/// them to pieces of some facets each, and any three rings lie on some torus.
#[test]
fn faces_beside_an_approximated_fillet_are_whole() {
    let mut rings = vec![[30.0, 0.0], [30.0, 10.0], [27.146447, 12.853553]];
    let tangent = 1.0 * (PI / 8.0).tan();
    let first = [24.0 + tangent * (0.25 * PI).cos(), 16.0 - tangent * (0.25 * PI).sin()];
    let fillet = arc([25.0, 16.0 + tangent], 1.0, -0.75 * PI, -PI, 2);
    assert!((fillet[0][0] - first[0]).abs() < 1e-12 && (fillet[0][1] - first[1]).abs() < 1e-12);
    rings.extend(&fillet);
    rings.push([24.0, 30.0]);
    let mut mesh = turned(&rings, 50, 0.5);
    for p in &mut mesh.points {
        if (15.0..17.0).contains(&p.z) {
            let off = 6e-6 * (7.0 * p.y.atan2(p.x)).sin();
            let radius = p.x.hypot(p.y);
            (p.x, p.y) = (p.x * (1.0 + off / radius), p.y * (1.0 + off / radius));
        }
    }
    let (mesh, errors) = exported(mesh, NOWHERE, NOWHERE, 1.0);
    let found = regions(&mesh, &errors);
    let tori = radii(&found, PrimitiveKind::Torus);
    assert!(tori.len() == 1 && (tori[0][0] - 25.0).abs() < 1e-3, "{tori:?}");
    assert_eq!(kinds(&found, PrimitiveKind::Cylinder), 2);
    assert_eq!(kinds(&found, PrimitiveKind::Cone), 1);
    assert_eq!(found.explained, 1.0);
}

/// The rounded end of a rod whose fillet is larger than half of its radius.
#[test]
fn a_fillet_whose_torus_crosses_itself_is_a_torus() {
    let mut rings = vec![[3.0, 0.0], [3.0, 6.0]];
    rings.extend(arc([1.0, 6.0], 2.0, 0.0, 0.5 * PI, 8).into_iter().skip(1));
    let (mesh, errors) = exported(turned(&rings, 32, 0.5), NOWHERE, NOWHERE, 1.0);
    let found = regions(&mesh, &errors);
    assert_eq!(radii(&found, PrimitiveKind::Torus), [[1.0, 2.0]]);
    assert_eq!(kinds(&found, PrimitiveKind::Cylinder), 1);
    assert_eq!(found.explained, 1.0);
}

/// A tube that bends in a plane, whose vertices lie half a step beside that plane: the strips above and below lie in one plane each, along
/// the straight pieces and the bend.
#[test]
fn a_bent_tube_is_whole_where_its_strips_lie_in_one_plane() {
    let (around, bend, steps) = (24, 20.0, 40);
    let mut frames = vec![([bend, -30.0], 0.0)];
    for k in 0..=steps {
        let angle = 0.5 * PI * k as f64 / steps as f64;
        frames.push(([bend * angle.cos(), bend * angle.sin()], angle));
    }
    frames.push(([-25.0, bend], 0.5 * PI));
    let mut mesh = Mesh::default();
    for ([x, y], angle) in &frames {
        for i in 0..around {
            let (sin, cos) = (TAU * (i as f64 + 0.5) / around as f64).sin_cos();
            let out = 5.0 * cos;
            mesh.points.push(Point::new(x + out * angle.cos(), y + out * angle.sin(), 5.0 * sin));
        }
    }
    let v = |k: usize, i: usize| VertexId::from(k * around + i % around);
    let last = frames.len() - 1;
    for k in 0..last {
        for i in 0..around {
            mesh.triangles.push([v(k, i), v(k + 1, i + 1), v(k, i + 1)]);
            mesh.triangles.push([v(k, i), v(k + 1, i), v(k + 1, i + 1)]);
        }
    }
    for i in 1..around - 1 {
        mesh.triangles.push([v(0, 0), v(0, i), v(0, i + 1)]);
        mesh.triangles.push([v(last, 0), v(last, i + 1), v(last, i)]);
    }
    let (mesh, errors) = exported(mesh, NOWHERE, NOWHERE, 1.0);
    let found = regions(&mesh, &errors);
    assert_eq!(radii(&found, PrimitiveKind::Torus), [[20.0, 5.0]]);
    assert_eq!(kinds(&found, PrimitiveKind::Cylinder), 2);
    assert_eq!(found.regions.len(), 5);
}

#[test]
fn a_triangle_folded_over_the_next_one_at_an_apex_is_of_the_cone() {
    let n = 24;
    let on_cone = |step: f64, radius: f64| {
        let angle = TAU * step / n as f64;
        Point::new(radius * angle.cos(), radius * angle.sin(), -0.5 * radius)
    };
    let mut mesh = Mesh::default();
    mesh.points.extend((0..n).map(|k| on_cone(k as f64, 10.0)));
    // The apex, and a vertex that lies behind the border of the triangle that it divides.
    mesh.points.extend([Point::origin(), on_cone(1.4, 5.0)]);
    let v = VertexId::from;
    let (apex, inner) = (v(n), v(n + 1));
    for k in 1..n {
        mesh.triangles.push([apex, v(k), v((k + 1) % n)]);
    }
    mesh.triangles.extend([[apex, v(0), inner], [v(0), v(1), inner], [v(1), apex, inner]]);
    mesh.triangles.extend((1..n - 1).map(|k| [v(0), v(k + 1), v(k)]));
    let (mesh, errors) = exported(mesh, Vector::new(0.3, -0.2, 0.5), NOWHERE, 1.0);
    let found = regions(&mesh, &errors);
    assert_eq!(found.regions.len(), 2, "{:?}", found.regions);
    assert_eq!(kinds(&found, PrimitiveKind::Cone), 1);
}

/// A shaft with a conical end, of whose common rim loose edges have put half of the vertices off. The others and those of the other rims tell
/// both surfaces as exactly as the file states them.
#[test]
fn loose_edges_do_not_move_the_surfaces_beside_them() {
    let [radius, angle, length] = [10.0371, 0.4637f64, 7.313];
    let height = |k: usize| 20.0 + length * k as f64 / 4.0;
    let mut rings = vec![[radius, 0.0]];
    rings.extend((0..5).map(|k| [radius - (height(k) - 20.0) * angle.tan(), height(k)]));
    let mut mesh = turned(&rings, 48, 0.5);
    for p in mesh.points.iter_mut().filter(|p| p.z == 20.0 && p.y > 0.0) {
        let longer = 1.0 + 8e-4 * (5.0 * p.y.atan2(p.x)).sin().powi(2) / radius;
        (p.x, p.y) = (p.x * longer, p.y * longer);
    }
    let (mesh, errors) = exported(mesh, Vector::new(0.3, -0.2, 0.5), NOWHERE, 1.0);
    let found = regions(&mesh, &errors);
    let curved: Vec<&FaceRegion> =
        found.regions.iter().filter(|r| r.origin == RegionOrigin::Curved).collect();
    assert_eq!(curved.len(), 2);
    for region in curved {
        match region.surface {
            Primitive::Cylinder { radius: found, .. } => {
                assert!((found - radius).abs() < 2e-6, "{found}");
            }
            Primitive::Cone { angle: found, .. } => {
                assert!((found - angle).abs() < 1e-6, "{found}");
            }
            other => panic!("{other:?}"),
        }
        let axis = region.surface.axis().expect("an axis");
        let turned = Rotation3::new(Vector::new(0.3, -0.2, 0.5)) * Vector::z();
        assert!(axis.cross(&turned).norm() < 1e-6, "{axis}");
        assert!(region.slack > 1.0);
    }
}
