//! How far the scan is from exact faces.

use rayon::prelude::*;

use super::conversion::ExactFace;
use crate::deviation::{Deviation, FaceToScan};
use crate::geometry::{Point, VertexId};
use crate::mesh::{Mesh, Triangles};
use crate::spline::Surface;
use crate::spline::nearest::{Foot, NearestPlace, NearestSearch};
use crate::stages::seams::FacePatch;

/// How far the vertices and the triangles of a mesh are from exact faces.
pub(super) struct Distances {
    /// For each vertex its distance, positive outside.
    pub of_vertices: Vec<f64>,
    /// What is known of each face.
    pub of_faces: Vec<ExactFace>,
    /// For each triangle its face.
    pub of_triangle: Vec<u32>,
    /// How far the faces are from the triangles.
    pub to_triangles: FaceToScan,
    /// The share of the area that is not facets.
    pub explained: f64,
}

impl Distances {
    /// Measures the first points and triangles of a mesh, so many of each, from the surfaces of their faces. Those behind
    /// them close its gaps. The distance of a vertex is the largest one from its surfaces.
    pub(super) fn of(mesh: &Mesh, measured: [usize; 2], patches: &[FacePatch]) -> Self {
        let mut of_vertices = vec![0.0f64; measured[0]];
        let mut of_faces = Vec::with_capacity(patches.len());
        let mut middles: Vec<(Point, f64)> = Vec::with_capacity(mesh.triangles.len());
        for patch in patches {
            let corners = patch.triangles.iter().flat_map(|&t| mesh.triangles[t as usize]);
            let mut vertices: Vec<VertexId> = corners.collect();
            vertices.sort_unstable();
            vertices.dedup();
            vertices.retain(|v| v.index() < measured[0]);
            let mut face = unmeasured(patch);
            let free = FreeFace::of(patch);
            let signed = |p: Point| match &free {
                Some(free) => patch.side * free.distance(p, 0.0),
                None => patch.side * patch.surface.distance(p).0,
            };
            for &v in &vertices {
                let distance = signed(mesh.point(v));
                let known = &mut of_vertices[v.index()];
                if distance.abs() > known.abs() {
                    *known = distance;
                }
                measure(&mut face, distance);
            }
            for &t in patch.triangles.iter().filter(|&&t| (t as usize) < measured[1]) {
                let middle = middle(mesh, t as usize);
                middles.push((middle, signed(middle).abs()));
            }
            of_faces.push(measured_face(face));
        }
        let (points, distances) = middles.into_iter().unzip();
        let mut to_triangles = to_triangles(points, distances);
        // The corners of the triangles lie on the surface, so that all of this is chord error.
        to_triangles.chord_error = to_triangles.max;
        let explained = explained(mesh, measured[1], patches);
        let of_triangle = faces_of(mesh, patches);
        Distances { of_vertices, of_faces, of_triangle, to_triangles, explained }
    }

    /// Measures the vertices and the middles of the triangles of a noisy scan from the nearest face. `mesh` has its vertices
    /// on the faces.
    pub(super) fn of_scan(scan: &Mesh, mesh: &Mesh, patches: &[FacePatch]) -> Self {
        let of_triangle = faces_of(mesh, patches);
        let triangles = Triangles::new(mesh);
        let face_at = |p: Point| of_triangle[triangles.nearest(p).1] as usize;
        let free: Vec<Option<FreeFace>> = patches.par_iter().map(FreeFace::of).collect();
        let signed = |p: Point| {
            let (off, triangle) = triangles.nearest(p);
            let face = of_triangle[triangle] as usize;
            if let Some(free) = &free[face] {
                return (face, patches[face].side * free.distance(p, off));
            }
            let distance = patches[face].side * patches[face].surface.distance(p).0;
            let foot = patches[face].surface.closest(p);
            let is_there = distance.abs() >= off || face_at(foot) == face;
            (face, if is_there { distance } else { off.copysign(distance) })
        };
        let found: Vec<(usize, f64)> = scan.points.par_iter().map(|&p| signed(p)).collect();
        let mut of_faces: Vec<ExactFace> = patches.iter().map(unmeasured).collect();
        found.iter().for_each(|&(face, distance)| measure(&mut of_faces[face], distance));
        let middles: Vec<Point> = (0..scan.triangles.len()).map(|t| middle(scan, t)).collect();
        let offs = middles.par_iter().map(|&p| signed(p).1.abs()).collect();
        Distances {
            of_vertices: found.into_iter().map(|found| found.1).collect(),
            of_faces: of_faces.into_iter().map(measured_face).collect(),
            to_triangles: to_triangles(middles, offs),
            explained: explained(mesh, mesh.triangles.len(), patches),
            of_triangle,
        }
    }

