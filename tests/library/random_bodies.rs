//! Random bodies become sound solids, or errors that name a place. The environment variable `BODIES` sets
//! their number.
//!
//! A body is a union of random capsules, rings and plates, cut out of a field of distances by marching
//! tetrahedra. Its triangles are uneven, as those of marching methods are.

use std::collections::HashMap;
use std::f64::consts::TAU;

use crate::common::random::Random;
use formats::Soup;
use scan2step::geometry::{Point, Vector};
use scan2step::mesh::{self, Components};
use scan2step::{Body, Error, Options, TargetShape};

/// A part of a body. The field of a part is the distance from its surface, negative inside.
enum Solid {
    Capsule { ends: [Point; 2], radius: f64 },
    Ring { middle: Point, axis: Vector, reach: f64, radius: f64 },
    Plate { middle: Point, half: Vector, round: f64 },
}

impl Solid {
    fn field(&self, p: &Point) -> f64 {
        match self {
            Solid::Capsule { ends: [a, b], radius } => {
                let along = b - a;
                let t = ((p - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                (p - (a + along * t)).norm() - radius
            }
            Solid::Ring { middle, axis, reach, radius } => {
                let height = (p - middle).dot(axis);
                let flat = ((p - middle) - axis * height).norm() - reach;
                height.hypot(flat) - radius
            }
            Solid::Plate { middle, half, round } => {
                let d = (p - middle).abs() - half + Vector::repeat(*round);
                d.sup(&Vector::zeros()).norm() + d.max().min(0.0) - round
            }
        }
    }
}

/// The kinds of bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    /// Limbs that meet in the middle.
    Limbs,
    /// A chain of rings: as many handles as rings.
    Chain(usize),
    /// A thin plate with a limb.
    Plate,
}

fn parts(kind: Kind, random: &mut Random) -> Vec<Solid> {
    let mut within = |low: f64, high: f64| low + (high - low) * random.share();
    match kind {
        Kind::Limbs => (0..3 + (3.0 * within(0.0, 1.0)) as usize)
            .map(|_| {
                let [u, z] = [TAU * within(0.0, 1.0), within(-1.0, 1.0)];
                let flat = f64::sqrt(1.0 - z * z);
                let end = within(18.0, 36.0) * Vector::new(flat * u.cos(), flat * u.sin(), z);
                let ends = [Point::origin(), Point::from(end)];
                Solid::Capsule { ends, radius: within(4.0, 8.0) }
            })
            .collect(),
        Kind::Chain(count) => (0..count)
            .map(|k| {
                let x = 19.0 * (k as f64 - 0.5 * (count - 1) as f64);
                let tilt = 0.3 * within(-1.0, 1.0);
                let middle = Point::new(x, within(-2.0, 2.0), 0.0);
                let axis = Vector::new(0.0, tilt.sin(), tilt.cos());
                Solid::Ring { middle, axis, reach: 9.5, radius: within(3.0, 4.0) }
            })
            .collect(),
        Kind::Plate => vec![
            Solid::Plate {
                middle: Point::origin(),
                half: Vector::new(34.0, within(15.0, 30.0), within(1.2, 2.5)),
                round: 0.8,
            },
            Solid::Capsule {
                ends: [Point::origin(), Point::new(5.0, 3.0, within(15.0, 30.0))],
                radius: within(4.0, 8.0),
            },
        ],
    }
}

/// The tetrahedra of a cube around its diagonal, by the numbers of its corners.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

/// The surface of some parts by marching tetrahedra over cubes with sides of `step` mm.
fn marched(parts: &[Solid], step: f64) -> Soup {
    let half = (66.0 / step) as i64;
    let at = |c: [i64; 3]| Point::from(c.map(|x| x as f64 * step + 0.013));
    let field = |c: [i64; 3]| {
        let p = at(c);
        parts.iter().map(|part| part.field(&p)).fold(f64::INFINITY, f64::min)
    };
    let mut soup = Soup::default();
    let mut known = HashMap::new();
    let mut value = HashMap::new();
    for (x, y, z) in cubes(half) {
        if field([x, y, z]).abs() > 3.0 * step {
            continue;
        }
        let corner = |k: usize| [0, 1, 2].map(|i| [x, y, z][i] + (k >> i & 1) as i64);
        for tetrahedron in TETRAHEDRA {
            let corners = tetrahedron.map(corner);
            let values = corners.map(|c| *value.entry(c).or_insert_with(|| field(c)));
            let (inside, outside): (Vec<usize>, Vec<usize>) =
                (0..4).partition(|&k| values[k] < 0.0);
            let mut cut = |i: usize, j: usize| {
                let key = (corners[i].min(corners[j]), corners[i].max(corners[j]));
                *known.entry(key).or_insert_with(|| {
                    let t = values[i] / (values[i] - values[j]);
                    soup.points.push(at(corners[i]).lerp(&at(corners[j]), t).into());
                    soup.points.len() as u32 - 1
                })
            };
            let polygon: Vec<u32> = match (inside.as_slice(), outside.as_slice()) {
                (&[a], &[b, c, d]) | (&[b, c, d], &[a]) => vec![cut(a, b), cut(a, c), cut(a, d)],
                (&[a, b], &[c, d]) => vec![cut(a, c), cut(a, d), cut(b, d), cut(b, c)],
                _ => continue,
            };
            let place = |k: &[usize]| {
                k.iter().map(|&k| at(corners[k]).coords).sum::<Vector>() / k.len() as f64
            };
            push_facing(&mut soup, polygon, place(&outside) - place(&inside));
        }
    }
    soup
}

fn cubes(half: i64) -> impl Iterator<Item = (i64, i64, i64)> {
    let all = move || -half..half;
    all().flat_map(move |x| all().flat_map(move |y| all().map(move |z| (x, y, z))))
}

/// Adds the triangles of a polygon so that they face in a direction.
fn push_facing(soup: &mut Soup, mut polygon: Vec<u32>, outward: Vector) {
    let p = |k: usize| Point::from(soup.points[polygon[k] as usize]);
    if (p(1) - p(0)).cross(&(p(2) - p(0))).dot(&outward) < 0.0 {
        polygon.reverse();
    }
    for k in 1..polygon.len() - 1 {
        soup.polygons.push([polygon[0], polygon[k], polygon[k + 1]]);
    }
}

/// The volume of a mesh.
fn volume(soup: &Soup) -> f64 {
    let triangle = |polygon: &[u32]| {
        let corner = |k: usize| Point::from(soup.points[polygon[k] as usize]).coords;
        corner(0).dot(&corner(1).cross(&corner(2))) / 6.0
    };
    soup.polygons.iter().map(triangle).sum()
}

/// Fails unless a solid is sound, has the genus of the body and about its volume.
fn judge(name: &str, solid: &Body, volume: [f64; 2], genus: Option<usize>) {
    let brep = &solid.brep;
    assert_eq!(brep.check(), Ok(()), "{name}");
    assert!(brep.uses().iter().all(|uses| uses.len() == 2), "{name}: an edge is free");
    if let Some(genus) = genus {
        // Faces of tori may have holes.
        let holes: usize = brep.faces.iter().map(|face| face.loops.len() - 1).sum();
        let plus = brep.vertices.len() + brep.faces.len();
        let euler = plus as i64 - (brep.edges.len() + holes) as i64;
        assert_eq!(euler, 2 - 2 * genus as i64, "{name}: the genus changed");
    }
    // Exact faces cannot fold: a ring is recognised as a torus.
    if solid.exact().is_none() {
        assert_eq!(solid.network().map(|fit| fit.folds), Some(0), "{name}: a face turns over");
    }
    let [exact, off] = volume;
    let share = solid.volume().expect("a solid has a volume") / exact;
    assert!((share - 1.0).abs() < off, "{name}: {share} of the volume");
}

#[test]
fn they_become_sound_solids_or_errors() {
    let kinds = [
        Kind::Limbs,
        Kind::Chain(1),
        Kind::Chain(3),
        Kind::Chain(6),
        Kind::Plate,
        Kind::Limbs,
        Kind::Plate,
        Kind::Chain(2),
    ];
    let mut refused = Vec::new();
    let count = std::env::var("BODIES").ok().and_then(|text| text.parse().ok());
    let count = count.unwrap_or(kinds.len());
    for seed in 0..count {
        let kind = kinds[seed % kinds.len()];
        let random = &mut Random(seed as u64 + 1);
        let step = 1.6;
        let parts = parts(kind, random);
        let mut soup = marched(&parts, step);
        let exact = volume(&soup);
        // From no noise to one edge, and every other body is far from the origin.
        let noise = step * (seed * 7 % 11) as f64 / 10.0;
        let far = if seed % 2 == 1 { 1e5 } else { 0.0 };
        for p in &mut soup.points {
            *p = p.map(|x| x + far + noise * (random.share() - 0.5));
        }
        let name = format!("body {seed} ({kind:?}, noise {noise:.2} mm)");
        let scan = Components::new(mesh::from_soup(&soup, 1.0).expect("a mesh"));
        let options = Options::builder().name("body").build().expect("options");
        match crate::common::body_of(&scan, TargetShape::Solid, &options, &mut |_| Ok(())) {
            Ok(solid) => {
                let genus = match kind {
                    Kind::Chain(count) => Some(count),
                    Kind::Limbs | Kind::Plate => None,
                };
                // Noise of a tenth of a tube's radius moves its surface, and its volume with it.
                judge(&name, &solid, [exact, 0.02 + 0.02 * noise], genus);
            }
            Err(error @ (Error::BodyFolds { .. } | Error::Layout(_))) => {
                eprintln!("{name}: {error}");
                refused.push(name);
            }
            Err(error) => panic!("{name}: {error}"),
        }
    }
    assert!(refused.len() <= count / 8, "{refused:?}");
}
