//! Islands: which components lie in a hole of another one, and the resulting faces.

use crate::common::{OneFace, face_seen};
use std::collections::HashSet;

use crate::common::virtual_scan::{VirtualScan, island_scan};
use crate::common::{arg, converted, inspected, json};
use formats::Soup;
use scan2step::mesh::{self, Bound, Choice, Components, Disk, Mesh, Outer, Patch, Repairs};
use scan2step::{Body, Cut, Options, Stage};

/// Sheets of n × n squares with two triangles each.
#[derive(Default)]
struct Sheets(Soup);

impl Sheets {
    /// The plate of 40 × 40 squares with a hole from 10 to 30 in each direction. It has 2400
    /// triangles.
    fn plate() -> Self {
        let hole = |i: usize| (10..30).contains(&i);
        let mut sheets = Sheets::default();
        sheets.add(40, |x, y| [x, y, 0.0], |i, j| !(hole(i) && hole(j)));
        sheets
    }

    /// A sheet with its corners and only the squares for which `kept` is true.
    fn add(
        &mut self,
        n: usize,
        place: impl Fn(f64, f64) -> [f64; 3],
        kept: impl Fn(usize, usize) -> bool,
    ) -> &mut Self {
        let first = self.0.points.len() as u32;
        let m = n as u32 + 1;
        let corners = (0..=n).flat_map(|i| (0..=n).map(move |j| (i as f64, j as f64)));
        self.0.points.extend(corners.map(|(x, y)| place(x, y)));
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).filter(|&(i, j)| kept(i, j))
        {
            let a = first + i as u32 * m + j as u32;
            self.0.polygons.push([a, a + m, a + m + 1]);
            self.0.polygons.push([a, a + m + 1, a + 1]);
        }
        self
    }

    /// A square of n × n with its lowest corner at a given place.
    fn square(&mut self, n: usize, [x, y, z]: [f64; 3]) -> &mut Self {
        self.add(n, |a, b| [x + a, y + b, z], |_, _| true)
    }

    /// A frame of n × n with a hole at the distance `width` from its sides.
    fn frame(&mut self, n: usize, width: usize, [x, y]: [f64; 2]) -> &mut Self {
        let inner = width..n - width;
        let kept = |i, j| !(inner.contains(&i) && inner.contains(&j));
        self.add(n, |a, b| [x + a, y + b, 0.0], kept)
    }

    fn components(&self) -> Components {
        Components::new(mesh::from_soup(&self.0, 1.0).expect("a sound mesh"))
    }

    /// The largest sheet as a disk, and its repairs.
    fn disk(&self) -> (Disk, Repairs) {
        let mut repairs = Repairs::new();
        let largest = self.components().take(Choice::Largest).expect("there is one");
        let disk = largest.into_disk(Outer::Auto, &mut repairs).expect("a disk");
        assert_eq!(pieces(&disk.mesh), 1 + disk.islands.len());
        (disk, repairs)
    }

    /// The numbers of triangles of its islands.
    #[track_caller]
    fn has_islands(&self, triangles: &[usize]) {
        let islands = self.disk().0.islands;
        assert_eq!(islands.iter().map(|i| i.triangles).collect::<Vec<_>>(), triangles);
    }
}

/// The number of connected parts of a mesh. Triangles are connected at their corners.
fn pieces(mesh: &Mesh) -> usize {
    let mut label: Vec<usize> = (0..mesh.points.len()).collect();
    let mut changed = true;
    while std::mem::take(&mut changed) {
        for t in &mesh.triangles {
            let least = t.iter().map(|v| label[v.index()]).min().expect("three corners");
            for v in t {
                changed |= std::mem::replace(&mut label[v.index()], least) != least;
            }
        }
    }
    label.into_iter().collect::<HashSet<_>>().len()
}

#[test]
fn a_square_in_the_hole_is_an_island() {
    let mut sheets = Sheets::plate();
    sheets.square(8, [16.0, 16.0, 0.5]);
    let (disk, repairs) = sheets.disk();
    let [island] = &disk.islands[..] else { panic!("{:?}", disk.islands) };
    assert_eq!((island.component, island.hole, island.holes.len()), (1, 0, 0));
    assert_eq!((island.rim.len(), disk.mesh.triangles.len()), (32, 2400 + 128));
    assert_eq!((disk.holes.len(), disk.loops().count()), (1, 3));
    assert!(repairs.is_empty(), "{repairs:?}");
    let around = mesh::boundary::area(&disk.mesh, &island.rim);
    assert!((around.z - 64.0).abs() < 1e-9, "the surface to its left");
}

