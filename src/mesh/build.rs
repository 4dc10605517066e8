//! From a soup of polygons to an oriented, edge-manifold mesh.
//!
//! Steps, each counted in [`Repairs`]: vertices that are not finite go, with
//! their faces; vertices at the same place become one; polygons are fanned;
//! degenerate and duplicate triangles go; orientation is made consistent over
//! every component; edges with more than two triangles and vertices with more
//! than one fan are opened.

use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};

use formats::Soup;

use super::{EdgeMap, Mesh};
use crate::error::{Error, Result};
use crate::geometry::{Point, VertexId};

/// What was repaired: kind and count. Kinds that did not occur are absent.
pub type Repairs = BTreeMap<&'static str, usize>;

/// A mesh made from a soup. Every component is edge-manifold, every vertex has
/// one fan of triangles, and the orientation is consistent except across the
/// sides listed in `twisted`.
#[derive(Debug)]
pub struct Build {
    /// All components.
    pub mesh: Mesh,
    /// For each vertex, the place it had before vertices were opened: vertices
    /// with the same number are copies of one vertex of the scan.
    pub place: Vec<u32>,
    /// Triangles whose orientation cannot agree with a neighbour's.
    pub twisted: Vec<usize>,
    /// What was repaired.
    pub repairs: Repairs,
}

/// Builds the mesh; `mm` is the length of the soup's unit in mm.
pub fn from_soup(soup: &Soup, mm: f64) -> Result<Build> {
    let mut repairs = Repairs::new();
    let (points, welded) = weld(soup, mm, &mut repairs);
    let mut triangles = fan(soup, &welded, &mut repairs);
    drop_useless(&points, &mut triangles, &mut repairs);
    if triangles.is_empty() {
        return Err(Error::Empty("every face is degenerate or has a non-finite vertex".into()));
    }
    let place = (0..points.len() as u32).collect();
    let mut build = Build { mesh: Mesh { points, triangles }, place, twisted: Vec::new(), repairs };
    build.orient();
    build.open_fans();
    while build.drop_overfull_edges() {
        build.open_fans();
    }
    build.drop_unused_vertices();
    Ok(build)
}

fn count(repairs: &mut Repairs, kind: &'static str, n: usize) {
    if n > 0 {
        *repairs.entry(kind).or_default() += n;
    }
}

/// Unique finite points in mm and, for each point of the soup, its number
/// among them (`u32::MAX`: not finite).
fn weld(soup: &Soup, mm: f64, repairs: &mut Repairs) -> (Vec<Point>, Vec<u32>) {
    let mut seen: HashMap<[u64; 3], u32> = HashMap::with_capacity(soup.points.len());
    let mut points = Vec::new();
    let mut not_finite = 0;
    let mut number = |p: &[f64; 3]| {
        let scaled = p.map(|x| x * mm);
        if !scaled.iter().all(|x| x.is_finite()) {
            not_finite += 1;
            return u32::MAX;
        }
        // Adding zero makes -0 and +0 the same place.
        *seen.entry(scaled.map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
            points.push(Point::from(scaled));
            points.len() as u32 - 1
        })
    };
    let welded: Vec<u32> = soup.points.iter().map(&mut number).collect();
    count(repairs, "non_finite_vertices", not_finite);
    count(repairs, "welded_vertices", soup.points.len() - not_finite - points.len());
    (points, welded)
}

fn fan(soup: &Soup, welded: &[u32], repairs: &mut Repairs) -> Vec<[VertexId; 3]> {
    let mut triangles = Vec::with_capacity(soup.polygons.len());
    let (mut lost, mut fanned) = (0, 0);
    for polygon in soup.polygons.iter() {
        let corner = |k: usize| welded[polygon[k] as usize];
        if (0..polygon.len()).any(|k| corner(k) == u32::MAX) {
            lost += 1;
            continue;
        }
        fanned += usize::from(polygon.len() > 3);
        for k in 2..polygon.len() {
            triangles.push([corner(0), corner(k - 1), corner(k)].map(VertexId));
        }
    }
    count(repairs, "faces_with_non_finite_vertices", lost);
    count(repairs, "polygons_triangulated", fanned);
    triangles
}

/// Drops triangles that repeat a vertex and those that repeat a triangle.
fn drop_useless(points: &[Point], triangles: &mut Vec<[VertexId; 3]>, repairs: &mut Repairs) {
    let before = triangles.len();
    triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
    let degenerate = before - triangles.len();
    let mut seen = HashSet::with_capacity(triangles.len());
    let before = triangles.len();
    triangles.retain(|t| {
        let mut key = *t;
        key.sort_unstable();
        seen.insert(key)
    });
    count(repairs, "degenerate_faces", degenerate);
    count(repairs, "duplicate_faces", before - triangles.len());
    debug_assert!(triangles.iter().flatten().all(|v| v.index() < points.len()));
}

