//! What becomes of each vertex of a scan: the point that it is, and how far that is from the
//! face, on which side.

use crate::common::face_seen;
use formats::Soup;
use scan2step::stages::smooth::Support;
use scan2step::{Body, Options, Stage};

/// Points along x and y, 10 mm apart.
const SIZE: [u32; 2] = [41, 31];
const COUNT: u32 = SIZE[0] * SIZE[1];

/// A vertex that is 3 mm higher than its neighbours, and one that is 2 mm lower.
const HIGH: usize = 10 * 41 + 15;
const LOW: usize = 20 * 41 + 25;

/// A sheet that is bent by 5 mm.
fn sheet() -> Soup {
    let mut soup = Soup::default();
    for k in 0..COUNT {
        let (x, y) = (10.0 * f64::from(k % SIZE[0]), 10.0 * f64::from(k / SIZE[0]));
        soup.points.push([x, y, 5.0 * (0.01 * x).sin()]);
    }
    soup.points[HIGH][2] += 3.0;
    soup.points[LOW][2] -= 2.0;
    for a in (0..COUNT - SIZE[0]).filter(|a| a % SIZE[0] + 1 < SIZE[0]) {
        soup.polygons.push([a, a + 1, a + SIZE[0] + 1, a + SIZE[0]]);
    }
    soup
}

/// Its face by a net that cannot follow a single vertex, and the points that it was made of.
fn face(soup: &Soup) -> (Body, Vec<[f64; 3]>) {
    let options = Options::builder().smooth(Support::Off).net([13, 10]).build();
    let mut points = Vec::new();
    let conversion = face_seen(soup, &options.expect("options"), &mut |stage| {
        if let Stage::Mesh(disk) = stage {
            points = disk.mesh.points.iter().map(|p| p.coords.into()).collect();
        }
        Ok(())
    });
    (conversion.expect("a face"), points)
}

/// Each vertex of `kept` is a point at its own place, no two of them the same one.
fn check_points(soup: &Soup, kept: impl Iterator<Item = usize>) -> Body {
    let (conversion, points) = face(soup);
    let mut taken = vec![false; points.len()];
    for vertex in kept {
        let point = conversion.point_of(vertex).expect("a point");
        assert_eq!(points[point], soup.points[vertex]);
        assert!(!std::mem::replace(&mut taken[point], true), "two vertices are point {point}");
    }
    assert!(taken.iter().all(|&taken| taken), "a point is no vertex");
    assert_eq!(conversion.deviation.distances.len(), points.len());
    conversion
}

#[test]
fn vertices_are_points_unless_they_are_left_out() {
    let mut soup = sheet();
    let polygons = std::mem::take(&mut soup.polygons);
    // One corner of one polygon is a second vertex at the same place.
    let twin = soup.points.len() as u32;
    soup.points.push(soup.points[45]);
    for (k, polygon) in polygons.iter().enumerate() {
        let second = |&v: &u32| if k == 44 && v == 45 { twin } else { v };
        soup.polygons.push(polygon.iter().map(second));
    }
    let unused = soup.points.len();
    soup.points.push([3.0, 4.0, 50.0]);
    let not_finite = soup.points.len();
    soup.points.push([f64::NAN, 0.0, 0.0]);
    let other = soup.points.len() as u32;
    soup.points.extend([[900.0, 0.0, 0.0], [910.0, 0.0, 0.0], [900.0, 10.0, 0.0]]);
    soup.polygons.push([other, other + 1, other + 2]);

    let conversion = check_points(&soup, 0..COUNT as usize);
    assert_eq!(conversion.point_of(twin as usize), conversion.point_of(45));
    let left_out = [unused, not_finite, other as usize, other as usize + 2, soup.points.len()];
    for vertex in left_out {
        assert_eq!(conversion.point_of(vertex), None, "vertex {vertex}");
    }
}

#[test]
fn the_order_of_a_file_may_be_any() {
    let sheet = sheet();
    let count = sheet.points.len();
    // 7 and the count have no factor in common.
    let place = |v: usize| (7 * v + 3) % count;
    let mut mixed = Soup { points: vec![[0.0; 3]; count], ..Soup::default() };
    for (v, &p) in sheet.points.iter().enumerate() {
        mixed.points[place(v)] = p;
    }
    let polygons: Vec<Vec<u32>> = sheet.polygons.iter().map(|p| p.to_vec()).collect();
    for polygon in polygons.iter().rev() {
        mixed.polygons.push(polygon.iter().map(|&v| place(v as usize) as u32));
    }
    let (ordered, mixed) = (check_points(&sheet, 0..count), check_points(&mixed, 0..count));
    for (v, expected) in [(HIGH, 3.0), (LOW, -2.0)] {
        for (conversion, v) in [(&ordered, v), (&mixed, place(v))] {
            let off = signed(conversion, v);
            assert!((0.5..1.2).contains(&(off / expected)), "{off} instead of {expected} mm");
        }
    }
}

#[test]
fn the_sign_is_that_of_the_side_which_the_scan_faces() {
    let sheet = sheet();
    let mut turned = Soup { points: sheet.points.clone(), ..Soup::default() };
    for polygon in sheet.polygons.iter() {
        turned.polygons.push(polygon.iter().rev().copied());
    }
    let (up, down) = (face(&sheet).0, face(&turned).0);
    assert!(signed(&up, HIGH) > 1.5 && signed(&up, LOW) < -1.0);
    assert!(signed(&down, HIGH) < -1.5 && signed(&down, LOW) > 1.0);
    for of in [&up.deviation, &up.fit_deviation] {
        let signed = of.signed().expect("signs");
        assert!(of.distances.iter().zip(&signed).all(|(d, s)| *d == s.abs()));
    }
}

/// How far a vertex is above the face, in mm.
fn signed(conversion: &Body, vertex: usize) -> f64 {
    let point = conversion.point_of(vertex).expect("a point");
    conversion.deviation.signed().expect("signs")[point]
}
