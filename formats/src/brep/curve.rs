//! The curves of edges in space, and of their pcurves in parameter planes.

use std::f64::consts::TAU;

use super::Frame;
use super::conic::{EllipseArc, LineSegment};
use crate::cad::affine::unit;
use crate::spline::SplineCurve;

/// A curve over a range of parameters, in space (D = 3) or in a parameter plane (D = 2).
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum BoundedCurve<const D: usize> {
    /// A B-spline curve, rational or not, over its whole range.
    Spline(SplineCurve<D>),
    /// A part of a line.
    Line(LineSegment<D>),
    /// A part of an ellipse, or the whole ellipse. A circle is an ellipse with equal radii.
    Ellipse(EllipseArc<D>),
}

/// The curve of an edge.
pub type BrepCurve = BoundedCurve<3>;

/// A curve in the parameter plane (u, v) of a face's surface.
pub type PCurve = BoundedCurve<2>;

impl<const D: usize> BoundedCurve<D> {
    /// The range of parameters.
    pub fn range(&self) -> (f64, f64) {
        match self {
            BoundedCurve::Spline(spline) => spline.knots().range(),
            BoundedCurve::Line(line) => line.range,
            BoundedCurve::Ellipse(ellipse) => ellipse.range,
        }
    }

    /// The point at `t`.
    pub fn point(&self, t: f64) -> [f64; D] {
        match self {
            BoundedCurve::Spline(spline) => spline.point(t),
            BoundedCurve::Line(line) => {
                std::array::from_fn(|i| line.origin[i] + t * line.direction[i])
            }
            BoundedCurve::Ellipse(ellipse) => ellipse.derivative(t, 0),
        }
    }

    /// The derivative at `t`.
    pub fn speed(&self, t: f64) -> [f64; D] {
        match self {
            BoundedCurve::Spline(spline) => spline.speed(t),
            BoundedCurve::Line(line) => line.direction,
            BoundedCurve::Ellipse(ellipse) => ellipse.derivative(t, 1),
        }
    }

    /// The points at the start and at the end of the range.
    pub fn ends(&self) -> [[f64; D]; 2] {
        let (start, end) = self.range();
        [self.point(start), self.point(end)]
    }

    /// The ends of the range and the knots between them. The curve is smooth between these.
    pub fn breaks(&self) -> Vec<f64> {
        match self {
            BoundedCurve::Spline(spline) => spline.knots().breaks(),
            BoundedCurve::Line(_) | BoundedCurve::Ellipse(_) => {
                let (start, end) = self.range();
                vec![start, end]
            }
        }
    }

    /// The B-spline curve, if it is one.
    pub fn spline(&self) -> Option<&SplineCurve<D>> {
        match self {
            BoundedCurve::Spline(spline) => Some(spline),
            _ => None,
        }
    }

    /// Whether the curve is a straight line.
    pub(crate) fn is_straight(&self) -> bool {
        match self {
            BoundedCurve::Spline(spline) => spline.knots().degree() == 1,
            BoundedCurve::Line(_) => true,
            BoundedCurve::Ellipse(_) => false,
        }
    }

    /// The curve in the opposite direction over the same range.
    ///
    /// # Errors
    /// The curve is an ellipse in a parameter plane, which would run clockwise, or an ellipse that
    /// is no circle.
    pub fn reversed(&self) -> Result<Self, String> {
        let (start, end) = self.range();
        let sum = start + end;
        match self {
            BoundedCurve::Spline(spline) => Ok(BoundedCurve::Spline(spline.reversed())),
            BoundedCurve::Line(line) => {
                let [to, from] = self.ends();
                LineSegment::new(from, to, line.range).map(BoundedCurve::Line)
            }
            BoundedCurve::Ellipse(ellipse) if D == 3 && ellipse.radius().is_some() => {
                let ([x, y], (sin, cos)) = (ellipse.axes, sum.sin_cos());
                let turned = std::array::from_fn(|i| cos * x[i] + sin * y[i]);
                let across = std::array::from_fn(|i| sin * x[i] - cos * y[i]);
                Ok(BoundedCurve::Ellipse(EllipseArc { axes: [turned, across], ..*ellipse }))
            }
            BoundedCurve::Ellipse(_) => Err("an ellipse that has no opposite".into()),
        }
    }

