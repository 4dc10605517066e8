//! Scans with every kind of damage.

use formats::Soup;
use proptest::prelude::*;

use crate::common::random::Random;
use crate::common::virtual_scan::Star;
use crate::sheet::{self, Mesh, Shape, Triangles};

/// A scan: a sheet and its damage. Shares are shares of the triangles or points. Lengths are
/// relative to the shape, whose size is 1 before it is scaled and moved.
#[derive(Debug, Clone)]
pub struct Scan {
    pub mesh: Mesh,
    pub shape: Shape,
    pub damage: Damage,
    pub place: Place,
    pub seed: u64,
}

#[derive(Debug, Clone)]
pub struct Damage {
    /// Regions where triangles are missing. A region inside another one is an island.
    pub holes: Vec<Star>,
    /// The noise as a share of an edge.
    pub noise: f64,
    /// The share of triangles that are missing anywhere.
    pub lost: f64,
    /// The share of triangles with the opposite orientation.
    pub flipped: f64,
    /// The share of triangles with their own points.
    pub torn: f64,
    /// The share of points that are far away.
    pub outliers: f64,
    /// The share of triangles that occur twice.
    pub doubled: f64,
    /// The number of pieces of the scan.
    pub copies: usize,
}

/// The place and the size of a scan.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    pub scale: f64,
    /// The distance from the origin in sizes of the scan.
    pub away: f64,
    pub turned: f64,
}

/// Scans of up to some thousands of triangles.
pub fn damaged() -> impl Strategy<Value = Scan> {
    (sheet::meshes(), sheet::shapes(), damages(), places(), any::<u64>())
        .prop_map(|(mesh, shape, damage, place, seed)| Scan { mesh, shape, damage, place, seed })
}

/// Scans of 1 to 20 triangles.
pub fn tiny() -> impl Strategy<Value = Scan> {
    let meshes = prop_oneof![
        (3..14_usize).prop_map(Mesh::Delaunay),
        (1..=10_usize).prop_map(|n| Mesh::Grid([1, n], 0.0)),
        (1..=3_usize).prop_map(|n| Mesh::Grid([n, 3], 0.4)),
    ];
    let damages = prop_oneof![Just(sound()), rare(0.2).prop_map(|lost| Damage { lost, ..sound() })];
    (meshes, sheet::shapes(), damages, places(), any::<u64>())
        .prop_map(|(mesh, shape, damage, place, seed)| Scan { mesh, shape, damage, place, seed })
}

/// No damage.
pub fn sound() -> Damage {
    let (noise, lost, flipped, torn, outliers, doubled) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    Damage { holes: vec![], noise, lost, flipped, torn, outliers, doubled, copies: 1 }
}

/// Usually nothing, otherwise up to `most`.
fn rare(most: f64) -> impl Strategy<Value = f64> {
    prop_oneof![3 => Just(0.0), 1 => 0.0..most]
}

fn damages() -> impl Strategy<Value = Damage> {
    let star = (0.0..1.0, 0.0..1.0, 0.02..0.3, 1..6_u8);
    let star =
        star.prop_map(|(x, y, radius, arms)| Star { centre: [x, y], radius, arms: arms.into() });
    let holes = prop::collection::vec(star, 0..5);
    let noise = prop_oneof![Just(0.0), 0.0..0.1, 0.1..0.6, 0.6..5.0];
    let copies = prop_oneof![4 => Just(1_usize), 1 => 2..4_usize];
    (holes, noise, rare(0.4), rare(0.3), rare(0.5), rare(0.05), rare(0.3), copies).prop_map(
        |(holes, noise, lost, flipped, torn, outliers, doubled, copies)| Damage {
            holes,
            noise,
            lost,
            flipped,
            torn,
            outliers,
            doubled,
            copies,
        },
    )
}

fn places() -> impl Strategy<Value = Place> {
    let scale = prop_oneof![2 => Just(100.0), 1 => (-6.0..6.0).prop_map(|e| 10f64.powf(e))];
    let away = prop_oneof![2 => Just(0.0), 1 => (0.0..6.0).prop_map(|e| 10f64.powf(e))];
    let turned = prop_oneof![Just(0.0), 0.0..6.0];
    (scale, away, turned).prop_map(|(scale, away, turned)| Place { scale, away, turned })
}

impl Scan {
    /// Whether it is a sheet as from a scanner: it has holes and some noise, no other triangles are
    /// missing, and no triangles overlap.
    pub fn is_whole(&self) -> bool {
        let Damage { noise, lost, flipped, torn, outliers, doubled, .. } = self.damage;
        let is_even = match self.mesh {
            // Vertices that move by half a square may invert triangles.
            Mesh::Grid(_, moved) => moved < 0.45,
            Mesh::Delaunay(_) => true,
        };
        is_even && noise <= 0.1 && [lost, flipped, torn, outliers, doubled] == [0.0; 5]
    }

    /// The output of a reader for this scan.
    pub fn soup(&self) -> Soup {
        let mut random = Random(self.seed);
        let (uv, triangles) = self.mesh.build(&mut random);
        let mut soup = Soup::default();
        for copy in 0..self.damage.copies {
            self.piece(copy, &uv, &triangles, &mut random, &mut soup);
        }
        soup
    }

    fn piece(
        &self,
        copy: usize,
        uv: &[[f64; 2]],
        triangles: &Triangles,
        random: &mut Random,
        soup: &mut Soup,
    ) {
        let Damage { noise, outliers, .. } = self.damage;
        let noise = noise * self.mesh.edge();
        let first = soup.points.len() as u32;
        for &at in uv {
            let mut p = self.shape.at(at);
            p[0] += 1.5 * copy as f64;
            let far = if random.share() < outliers { 20.0 } else { noise };
            soup.points.push(self.place.of(p.map(|x| x + far * (2.0 * random.share() - 1.0))));
        }
        for t in triangles.iter().filter(|t| !self.misses(t.map(|k| uv[k as usize]))) {
            self.triangle(t.map(|k| k + first), random, soup);
        }
    }

    /// Whether a triangle is in an odd number of holes.
    fn misses(&self, corners: [[f64; 2]; 3]) -> bool {
        let [u, v] = [0, 1].map(|axis| corners.iter().map(|c| c[axis]).sum::<f64>() / 3.0);
        self.damage.holes.iter().filter(|star| star.holds(u, v)).count() % 2 == 1
    }

    fn triangle(&self, mut corners: [u32; 3], random: &mut Random, soup: &mut Soup) {
        let Damage { lost, flipped, torn, doubled, .. } = self.damage;
        let mut happens = |share: f64| random.share() < share;
        if happens(lost) {
            return;
        }
        if happens(flipped) {
            corners.swap(0, 1);
        }
        if happens(doubled) {
            soup.polygons.push(corners);
        }
        if happens(torn) {
            corners = corners.map(|k| {
                soup.points.push(soup.points[k as usize]);
                soup.points.len() as u32 - 1
            });
        }
        soup.polygons.push(corners);
    }
}

impl Place {
    /// A point of the shape after it is rotated, moved and scaled.
    pub fn of(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = self.turned.sin_cos();
        let (x, z) = (cos * x - sin * z, sin * x + cos * z);
        let (y, z) = (cos * y - sin * z, sin * y + cos * z);
        let [x, y, z] = [x + self.away, y - 0.5 * self.away, z + 0.3 * self.away];
        [x, y, z].map(|x| self.scale * x)
    }
}
