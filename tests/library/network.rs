//! One smooth surface over a quad mesh, its exact patches, and the solid that they bound.

use std::collections::{HashMap, HashSet};

use nalgebra::Vector2;
use scan2step::deviation;
use scan2step::geometry::{Bound, Point, Uv, Vector, VertexId};
use scan2step::mesh::{Mesh, Patch, QuadMesh};
use scan2step::spline::subdivision::{QuadPlace, SubdivisionSurface};
use scan2step::spline::{Network, NetworkCut};
use scan2step::stages::trim::network::NetworkRim;
use scan2step::stages::{brep, net, patches, refine, trim};

/// The surface of unit cubes as a quad mesh, with a block of `n` × `n` quads for each square.
fn cubes(cells: &[[i32; 3]], n: usize) -> QuadMesh {
    let mut mesh = QuadMesh { side: n, ..QuadMesh::default() };
    let mut numbers = HashMap::new();
    for cell in cells {
        for (axis, side) in (0..6).map(|k| (k / 2, k % 2)) {
            let mut beside = *cell;
            beside[axis] += if side == 0 { -1 } else { 1 };
            if cells.contains(&beside) {
                continue;
            }
            let mut vertex = |a: usize, b: usize| {
                // Seen from outside, (a, b) run counter-clockwise.
                let (a, b) = if side == 0 { (b, a) } else { (a, b) };
                let mut at = cell.map(|x| x as usize * n);
                at[axis] += side * n;
                at[(axis + 1) % 3] += a;
                at[(axis + 2) % 3] += b;
                *numbers.entry(at).or_insert_with(|| {
                    mesh.points.push(Point::from(Vector::from(at.map(|x| x as f64 / n as f64))));
                    VertexId::from(mesh.points.len() - 1)
                })
            };
            let quads = (0..n * n).map(|k| (k % n, k / n)).map(|(i, j)| {
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(a, b)| vertex(a, b))
            });
            let quads: Vec<_> = quads.collect();
            mesh.quads.extend(quads);
        }
    }
    assert_eq!(mesh.fault(), None);
    mesh
}

/// The mesh with each vertex moved to the mean of its neighbours, several times.
fn rounded(mut mesh: QuadMesh) -> QuadMesh {
    let surface = SubdivisionSurface::new(&mesh.quads).expect("a closed quad mesh");
    for _ in 0..8 {
        let mean = |v: usize| {
            let (quad, k) = surface.corner(v.into());
            let ring = surface.ring(quad, k);
            let spokes: Vec<_> = ring.iter().skip(1).step_by(2).collect();
            let sum: Vector = spokes.iter().map(|&&w| mesh.points[w as usize].coords).sum();
            Point::from(sum / spokes.len() as f64)
        };
        mesh.points = (0..mesh.points.len()).map(mean).collect();
    }
    mesh
}

