//! The faces of a conversion as triangles, with what the page colours them by.

use std::collections::HashMap;

use super::exact_view::kind_of;
use super::scale::SPREAD;
use super::view::ReportView;
use crate::convert::{ExactFit, NetworkFit, SurfaceFit};
use crate::geometry::{Uv, Vector, VertexId};
use crate::mesh::Mesh;
use crate::report::picture::scale::rounded_up;
use crate::report::picture::tessellate;
use crate::spline::Surface;

/// The largest number of points inside all the faces that a page shows together. A page with more
/// is too large to be mailed, and browsers turn it slowly.
const MOST_FACE_POINTS: usize = 60_000;

/// The most points along a side of a cell between knots: enough for stripes to look smooth.
const MOST_CELL_STEPS: usize = 8;

/// The number of points along the sides of so many cells.
fn cell_steps(cells: usize, parts: usize) -> usize {
    (MOST_FACE_POINTS / parts.max(1) / cells.max(1)).isqrt().clamp(1, MOST_CELL_STEPS)
}

/// Parameters from the first break to the last, with so many steps in every span.
fn steps(breaks: &[f64], count: usize) -> Vec<f64> {
    let of_span = |span: &[f64]| {
        let (low, step) = (span[0], (span[1] - span[0]) / count as f64);
        (0..count).map(move |i| low + step * i as f64)
    };
    breaks.windows(2).flat_map(of_span).chain(breaks.last().copied()).collect()
}

/// Faces as triangles. Each face has vertices of its own, so that a kink between two faces shows.
#[derive(Debug)]
pub(super) struct FaceMesh {
    pub mesh: Mesh,
    /// The unit normal of the surface at each vertex.
    pub normals: Vec<Vector>,
    /// The mean curvature of the surface at each vertex, in 1/mm, positive where the face bulges to
    /// the side of its normal.
    pub curvatures: Vec<f32>,
    /// The face of each vertex.
    pub face_of: Vec<usize>,
}

impl FaceMesh {
    /// The triangles of a single face, one of `parts` conversions, with the same number of vertices in
    /// every cell between knots; or, if there are more cells than vertices, with some of these.
    pub(crate) fn of_face(c: &SurfaceFit, outlines: &[Vec<Uv>], parts: usize) -> Option<FaceMesh> {
        let inner = c.surface.middles(cell_steps(c.surface.middles(1).len(), parts));
        let every = (inner.len() * parts).div_ceil(MOST_FACE_POINTS).max(1);
        let inner: Vec<Uv> = inner.into_iter().step_by(every).collect();
        let (triangles, places) = tessellate(&c.surface, c.outer.is_some(), outlines, &inner)?;
        let (triangles, places) = without_unused(triangles, &places);
        let mut mesh = FaceMesh::empty();
        mesh.add(&c.surface, 0, &places);
        mesh.mesh.triangles = triangles;
        Some(mesh)
    }

    /// The triangles of the kept faces of a network, one of `parts` conversions.
    pub(super) fn of_network(body: &NetworkFit, parts: usize) -> FaceMesh {
        let surfaces = &body.network.surfaces;
        let count = cell_steps(surfaces.iter().map(|s| s.middles(1).len()).sum(), parts);
        let kept = body.cut.kept_places(&body.network);
        let mut mesh = FaceMesh::empty();
        for (number, surface) in surfaces.iter().enumerate() {
            let (us, vs) = (steps(&surface.u.breaks(), count), steps(&surface.v.breaks(), count));
            let places: Vec<Uv> =
                vs.iter().flat_map(|&v| us.iter().map(move |&u| Uv::new(u, v))).collect();
            let first = mesh.mesh.points.len();
            mesh.add(surface, number, &places);
            let is_kept = |corners: &[usize; 3]| {
                let sum =
                    corners.map(|k| places[k].coords).into_iter().sum::<nalgebra::Vector2<_>>();
                kept.contains(number, Uv::from(sum / 3.0))
            };
            let triangles = grid_triangles(us.len(), vs.len()).filter(is_kept);
            mesh.mesh.triangles.extend(triangles.map(|t| t.map(|k| VertexId::from(first + k))));
        }
        mesh
    }

