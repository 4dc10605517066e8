//! Facets: triangles that lie in one plane within the rounding, and their neighbours.

use super::corners;
use super::tessellation::{MOST_ERRORS, SLIVER, Tessellation};
use crate::geometry::{NONE, Point, Vector, plane_axes};

/// A neighbour of a facet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Border {
    pub(super) facet: u32,
    /// The angle between the normals. At an edge that is sharp on demand it is at least [`CREASE`].
    pub(super) dihedral: f64,
    /// Whether no region may reach across it.
    pub(super) is_sharp: bool,
    /// The length of the common edges.
    pub(super) length: f64,
    /// The common edges, as a range of [`FacetMesh::sides`].
    sides: [u32; 2],
}

/// Coplanar connected triangles.
#[derive(Debug, Clone)]
pub(super) struct Facet {
    pub(super) triangles: Vec<u32>,
    /// The vertices that are evidence: corners of the outline. Points inside a facet or on a straight edge of it lie
    /// on the chord, not on the surface.
    pub(super) corners: Vec<u32>,
    pub(super) normal: Vector,
    pub(super) centre: Point,
    pub(super) area: f64,
    /// The area over the longest edge.
    pub(super) width: f64,
    /// The largest error of a corner.
    pub(super) error: f64,
    pub(super) borders: Vec<Border>,
    /// Whether it has too many corners to be a strip of a curved face.
    pub(super) is_flat: bool,
}

impl Facet {
    /// How far its normal may be off for the rounding.
    pub(super) fn normal_error(&self) -> f64 {
        SLIVER * self.error / self.width.max(f64::MIN_POSITIVE)
    }

    pub(super) fn border(&self, facet: u32) -> Option<&Border> {
        self.borders.iter().find(|b| b.facet == facet)
    }
}

/// The facets of a mesh.
#[derive(Clone)]
pub(super) struct FacetMesh {
    pub(super) all: Vec<Facet>,
    /// For each triangle its facet.
    pub(super) of: Vec<u32>,
    sides: Vec<u32>,
    /// Edges that turn by more are sharp.
    sharp: f64,
}

/// An angle of creases: no curved face turns by so much from a facet to the next.
const CREASE: f64 = std::f64::consts::FRAC_PI_2;

/// A facet with so many corners is flat for sure. Four can be a strip of a ruled surface.
const FLAT_CORNERS: usize = 5;

/// The plane of a growing facet is fitted again whenever it has so many times as many vertices.
const REFIT_GROWTH: f64 = 1.6;

impl FacetMesh {
    /// The facets of a mesh. No region reaches across an edge that turns by more than `sharp`.
    pub(super) fn of(mesh: &Tessellation, sharp: f64) -> Self {
        let (mut members, mut of) = grown(mesh);
        give_slivers(mesh, &mut members, &mut of);
        let mut all: Vec<Facet> =
            members.into_iter().map(|triangles| measured(mesh, triangles, &of)).collect();
        let sides = join(mesh, &of, &mut all, sharp);
        FacetMesh { all, of, sides, sharp }
    }

    /// Cuts a facet into groups of its triangles. The first group keeps the number, the others get new ones, which are
    /// returned. Call [`FacetMesh::rejoin`] after the last cut.
    pub(super) fn cut(&mut self, mesh: &Tessellation, f: u32, groups: Vec<Vec<u32>>) -> Vec<u32> {
        let first = self.all.len() as u32;
        let numbers: Vec<u32> =
            (0..groups.len() as u32).map(|k| if k == 0 { f } else { first + k - 1 }).collect();
        for (group, &number) in groups.iter().zip(&numbers) {
            group.iter().for_each(|&t| self.of[t as usize] = number);
        }
        for (group, &number) in groups.into_iter().zip(&numbers) {
            let facet = measured(mesh, group, &self.of);
            match self.all.get_mut(number as usize) {
                Some(old) => *old = facet,
                None => self.all.push(facet),
            }
        }
        numbers
    }

    /// Finds the neighbours of all facets again.
    pub(super) fn rejoin(&mut self, mesh: &Tessellation) {
        self.all.iter_mut().for_each(|f| f.borders.clear());
        self.sides = join(mesh, &self.of, &mut self.all, self.sharp);
    }

    /// The common edges of a facet and a neighbour, as sides of triangles.
    pub(super) fn common_sides(&self, border: &Border) -> &[u32] {
        &self.sides[border.sides[0] as usize..border.sides[1] as usize]
    }

