//! Measures whether the time of searches is proportional to their number of elements: the CPU time
//! per element for n elements and for four times as many.
//!
//! cargo bench --bench growth                 all searches, in a minute
//! cargo bench --bench growth -- shells       searches with this in their name

use cpu_time::ProcessTime;
use formats::{Brep, Soup};
use scan2step::geometry::{Point, UvVector};
use scan2step::mesh::{self, Choice, Components, Disk, Outer, Repairs};
use scan2step::spline::{CertifiedLoop, Curve, KnotVector, crossings};
use scan2step::stages::fill;
use scan2step::stages::smooth;
use scan2step::{Options, convert};

/// The number of measurements. The shortest one counts.
const TIMES: usize = 3;

/// A search, its first number of elements, and the function that prepares a number of elements and
/// returns what is measured.
type Case = (&'static str, usize, fn(usize) -> Box<dyn FnMut()>);

const CASES: [Case; 5] = [
    ("pieces taken", 1_000, pieces),
    ("loops crossing, along v", 1_000, loops),
    ("shells of faces", 2_000, shells),
    ("rims crossing, along y", 10_000, rims),
    ("islands in a hole", 25, islands),
];

fn main() {
    let filter = std::env::args().skip(1).find(|arg| !arg.starts_with("--"));
    println!("| search | n | µs each | 4 n | µs each | ratio |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for (name, n, prepare) in CASES {
        if filter.as_ref().is_none_or(|part| name.contains(part.as_str())) {
            let [few, many] = [n, 4 * n].map(|n| each(n, prepare));
            println!("| {name} | {n} | {few:.2} | {} | {many:.2} | {:.2} |", 4 * n, many / few);
        }
    }
}

/// The CPU time in µs per element.
fn each(n: usize, prepare: fn(usize) -> Box<dyn FnMut()>) -> f64 {
    let once = |_| {
        let mut work = prepare(n);
        let begun = ProcessTime::now();
        work();
        begun.elapsed().as_secs_f64()
    };
    1e6 * (0..TIMES).map(once).fold(f64::INFINITY, f64::min) / n as f64
}

/// A sheet of squares of 1 mm with two triangles each. Its lower corner is at a given place, and
/// some squares are omitted.
fn sheet(
    soup: &mut Soup,
    [m, n]: [usize; 2],
    [x, y]: [f64; 2],
    is_out: impl Fn(usize, usize) -> bool,
) {
    let first = soup.points.len() as u32;
    for (i, j) in (0..=m).flat_map(|i| (0..=n).map(move |j| (i as f64, j as f64))) {
        let z = 0.01 * (7.0 * i + 3.0 * j).sin();
        soup.points.push([x + i, y + j, z]);
    }
    let row = n as u32 + 1;
    for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))).filter(|&(i, j)| !is_out(i, j)) {
        let a = first + i as u32 * row + j as u32;
        soup.polygons.push([a, a + row, a + row + 1]);
        soup.polygons.push([a, a + row + 1, a + 1]);
    }
}

fn disk(soup: &Soup) -> Disk {
    let scan = Components::new(mesh::from_soup(soup, 1.0).expect("a mesh"));
    let largest = scan.take(Choice::Largest).expect("a piece");
    largest.into_disk(Outer::Auto, &mut Repairs::new()).expect("a disk")
}

/// Takes every component of a scan out separately.
fn pieces(n: usize) -> Box<dyn FnMut()> {
    let mut soup = Soup::default();
    let side = (n as f64).sqrt().ceil() as usize;
    for k in 0..n {
        let at = [k % side, k / side].map(|t| 12.0 * t as f64);
        sheet(&mut soup, [8, 8], at, |i, j| i == 4 && j == 4);
    }
    let scan = Components::new(mesh::from_soup(&soup, 1.0).expect("a mesh"));
    Box::new(move || {
        for k in 0..scan.count() {
            scan.take(Choice::Number(k)).expect("a piece");
        }
    })
}

/// A loop of short arcs that runs up and down along v.
fn loops(n: usize) -> Box<dyn FnMut()> {
    let half = n / 2;
    let at = |k: usize| {
        let (u, k) = if k < half { (0.6, k) } else { (0.4, n - 1 - k) };
        UvVector::new(u, 0.1 + 0.8 * k as f64 / half as f64)
    };
    let arc = |k: usize| {
        let knots = KnotVector::clamped(3, &[k as f64 / n as f64, (k + 1) as f64 / n as f64], 1);
        let (a, b) = (at(k), at((k + 1) % n));
        Curve::new(knots, (0..4).map(|t| a.lerp(&b, f64::from(t) / 3.0)).collect())
    };
    let outline = CertifiedLoop::new(&(0..n).map(arc).collect::<Vec<_>>()).expect("a loop");
    Box::new(move || assert!(crossings(&[&outline]).is_empty()))
}

/// A file of faces beside each other.
fn shells(n: usize) -> Box<dyn FnMut()> {
    let mut soup = Soup::default();
    sheet(&mut soup, [9, 9], [0.0; 2], |_, _| false);
    let options = Options::builder().net([4, 4]).build().expect("options");
    let made = convert(&soup, &options, &mut |_| Ok(())).expect("a face");
    let made = made.into_body().expect("a face").brep;
    let faces = (0..n).map(|_| made.faces[0].clone()).collect();
    let brep = Brep { faces, ..made };
    Box::new(move || {
        let how = formats::step::Options::default();
        formats::step::write(&brep, &how, &mut std::io::sink()).expect("it is written");
    })
}

/// Smooths a strip along y, which searches for crossings of its rim.
fn rims(n: usize) -> Box<dyn FnMut()> {
    let mut soup = Soup::default();
    sheet(&mut soup, [2, n], [0.0; 2], |_, _| false);
    let disk = disk(&soup);
    let options = smooth::Options { support: smooth::Support::Fixed(4.0), ..Default::default() };
    Box::new(move || {
        smooth::smooth(&disk, &options).expect("it is smoothed");
    })
}

/// Fills a hole with islands.
fn islands(n: usize) -> Box<dyn FnMut()> {
    let mut soup = Soup::default();
    let side = (n as f64).sqrt().round() as usize;
    let across = 8 * side + 8;
    let is_rim = move |t: usize| t < 2 || t >= across - 2;
    sheet(&mut soup, [across, across], [0.0; 2], |i, j| !is_rim(i) && !is_rim(j));
    for k in 0..side * side {
        let at = [k % side, k / side].map(|t| 8.0 * t as f64 + 6.0);
        sheet(&mut soup, [4, 4], at, |_, _| false);
    }
    let disk = disk(&soup);
    assert_eq!(disk.islands.len(), side * side);
    let measured: Vec<Point> = disk.mesh.points.clone();
    Box::new(move || {
        fill::fill(disk.clone(), &measured, &fill::Options::default()).expect("it is filled");
    })
}