#[test]
fn what_is_beside_above_or_over_the_rim_is_none() {
    // Half of the width of the hole is 10.
    Sheets::plate().square(8, [16.0, 16.0, 9.9]).has_islands(&[128]);
    Sheets::plate().square(8, [16.0, 16.0, 10.1]).has_islands(&[]);
    Sheets::plate().square(8, [50.0, 16.0, 0.0]).has_islands(&[]);
    Sheets::plate().square(8, [1.0, 16.0, 0.5]).has_islands(&[]);
    Sheets::plate().square(8, [8.0, 16.0, 0.5]).has_islands(&[]);
    let upright = |x: f64, y: f64| [20.0, 16.0 + x, y - 4.0];
    Sheets::plate().add(8, upright, |_, _| true).has_islands(&[]);
}

#[test]
fn of_islands_that_overlap_the_larger_stays() {
    let mut sheets = Sheets::plate();
    sheets.square(6, [20.0, 20.0, 1.0]).square(8, [13.0, 13.0, 0.0]).has_islands(&[128]);
    let mut sheets = Sheets::plate();
    sheets.square(6, [22.0, 22.0, 1.0]).square(8, [13.0, 13.0, 0.0]).has_islands(&[128, 72]);
}

#[test]
fn an_island_that_looks_the_other_way_is_turned_over() {
    let mut sheets = Sheets::plate();
    sheets.add(8, |x, y| [16.0 + y, 16.0 + x, 0.0], |_, _| true);
    let (disk, repairs) = sheets.disk();
    assert_eq!((disk.islands.len(), repairs["flipped_faces"]), (1, 128));
    assert!(disk.mesh.triangles.iter().all(|&t| disk.mesh.area_vector(t).z > 0.0));
}

#[test]
fn islands_lie_in_holes_of_islands() {
    // The inner one has more triangles than the one around it, or fewer.
    for (frame, width, inner) in [(18, 1, 14), (18, 5, 6)] {
        let mut sheets = Sheets::plate();
        let at = 20.0 - 0.5 * f64::from(inner);
        sheets.frame(frame, width, [11.0, 11.0]).square(inner as usize, [at, at, 0.0]);
        let disk = sheets.disk().0;
        let [outer, inner] = &disk.islands[..] else { panic!("{:?}", disk.islands) };
        assert_eq!((outer.hole, outer.holes.clone()), (0, 1..2));
        assert_eq!((inner.hole, inner.holes.clone()), (1, 2..2));
        assert!(mesh::boundary::area(&disk.mesh, &disk.holes[1]).z < 0.0);
    }
}

/// Two holes on opposite sides of a roll with an island in each.
#[test]
fn islands_behind_each_other_do_not_overlap() {
    let roll = |x: f64, y: f64| {
        let angle = x / 80.0 * 1.5 * std::f64::consts::PI;
        [17.0 * angle.sin(), y, 17.0 * angle.cos()]
    };
    let hole = |i: usize, j: usize, first| (first..first + 20).contains(&i) && j / 20 == 1;
    let mut sheets = Sheets::default();
    sheets.add(80, roll, |i, j| !hole(i, j, 5) && !hole(i, j, 55));
    sheets.add(10, |x, y| roll(x + 10.0, y + 25.0), |_, _| true);
    sheets.add(8, |x, y| roll(x + 61.0, y + 26.0), |_, _| true);
    sheets.has_islands(&[200, 128]);
}

#[test]
fn dust_is_no_island() {
    Sheets::plate().square(3, [18.0, 18.0, 0.0]).has_islands(&[]);
    Sheets::plate().square(4, [18.0, 18.0, 0.0]).has_islands(&[32]);
}

#[test]
fn an_island_that_touches_the_rim_lets_go() {
    let tilted = |x: f64, y: f64| [10.0 + 0.7 * (x + y), 20.0 + 0.7 * (x - y), 0.0];
    let mut sheets = Sheets::plate();
    sheets.add(10, tilted, |_, _| true);
    let (disk, repairs) = sheets.disk();
    assert_eq!(repairs["faces_dropped_at_bow_ties"], 2);
    assert_eq!(disk.islands.len(), 1);
}

