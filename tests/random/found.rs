//! What random scans have found, each by itself.

use scan2step::parameterize::Outline;
use scan2step::{Options, fit};

use crate::judge;
use crate::scan::{Place, Scan, sound};
use crate::sheet::{Mesh, Shape};

fn becomes_a_face(scan: &Scan, options: &Options) {
    match judge::sound(&scan.soup(), options) {
        Ok(became) => assert!(became, "{scan:?}"),
        Err(why) => panic!("{why}: {scan:?}"),
    }
}

fn sheet(size: [usize; 2], shape: Shape, place: Place) -> Scan {
    Scan { mesh: Mesh::Grid(size, 0.0), shape, damage: sound(), place, seed: 0 }
}

/// Coordinates of so many mm that their roundings exceed the accuracy of edges: these
/// were halved until memory was full.
#[test]
fn what_is_far_away_is_as_near_as_doubles_tell() {
    let options = Options::builder().outline(Outline::Free).build().expect("options");
    for away in [1e4, 1e6] {
        let place = Place { scale: 100.0, away, turned: 0.0 };
        becomes_a_face(&sheet([12, 9], Shape::Waves, place), &options);
    }
}

/// Parameters rounded to so many digits that it moved the edges of what is large.
#[test]
fn hundreds_of_metres_are_no_bug() {
    let options = Options::builder().outline(Outline::Free).fit(fit::Method::Blend);
    let options = options.build().expect("options");
    for scale in [2e5, 6e5, 1e8, 1e15] {
        let place = Place { scale, away: 0.0, turned: 0.0 };
        becomes_a_face(&sheet([2, 3], Shape::Plane, place), &options);
    }
}

/// Edges were as far off the surface of a speck as off that of a hall.
#[test]
fn edges_of_specks_are_on_them() {
    let options = Options::builder().outline(Outline::Free).build().expect("options");
    for scale in [1e-6, 2e-5, 1e-3] {
        let place = Place { scale, away: 0.0, turned: 0.0 };
        becomes_a_face(&sheet([12, 9], Shape::Waves, place), &options);
    }
}