    /// The curve moved by a vector.
    #[must_use]
    pub fn translated(self, by: [f64; D]) -> Self {
        let moved = |p: [f64; D]| std::array::from_fn(|i| p[i] + by[i]);
        match self {
            BoundedCurve::Spline(spline) => BoundedCurve::Spline(spline.mapped(moved)),
            BoundedCurve::Line(line) => {
                BoundedCurve::Line(LineSegment { origin: moved(line.origin), ..line })
            }
            BoundedCurve::Ellipse(ellipse) => {
                BoundedCurve::Ellipse(EllipseArc { centre: moved(ellipse.centre), ..ellipse })
            }
        }
    }
}

impl BoundedCurve<3> {
    /// The line from a point to another one. Its parameter is the length in mm, from 0.
    ///
    /// # Errors
    /// The points are the same or not finite.
    pub fn line(from: [f64; 3], to: [f64; 3]) -> Result<Self, String> {
        let square: f64 = (0..3).map(|i| (to[i] - from[i]).powi(2)).sum();
        LineSegment::new(from, to, (0.0, square.sqrt())).map(BoundedCurve::Line)
    }

    /// The circle about the z axis of a frame. It begins and ends on the x axis.
    ///
    /// # Errors
    /// The radius is not positive.
    pub fn circle(frame: &Frame, radius: f64) -> Result<Self, String> {
        BrepCurve::arc(frame, radius, TAU)
    }

    /// The arc of a circle about the z axis of a frame. It begins on the x axis and turns by an
    /// angle of at most 2π towards the y axis.
    ///
    /// # Errors
    /// The radius or the angle is not positive.
    pub fn arc(frame: &Frame, radius: f64, angle: f64) -> Result<Self, String> {
        BrepCurve::ellipse(frame, [radius; 2], (0.0, angle))
    }

    /// The arc of an ellipse in the plane of x and y of a frame. The radii are along x and y. The
    /// first one must not be smaller than the second one. The range begins within [0, 2π).
    ///
    /// # Errors
    /// The radii or the range are not valid.
    pub fn ellipse(frame: &Frame, radii: [f64; 2], range: (f64, f64)) -> Result<Self, String> {
        EllipseArc::<3>::new(frame.origin(), [frame.x(), frame.y()], radii, range)
            .map(BoundedCurve::Ellipse)
    }
}

impl BoundedCurve<2> {
    /// The line in a parameter plane that is at `from` at the start of the range, and at `to` at
    /// its end. The range is that of the edge's curve.
    ///
    /// # Errors
    /// The points are the same or not finite, or the range is empty.
    pub fn line(from: [f64; 2], to: [f64; 2], range: (f64, f64)) -> Result<Self, String> {
        LineSegment::new(from, to, range).map(BoundedCurve::Line)
    }

    /// The image of a line, a circle or an ellipse in the plane of x and y of a frame.
    ///
    /// # Errors
    /// The curve is no line and no ellipse, or it runs clockwise there. Then the plane should have
    /// the [flipped](Frame::flipped) frame.
    pub fn on_plane(plane: &Frame, curve: &BrepCurve) -> Result<Self, String> {
        let flat = |p: [f64; 3]| {
            let [u, v, _] = plane.coordinates(p);
            [u, v]
        };
        match curve {
            BoundedCurve::Spline(spline) => Ok(PCurve::Spline(spline.clone().mapped(flat))),
            BoundedCurve::Line(line) => {
                let [from, to] = curve.ends().map(flat);
                PCurve::line(from, to, line.range)
            }
            BoundedCurve::Ellipse(ellipse) => {
                let ends = ellipse.axes.map(|axis| {
                    let at = std::array::from_fn(|i| plane.origin()[i] + axis[i]);
                    flat(at)
                });
                let [[a, b], [c, d]] = ends;
                if a * d - b * c <= 0.0 {
                    return Err("an ellipse that runs clockwise in its plane".into());
                }
                PCurve::ellipse(flat(ellipse.centre), ends[0], ellipse.radii, ellipse.range)
            }
        }
    }

    /// The arc of an ellipse in a parameter plane, counter-clockwise. `x` is the direction towards
    /// t = 0.
    ///
    /// # Errors
    /// The direction, the radii or the range are not valid.
    pub fn ellipse(
        centre: [f64; 2],
        x: [f64; 2],
        radii: [f64; 2],
        range: (f64, f64),
    ) -> Result<Self, String> {
        let [a, b, _] = unit([x[0], x[1], 0.0]).ok_or("an ellipse without a direction")?;
        EllipseArc::<2>::new(centre, [[a, b], [-b, a]], radii, range).map(BoundedCurve::Ellipse)
    }
}

impl<const D: usize> From<SplineCurve<D>> for BoundedCurve<D> {
    fn from(spline: SplineCurve<D>) -> Self {
        BoundedCurve::Spline(spline)
    }
}