#[test]
fn an_island_is_no_face_of_its_own_besides() {
    let mut sheets = Sheets::plate();
    sheets.frame(18, 1, [11.0, 11.0]).square(14, [13.0, 13.0, 0.0]).square(9, [90.0, 0.0, 0.0]);
    let components = sheets.components();
    assert_eq!(components.sizes(), [2400, 392, 162, 136]);
    assert_eq!(components.without_islands(Outer::Auto), [0, 2]);
}

fn soup(scan: &VirtualScan) -> Soup {
    let mut soup = Soup { points: scan.points.clone(), ..Soup::default() };
    scan.triangles.iter().for_each(|t| soup.polygons.push(*t));
    soup
}

fn convert_with(cut: Cut) -> (Body, Patch) {
    let options = Options::builder().cut(cut).build().expect("sound options");
    let mut filled = None;
    let conversion = face_seen(&soup(&island_scan()), &options, &mut |stage| {
        if let Stage::Fill(patch) = stage {
            filled = Some(patch.clone());
        }
        Ok(())
    });
    (conversion.expect("it converts"), filled.expect("a filled mesh"))
}

/// The number of loops of each face.
fn loops(conversion: &Body) -> Vec<usize> {
    conversion.brep.faces.iter().map(|face| face.loops.len()).collect()
}

#[test]
fn an_island_becomes_a_face_of_the_same_surface() {
    let (conversion, patch) = convert_with(Cut::All);
    assert!(patch.is_disk());
    let [island] = &patch.islands[..] else { panic!("{:?}", patch.islands) };
    assert_eq!((conversion.input.islands, conversion.input.left_out), (1, 0));
    assert_eq!(conversion.input.island_triangles, island.triangles);
    assert_eq!(conversion.fill.holes.iter().map(|h| h.islands).collect::<Vec<_>>(), [1, 0]);
    assert_eq!(loops(&conversion), [2, 2]);
    let places: Vec<_> = conversion.one().loops.iter().map(|l| (l.of, l.within)).collect();
    let isle = Bound::Island { hole: 0, number: 0 };
    assert_eq!(places, [(Bound::Hole(0), None), (isle, Some(0)), (Bound::Hole(1), Some(1))]);
    // The vertices of the island come last. If it were not a face, their distance from one would be
    // that of the rim of the hole.
    let own: HashSet<_> = island.rim.iter().map(|v| v.index()).collect();
    let first = *own.iter().min().expect("a rim");
    let inner = (first..patch.measured).filter(|v| !own.contains(v));
    let (mut worst, mut count) = (0.0_f64, 0);
    for v in inner {
        worst = worst.max(conversion.fit_deviation.distances[v]);
        count += 1;
    }
    assert!(count > 150, "{count}");
    // A loop may cut off the vertices next to the rim as far as the rim is uncertain.
    assert!(
        worst < 1.2 * conversion.one().rim_tolerance,
        "{worst} {}",
        conversion.one().rim_tolerance
    );
}

#[test]
fn an_island_in_a_hole_that_stays_filled_is_part_of_the_face() {
    assert_eq!(loops(&convert_with(Cut::None).0), [1]);
    // Only the wide hole is cut out. The one in the island stays filled.
    assert_eq!(loops(&convert_with(Cut::FromLength(60.0)).0), [2, 1]);
}

#[test]
fn the_program_tells_of_islands() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    let (scan, report) = (path("island.ply"), path("r.json"));
    let mut file = std::fs::File::create(&scan).expect("a temporary file");
    island_scan().write_ply(&mut file).expect("a temporary file");
    let found = inspected(&scan);
    assert_eq!((&found["islands"], &found["left_out_triangles"]), (&1.into(), &0.into()));
    for component in ["largest", "all"] {
        let said = converted(&[
            arg(&scan),
            arg(&path("a.step")),
            "--component",
            component,
            "--report",
            arg(&report),
        ]);
        let input = &json(&report)["input"];
        assert_eq!(input["island_triangles"], found["island_triangles"]);
        let line = format!("islands: 1 kept, {} triangles", input["island_triangles"]);
        assert!(said.contains(&line) && !said.contains("left out"), "{said}");
        assert!(said.contains("2 holes cut out"), "{said}");
        let text = std::fs::read_to_string(path("a.step")).expect("a file");
        assert_eq!(text.matches("ADVANCED_FACE").count(), 2);
    }
}
