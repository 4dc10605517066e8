//! Remeshing of a closed mesh to triangles with sides of about the same length (Botsch, Kobbelt, "A
//! remeshing approach to multiresolution modeling", 2004).

use rayon::prelude::*;

use super::flips::{EdgeFlip, Sides, flip};
use super::{FLAT, ROUNDS, TOO_LONG, divide};
use crate::error::{Error, Result};
use crate::geometry::{BLOCK, MOST_ROUNDS, Point, SAME_SIDE, Vector, VertexId, unit_normal};
use crate::mesh::triangles::{Triangles, nearest_on};
use crate::mesh::{Mesh, VertexRings};
use crate::progress::Progress;

/// The least number of triangles around a vertex that loses one in a collapse. If pairs of triangles
/// are joined to quads, three of these should be left.
pub(crate) const LEAST_VALENCE: usize = 4;

/// Divisions add at most so many points for each that triangles of the wanted length need. Without flips in between, a
/// triangle of a length n takes n^1.6 points, and not n. Parts of CAD programs with long slivers need up to 4.
const MOST_ADDED: f64 = 5.0;

/// The sides may have so many wanted lengths for each point that the area needs. Parts of CAD programs have up to 3,
/// and a pipe of 2,000 facets that is 50 times as long as wide has 43.
const THIN: f64 = 100.0;

/// The area of a vertex in a mesh of equilateral triangles is the square of their side divided by this.
pub(crate) const EQUILATERAL: f64 = 1.154_7;

/// A closed mesh with sides of about a length. Its vertices lie on the given mesh.
///
/// # Errors
/// What `progress` returns, or that the triangles are too thin to be divided.
pub(crate) fn isotropic(scan: &Mesh, length: f64, progress: &mut Progress) -> Result<Mesh> {
    let needed = EQUILATERAL * scan.area() / length.powi(2);
    let side = |side: usize| {
        let (a, b) = scan.side(side);
        ((scan.point(b) - scan.point(a)).norm() / length).floor()
    };
    let lengths: f64 = (0..3 * scan.triangles.len()).map(side).sum();
    if lengths.is_nan() || lengths > THIN * needed.max(1.0) {
        return Err(Error::Layout("its triangles are too thin and too long for their area"));
    }
    let most = scan.points.len() + (MOST_ADDED * needed) as usize;
    let surface = Triangles::new(scan);
    let mut points = scan.points.clone();
    let mut triangles: Vec<[usize; 3]> =
        scan.triangles.iter().map(|t| t.map(|v| v.index())).collect();
    for round in 0..ROUNDS {
        // The first round takes about half of the time if the scan has many points.
        let mut progress = |done: f64| match round {
            0 => progress(0.5 * done),
            _ => progress(0.5 + 0.5 * (round as f64 - 1.0 + done) / (ROUNDS - 1) as f64),
        };
        // Each division halves the longest edges.
        for _ in 0..MOST_ROUNDS {
            if divide(&mut points, &mut triangles, |_| length, most).is_empty() {
                break;
            }
        }
        collapse(&points, &mut triangles, length, &mut |done| progress(0.5 * done))?;
        flip_edges(&points, &mut triangles);
        progress(3.0 / 4.0)?;
        move_points(&mut points, &triangles, scan, &surface);
    }
    Ok(used(points, &triangles))
}

/// The unit normal of a triangle, or nothing for one without an area.
fn facing(points: &[Point], t: [usize; 3]) -> Vector {
    unit_normal(t.map(|v| points[v])).unwrap_or_default()
}

/// Triangles of which some were removed by collapses.
struct Collapses<'a> {
    points: &'a [Point],
    triangles: &'a mut Vec<[usize; 3]>,
    /// The triangles around each vertex.
    around: Vec<Vec<usize>>,
    longest: f64,
}

