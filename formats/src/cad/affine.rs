//! Similarity transforms: the unit of a file and the placement of its entities.

use std::sync::Arc;

use super::model::{CadCurve, CadSurface};

/// The map x ↦ scale · (turn x + shift). `turn` preserves lengths but may mirror.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Affine {
    pub(crate) turn: [[f64; 3]; 3],
    pub(crate) shift: [f64; 3],
    pub(crate) scale: f64,
}

impl Affine {
    /// A scaling.
    pub(crate) fn scaling(scale: f64) -> Self {
        let turn = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Affine { turn, shift: [0.0; 3], scale }
    }

    /// The composition: first `inner` without its scale, then this one.
    pub(crate) fn after(&self, inner: &Affine) -> Affine {
        let row = |i: usize| {
            [0, 1, 2].map(|j| (0..3).map(|k| self.turn[i][k] * inner.turn[k][j]).sum::<f64>())
        };
        let shift = [0, 1, 2].map(|i| dot(self.turn[i], inner.shift) + self.shift[i]);
        Affine { turn: [row(0), row(1), row(2)], shift, scale: self.scale }
    }

    pub(crate) fn point(&self, p: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| self.scale * (dot(self.turn[i], p) + self.shift[i]))
    }

    pub(crate) fn vector(&self, d: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| self.scale * dot(self.turn[i], d))
    }

    /// The point whose image is `p`.
    pub(crate) fn back(&self, p: [f64; 3]) -> [f64; 3] {
        let from = [0, 1, 2].map(|i| p[i] / self.scale - self.shift[i]);
        [0, 1, 2].map(|i| (0..3).map(|k| self.turn[k][i] * from[k]).sum())
    }

    /// The map whose columns are the axes of a coordinate system, and that takes the origin to `origin`.
    pub(crate) fn to_axes(origin: [f64; 3], axes: [[f64; 3]; 3]) -> Self {
        let turn = [0, 1, 2].map(|i| axes.map(|axis| axis[i]));
        Affine { turn, shift: origin, scale: 1.0 }
    }

    /// The inverse map.
    pub(crate) fn inverse(&self) -> Self {
        let turn = [0, 1, 2].map(|i| [0, 1, 2].map(|k| self.turn[k][i]));
        let shift = turn.map(|row| -self.scale * dot(row, self.shift));
        Affine { turn, shift, scale: 1.0 / self.scale }
    }

    /// The composition: first `inner`, then this one.
    pub(crate) fn compose(&self, inner: &Affine) -> Affine {
        let turned = self.after(inner);
        // scale · (turn (inner.scale (inner.turn x + inner.shift)) + shift)
        let shift = [0, 1, 2].map(|i| dot(self.turn[i], inner.shift) + self.shift[i] / inner.scale);
        Affine { shift, scale: self.scale * inner.scale, ..turned }
    }

    pub(crate) fn curve(&self, curve: CadCurve<3>) -> CadCurve<3> {
        let shape = curve.shape.mapped(|p| self.point(p), |d| self.vector(d));
        CadCurve { shape, range: curve.range }
    }

    pub(crate) fn surface(&self, surface: CadSurface) -> CadSurface {
        match surface {
            CadSurface::Spline(spline) => CadSurface::Spline(spline.mapped(|p| self.point(p))),
            CadSurface::Plane { origin, x, y } => CadSurface::Plane {
                origin: self.point(origin),
                x: self.vector(x),
                y: self.vector(y),
            },
            CadSurface::Cylinder { origin, x, y, z } => CadSurface::Cylinder {
                origin: self.point(origin),
                x: self.vector(x),
                y: self.vector(y),
                z: self.vector(z),
            },
            CadSurface::Cone { origin, x, y, z, radius, slope } => {
                let [x, y, z] = [x, y, z].map(|axis| self.vector(axis));
                CadSurface::Cone { origin: self.point(origin), x, y, z, radius, slope }
            }
            CadSurface::Sphere { origin, x, y, z } => {
                let [x, y, z] = [x, y, z].map(|axis| self.vector(axis));
                CadSurface::Sphere { origin: self.point(origin), x, y, z }
            }
            CadSurface::Torus { origin, x, y, z, major, minor } => {
                let [x, y, z] = [x, y, z].map(|axis| self.vector(axis));
                CadSurface::Torus { origin: self.point(origin), x, y, z, major, minor }
            }
            CadSurface::Revolution { curve, origin, axis, angles } => CadSurface::Revolution {
                curve: self.curve(curve),
                origin: self.point(origin),
                axis: self.axis(axis),
                angles,
            },
            CadSurface::Extrusion { curve, vector } => {
                CadSurface::Extrusion { curve: self.curve(curve), vector: self.vector(vector) }
            }
            CadSurface::Offset { base, distance } => CadSurface::Offset {
                base: Arc::new(self.surface(Arc::unwrap_or_clone(base))),
                distance: distance * self.scale * self.side(),
            },
            CadSurface::Part { base, u, v } => {
                CadSurface::Part { base: Arc::new(self.surface(Arc::unwrap_or_clone(base))), u, v }
            }
        }
    }

    /// The direction about which turns appear to go after the map. Mirroring reverses it.
    fn axis(&self, axis: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| self.side() * dot(self.turn[i], axis))
    }

    /// −1 if the map mirrors, otherwise 1.
    fn side(&self) -> f64 {
        dot(self.turn[0], cross(self.turn[1], self.turn[2])).signum()
    }
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The unit vector in the direction of `a`. `None` if `a` has no direction.
pub(crate) fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(a, a).sqrt();
    (length.is_finite() && length > 0.0).then(|| a.map(|x| x / length))
}
