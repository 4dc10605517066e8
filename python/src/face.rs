//! One face of a conversion.

use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use scan2step::formats::brep::{self, BoundedCurve, BrepSurface};
use scan2step::formats::spline::SplineSurface;

use crate::arrays;
use crate::conversion::Conversion;

/// A trimmed face.
#[pyclass(frozen, module = "scan2step._scan2step")]
pub struct Face {
    conversion: Py<Conversion>,
    number: usize,
}

impl Face {
    pub fn new(conversion: Py<Conversion>, number: usize) -> Self {
        Face { conversion, number }
    }

    fn face(&self) -> &brep::Face {
        &self.conversion.get().brep().faces[self.number]
    }

    fn surface(&self) -> &BrepSurface {
        &self.conversion.get().brep().surfaces[self.face().surface.0]
    }

    /// The surface, if it is a B-spline.
    fn spline(&self) -> PyResult<&SplineSurface> {
        match self.surface() {
            BrepSurface::Spline(surface) => Ok(surface),
            other => Err(PyValueError::new_err(format!(
                "a {} has no control points, knots and degree: its parameters are in surface",
                kind(other)
            ))),
        }
    }

    /// An array of a row for each parameter point.
    fn at<'py>(
        &self,
        py: Python<'py>,
        uv: &PyReadonlyArray2<f64>,
        row: impl Fn(&BrepSurface, f64, f64) -> [f64; 3],
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (surface, uv) = (self.surface(), uv.as_array());
        if uv.ncols() != 2 {
            return Err(PyValueError::new_err("parameter points have 2 coordinates each"));
        }
        let is_inside = |u: f64, v: f64| match surface {
            BrepSurface::Spline(spline) => {
                let inside = |x: f64, (low, high): (f64, f64)| (low..=high).contains(&x);
                inside(u, spline.u().range()) && inside(v, spline.v().range())
            }
            _ => u.is_finite() && v.is_finite(),
        };
        if !uv.rows().into_iter().all(|p| is_inside(p[0], p[1])) {
            return Err(PyValueError::new_err("a parameter point is outside of the surface"));
        }
        let rows: Vec<_> = uv.rows().into_iter().map(|p| row(surface, p[0], p[1])).collect();
        arrays::points(py, &rows)
    }
}

/// The kind of a surface.
fn kind(surface: &BrepSurface) -> &'static str {
    match surface {
        BrepSurface::Plane { .. } => "plane",
        BrepSurface::Cylinder { .. } => "cylinder",
        BrepSurface::Cone { .. } => "cone",
        BrepSurface::Sphere { .. } => "sphere",
        BrepSurface::Torus { .. } => "torus",
        BrepSurface::Extrusion { .. } => "extrusion",
        BrepSurface::Revolution { .. } => "revolution",
        _ => "spline",
    }
}

/// The kind, the frame (origin, x, y and z axis) and the numbers of a surface: the radii in mm, and the half angle of a
/// cone in radians.
type Parameters = (&'static str, Option<[[f64; 3]; 4]>, Vec<f64>);

#[pymethods]
impl Face {
    #[getter]
    fn control_points<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let surface = slf.get().spline()?;
        arrays::net(slf, surface.poles(), [surface.u().poles(), surface.v().poles()])
    }

    #[getter]
    fn knots_u<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(arrays::view(slf, slf.get().spline()?.u().knots()))
    }

    #[getter]
    fn knots_v<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(arrays::view(slf, slf.get().spline()?.v().knots()))
    }

    #[getter]
    fn degree(&self) -> PyResult<(usize, usize)> {
        let surface = self.spline()?;
        Ok((surface.u().degree(), surface.v().degree()))
    }

    #[getter]
    fn parameters(&self) -> Parameters {
        let surface = self.surface();
        let (frame, numbers) = match surface {
            BrepSurface::Plane { frame } => (Some(frame), vec![]),
            BrepSurface::Cylinder { frame, radius } | BrepSurface::Sphere { frame, radius } => {
                (Some(frame), vec![*radius])
            }
            BrepSurface::Cone { frame, radius, half_angle } => {
                (Some(frame), vec![*radius, *half_angle])
            }
            BrepSurface::Torus { frame, major, minor } => (Some(frame), vec![*major, *minor]),
            _ => (None, vec![]),
        };
        let axes = |frame: &brep::Frame| [frame.origin(), frame.x(), frame.y(), frame.z()];
        (kind(surface), frame.map(axes), numbers)
    }

    /// For each loop its arcs: the curve in the parameter plane, the curve in space, and whether the loop runs
    /// along them.
    #[getter]
    fn loops<'py>(&self, py: Python<'py>) -> PyResult<Vec<Vec<Arc<'py>>>> {
        let brep = self.conversion.get().brep();
        let arc = |used: &brep::EdgeUse| {
            let edge = &brep.edges[used.edge.0].curve;
            Ok((curve(py, &used.pcurve)?, curve(py, edge)?, used.forward))
        };
        let ring = |ring: &Vec<brep::EdgeUse>| ring.iter().map(arc).collect();
        self.face().loops.iter().map(ring).collect()
    }

    fn points<'py>(
        &self,
        py: Python<'py>,
        uv: PyReadonlyArray2<f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.at(py, &uv, BrepSurface::point)
    }

    fn normals<'py>(
        &self,
        py: Python<'py>,
        uv: PyReadonlyArray2<f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let side = if self.face().forward { 1.0 } else { -1.0 };
        self.at(py, &uv, |surface, u, v| {
            let [_, su, sv] = surface.tangents(u, v);
            let cross = [0, 1, 2].map(|k| {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                side * (su[i] * sv[j] - su[j] * sv[i])
            });
            let length = cross.iter().map(|x| x * x).sum::<f64>().sqrt();
            cross.map(|x| x / length)
        })
    }
}

/// Degree, knots and control points of a spline or a line. An ellipse has the degree 0, the range of its angle, and
/// its centre and axes.
type Curve<'py> = (usize, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

/// An edge in the parameter plane and in space, and whether its loop runs along it.
type Arc<'py> = (Curve<'py>, Curve<'py>, bool);

fn curve<'py, const D: usize>(py: Python<'py>, curve: &BoundedCurve<D>) -> PyResult<Curve<'py>> {
    let (low, high) = curve.range();
    let (degree, knots, points) = match curve {
        BoundedCurve::Spline(spline) => {
            (spline.knots().degree(), spline.knots().knots().to_vec(), spline.poles().to_vec())
        }
        BoundedCurve::Ellipse(ellipse) => {
            let ([x, y], [a, b]) = (ellipse.axes(), ellipse.radii());
            (0, vec![low, high], vec![ellipse.centre(), x.map(|e| a * e), y.map(|e| b * e)])
        }
        _ => (1, vec![low, low, high, high], curve.ends().to_vec()),
    };
    let points: Vec<Vec<f64>> = points.iter().map(|p| p.to_vec()).collect();
    Ok((degree, PyArray1::from_vec(py, knots), PyArray2::from_vec2(py, &points)?))
}