/// Moves ends of short edges onto their other ends, the shortest edges first.
fn collapse(
    points: &[Point],
    triangles: &mut Vec<[usize; 3]>,
    length: f64,
    progress: &mut Progress,
) -> Result<()> {
    let mut around = vec![Vec::new(); points.len()];
    for (t, corners) in triangles.iter().enumerate() {
        corners.iter().for_each(|&v| around[v].push(t));
    }
    let sides = triangles.iter().flat_map(|t| (0..3).map(|k| [t[k], t[(k + 1) % 3]]));
    let lengths = sides.filter(|[a, b]| a < b).map(|[a, b]| ((points[b] - points[a]).norm(), a, b));
    // The halves of a divided edge are not collapsed again.
    let mut short: Vec<_> = lengths.filter(|edge| edge.0 < 0.5 * TOO_LONG * length).collect();
    short.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    let mut collapses = Collapses { points, triangles, around, longest: TOO_LONG * length };
    let count = short.len();
    for (done, (_, a, b)) in short.into_iter().enumerate() {
        if done.is_multiple_of(BLOCK) {
            progress(done as f64 / count as f64)?;
        }
        if !collapses.may(a, b) || collapses.move_onto(a, b) {
            continue;
        }
        collapses.move_onto(b, a);
    }
    let Collapses { around, triangles, .. } = collapses;
    let mut alive = vec![false; triangles.len()];
    around.iter().flatten().for_each(|&t| alive[t] = true);
    let mut number = 0;
    triangles.retain(|_| {
        number += 1;
        alive[number - 1]
    });
    Ok(())
}

impl Collapses<'_> {
    fn neighbours(&self, v: usize) -> Vec<usize> {
        let corners = self.around[v].iter().flat_map(|&t| self.triangles[t]);
        let mut all: Vec<usize> = corners.filter(|&w| w != v).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Whether the edge exists, and the mesh stays manifold without it.
    fn may(&self, a: usize, b: usize) -> bool {
        let (of_a, of_b) = (self.neighbours(a), self.neighbours(b));
        let common: Vec<usize> =
            of_a.iter().copied().filter(|v| of_b.binary_search(v).is_ok()).collect();
        of_a.binary_search(&b).is_ok()
            && common.len() == 2
            && common.iter().all(|&v| self.around[v].len() >= LEAST_VALENCE)
    }

    /// Moves `a` onto `b` unless a triangle turns too far or an edge becomes too long.
    fn move_onto(&mut self, a: usize, b: usize) -> bool {
        let with = |t: [usize; 3]| t.map(|v| if v == a { b } else { v });
        let (lost, kept): (Vec<usize>, Vec<usize>) =
            self.around[a].iter().partition(|&&t| self.triangles[t].contains(&b));
        let is_good = |&t: &usize| {
            let (old, new) = (self.triangles[t], with(self.triangles[t]));
            let far = |&v: &usize| (self.points[v] - self.points[b]).norm() > self.longest;
            let (before, after) = (facing(self.points, old), facing(self.points, new));
            !new.iter().any(far) && after.dot(&before) > SAME_SIDE
        };
        if !kept.iter().all(is_good) {
            return false;
        }
        for &t in &lost {
            self.triangles[t].into_iter().for_each(|v| self.around[v].retain(|&other| other != t));
        }
        for &t in &kept {
            self.triangles[t] = with(self.triangles[t]);
        }
        self.around[a].clear();
        self.around[b].extend(kept);
        true
    }
}

/// Flips edges towards the Delaunay criterion where no triangle turns far.
fn flip_edges(points: &[Point], triangles: &mut [[usize; 3]]) {
    let may = |edge: &EdgeFlip| {
        let [old, new] = [edge.old, edge.new].map(|pair| pair.map(|t| facing(points, t)));
        let mean: Vector = old[0] + old[1];
        new.iter().all(|n| n.dot(&mean) > SAME_SIDE * mean.norm())
            && new[0].dot(&new[1]) >= old[0].dot(&old[1]).min(FLAT)
    };
    let mut sides = Sides::of(triangles);
    flip(points, triangles, &mut sides, |_, _| false, may);
}