    pub(super) fn get(&self, facet: u32) -> &Facet {
        &self.all[facet as usize]
    }
}

/// A plane through the vertices of a growing facet, and how exactly it is known at a place.
struct GrowingPlane {
    centre: Point,
    normal: Vector,
    axes: [Vector; 2],
    /// The inverse of the sums of products of (1, x, y).
    inverse: nalgebra::Matrix3<f64>,
}

impl GrowingPlane {
    fn through(points: &[Point], normal: Vector) -> Self {
        let n = points.len() as f64;
        let sum: Vector = points.iter().map(|p| p.coords).sum();
        let centre = Point::from(sum / n);
        let normal = if points.len() > 3 { flattest(points, centre, normal) } else { normal };
        let (x, y) = plane_axes(normal);
        let mut products = nalgebra::Matrix3::zeros();
        for p in points {
            let q = p - centre;
            let row = Vector::new(1.0, q.dot(&x), q.dot(&y));
            products += row * row.transpose();
        }
        let inverse = products.try_inverse().unwrap_or_else(nalgebra::Matrix3::zeros);
        GrowingPlane { centre, normal, axes: [x, y], inverse }
    }

    /// Whether a point with this error may lie in the plane.
    fn holds(&self, p: Point, error: f64) -> bool {
        let q = p - self.centre;
        let row = Vector::new(1.0, q.dot(&self.axes[0]), q.dot(&self.axes[1]));
        let leverage = (row.transpose() * self.inverse * row)[(0, 0)].max(0.0);
        q.dot(&self.normal).abs() <= MOST_ERRORS * error * (1.0 + leverage).sqrt()
    }
}

/// The direction across which points are flattest, on the side of a known normal.
fn flattest(points: &[Point], centre: Point, normal: Vector) -> Vector {
    let mut moments = nalgebra::Matrix3::zeros();
    for p in points {
        let q = p - centre;
        moments += q * q.transpose();
    }
    let eigen = moments.symmetric_eigen();
    let least = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    if least.dot(&normal) < 0.0 { -least } else { least }
}

/// Grows facets from the triangles with the largest altitudes down. Slivers without a facet are left.
fn grown(mesh: &Tessellation) -> (Vec<Vec<u32>>, Vec<u32>) {
    let count = mesh.areas.len();
    let mut order: Vec<u32> = (0..count as u32).filter(|&t| !mesh.is_sliver(t)).collect();
    order.sort_by(|&a, &b| mesh.altitude(b).total_cmp(&mesh.altitude(a)));
    let mut of = vec![NONE; count];
    let mut seen = vec![NONE; mesh.errors.len()];
    let mut members = Vec::new();
    for first in order {
        if of[first as usize] == NONE {
            let facet = members.len() as u32;
            members.push(grow(mesh, first, facet, &mut of, &mut seen));
        }
    }
    (members, of)
}

fn grow(mesh: &Tessellation, first: u32, facet: u32, of: &mut [u32], seen: &mut [u32]) -> Vec<u32> {
    let mut triangles = vec![first];
    of[first as usize] = facet;
    let mut points: Vec<Point> = Vec::new();
    let mut add = |t: u32, points: &mut Vec<Point>| {
        for v in mesh.corners(t) {
            if seen[v as usize] != facet {
                seen[v as usize] = facet;
                points.push(mesh.point(v));
            }
        }
    };
    add(first, &mut points);
    let mut fitted = points.len();
    let mut plane = GrowingPlane::through(&points, mesh.normals[first as usize]);
    let mut done = 0;
    while let Some(&t) = triangles.get(done) {
        done += 1;
        for (other, _) in mesh.across(t) {
            if of[other as usize] != NONE {
                continue;
            }
            let same_side = mesh.normals[other as usize].dot(&plane.normal) > 0.5;
            if !(same_side || mesh.is_sliver(other)) {
                continue;
            }
            if mesh.corners(other).iter().all(|&v| plane.holds(mesh.point(v), mesh.error(v))) {
                of[other as usize] = facet;
                triangles.push(other);
                add(other, &mut points);
                if points.len() as f64 >= REFIT_GROWTH * fitted as f64 {
                    fitted = points.len();
                    plane = GrowingPlane::through(&points, plane.normal);
                }
            }
        }
    }
    triangles
}

