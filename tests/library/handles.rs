//! Handles of a few triangles are found and cut, in sheets and in bodies.

use crate::common::{body_of, face_of};
use std::f64::consts::TAU;

use crate::common::random::Random;
use formats::Soup;
use scan2step::geometry::Point;
use scan2step::mesh::{self, Choice, Component, Components, RawPoints};
use scan2step::{Options, TargetShape};

/// A grid of `n` × `n` places, bent into a sheet or closed to a torus, with edges of about 1 mm.
struct Grid {
    n: usize,
    points: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
}

impl Grid {
    fn new(n: usize, closed: bool, random: &mut Random) -> Self {
        let count = if closed { n } else { n + 1 };
        let mut grid = Grid { n: count, points: Vec::new(), triangles: Vec::new() };
        let wave = 2.0 * random.share();
        for k in 0..count * count {
            let (i, j) = ((k / count) as f64, (k % count) as f64);
            grid.points.push(if closed {
                let (u, v) = (TAU * i / n as f64, TAU * j / n as f64);
                let tube = n as f64 / TAU;
                let reach = 2.5 * tube + tube * v.cos();
                [reach * u.cos(), reach * u.sin(), tube * v.sin()]
            } else {
                let height = wave * (0.2 * i).sin() * (0.15 * j).cos() + 0.05 * random.share();
                [i, j, height]
            });
        }
        for (i, j) in (0..n * n).map(|k| (k / n, k % n)) {
            let [a, b] = [grid.name(i, j), grid.name(i + 1, j)];
            let [c, d] = [grid.name(i + 1, j + 1), grid.name(i, j + 1)];
            grid.triangles.extend([[a, b, c], [a, c, d]]);
        }
        grid
    }

    fn name(&self, i: usize, j: usize) -> usize {
        (i % self.n) * self.n + j % self.n
    }

    /// The lower triangle of the cell at (i, j).
    fn cell(&self, i: usize, j: usize) -> [usize; 3] {
        [self.name(i, j), self.name(i + 1, j), self.name(i + 1, j + 1)]
    }

    /// Joins the cell at (i, j) to another one, three cells farther, by a tube of three sides. Returns the
    /// middles of both.
    fn add_handle(&mut self, i: usize, j: usize) -> [Point; 2] {
        let ends = [self.cell(i, j), self.cell(i + 3, j)];
        self.triangles.retain(|t| !ends.contains(t));
        for k in 0..3 {
            let l = (k + 1) % 3;
            // The rims run in opposite directions.
            let [a, b] = [ends[0][k], ends[0][l]];
            let [c, d] = [ends[1][(6 - k) % 3], ends[1][(6 - l) % 3]];
            self.triangles.extend([[a, b, c], [b, d, c]]);
        }
        ends.map(|t| {
            let points = t.map(|v| Point::from(self.points[v]));
            Point::from(points.iter().map(|p| p.coords).sum::<scan2step::geometry::Vector>() / 3.0)
        })
    }

