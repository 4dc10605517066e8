//! Regressions: random cases that failed once.

use scan2step::Options;
use scan2step::geometry::Point;
use scan2step::mesh::Outer;
use scan2step::stages::fit;
use scan2step::stages::parameterize::Outline;

use crate::choices::splines;
use crate::common::virtual_scan::Star;
use crate::oracle;
use crate::scan::{Damage, Place, Scan, sound};
use crate::sheet::{Mesh, Shape};

fn becomes_a_face(scan: &Scan, options: &Options) {
    match oracle::sound(&scan.soup(), options, false) {
        Ok(became) => assert!(became, "{scan:?}"),
        Err(why) => panic!("{why}: {scan:?}"),
    }
}

fn star(centre: [f64; 2], radius: f64, arms: f64) -> Star {
    Star { centre, radius, arms }
}

fn sheet(size: [usize; 2], shape: Shape, place: Place) -> Scan {
    Scan { mesh: Mesh::Grid(size, 0.0), shape, damage: sound(), place, seed: 0 }
}

/// The rounding errors of large coordinates exceed the accuracy of edges. Spans were halved until
/// the memory was full.
#[test]
fn what_is_far_away_is_as_near_as_doubles_tell() {
    let options = Options::builder().outline(Outline::Free).build().expect("options");
    for away in [1e4, 1e6] {
        let place = Place { scale: 100.0, away, turned: 0.0 };
        becomes_a_face(&sheet([12, 9], Shape::Waves, place), &options);
    }
}

/// Parameters were rounded to a number of digits that moved the edges of a large face.
#[test]
fn hundreds_of_metres_are_no_bug() {
    let options = Options::builder().outline(Outline::Free).fit(fit::Method::Blend);
    let options = options.build().expect("options");
    for scale in [2e5, 6e5, 1e8, 1e15] {
        let place = Place { scale, away: 0.0, turned: 0.0 };
        becomes_a_face(&sheet([2, 3], Shape::Plane, place), &options);
    }
}

/// The distance of edges from a tiny surface was as large as for a large surface.
#[test]
fn edges_of_specks_are_on_them() {
    let options = Options::builder().outline(Outline::Free).build().expect("options");
    for scale in [1e-6, 2e-5, 1e-3] {
        let place = Place { scale, away: 0.0, turned: 0.0 };
        becomes_a_face(&sheet([12, 9], Shape::Waves, place), &options);
    }
}

/// The surface is so steep in its parameters that their rounding errors move its points by more
/// than the accuracy of edges. Spans were halved without end.
#[test]
fn a_crumpled_needle_is_traced_as_near_as_doubles_tell() {
    let holes = vec![
        star([0.8323671078286519, 0.9208060029460479], 0.26684842309518436, 1.0),
        star([0.32129652040014445, 0.29738868397779333], 0.19847874362945522, 3.0),
        star([0.22346561412464563, 0.6872475952705887], 0.28965925067989623, 3.0),
        star([0.8295627822369028, 0.21578281469603192], 0.16299370425570894, 5.0),
    ];
    let damage = Damage {
        holes,
        noise: 3.4038651152707677,
        flipped: 0.22580187671004018,
        outliers: 0.034814882598286585,
        ..sound()
    };
    let place = Place { scale: 162_660.95923345088, away: 0.0, turned: 5.862291836800568 };
    let (mesh, shape) = (Mesh::Delaunay(394), Shape::Needle(8618.275363864932));
    let scan = Scan { mesh, shape, damage, place, seed: 4_849_664_821_253_270_522 };
    becomes_a_face(&scan, &splines().build().expect("options"));
}

/// A fill that was triangulated again in a plane had edges that the mesh already had, at the tips
/// of a ragged rim. The parameterization failed at an inner vertex with two neighbours.
#[test]
fn fills_join_nothing_twice() {
    let holes = vec![
        star([0.8147561793825635, 0.8605596179836997], 0.1784429135222119, 3.0),
        star([0.963593546737247, 0.42039283274563977], 0.2575835713130661, 1.0),
        star([0.10708471471560997, 0.9126325809083701], 0.06470844895494, 5.0),
        star([0.45607529176157213, 0.8034049611961114], 0.11319924504827768, 3.0),
    ];
    let damage = Damage {
        holes,
        noise: 0.006674934524483801,
        lost: 0.14611357588327828,
        outliers: 0.03025449304320261,
        ..sound()
    };
    let place = Place { scale: 100.0, away: 0.0, turned: 0.0 };
    let mesh = Mesh::Grid([17, 14], 0.27761200570141964);
    let scan = Scan { mesh, shape: Shape::Plane, damage, place, seed: 4_656_975_079_722_510_168 };
    let outer = Outer::Near(Point::new(53.635505982941446, 17.71801774054378, 0.0));
    let options = Options::builder().fit(fit::Method::Blend).outer(outer);
    becomes_a_face(&scan, &options.build().expect("options"));
}

/// Needle-shaped folds prevent the tolerance everywhere. Folds were removed again and again.
#[test]
fn a_needle_within_a_hair_ends() {
    let holes = vec![star([0.1943771623078975, 0.6740623086366038], 0.10577045530523801, 2.0)];
    let place = Place { scale: 36.8, away: 0.0, turned: 3.37 };
    let (mesh, shape) = (Mesh::Grid([10, 9], 0.1437380073184123), Shape::Needle(5976.0));
    let damage = Damage { holes, ..sound() };
    let scan = Scan { mesh, shape, damage, place, seed: 1_667_030_670_259_945_676 };
    let options = splines().tolerance(3e-4).max_net(2500);
    becomes_a_face(&scan, &options.build().expect("options"));
}
