//! Noisy scans of parts: their faces and sizes. Smooth bodies stay what they were.

use formats::Soup;
use formats::brep::ShellId;
use formats::step;
use scan2step::mesh::{Choice, Outer};
use scan2step::nalgebra::{Rotation3, Vector3};
use scan2step::primitives::{Primitive, PrimitiveKind, Uncertainty};
use scan2step::stages::sharpen::{Size, SizeKind};
use scan2step::{
    Body, Conversion, Error, ExactFace, FaceSize, Options, SurfaceChoice, convert, inspect,
    mesh_components,
};

type Field = dyn Fn(Vector3<f64>) -> f64;

/// Numbers that look random, from -0.5 to 0.5.
fn scattered(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

fn gradient(field: &Field, p: Vector3<f64>) -> Vector3<f64> {
    let h = 1e-5;
    let along = |e: Vector3<f64>| (field(p + h * e) - field(p - h * e)) / (2.0 * h);
    Vector3::new(along(Vector3::x()), along(Vector3::y()), along(Vector3::z()))
}

/// The surface on which a field is zero, as a scanner sees it: no vertex lies on an edge, and all have noise along the normal. The grid
/// of surface nets is cubic, from `-size` to `size`.
fn scan(field: &Field, size: f64, edge: f64, noise: f64) -> Soup {
    let n = (2.0 * size / edge).ceil() as usize;
    let at = |i: [usize; 3]| Vector3::from(i.map(|k| k as f64 * edge - size));
    let index = |i: [usize; 3]| (i[2] * (n + 1) + i[1]) * (n + 1) + i[0];
    let mut values = vec![0.0; (n + 1).pow(3)];
    for (z, y, x) in
        (0..=n).flat_map(|z| (0..=n).flat_map(move |y| (0..=n).map(move |x| (z, y, x))))
    {
        values[index([x, y, z])] = field(at([x, y, z]));
    }
    let mut number = vec![u32::MAX; (n + 1).pow(3)];
    let mut points: Vec<Vector3<f64>> = Vec::new();
    for (z, y, x) in (0..n).flat_map(|z| (0..n).flat_map(move |y| (0..n).map(move |x| (z, y, x)))) {
        let corners: Vec<[usize; 3]> =
            (0..8).map(|k| [x + (k & 1), y + (k >> 1 & 1), z + (k >> 2)]).collect();
        let (mut sum, mut count) = (Vector3::zeros(), 0.0);
        for (a, b) in (0..8).flat_map(|a| (a + 1..8).map(move |b| (a, b))) {
            let (u, v) = (values[index(corners[a])], values[index(corners[b])]);
            if (a ^ b).count_ones() == 1 && (u < 0.0) != (v < 0.0) {
                sum += at(corners[a]) + (at(corners[b]) - at(corners[a])) * (u / (u - v));
                count += 1.0;
            }
        }
        if count > 0.0 {
            number[index([x, y, z])] = points.len() as u32;
            points.push(sum / count);
        }
    }
    let mut polygons: Vec<[u32; 3]> = Vec::new();
    for (z, y, x) in (1..n).flat_map(|z| (1..n).flat_map(move |y| (1..n).map(move |x| (z, y, x)))) {
        for axis in 0..3 {
            let mut next = [x, y, z];
            next[axis] += 1;
            let (u, v) = (values[index([x, y, z])], values[index(next)]);
            if (u < 0.0) == (v < 0.0) {
                continue;
            }
            let cell = |a: usize, b: usize| {
                let mut at = [x, y, z];
                at[(axis + 1) % 3] -= a;
                at[(axis + 2) % 3] -= b;
                number[index(at)]
            };
            let mut quad = [cell(0, 0), cell(1, 0), cell(1, 1), cell(0, 1)];
            if u >= 0.0 {
                quad.reverse();
            }
            polygons.push([quad[0], quad[1], quad[2]]);
            polygons.push([quad[0], quad[2], quad[3]]);
        }
    }
    let mut state = 7;
    for p in &mut points {
        for _ in 0..4 {
            let g = gradient(field, *p);
            *p -= g * (field(*p) / g.norm_squared().max(1e-9));
        }
        // The sum of twelve has a standard deviation of one.
        let normal: f64 = (0..12).map(|_| scattered(&mut state)).sum();
        *p += gradient(field, *p).normalize() * (noise * normal);
    }
    let points = points.into_iter().map(<[f64; 3]>::from).collect();
    let mut soup = Soup { points, ..Soup::default() };
    polygons.into_iter().for_each(|polygon| soup.polygons.push(polygon));
    soup
}

fn converted(soup: &Soup, surfaces: SurfaceChoice) -> Conversion {
    let options = Options::builder().surfaces(surfaces).build().expect("options");
    convert(soup, &options, &mut |_| Ok(())).expect("a conversion")
}

/// What the turned scan of a part becomes, without a fallback. The edges of the scan are 0.7 mm long.
fn posed(field: &Field, size: f64, noise: f64) -> Body {
    posed_with(field, size, noise, &Options::default())
}

/// The same with options.
fn posed_with(field: &Field, size: f64, noise: f64, options: &Options) -> Body {
    let mut soup = scan(field, size, 0.7, noise);
    let pose = Rotation3::from_euler_angles(0.4, 0.3, 0.0);
    soup.points.iter_mut().for_each(|p| *p = (pose * Vector3::from(*p)).into());
    let made = convert(&soup, options, &mut |_| Ok(())).expect("a conversion");
    assert_eq!(made.fallback, None);
    made.into_body().expect("one body")
}

#[test]
fn a_scanned_block_with_a_bore_becomes_exact() {
    // The grid has no cell with two sheets while the walls are along one of its axes.
    let turn = Rotation3::from_euler_angles(0.0, 0.0, 0.9);
    let half = Vector3::new(14.0, 10.0, 6.0);
    let field = move |p: Vector3<f64>| {
        let q = turn * p;
        let block = (q.abs() - half).max();
        block.max(5.0 - q.x.hypot(q.y))
    };
    let noise = 0.05;
    let body = posed(&field, 19.0, noise);
    let exact = body.exact().expect("exact faces");
    let count = |kind| exact.faces.iter().filter(|face| face.surface.kind() == kind).count();
    let kinds = [PrimitiveKind::Plane, PrimitiveKind::Cylinder].map(count);
    assert_eq!((exact.faces.len(), kinds, exact.facets), (7, [6, 1], 0));
    let radius = exact.faces.iter().find_map(|face| match face.surface {
        Primitive::Cylinder { radius, .. } => Some(radius),
        _ => None,
    });
    assert!((radius.expect("a bore") - 5.0).abs() < 0.2 * noise, "{radius:?}");
    let volume = body.brep.volume(ShellId(0));
    let wanted = 8.0 * half.product() - std::f64::consts::PI * 25.0 * 12.0;
    assert!((volume / wanted - 1.0).abs() < 1e-3, "{volume} of {wanted}");
    assert!(body.deviation.rms < 1.2 * noise, "{}", body.deviation.rms);
}

/// A block of 28 × 20 × 12 mm with two bores of 6 mm through it, turned about z.
fn block_with_bores(p: Vector3<f64>) -> f64 {
    let q = Rotation3::from_euler_angles(0.0, 0.0, 0.9) * p;
    let block = (q.abs() - Vector3::new(14.0, 10.0, 6.0)).max();
    let bore = |x: f64| 3.0 - (q.x - x).hypot(q.y);
    block.max(bore(-7.0)).max(bore(6.0))
}

/// The cylinders of a body with their standard deviations.
fn cylinders(body: &Body) -> Vec<(f64, Vector3<f64>, Uncertainty)> {
    let faces = &body.exact().expect("exact faces").faces;
    let cylinder = |face: &ExactFace| match face.surface {
        Primitive::Cylinder { radius, axis, .. } => Some((radius, axis, face.uncertainty?)),
        _ => None,
    };
    faces.iter().filter_map(cylinder).collect()
}

#[test]
fn sizes_have_standard_deviations_and_become_round_if_asked() {
    let noise = 0.05;
    let [plain, round] = [false, true].map(|regularize| {
        let options = Options::builder().regularize(regularize).build().expect("options");
        posed_with(&block_with_bores, 19.0, noise, &options)
    });
    let measured = cylinders(&plain);
    assert_eq!(measured.len(), 2);
    for (radius, _, of) in &measured {
        let deviation = of.radius.expect("a standard deviation");
        assert!(deviation > 0.0 && deviation < 0.2 * noise, "{deviation}");
        assert!((radius - 3.0).abs() < 4.0 * deviation, "{radius} ± {deviation}");
    }
    // Both bores have one radius, which nobody has made round.
    assert!((measured[0].0 - measured[1].0).abs() < 1e-9 && measured[0].0 != 3.0);
    let sizes = &plain.exact().expect("exact faces").round_sizes;
    assert!(!sizes.is_empty() && sizes.iter().all(|of| !of.is_taken));
    let taken: Vec<&FaceSize> =
        round.exact().expect("exact faces").round_sizes.iter().filter(|of| of.is_taken).collect();
    for of in &taken {
        assert!((of.value - of.round).abs() <= 2.0 * of.deviation, "{of:?}");
    }
    let is_bore = |of: &&&FaceSize| matches!(of.kind, SizeKind::Own(Size::Radius));
    assert!(taken.iter().any(|of| is_bore(&of)), "{taken:?}");
    for (radius, ..) in cylinders(&round) {
        assert!((radius - 3.0).abs() < 1e-9, "{radius}");
    }
    round.brep.check().expect("a valid solid");
}

#[test]
fn inspect_tells_what_a_scanned_part_becomes() {
    let soup = scan(&block_with_bores, 19.0, 0.7, 0.05);
    let components = mesh_components(&soup, &Options::default()).expect("a mesh");
    let found = inspect(components, Choice::Auto, Outer::Auto).expect("an inspection");
    let exact = found.exact.expect("exact faces");
    let count = |kind| exact.kinds.iter().filter(|&&of| of == kind).count();
    assert_eq!([PrimitiveKind::Plane, PrimitiveKind::Cylinder].map(count), [6, 2]);
    assert!(exact.noise.is_some_and(|noise| (noise / 0.05 - 1.0).abs() < 0.2), "{:?}", exact.noise);
    assert!(exact.radii.iter().all(|radius| (radius - 3.0).abs() < 0.1), "{:?}", exact.radii);
    assert!(exact.explained > 0.98 && exact.facets == 0);
}

#[test]
fn an_aligned_scan_stands_on_its_main_plane() {
    let options = Options::builder().align(true).build().expect("options");
    let body = posed_with(&block_with_bores, 19.0, 0.05, &options);
    let placement = body.placement.expect("a placement");
    let low = body.brep.vertices.iter().map(|p| p[2]).fold(f64::INFINITY, f64::min);
    assert!(low.abs() < 1e-9, "{low}");
    for (_, axis, _) in cylinders(&body) {
        assert_eq!(axis.xy().norm(), 0.0, "{axis}");
    }
    // The scan lies on the part if it is put there.
    let exact = body.exact().expect("exact faces");
    let sides = exact.faces.iter().filter(|face| matches!(face.surface, Primitive::Plane { .. }));
    assert_eq!(sides.count(), 6);
    assert!(body.deviation.rms < 0.06, "{}", body.deviation.rms);
    assert!(placement.axes != [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
}

#[test]
fn a_smooth_scan_cannot_be_aligned() {
    let field = |p: Vector3<f64>| p.norm() - 8.0 - 0.9 * (0.5 * p.x).sin() * (0.6 * p.y).cos();
    let soup = scan(&field, 10.0, 1.2, 0.05);
    let options = Options::builder().align(true).build().expect("options");
    let refused = convert(&soup, &options, &mut |_| Ok(()));
    assert!(matches!(refused, Err(Error::Unaligned(_))), "{refused:?}");
}

#[test]
fn the_floor_of_a_narrow_bore_is_found_beside_its_wall() {
    // Three edges of the scan go across the floor, and so few vertices tell nothing by themselves.
    let turn = Rotation3::from_euler_angles(0.0, 0.0, 0.9);
    let half = Vector3::new(12.0, 9.0, 6.0);
    let field = move |p: Vector3<f64>| {
        let q = turn * p;
        let block = (q.abs() - half).max();
        block.max((1.9 - q.x.hypot(q.y)).min(q.z + 1.1))
    };
    let noise = 0.04;
    let body = posed(&field, 17.0, noise);
    let exact = body.exact().expect("exact faces");
    let count = |kind| exact.faces.iter().filter(|face| face.surface.kind() == kind).count();
    let kinds = [PrimitiveKind::Plane, PrimitiveKind::Cylinder].map(count);
    assert_eq!((exact.faces.len(), kinds, exact.facets), (8, [7, 1], 0));
    let volume = body.brep.volume(ShellId(0));
    let wanted = 8.0 * half.product() - std::f64::consts::PI * 1.9 * 1.9 * 7.1;
    assert!((volume / wanted - 1.0).abs() < 1e-3, "{volume} of {wanted}");
}

#[test]
fn a_step_that_is_lower_than_an_edge_of_the_scan_becomes_free_form_faces() {
    // The ring between the cylinders has no vertex of its own.
    let field = |p: Vector3<f64>| {
        let turned = |radius: f64, low: f64, high: f64| {
            (p.x.hypot(p.y) - radius).max(low - p.z).max(p.z - high)
        };
        turned(6.0, -8.1, 8.1).min(turned(6.9, -8.1, 0.3))
    };
    let noise = 0.03;
    let body = posed(&field, 10.0, noise);
    body.brep.check().expect("a valid solid");
    let exact = body.exact().expect("exact faces");
    let radius = |surface: &Primitive| match *surface {
        Primitive::Cylinder { radius, .. } => Some(radius),
        _ => None,
    };
    let mut radii: Vec<f64> = exact.faces.iter().filter_map(|face| radius(&face.surface)).collect();
    radii.sort_unstable_by(f64::total_cmp);
    assert_eq!(radii.len(), 2, "{radii:?}");
    for (radius, wanted) in radii.iter().zip([6.0, 6.9]) {
        assert!((radius - wanted).abs() < 0.2 * noise, "{radii:?}");
    }
    assert!(exact.explained > 0.95, "{}", exact.explained);
    assert!(exact.risers.iter().map(|riser| riser.triangles).sum::<usize>() > 20);
    // The ring has hundreds of triangles, and the edges of its few faces lie on the cylinders.
    let (free, facets) = (exact.free_forms, exact.facets);
    assert!((1..=12).contains(&free) && facets < 12, "{free} free-form faces, {facets} facets");
    let splines = body.brep.surfaces.iter().filter(|surface| surface.spline().is_some()).count();
    assert!(splines >= free, "{splines}");
    for face in exact.faces.iter().filter(|face| face.is_free) {
        assert!(face.max < 1.0, "{}", face.max);
    }
    let volume = body.brep.volume(ShellId(0));
    let wanted = std::f64::consts::PI * (36.0 * 7.8 + 6.9 * 6.9 * 8.4);
    assert!((volume / wanted - 1.0).abs() < 2e-3, "{volume} of {wanted}");
}

#[test]
fn a_smooth_scan_keeps_its_splines() {
    let field = |p: Vector3<f64>| {
        p.norm() - 8.0 - 0.9 * (0.5 * p.x).sin() * (0.6 * p.y + 1.0).sin() * (0.4 * p.z + 2.0).sin()
    };
    let soup = scan(&field, 10.0, 0.8, 0.05);
    let [auto, spline] = [SurfaceChoice::Auto, SurfaceChoice::Spline].map(|surfaces| {
        let mut file = Vec::new();
        let made = converted(&soup, surfaces);
        assert_eq!(made.fallback, None);
        step::write(&made.parts[0].brep, &step::Options::default(), &mut file).expect("a file");
        file
    });
    assert!(auto == spline, "{} and {} bytes", auto.len(), spline.len());
}