    /// The triangles of exact faces, with the normals of their surfaces. The number of a face is that of its kind
    /// ([`kind_of`]).
    pub(super) fn of_exact(fit: &ExactFit) -> FaceMesh {
        let mut mesh = FaceMesh::empty();
        let mut numbers = HashMap::new();
        for (&face, &triangle) in fit.of_triangle.iter().zip(&fit.mesh.triangles) {
            let of = &fit.faces[face as usize];
            let normals = of.normals(fit.mesh.corners(triangle));
            let mut number = |(v, normal): (VertexId, Vector)| {
                *numbers.entry((face, v)).or_insert_with(|| {
                    let p = fit.mesh.point(v);
                    mesh.mesh.points.push(p);
                    mesh.normals.push(normal);
                    mesh.curvatures.push((of.side * of.surface.curvature(p)) as f32);
                    mesh.face_of.push(kind_of(of));
                    VertexId::from(mesh.mesh.points.len() - 1)
                })
            };
            let corners = [0, 1, 2].map(|k| number((triangle[k], normals[k])));
            mesh.mesh.triangles.push(corners);
        }
        mesh
    }

    fn empty() -> FaceMesh {
        FaceMesh {
            mesh: Mesh { points: Vec::new(), triangles: Vec::new() },
            normals: Vec::new(),
            curvatures: Vec::new(),
            face_of: Vec::new(),
        }
    }

    /// Adds vertices of a face.
    fn add(&mut self, surface: &Surface, number: usize, places: &[Uv]) {
        for &place in places {
            let jet = surface.jet(place);
            self.mesh.points.push(jet.s);
            self.normals.push(jet.su.cross(&jet.sv).try_normalize(0.0).unwrap_or_default());
            self.curvatures.push(jet.mean_curvature() as f32);
            self.face_of.push(number);
        }
    }
}

/// The same triangles with only those places that are corners: those in holes are none.
fn without_unused(
    mut triangles: Vec<[VertexId; 3]>,
    places: &[Uv],
) -> (Vec<[VertexId; 3]>, Vec<Uv>) {
    let mut number = vec![None; places.len()];
    let mut used = Vec::new();
    for corner in triangles.iter_mut().flatten() {
        let k = corner.index();
        *corner = *number[k].get_or_insert_with(|| {
            used.push(places[k]);
            VertexId::from(used.len() - 1)
        });
    }
    (triangles, used)
}

/// The triangles of a grid of so many columns and rows of points.
fn grid_triangles(columns: usize, rows: usize) -> impl Iterator<Item = [usize; 3]> {
    let cells = (0..rows - 1).flat_map(move |j| (0..columns - 1).map(move |i| j * columns + i));
    cells.flat_map(move |a| {
        let (b, c, d) = (a + 1, a + columns + 1, a + columns);
        [[a, b, c], [a, c, d]]
    })
}

/// The end of the scale of curvatures, in 1/mm. Sharp places, which are few, would make all others look
/// alike.
pub(super) fn curvature_end(views: &[ReportView]) -> f64 {
    let faces = || views.iter().filter_map(|view| view.face.as_ref());
    let mut all: Vec<f64> =
        faces().flat_map(|face| &face.curvatures).map(|k| f64::from(k.abs())).collect();
    all.sort_by(f64::total_cmp);
    let p95 = all.get(all.len() * 95 / 100).copied().unwrap_or(0.0);
    rounded_up((SPREAD * p95).max(least_curvature(views)))
}

/// The curvature at which a face as large as the scan leaves a plane by its tolerance: with less,
/// the colours would show nothing but rounding.
fn least_curvature(views: &[ReportView]) -> f64 {
    let least = |view: &ReportView| {
        // The sagitta of a chord d of a circle of curvature k is k d² / 8.
        8.0 * view.figures.tolerance / view.scan.mesh.diagonal().powi(2)
    };
    views.iter().map(least).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_covers_its_rectangle_once() {
        let (us, vs) = (steps(&[0.0, 1.0, 3.0], 2), steps(&[0.0, 1.0], 3));
        assert_eq!(us, [0.0, 0.5, 1.0, 2.0, 3.0]);
        let at = |k: usize| Uv::new(us[k % us.len()], vs[k / us.len()]);
        let area = |[a, b, c]: [usize; 3]| {
            let (p, q) = (at(b) - at(a), at(c) - at(a));
            0.5 * (p.x * q.y - p.y * q.x)
        };
        let areas: Vec<f64> = grid_triangles(us.len(), vs.len()).map(area).collect();
        assert!(areas.iter().all(|&area| area > 0.0), "{areas:?}");
        assert!((areas.iter().sum::<f64>() - 3.0).abs() < 1e-12);
    }

    #[test]
    fn places_that_are_no_corners_are_left_out() {
        let places = [0.0, 1.0, 2.0, 3.0].map(|x| Uv::new(x, x * x));
        let (triangles, used) = without_unused(vec![[3, 0, 2].map(VertexId::from)], &places);
        assert_eq!(used, [places[3], places[0], places[2]]);
        assert_eq!(triangles, [[0, 1, 2].map(VertexId::from)]);
    }
}
