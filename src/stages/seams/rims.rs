//! The rims of an open mesh, and the planes in which they lie.

use std::collections::BTreeMap;

use crate::geometry::{Point, Vector, VertexId};
use crate::mesh::{EdgeMap, Mesh, boundary};
use crate::primitives::{FitOptions, FitSample, Primitive, fit};

/// A vertex is at most so many errors off the plane of a rim: those of its own, and as many of the fit to the others.
pub(super) const OFF_RIM: f64 = 4.0;

/// A boundary loop of a mesh, with the surface on its left.
pub(super) struct Rim {
    /// The sides of triangles along the loop.
    pub sides: Vec<usize>,
    /// The start of each side.
    pub vertices: Vec<VertexId>,
}

/// The boundary loops of a mesh whose vertices have at most one boundary side that leaves them.
pub(super) fn rims(mesh: &Mesh, edges: &EdgeMap) -> Vec<Rim> {
    let side_from: BTreeMap<VertexId, usize> =
        edges.open_sides().map(|side| (mesh.side(side).0, side)).collect();
    let loops = boundary::boundary_loops(mesh, edges).into_iter();
    loops
        .map(|vertices| Rim {
            sides: vertices.iter().filter_map(|v| side_from.get(v).copied()).collect(),
            vertices,
        })
        .filter(|rim| rim.sides.len() == rim.vertices.len())
        .collect()
}

impl Rim {
    /// The places of its vertices.
    pub(super) fn points(&self, mesh: &Mesh) -> Vec<Point> {
        self.vertices.iter().map(|&v| mesh.point(v)).collect()
    }

    /// The runs of the rim along its patches: the first side, the one after the last, and the patch. There are none if it
    /// has one patch only. `of_triangle` has the patch of each triangle.
    pub(super) fn runs(&self, of_triangle: &[usize]) -> Vec<(usize, usize, usize)> {
        let n = self.sides.len();
        let patch_of = |k: usize| of_triangle[self.sides[k % n] / 3];
        let starts: Vec<usize> = (0..n).filter(|&k| patch_of(k) != patch_of(k + n - 1)).collect();
        let ends = starts.iter().skip(1).copied().chain(starts.first().map(|&first| first + n));
        starts.iter().zip(ends).map(|(&from, to)| (from, to, patch_of(from))).collect()
    }

    /// The plane of the rim, if it is flat, with its normal on the outer side of a surface that would close it. If one of
    /// some directions is normal to the rim within the errors, the plane has this direction.
    pub(super) fn plane(
        &self,
        mesh: &Mesh,
        errors: &[f64],
        directions: &[Vector],
    ) -> Option<Primitive> {
        let outwards = -boundary::area(mesh, &self.vertices);
        let normal = outwards.try_normalize(f64::MIN_POSITIVE)?;
        let points = self.points(mesh);
        let centre =
            Point::from(points.iter().map(|p| p.coords).sum::<Vector>() / points.len() as f64);
        let sample = |&v: &VertexId| FitSample { at: mesh.point(v), error: errors[v.index()] };
        let samples: Vec<FitSample> = self.vertices.iter().map(sample).collect();
        let start = Primitive::Plane { origin: centre, normal };
        let fitted = fit(start, &samples, &FitOptions::default()).map_or(start, |fit| fit.surface);
        let holds = |plane: &Primitive| {
            samples.iter().all(|s| plane.distance(s.at).0.abs() <= OFF_RIM * s.error)
        };
        let along = |direction: &Vector| {
            let sign = if direction.dot(&normal) < 0.0 { -1.0 } else { 1.0 };
            Primitive::Plane { origin: centre, normal: sign * direction }
        };
        let fitted = match fitted {
            Primitive::Plane { origin, normal: found } if found.dot(&normal) < 0.0 => {
                Primitive::Plane { origin, normal: -found }
            }
            fitted => fitted,
        };
        directions.iter().map(along).find(&holds).or_else(|| holds(&fitted).then_some(fitted))
    }
}

/// The directions that planes of rims are likely to have: the axes of the coordinates, and those of some surfaces.
pub(super) fn directions<'a>(surfaces: impl Iterator<Item = &'a Primitive>) -> Vec<Vector> {
    let mut all = vec![Vector::x(), Vector::y(), Vector::z()];
    all.extend(surfaces.filter_map(|surface| match *surface {
        Primitive::Plane { normal, .. } => Some(normal),
        _ => surface.axis(),
    }));
    all
}