    /// The deviation of the measured vertices.
    pub(super) fn deviation(&self, points: &[Point]) -> Deviation {
        let outside = self.of_vertices.iter().map(|d| *d > 0.0).collect();
        let absolute = self.of_vertices.iter().map(|d| d.abs()).collect();
        Deviation::of(points, absolute).with_sides(outside)
    }
}

/// A free-form face with what finds its points.
struct FreeFace<'a> {
    surface: &'a Surface,
    /// The farthest that it is off its triangles.
    off: f64,
    search: NearestSearch,
}

impl<'a> FreeFace<'a> {
    fn of(patch: &'a FacePatch) -> Option<Self> {
        let form = patch.free_form()?;
        let surface = form.surface()?;
        Some(FreeFace {
            surface,
            off: form.off(),
            search: NearestSearch::new(surface, |_, _| true),
        })
    }

    /// The distance of a point, positive on the side of the normal, if its distance from the triangles is known.
    fn distance(&self, p: Point, from_triangles: f64) -> f64 {
        let foot = Foot::find(self.surface, p, self.search.start(p));
        let mut best = NearestPlace { at: foot.at, distance: foot.distance };
        // What is farther is not the nearest place.
        if best.distance > from_triangles + self.off {
            best = self.search.improve(self.surface, p, best, &|_| true);
        }
        let NearestPlace { at, distance } = best;
        let jet = self.surface.jet(at);
        distance.copysign(jet.su.cross(&jet.sv).dot(&(p - jet.s)))
    }
}

/// The share of the area of the first triangles, so many, that is not facets.
fn explained(mesh: &Mesh, count: usize, patches: &[FacePatch]) -> f64 {
    let (mut all, mut exact) = (0.0, 0.0);
    for patch in patches {
        for &t in patch.triangles.iter().filter(|&&t| (t as usize) < count) {
            let area = mesh.area_vector(mesh.triangles[t as usize]).norm();
            all += area;
            exact += if patch.is_facet { 0.0 } else { area };
        }
    }
    exact / f64::max(all, f64::MIN_POSITIVE)
}

/// For each triangle its face.
fn faces_of(mesh: &Mesh, patches: &[FacePatch]) -> Vec<u32> {
    let mut faces = vec![0; mesh.triangles.len()];
    for (number, patch) in patches.iter().enumerate() {
        patch.triangles.iter().for_each(|&t| faces[t as usize] = number as u32);
    }
    faces
}

/// A face before any point of it is measured. While points are, its `rms` is their sum of squares.
fn unmeasured(patch: &FacePatch) -> ExactFace {
    let &FacePatch { surface, side, is_facet, .. } = patch;
    let is_free = patch.free_form().is_some();
    ExactFace { surface, side, is_facet, is_free, rms: 0.0, max: 0.0, points: 0, uncertainty: None }
}

fn measure(of: &mut ExactFace, distance: f64) {
    of.rms += distance * distance;
    of.max = of.max.max(distance.abs());
    of.points += 1;
}

fn measured_face(of: ExactFace) -> ExactFace {
    ExactFace { rms: (of.rms / of.points.max(1) as f64).sqrt(), ..of }
}

fn middle(mesh: &Mesh, triangle: usize) -> Point {
    let [a, b, c] = mesh.corners(mesh.triangles[triangle]).map(|p| p.coords);
    Point::from((a + b + c) / 3.0)
}

fn to_triangles(places: Vec<Point>, distances: Vec<f64>) -> FaceToScan {
    let Deviation { rms, p95, max, max_at, .. } = Deviation::of(&places, distances);
    FaceToScan { rms, p95, max, max_at, chord_error: 0.0, beyond: 0, places: places.len() }
}