impl Build {
    /// Walks over every component and turns triangles to agree with the first
    /// one; the larger part of a component keeps its orientation.
    fn orient(&mut self) {
        let glue = EdgeMap::unoriented(&self.mesh);
        let n = self.mesh.triangles.len();
        let mut turned: Vec<Option<bool>> = vec![None; n];
        let mut twisted = HashSet::new();
        for first in 0..n {
            if turned[first].is_some() {
                continue;
            }
            let mut members = Vec::new();
            let mut queue = VecDeque::from([first]);
            turned[first] = Some(false);
            while let Some(t) = queue.pop_front() {
                members.push(t);
                for side in 3 * t..3 * t + 3 {
                    let Some(other) = glue.across(side) else { continue };
                    let same_way = self.from(side) == self.from(other);
                    let wanted = turned[t].map(|f| f ^ same_way);
                    if turned[other / 3].is_none() {
                        turned[other / 3] = wanted;
                        queue.push_back(other / 3);
                    } else if turned[other / 3] != wanted {
                        twisted.insert(t);
                    }
                }
            }
            let flips = members.iter().filter(|&&t| turned[t] == Some(true)).count();
            let keep = flips * 2 <= members.len();
            for &t in &members {
                turned[t] = turned[t].map(|f| f == keep);
            }
        }
        let mut flipped = 0;
        for (t, turn) in self.mesh.triangles.iter_mut().zip(&turned) {
            if *turn == Some(true) {
                t.swap(1, 2);
                flipped += 1;
            }
        }
        count(&mut self.repairs, "flipped_faces", flipped);
        self.twisted = twisted.into_iter().collect();
        self.twisted.sort_unstable();
    }

    fn from(&self, side: usize) -> VertexId {
        self.mesh.triangles[side / 3][side % 3]
    }

    /// Gives every fan of triangles around a vertex a vertex of its own.
    pub(super) fn open_fans(&mut self) {
        let glue = EdgeMap::new(&self.mesh);
        let mut fans = Fans::new(3 * self.mesh.triangles.len());
        for side in 0..3 * self.mesh.triangles.len() {
            if let Some(other) = glue.across(side) {
                let next = |s: usize| s / 3 * 3 + (s % 3 + 1) % 3;
                fans.join(side, next(other));
                fans.join(next(side), other);
            }
        }
        let mut owner: Vec<u32> = vec![u32::MAX; self.mesh.points.len()];
        let mut copies: HashMap<usize, VertexId> = HashMap::new();
        for corner in 0..3 * self.mesh.triangles.len() {
            let v = self.from(corner);
            let fan = fans.find(corner);
            if owner[v.index()] == u32::MAX {
                owner[v.index()] = fan as u32;
            }
            if owner[v.index()] != fan as u32 {
                let copy = *copies.entry(fan).or_insert_with(|| {
                    self.mesh.points.push(self.mesh.points[v.index()]);
                    self.place.push(self.place[v.index()]);
                    VertexId::from(self.mesh.points.len() - 1)
                });
                self.mesh.triangles[corner / 3][corner % 3] = copy;
            }
        }
        count(&mut self.repairs, "opened_vertices", copies.len());
    }

    /// Drops, from every edge that still has too many triangles or two that
    /// run along it in the same direction, the smallest one; says whether it
    /// dropped any.
    fn drop_overfull_edges(&mut self) -> bool {
        let mut users: HashMap<(VertexId, VertexId), Vec<usize>> = HashMap::new();
        let glue = EdgeMap::new(&self.mesh);
        for side in glue.open_sides() {
            let t = self.mesh.triangles[side / 3];
            let (a, b) = (t[side % 3], t[(side % 3 + 1) % 3]);
            users.entry((a.min(b), a.max(b))).or_default().push(side / 3);
        }
        let area = |t: usize| self.mesh.area_vector(self.mesh.triangles[t]).norm();
        let mut doomed = HashSet::new();
        for triangles in users.values().filter(|u| u.len() > 1) {
            let smallest =
                triangles.iter().min_by(|&&x, &&y| area(x).total_cmp(&area(y)).then(x.cmp(&y)));
            doomed.extend(smallest.copied());
        }
        self.drop_triangles(&doomed);
        count(&mut self.repairs, "faces_dropped_at_non_manifold_edges", doomed.len());
        !doomed.is_empty()
    }

