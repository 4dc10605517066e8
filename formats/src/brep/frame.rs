//! Right-handed frames, which place curves and surfaces in space.

use crate::cad::affine::{cross, dot, unit};

/// An origin and three axes of unit length at right angles to each other. The axes are right-handed:
/// z = x × y. This is the `axis2_placement_3d` of ISO 10303-42.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    origin: [f64; 3],
    axes: [[f64; 3]; 3],
}

/// A direction may lie along a coordinate axis if its component there is below this. Every
/// direction has such a component, because the smallest one is at most 1/√3 ≈ 0.58.
const NOT_ALONG: f64 = 0.9;

/// Two directions are parallel if the sine of their angle is below this. Files give directions to ten digits and
/// more.
const PARALLEL: f64 = 1e-9;

impl Frame {
    /// The frame of the coordinate system itself.
    pub const WORLD: Frame =
        Frame { origin: [0.0; 3], axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] };

    /// The frame with a given direction of z. The direction of x is the part of `towards` at right
    /// angles to z. Both directions may have any length.
    ///
    /// # Errors
    /// A direction has no length, or the two are parallel, or the origin is not finite.
    pub fn new(origin: [f64; 3], z: [f64; 3], towards: [f64; 3]) -> Result<Self, String> {
        let z = unit(z).ok_or("a frame without a direction of z")?;
        let towards = unit(towards).ok_or("a frame without a direction of x")?;
        if origin.iter().any(|x| !x.is_finite()) {
            return Err("a frame whose origin is not finite".into());
        }
        let across = |a: [f64; 3]| {
            let along = dot(a, z);
            [0, 1, 2].map(|i| a[i] - along * z[i])
        };
        let rest = across(towards);
        if dot(rest, rest).sqrt() < PARALLEL {
            return Err("a frame with parallel axes".into());
        }
        // A second step removes what the first one leaves by rounding.
        let x = unit(rest).map(across).and_then(unit).ok_or("a frame with parallel axes")?;
        Ok(Frame { origin, axes: [x, cross(z, x), z] })
    }

    /// The frame with a given direction of z and any direction of x.
    ///
    /// # Errors
    /// The direction has no length, or the origin is not finite.
    pub fn along(origin: [f64; 3], z: [f64; 3]) -> Result<Self, String> {
        let direction = unit(z).ok_or("a frame without a direction of z")?;
        let towards =
            if direction[0].abs() < NOT_ALONG { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        Frame::new(origin, z, towards)
    }

    /// The origin.
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// The direction of x.
    pub fn x(&self) -> [f64; 3] {
        self.axes[0]
    }

    /// The direction of y.
    pub fn y(&self) -> [f64; 3] {
        self.axes[1]
    }

    /// The direction of z.
    pub fn z(&self) -> [f64; 3] {
        self.axes[2]
    }

    /// The point with the given coordinates in the frame.
    pub fn point(&self, at: [f64; 3]) -> [f64; 3] {
        let vector = self.vector(at);
        [0, 1, 2].map(|i| self.origin[i] + vector[i])
    }

    /// The vector with the given components in the frame.
    pub fn vector(&self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.axes;
        [0, 1, 2].map(|i| a * x[i] + b * y[i] + c * z[i])
    }

    /// The coordinates of a point in the frame.
    pub fn coordinates(&self, point: [f64; 3]) -> [f64; 3] {
        let from = [0, 1, 2].map(|i| point[i] - self.origin[i]);
        self.axes.map(|axis| dot(from, axis))
    }

    /// The frame turned about its own z by an angle in radians, from x to y.
    #[must_use]
    pub fn turned(&self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let x = self.vector([cos, sin, 0.0]);
        Frame { axes: [x, cross(self.z(), x), self.z()], ..*self }
    }

    /// The frame with y and z reversed.
    #[must_use]
    pub fn flipped(&self) -> Self {
        let [x, y, z] = self.axes;
        Frame { axes: [x, y.map(|e| -e), z.map(|e| -e)], ..*self }
    }

    /// The frame with the same axes and another origin.
    #[must_use]
    pub fn at(&self, origin: [f64; 3]) -> Self {
        Frame { origin, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_at_right_angles() {
        let frame = Frame::new([1.0, 2.0, 3.0], [1.0, 2.0, -2.0], [0.3, 0.4, 7.0]).unwrap();
        for frame in [frame, frame.turned(0.7), frame.flipped()] {
            let [x, y, z] = [frame.x(), frame.y(), frame.z()];
            for (a, b, product) in [(x, x, 1.0), (y, y, 1.0), (x, y, 0.0), (y, z, 0.0)] {
                assert!((dot(a, b) - product).abs() < 1e-15);
            }
            assert!(dot(cross(x, y), z) > 0.999);
            let back = frame.coordinates(frame.point([4.0, -5.0, 6.0]));
            assert!((0..3).all(|i| (back[i] - [4.0, -5.0, 6.0][i]).abs() < 1e-14));
        }
    }

    #[test]
    fn frames_without_directions_are_refused() {
        assert!(Frame::new([0.0; 3], [0.0; 3], [1.0, 0.0, 0.0]).is_err());
        assert!(Frame::new([0.0; 3], [1.0, 1.0, 0.0], [2.0, 2.0, 0.0]).is_err());
        assert!(Frame::along([f64::NAN, 0.0, 0.0], [1.0, 0.0, 0.0]).is_err());
    }
}