/// Moves the points along the surface towards the means of their neighbours, and onto the scan.
fn move_points(points: &mut [Point], triangles: &[[usize; 3]], scan: &Mesh, surface: &Triangles) {
    let mesh = Mesh {
        points: points.to_vec(),
        triangles: triangles.iter().map(|t| t.map(VertexId::from)).collect(),
    };
    let rings = VertexRings::new(&mesh);
    let normals = mesh.vertex_normals();
    let place = |v: usize| {
        let id = VertexId::from(v);
        let (sum, count) = rings
            .neighbours(&mesh, id)
            .fold((Vector::zeros(), 0.0), |(sum, n), w| (sum + mesh.point(w).coords, n + 1.0));
        if count == 0.0 {
            return None;
        }
        let p = mesh.points[v];
        let step = sum / count - p.coords;
        let moved = p + step - normals[v] * normals[v].dot(&step);
        let (_, t) = surface.nearest(moved);
        let faces = scan.area_vector(scan.triangles[t]).dot(&normals[v]) > 0.0;
        faces.then(|| nearest_on(scan.corners(scan.triangles[t]), moved))
    };
    let places: Vec<Option<Point>> = (0..points.len()).into_par_iter().map(place).collect();
    for (v, place) in places.into_iter().enumerate() {
        let Some(place) = place else { continue };
        let around = rings.triangles(v.into());
        let facings = |points: &[Point]| -> Vec<Vector> {
            around.iter().map(|&t| facing(points, triangles[t as usize])).collect()
        };
        let before = facings(points);
        let old = std::mem::replace(&mut points[v], place);
        if facings(points).iter().zip(&before).any(|(n, m)| n.dot(m) <= SAME_SIDE) {
            points[v] = old;
        }
    }
}

/// The mesh without the points that no triangle has.
fn used(points: Vec<Point>, triangles: &[[usize; 3]]) -> Mesh {
    let count = triangles.len();
    let triangles = triangles.iter().map(|t| t.map(VertexId::from)).collect();
    Mesh { points, triangles }.part(0..count).0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::EdgeMap;

    /// A cylinder of radius 10 and height 40 with two flat ends, as CAD programs write it: long slivers.
    fn cylinder() -> Mesh {
        let n = 90;
        let rim = |z: f64| {
            (0..n).map(move |k| {
                let turn = std::f64::consts::TAU * k as f64 / n as f64;
                Point::new(10.0 * turn.cos(), 10.0 * turn.sin(), z)
            })
        };
        let points: Vec<Point> = rim(0.0).chain(rim(40.0)).collect();
        let sides = (0..n).flat_map(|k| {
            let (next, up) = ((k + 1) % n, n);
            [[k, next, up + next], [k, up + next, up + k]]
        });
        let ends = (1..n - 1).flat_map(|k| [[0, k + 1, k], [n, n + k, n + k + 1]]);
        let triangles = sides.chain(ends).map(|t: [usize; 3]| t.map(VertexId::from));
        Mesh { points, triangles: triangles.collect() }
    }

    #[test]
    fn what_is_too_thin_is_refused_before_the_work() {
        let mut thin = cylinder();
        thin.points.iter_mut().for_each(|p| (p.x, p.y) = (1e-9 * p.x, 1e-9 * p.y));
        let length = (EQUILATERAL * thin.area() / 30_000.0).sqrt();
        let made = isotropic(&thin, length, &mut crate::progress::ignore);
        assert!(matches!(made, Err(Error::Layout(_))));
    }

    #[test]
    fn slivers_become_even_and_the_surface_stays() {
        let scan = cylinder();
        let length = 1.0;
        let even = isotropic(&scan, length, &mut crate::progress::ignore).unwrap();
        let edges = EdgeMap::new(&even);
        let sides = 0..3 * even.triangles.len();
        assert!(sides.clone().all(|side| edges.across(side).is_some()), "it is not closed");
        assert_eq!(2 * even.points.len(), even.triangles.len() + 4, "it has another genus");
        let lengths: Vec<f64> = sides
            .map(|side| {
                let (a, b) = even.side(side);
                (even.point(b) - even.point(a)).norm()
            })
            .collect();
        let uneven = lengths.iter().filter(|l| !(0.4..1.6).contains(*l)).count();
        assert!(uneven * 200 < lengths.len(), "{uneven} of {}", lengths.len());
        let area = even.area() / scan.area();
        assert!((area - 1.0).abs() < 0.02, "{area}");
        let surface = Triangles::new(&scan);
        let off = even.points.iter().map(|&p| surface.nearest(p).0).fold(0.0, f64::max);
        assert!(off < 1e-9, "{off}");
    }
}