    /// Drops the triangles with the given numbers.
    pub(super) fn drop_triangles(&mut self, doomed: &HashSet<usize>) {
        if doomed.is_empty() {
            return;
        }
        let mut t = 0;
        self.mesh.triangles.retain(|_| {
            t += 1;
            !doomed.contains(&(t - 1))
        });
        let before = |t: usize| t - doomed.iter().filter(|&&d| d < t).count();
        self.twisted =
            self.twisted.iter().filter(|t| !doomed.contains(t)).map(|&t| before(t)).collect();
    }

    /// The component, or part of one, that the triangles given make.
    pub(super) fn part(&self, triangles: &[usize]) -> Build {
        let (mesh, old) = self.mesh.part(triangles.iter().copied());
        let place = old.into_iter().map(|v| self.place[v]).collect();
        Build { mesh, place, twisted: Vec::new(), repairs: Repairs::new() }
    }

    /// Drops vertices without a triangle; the others keep their order.
    fn drop_unused_vertices(&mut self) {
        let (mesh, old) = self.mesh.part(0..self.mesh.triangles.len());
        count(&mut self.repairs, "unused_vertices", self.place.len() - old.len());
        self.place = old.into_iter().map(|v| self.place[v]).collect();
        self.mesh = mesh;
    }
}

/// Union-find over triangle corners.
struct Fans(Vec<u32>);

impl Fans {
    fn new(n: usize) -> Self {
        Fans((0..n as u32).collect())
    }

    fn find(&mut self, mut i: usize) -> usize {
        while self.0[i] as usize != i {
            self.0[i] = self.0[self.0[i] as usize];
            i = self.0[i] as usize;
        }
        i
    }

    fn join(&mut self, i: usize, j: usize) {
        let (i, j) = (self.find(i), self.find(j));
        self.0[i.max(j)] = i.min(j) as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn soup(points: &[[f64; 3]], polygons: &[&[u32]]) -> Soup {
        let mut soup = Soup { points: points.to_vec(), ..Soup::default() };
        for p in polygons {
            soup.polygons.push(p.iter().copied());
        }
        soup
    }

    const SQUARE: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

    #[test]
    fn welds_scales_and_orients() {
        let mut points = SQUARE.to_vec();
        points.extend([[1., 1., 0.], [f64::NAN, 0., 0.]]);
        let b = from_soup(&soup(&points, &[&[0, 1, 2], &[0, 4, 3], &[0, 3, 1], &[5, 1, 2]]), 10.0)
            .unwrap();
        assert_eq!(b.repairs["welded_vertices"], 1);
        assert_eq!(b.repairs["non_finite_vertices"], 1);
        assert!(b.mesh.points.iter().any(|p| *p == Point::new(10., 10., 0.)));
    }

    #[test]
    fn a_vertex_with_two_fans_is_opened() {
        let points = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [-1., 0., 0.], [0., -1., 0.]];
        let b = from_soup(&soup(&points, &[&[0, 1, 2], &[0, 3, 4]]), 1.0).unwrap();
        assert_eq!(b.mesh.points.len(), 6);
        assert_eq!(b.repairs["opened_vertices"], 1);
    }

    #[test]
    fn an_edge_with_three_triangles_is_opened() {
        let points = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.]];
        let b = from_soup(&soup(&points, &[&[0, 1, 2], &[1, 0, 3], &[0, 1, 4]]), 1.0).unwrap();
        let glue = EdgeMap::new(&b.mesh);
        assert_eq!(glue.open_sides().count(), 3 * b.mesh.triangles.len());
    }

    #[test]
    fn a_flipped_triangle_is_turned() {
        let b = from_soup(&soup(&SQUARE, &[&[0, 1, 2], &[0, 3, 2]]), 1.0).unwrap();
        assert_eq!(b.repairs["flipped_faces"], 1);
        assert_eq!(EdgeMap::new(&b.mesh).open_sides().count(), 4);
    }

    #[test]
    fn a_moebius_strip_is_twisted() {
        let n = 8;
        let mut points = Vec::new();
        for i in 0..n {
            let a = std::f64::consts::TAU * i as f64 / n as f64;
            for w in [-0.3, 0.3] {
                let r = 1.0 + w * (a / 2.0).cos();
                points.push([r * a.cos(), r * a.sin(), w * (a / 2.0).sin()]);
            }
        }
        let mut polygons: Vec<Vec<u32>> = Vec::new();
        for i in 0..n {
            let (a, b) = (2 * i, 2 * i + 1);
            let (c, d) = if i + 1 < n { (2 * i + 2, 2 * i + 3) } else { (1, 0) };
            polygons.push(vec![a, c, d, b]);
        }
        let polygons: Vec<&[u32]> = polygons.iter().map(|p| p.as_slice()).collect();
        assert!(!from_soup(&soup(&points, &polygons), 1.0).unwrap().twisted.is_empty());
    }
}