/// Gives slivers to the neighbour whose plane holds them, of several to the one across the longest edge.
fn give_slivers(mesh: &Tessellation, members: &mut Vec<Vec<u32>>, of: &mut [u32]) {
    let mut left: Vec<u32> = (0..of.len() as u32).filter(|&t| of[t as usize] == NONE).collect();
    while !left.is_empty() {
        let mut still = Vec::new();
        let mut given = Vec::new();
        for &t in &left {
            match best_home(mesh, members, of, t) {
                Some(facet) => given.push((t, facet)),
                None => still.push(t),
            }
        }
        if given.is_empty() {
            // Nothing but slivers: each is a facet.
            for &t in &still {
                of[t as usize] = members.len() as u32;
                members.push(vec![t]);
            }
            return;
        }
        for (t, facet) in given {
            of[t as usize] = facet;
            members[facet as usize].push(t);
        }
        left = still;
    }
}

fn best_home(mesh: &Tessellation, members: &[Vec<u32>], of: &[u32], t: u32) -> Option<u32> {
    let homes = mesh.across(t).filter(|&(other, _)| of[other as usize] != NONE);
    let rated = homes.map(|(other, side)| {
        let facet = of[other as usize];
        // The first triangle of a facet has the largest altitude.
        let best = members[facet as usize][0];
        let origin = mesh.point(mesh.corners(best)[0]);
        let normal = mesh.normals[best as usize];
        let off = |v: u32| (mesh.point(v) - origin).dot(&normal).abs();
        let off = mesh.corners(t).into_iter().map(off).fold(0.0, f64::max);
        let [a, b] = mesh.ends(side).map(|v| mesh.point(v));
        (off > SLIVER * mesh.triangle_error(t), (b - a).norm(), facet)
    });
    rated.min_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1))).map(|(.., facet)| facet)
}

fn measured(mesh: &Tessellation, triangles: Vec<u32>, of: &[u32]) -> Facet {
    let mut sum = Vector::zeros();
    let mut middle = Vector::zeros();
    let (mut area, mut longest) = (0.0, 0.0f64);
    let base = mesh.point(mesh.corners(triangles[0])[0]);
    for &t in &triangles {
        let twice = mesh.areas[t as usize];
        sum += twice * mesh.normals[t as usize];
        area += twice;
        longest = longest.max(mesh.longest[t as usize]);
        let q: Vector = mesh.corners(t).iter().map(|&v| mesh.point(v) - base).sum();
        middle += twice / 3.0 * q;
    }
    let (corners, count) = corners::of(mesh, &triangles, of);
    let normal = sum.try_normalize(0.0).unwrap_or_else(Vector::z);
    let error = corners.iter().map(|&v| mesh.error(v)).fold(0.0, f64::max);
    Facet {
        normal,
        centre: base + middle / area.max(f64::MIN_POSITIVE),
        area: area / 2.0,
        width: area / 2.0 / longest.max(f64::MIN_POSITIVE),
        error,
        is_flat: count >= FLAT_CORNERS,
        corners,
        borders: Vec::new(),
        triangles,
    }
}

/// Finds the neighbours of all facets. Returns the common edges.
fn join(mesh: &Tessellation, of: &[u32], all: &mut [Facet], sharp: f64) -> Vec<u32> {
    let mut pairs: Vec<(u32, u32, u32)> = Vec::new();
    for t in 0..of.len() as u32 {
        for (other, side) in mesh.across(t) {
            let (a, b) = (of[t as usize], of[other as usize]);
            if a != b {
                pairs.push((a, b, side as u32));
            }
        }
    }
    pairs.sort_unstable();
    let mut first = 0;
    for same in pairs.chunk_by(|x, y| x.0 == y.0 && x.1 == y.1) {
        let (a, b) = (same[0].0, same[0].1);
        let cosine = all[a as usize].normal.dot(&all[b as usize].normal);
        let sine = all[a as usize].normal.cross(&all[b as usize].normal).norm();
        let length = same.iter().map(|&(_, _, side)| {
            let [p, q] = mesh.ends(side as usize).map(|v| mesh.point(v));
            (q - p).norm()
        });
        let turn = sine.atan2(cosine);
        let is_sharp = turn > sharp;
        let border = Border {
            facet: b,
            dihedral: if is_sharp { turn.max(CREASE) } else { turn },
            is_sharp,
            length: length.sum(),
            sides: [first, first + same.len() as u32],
        };
        first += same.len() as u32;
        all[a as usize].borders.push(border);
    }
    pairs.into_iter().map(|(.., side)| side).collect()
}