    /// Cuts out six by six cells at (i, j), and lays two bands across the hole, one over the other. Each is
    /// one cell wide.
    fn add_crossing_bands(&mut self, i: usize, j: usize) {
        let window: Vec<usize> = (0..49).map(|k| self.name(i + k / 7, j + k % 7)).collect();
        self.triangles.retain(|t| t.iter().any(|v| !window.contains(v)));
        for (across, height) in [(false, 1.0), (true, -1.0)] {
            let rails = [3, 4].map(|side| {
                let mut place = |along: usize| {
                    let (di, dj) = if across { (side, along) } else { (along, side) };
                    let own = self.name(i + di, j + dj);
                    if along == 0 || along == 6 {
                        return own;
                    }
                    let [x, y, z] = self.points[own];
                    self.points.push([x, y, z + height]);
                    self.points.len() - 1
                };
                [0, 1, 2, 3, 4, 5, 6].map(&mut place)
            });
            let [low, high] = if across { [&rails[1], &rails[0]] } else { [&rails[0], &rails[1]] };
            for k in 0..6 {
                let [a, b, c, d] = [low[k], low[k + 1], high[k + 1], high[k]];
                self.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }

    fn soup(&self) -> Soup {
        let mut soup = Soup { points: self.points.clone(), ..Soup::default() };
        self.triangles.iter().for_each(|t| soup.polygons.push(t.iter().map(|&v| v as u32)));
        soup
    }
}

fn component(soup: &Soup, longest: Option<f64>) -> Component {
    let scan = Components::new(mesh::from_soup(soup, 1.0).expect("a mesh")).with_handles(longest);
    scan.take(Choice::Largest).expect("a component")
}

/// A grid with some handles, and their places.
fn with_handles(count: usize, closed: bool, random: &mut Random) -> (Grid, Vec<[Point; 2]>) {
    let mut grid = Grid::new(48, closed, random);
    // One handle at most in each field of 12 × 12 cells.
    let mut fields: Vec<usize> = (0..16).collect();
    let places = (0..count).map(|_| {
        let field = fields.swap_remove((random.share() * fields.len() as f64) as usize);
        let [di, dj] = [0; 2].map(|_| 2 + (3.0 * random.share()) as usize);
        grid.add_handle(12 * (field / 4) + di, 12 * (field % 4) + dj)
    });
    let places = places.collect();
    (grid, places)
}

#[test]
fn made_handles_are_found_at_their_places_and_cut() {
    let mut random = Random(11);
    for number in 0..200 {
        let (closed, count) = (number % 2 == 1, 1 + number / 2 % 10);
        let (grid, places) = with_handles(count, closed, &mut random);
        let soup = grid.soup();
        let whole = component(&soup, Some(0.0));
        let own = if closed { 1.0 } else { 0.0 };
        assert_eq!(whole.topology.genus(), own + count as f64, "{number}");
        assert!(whole.handles.is_empty(), "{number}");
        // The edges of the torus have different lengths.
        let cut = component(&soup, closed.then_some(9.0));
        assert_eq!(cut.topology.genus(), own, "{number}: the handle of a torus is kept");
        assert_eq!(cut.topology.loops, whole.topology.loops, "{number}");
        assert_eq!(cut.handles.len(), count, "{number}");
        let scale = cut.mesh().diagonal() / whole.mesh().diagonal();
        assert!((scale - 1.0).abs() < 1e-12, "{number}");
        let mm = Components::new(mesh::from_soup(&soup, 1.0).expect("a mesh")).mm();
        for place in places {
            let off = |at: Point| {
                let [a, b] = place;
                scan2step::geometry::segment_distance(at, a, b)
            };
            let nearest = cut.handles.iter().map(|handle| off(handle.at * mm));
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            assert!(nearest < 1.0, "{number}: no handle within an edge of {place:?}: {nearest} mm");
        }
    }
}

#[test]
fn bands_that_cross_in_a_gap_are_cut() {
    let mut random = Random(5);
    for number in 0..40 {
        let count = 1 + number % 4;
        let mut grid = Grid::new(48, false, &mut random);
        for band in 0..count {
            let [di, dj] = [0; 2].map(|_| 2 + (3.0 * random.share()) as usize);
            grid.add_crossing_bands(12 * band + di, 12 * (number % 3) + dj);
        }
        let soup = grid.soup();
        let whole = component(&soup, Some(0.0));
        assert_eq!((whole.topology.genus(), whole.topology.loops), (count as f64, 1 + count));
        let cut = component(&soup, None);
        assert_eq!(cut.topology.genus(), 0.0, "{number}");
        assert_eq!(cut.handles.len(), count, "{number}");
        assert_eq!(cut.topology.loops, 1 + 2 * count, "{number}: one band of each pair stays");
        // Conversions take longer than all the rest of this test. `HANDLES` asks for all of them.
        if std::env::var_os("HANDLES").is_some() || number % 10 == 3 {
            let face = face_of(&soup, &Options::default());
            let face = face.unwrap_or_else(|e| panic!("{number}: {e}"));
            assert_eq!(face.brep.faces.len(), 1, "{number}");
        }
    }
}

#[test]
fn a_tube_of_a_cloud_with_too_few_points_around_it_is_cut() {
    // The shortest loop around the tube is about eight median edges long.
    let soup = Grid::new(20, true, &mut Random(1)).soup();
    let of_mesh = component(&soup, None);
    assert_eq!((of_mesh.topology.genus(), of_mesh.handles.len()), (1.0, 0));
    let points = soup.points.iter().map(|&p| Point::from(p)).collect();
    let raw = RawPoints::new(points, (0..400).collect(), 0.0);
    let scan = Components::new(mesh::from_soup(&soup, 1.0).expect("a mesh"));
    let of_cloud = scan.with_raw_points(raw, 1.0).take(Choice::Largest).expect("a component");
    assert_eq!((of_cloud.topology.genus(), of_cloud.handles.len()), (0.0, 1));
}

#[test]
fn scans_with_made_handles_convert() {
    let mut random = Random(3);
    let rounds = std::env::var("HANDLES").ok().and_then(|text| text.parse().ok());
    for number in 0..rounds.unwrap_or(6) {
        let count = 1 + 2 * (number / 2) % 10;
        let (grid, _) = with_handles(count, number % 2 == 1, &mut random);
        let (soup, options) = (grid.soup(), Options::default());
        if number % 2 == 0 {
            let face = face_of(&soup, &options);
            let face = face.unwrap_or_else(|e| panic!("{number}: {e}"));
            assert_eq!(face.input.handles.len(), count);
            assert_eq!(face.brep.faces.len(), 1, "{number}");
        } else {
            let scan = Components::new(mesh::from_soup(&soup, 1.0).expect("a mesh"));
            let scan = scan.with_handles(Some(9.0));
            let shape = scan2step::shape(&scan, Choice::Largest).expect("a component");
            assert_eq!(shape, TargetShape::Solid);
            let solid = body_of(&scan, shape, &options, &mut |_| Ok(()));
            let solid = solid.unwrap_or_else(|e| panic!("{number}: {e}"));
            assert_eq!(solid.brep.solids.len(), 1, "{number}");
        }
    }
}