/// Rounded bodies with vertices of three and five quads: a cube, three cubes around a corner, and a
/// ring of eight cubes.
fn bodies(n: usize) -> [(&'static str, QuadMesh, i64); 3] {
    let ring: Vec<[i32; 3]> = (0..9).filter(|&k| k != 4).map(|k| [k % 3, k / 3, 0]).collect();
    [
        ("cube", rounded(cubes(&[[0; 3]], n)), 2),
        ("corner", rounded(cubes(&[[0; 3], [1, 0, 0], [0, 1, 0]], n)), 2),
        ("ring", rounded(cubes(&ring, n)), 0),
    ]
}

fn control(mesh: &QuadMesh) -> Vec<Vector> {
    mesh.points.iter().map(|p| p.coords).collect()
}

/// The limit surface over a quad mesh as triangles. Neighbouring quads share vertices.
fn limit_surface(mesh: &QuadMesh, steps: usize) -> Mesh {
    let surface = SubdivisionSurface::new(&mesh.quads).expect("a closed quad mesh");
    let (control, mut scratch) = (control(mesh), Vec::new());
    let mut scan = Mesh::default();
    let mut numbers = HashMap::new();
    for quad in 0..mesh.quads.len() {
        let mut vertex = |i: usize, j: usize| {
            let at = Uv::new(i as f64, j as f64) / steps as f64;
            let p = surface.jet(&control, QuadPlace { quad, at }, &mut scratch)[0];
            let key = [0, 1, 2].map(|k| (p[k] * 1e7).round() as i64);
            *numbers.entry(key).or_insert_with(|| {
                scan.points.push(Point::from(p));
                VertexId::from(scan.points.len() - 1)
            })
        };
        let mut triangles = Vec::new();
        for (i, j) in (0..steps * steps).map(|k| (k % steps, k / steps)) {
            let [a, b] = [vertex(i, j), vertex(i + 1, j)];
            let [c, d] = [vertex(i + 1, j + 1), vertex(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        scan.triangles.extend(triangles);
    }
    scan
}

fn patches_of(mesh: &QuadMesh) -> Network {
    let surface = SubdivisionSurface::new(&mesh.quads).expect("a closed quad mesh");
    patches::extract(mesh, &surface).expect("patches").0
}

#[test]
fn faces_become_a_closed_mesh_that_does_not_cross_itself() {
    for (name, mesh, euler) in bodies(4) {
        let network = patches_of(&mesh);
        let (triangles, faces) = deviation::tessellation(&network);
        assert_eq!(faces.len(), triangles.triangles.len(), "{name}");
        let sides = |t: &[VertexId; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
        let all: HashSet<_> = triangles.triangles.iter().flat_map(sides).collect();
        assert_eq!(all.len(), 3 * faces.len(), "{name}: a side is used twice");
        assert!(all.iter().all(|&(a, b)| all.contains(&(b, a))), "{name}: an open side");
        let count = triangles.points.len() as i64 - faces.len() as i64 / 2;
        assert_eq!(count, euler, "{name}");
        assert!(crossing(&network).is_empty(), "{name}");
    }
}

#[test]
fn a_face_that_goes_through_another_is_found() {
    let (_, mesh, _) = bodies(4).into_iter().next().expect("a cube");
    let mut network = patches_of(&mesh);
    let middle = network.surfaces[0].net.len() / 2;
    // The middle of one side of the cube is drawn through the opposite side.
    let away = network.surfaces[0].net[middle];
    let centre = network.corners.iter().map(|p| p.coords).sum::<Vector>() / 8.0;
    network.surfaces[0].net[middle] += 12.0 * (centre - away);
    let faces: HashSet<usize> = crossing(&network).into_iter().map(|found| found.0).collect();
    assert!(faces.contains(&0) && faces.len() > 1, "{faces:?}");
}

fn crossing(network: &Network) -> Vec<(usize, Point)> {
    deviation::crossing_faces(network, &NetworkCut::none(network).kept_places(network))
}

/// The polygon in which a plane cuts the faces of a round body. What is below the plane is on its
/// left, seen from outside.
fn rim(network: &Network, normal: Vector, height: f64) -> NetworkRim {
    let (mesh, _) = deviation::tessellation(network);
    let above = |v: VertexId| mesh.point(v).coords.dot(&normal) - height;
    let mut next = HashMap::new();
    for t in &mesh.triangles {
        let side = |k: usize| (t[k], t[(k + 1) % 3]);
        let up = (0..3).find(|&k| above(side(k).0) < 0.0 && above(side(k).1) >= 0.0);
        let down = (0..3).find(|&k| above(side(k).0) >= 0.0 && above(side(k).1) < 0.0);
        if let (Some(up), Some(down)) = (up, down) {
            // What is below is on the left from the side that goes up to the one that goes down.
            let (a, b) = side(up);
            next.insert((b, a), side(down));
        }
    }
    let first = *next.keys().min().expect("the plane meets the body");
    let mut rim = NetworkRim { of: Bound::Hole(0), points: Vec::new(), normals: Vec::new() };
    let mut at = first;
    loop {
        let (a, b) = at;
        let share = above(a) / (above(a) - above(b));
        rim.points.push(mesh.point(a) + share * (mesh.point(b) - mesh.point(a)));
        at = next[&at];
        if at == first {
            break;
        }
    }
    let corners = network.corners.iter().map(|p| p.coords);
    let inside = corners.sum::<Vector>() / network.corners.len() as f64;
    rim.normals = rim.points.iter().map(|p| p.coords - inside).collect();
    rim
}

#[test]
fn a_loop_across_faces_leaves_a_sound_shell() {
    let (_, mesh, _) = bodies(4).into_iter().next().expect("a cube");
    let network = patches_of(&mesh);
    let options =
        trim::Options { tolerance: 1e-3, rim: 1e-3, least_rim: 1e-3, keeps_vertices: false };
    let mut random = crate::common::random::Random(5);
    let mut divided = 0;
    for number in 0..60 {
        let normal = Vector::from([0; 3].map(|_| random.share() - 0.5)).normalize();
        let heights = network.corners.iter().map(|p| p.coords.dot(&normal));
        let (low, high) = heights.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
        let height = low + (0.1 + 0.8 * random.share()) * (high - low);
        let rim = rim(&network, normal, height);
        let cut = trim::network::cut(&network, std::slice::from_ref(&rim), &options)
            .unwrap_or_else(|e| panic!("{number}: {e:?}"));
        let shell = brep::open(&network, &cut, "shell", 1e-7).expect("a shell");
        let free = shell.uses().iter().filter(|uses| uses.len() == 1).count();
        let inside: usize = cut.arcs.iter().map(|arc| arc.pcurves.len()).sum();
        assert_eq!(free, inside, "{number}: only the loop is free");
        let euler = shell.vertices.len() + shell.faces.len() - shell.edges.len();
        assert_eq!(euler, 1, "{number}: a cap of a ball is a disk");
        assert!(cut.arcs.len() > 1 || cut.nodes.is_empty(), "{number}");
        divided += usize::from(!cut.nodes.is_empty());
        // The loop keeps to its rim, and the faces are below the plane.
        let off = deviation::of_network(&network, &cut, &rim.points).max;
        assert!(off < 5e-3, "{number}: {off} mm from the rim");
        let beyond =
            shell.vertices.iter().filter(|v| Vector::from(**v).dot(&normal) > height + 0.05);
        let beyond: Vec<f64> = beyond.map(|v| Vector::from(*v).dot(&normal) - height).collect();
        assert_eq!(
            beyond, [0.0; 0],
            "{number}: vertices above the plane of {height} in {low} to {high}"
        );
    }
    assert!(divided > 50, "{divided} loops cross tracks");
}

#[test]
fn outer_rows_are_the_tracks_on_both_sides() {
    for (name, mesh, euler) in bodies(4) {
        let network = patches_of(&mesh);
        let count = network.corners.len() as i64 - network.tracks.len() as i64;
        assert_eq!(count + network.surfaces.len() as i64, euler, "{name}");
        let mut uses = vec![0; network.tracks.len()];
        for (surface, sides) in network.surfaces.iter().zip(&network.sides) {
            for (k, side) in sides.iter().enumerate() {
                uses[side.track] += 1;
                let curve = &network.tracks[side.track].curve;
                let end = curve.knots.range().1;
                for i in 0..=40 {
                    let t = end * f64::from(i) / 40.0;
                    let along = if side.forward { t } else { end - t };
                    let at = [
                        Vector2::new(along, 0.0),
                        Vector2::new(end, along),
                        Vector2::new(end - along, end),
                        Vector2::new(0.0, end - along),
                    ][k];
                    let off = surface.point(at.into()).coords - curve.point(t);
                    assert!(off.norm() < 1e-12, "{name}: {off}");
                }
            }
        }
        assert!(uses.iter().all(|&n| n == 2), "{name}");
    }
}

#[test]
fn patches_of_regular_quads_are_the_limit_surface() {
    for (name, mesh, _) in bodies(5) {
        let surface = SubdivisionSurface::new(&mesh.quads).expect("a closed quad mesh");
        let network = patches_of(&mesh);
        let (control, mut scratch) = (control(&mesh), Vec::new());
        let n = mesh.side;
        let (mut exact, mut near): (f64, f64) = (0.0, 0.0);
        for quad in 0..mesh.quads.len() {
            let (block, i, j) = (quad / (n * n), quad % n, quad / n % n);
            for k in 0..25 {
                let at = Uv::new(f64::from(k % 5), f64::from(k / 5)) / 4.0;
                let limit = surface.jet(&control, QuadPlace { quad, at }, &mut scratch)[0];
                let uv = Uv::new(i as f64 + at.x, j as f64 + at.y);
                if surface.is_regular(quad) {
                    let off = network.surfaces[block].point(uv).coords - limit;
                    exact = exact.max(off.norm());
                } else {
                    let patch = &network.surfaces[block];
                    let (_, off) = scan2step::spline::foot_point(patch, Point::from(limit), uv);
                    near = near.max(off);
                }
            }
        }
        assert!(exact < 1e-12, "{name}: {exact}");
        // A quad has a side of a fifth.
        assert!(near < 1e-3 && near > 0.0, "{name}: {near}");
    }
}

#[test]
fn tangent_planes_agree_along_seams() {
    for (name, mesh, _) in bodies(6) {
        let places = patches_of(&mesh).seams(4).into_iter();
        let mut angles: Vec<f64> = places.map(|place| place.angle).collect();
        angles.sort_by(f64::total_cmp);
        let mean = angles.iter().sum::<f64>() / angles.len() as f64;
        let [p95, max] = [0.95, 1.0].map(|q| angles[((angles.len() - 1) as f64 * q) as usize]);
        let degrees = [mean, p95, max].map(f64::to_degrees);
        println!("{name}: seams {degrees:.4?}°");
        // Six quads turn by 90° here. On scans quads turn less.
        assert!(degrees[0] < 0.02 && degrees[1] < 0.05 && degrees[2] < 0.1, "{name}: {degrees:?}");
    }
}

#[test]
fn the_fit_finds_a_surface_that_it_can_represent() {
    for (name, mesh, euler) in bodies(6) {
        let scan = limit_surface(&mesh, 4);
        // The fit does not know the control points: it begins with points of the scan.
        let start = limit_surface_at_vertices(&mesh);
        let options = net::Options { tolerance: 1e-3, outliers: 0.0, max_side: 100 };
        let (fitted, report) =
            net::fit(&start, &Patch::closed(scan.clone()), &options).expect("a fit");
        assert_eq!(report.without_foot, 0, "{name}");
        assert!(report.rms < 1e-4 && report.beyond == 0.0, "{name}: {report:?}");
        let (network, found) = patches::extract(&fitted.mesh, &fitted.surface).expect("patches");
        assert_eq!(found.irregular, mesh.valences().iter().filter(|&&n| n != 4).count());
        let solid = brep::closed(&network, name, 1e-7).expect("a solid");
        assert_eq!(
            solid.faces.len() as i64 + solid.vertices.len() as i64,
            euler + solid.edges.len() as i64
        );
        let volume = solid.volume(solid.solids[0].outer);
        let off = volume / enclosed(&scan) - 1.0;
        assert!(off.abs() < 2e-3, "{name}: {off}");
    }
}

/// The quad mesh with its vertices moved to the limit surface.
fn limit_surface_at_vertices(mesh: &QuadMesh) -> QuadMesh {
    let surface = SubdivisionSurface::new(&mesh.quads).expect("a closed quad mesh");
    let control = control(mesh);
    let limit = |v: usize| {
        let (quad, k) = surface.corner(v.into());
        scan2step::spline::subdivision::limit_point(&surface.ring(quad, k), &control)
    };
    with_normals(QuadMesh { points: (0..control.len()).map(limit).collect(), ..mesh.clone() })
}

/// The mesh with the normals that its quads give its vertices.
fn with_normals(mut mesh: QuadMesh) -> QuadMesh {
    let mut normals = vec![Vector::zeros(); mesh.points.len()];
    for quad in &mesh.quads {
        let [a, b, c, d] = quad.map(|v| mesh.points[v.index()]);
        let normal = (c - a).cross(&(d - b));
        quad.iter().for_each(|v| normals[v.index()] += normal);
    }
    mesh.normals = normals.iter().map(Vector::normalize).collect();
    mesh
}

/// The volume that triangles enclose.
fn enclosed(mesh: &Mesh) -> f64 {
    let of = |t: &[VertexId; 3]| {
        let [a, b, c] = mesh.corners(*t).map(|p| p.coords);
        a.dot(&b.cross(&c)) / 6.0
    };
    mesh.triangles.iter().map(of).sum()
}

#[test]
fn quads_are_divided_until_the_tolerance_holds() {
    let (_, mesh, _) = bodies(8).into_iter().nth(1).expect("a body");
    let scan = limit_surface(&mesh, 2);
    // Four times fewer quads cannot follow the rounded edges.
    let coarse = limit_surface_at_vertices(&bodies(4)[1].1);
    let coarse =
        QuadMesh { points: coarse.points.iter().map(|p| nearest(&scan, *p)).collect(), ..coarse };
    let fit = |tolerance: f64| {
        let options = net::Options { tolerance, outliers: 0.0, max_side: 100 };
        net::fit(&coarse, &Patch::closed(scan.clone()), &options).expect("a fit").1
    };
    let [loose, tight] = [0.1, 0.005].map(fit);
    assert_eq!((loose.side, tight.side), (4, 8), "{loose:?} {tight:?}");
    assert!(tight.beyond == 0.0 && tight.rms < loose.rms);
}

fn nearest(mesh: &Mesh, p: Point) -> Point {
    let off = |q: &&Point| (**q - p).norm();
    *mesh.points.iter().min_by(|a, b| off(a).total_cmp(&off(b))).expect("a point")
}

/// A rounded cube with a narrow bump on it.
fn bumpy_scan() -> (QuadMesh, Mesh) {
    let [(_, mesh, _), ..] = bodies(6);
    let mut scan = limit_surface(&mesh, 6);
    let top = *scan.points.iter().max_by(|a, b| a.x.total_cmp(&b.x)).expect("a point");
    for p in &mut scan.points {
        p.x += 0.01 * (-((*p - top).norm() / 0.08).powi(2)).exp();
    }
    (limit_surface_at_vertices(&mesh), scan)
}

#[test]
fn a_refined_face_keeps_its_sides_and_its_tangent_planes_there() {
    let (start, scan) = bumpy_scan();
    let patch = Patch::closed(scan);
    // No net is made finer.
    let options = net::Options { tolerance: 2e-4, outliers: 0.0, max_side: 6 };
    let fit = net::fit_with(&start, &patch, &options, &mut |_| Ok(())).expect("a fit");
    let (network, _) = patches::extract(&fit.net.mesh, &fit.net.surface).expect("patches");
    let how = refine::Options { tolerance: 2e-4, outliers: 0.0, max_control: 10_000 };
    let mut refinement = refine::refine(&network, fit.samples(), &how).expect("as many lists");
    let report = refinement.report();
    assert!(!report.faces.is_empty() && report.faces.len() < network.surfaces.len(), "{report:?}");
    let before = (fit.report.beyond * patch.measured as f64).round();
    assert!((report.beyond as f64) < 0.2 * before, "{report:?}, and {before} before");
    for (face, old) in network.surfaces.iter().enumerate() {
        let new = &refinement.network.surfaces[face];
        if !report.faces.contains(&face) {
            assert_eq!(new, old);
            continue;
        }
        assert_ne!(new, old);
        let end = network.end();
        for t in (0..=100).map(|k| end * f64::from(k) / 100.0) {
            for at in [Uv::new(t, 0.0), Uv::new(end, t), Uv::new(t, end), Uv::new(0.0, t)] {
                let [a, b] = [old, new].map(|surface| surface.jet(at));
                let off = [a.s - b.s, a.su - b.su, a.sv - b.sv].map(|v| v.norm());
                assert!(off.iter().all(|&off| off < 1e-12), "face {face} at {at}: {off:?}");
            }
        }
    }
    brep::closed(&refinement.network, "bump", 1e-7).expect("a solid");
    refinement.put_back(&report.faces);
    assert_eq!(refinement.network.surfaces, network.surfaces);
    // The share before and the share after are those of the same points.
    let back = refinement.report();
    assert!(back.faces.is_empty());
    assert_eq!((back.measured, back.beyond), (patch.measured, report.beyond_before));
}
