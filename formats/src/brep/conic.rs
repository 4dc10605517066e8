//! Parts of lines and of ellipses, in space or in a parameter plane.

use std::f64::consts::TAU;

/// The part of the line origin + t direction over a range of t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineSegment<const D: usize> {
    pub(super) origin: [f64; D],
    pub(super) direction: [f64; D],
    pub(super) range: (f64, f64),
}

/// The part of the ellipse centre + a cos(t) x + b sin(t) y over a range of t. The axes x and y are
/// unit vectors at right angles, and a ≥ b. In a parameter plane it runs counter-clockwise, because
/// STEP has no other one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EllipseArc<const D: usize> {
    pub(super) centre: [f64; D],
    pub(super) axes: [[f64; D]; 2],
    pub(super) radii: [f64; 2],
    pub(super) range: (f64, f64),
}

impl<const D: usize> LineSegment<D> {
    /// The line that is at `from` at the start of the range, and at `to` at its end.
    ///
    /// # Errors
    /// The points are the same or not finite, or the range is empty.
    pub fn new(from: [f64; D], to: [f64; D], range: (f64, f64)) -> Result<Self, String> {
        let range = proper(range)?;
        let direction = std::array::from_fn(|i| (to[i] - from[i]) / (range.1 - range.0));
        let origin = std::array::from_fn(|i| from[i] - range.0 * direction[i]);
        if direction.iter().all(|x: &f64| *x == 0.0) {
            return Err("a line without a length".into());
        }
        match origin.iter().chain(&direction).all(|x| x.is_finite()) {
            true => Ok(LineSegment { origin, direction, range }),
            false => Err("a line that is not finite".into()),
        }
    }

    /// The point at t = 0.
    pub fn origin(&self) -> [f64; D] {
        self.origin
    }

    /// The derivative in t.
    pub fn direction(&self) -> [f64; D] {
        self.direction
    }
}

impl<const D: usize> EllipseArc<D> {
    /// The centre.
    pub fn centre(&self) -> [f64; D] {
        self.centre
    }

    /// The unit vectors towards t = 0 and t = π/2.
    pub fn axes(&self) -> [[f64; D]; 2] {
        self.axes
    }

    /// The radii along the two axes in mm.
    pub fn radii(&self) -> [f64; 2] {
        self.radii
    }

    /// The radius, if the ellipse is a circle.
    pub fn radius(&self) -> Option<f64> {
        let [a, b] = self.radii;
        (a == b).then_some(a)
    }

    pub(super) fn new(
        centre: [f64; D],
        axes: [[f64; D]; 2],
        radii: [f64; 2],
        range: (f64, f64),
    ) -> Result<Self, String> {
        let range = proper(range)?;
        let [a, b] = radii;
        if !(a.is_finite() && b > 0.0 && a >= b) {
            return Err(format!("an ellipse with the radii {a} and {b}"));
        }
        // CAD files have no parameters of the ends of arcs. Importers compute them from the
        // vertices and take the first one within [0, 2π).
        if !(0.0..TAU).contains(&range.0) || range.1 - range.0 > TAU {
            return Err(format!("an ellipse from {} to {}", range.0, range.1));
        }
        match centre.iter().all(|x| x.is_finite()) {
            true => Ok(EllipseArc { centre, axes, radii, range }),
            false => Err("an ellipse that is not finite".into()),
        }
    }

    /// The point (k = 0) or its first derivative (k = 1).
    pub(super) fn derivative(&self, t: f64, k: usize) -> [f64; D] {
        let (sin, cos) = t.sin_cos();
        let [p, q] = if k == 0 { [cos, sin] } else { [-sin, cos] };
        let [x, y] = self.axes;
        std::array::from_fn(|i| {
            let from = if k == 0 { self.centre[i] } else { 0.0 };
            from + self.radii[0] * p * x[i] + self.radii[1] * q * y[i]
        })
    }
}

fn proper(range: (f64, f64)) -> Result<(f64, f64), String> {
    let is_proper = range.0.is_finite() && range.1.is_finite() && range.0 < range.1;
    if is_proper { Ok(range) } else { Err(format!("a curve from {} to {}", range.0, range.1)) }
}
