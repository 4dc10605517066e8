//! One face of a conversion.

use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use scan2step::formats::brep::{self, BrepCurve, BrepSurface, PCurve};
use scan2step::formats::spline::{SplineCurve, SplineSurface};

use crate::arrays;
use crate::conversion::Conversion;

/// A trimmed B-spline face.
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

    fn surface(&self) -> &SplineSurface {
        match &self.conversion.get().brep().surfaces[self.face().surface.0] {
            BrepSurface::Spline(surface) => surface,
            _ => unreachable!("the pipeline makes splines only"),
        }
    }

    /// An array of a row for each parameter point.
    fn at<'py>(
        &self,
        py: Python<'py>,
        uv: &PyReadonlyArray2<f64>,
        row: impl Fn(&SplineSurface, f64, f64) -> [f64; 3],
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (surface, uv) = (self.surface(), uv.as_array());
        if uv.ncols() != 2 {
            return Err(PyValueError::new_err("parameter points have 2 coordinates each"));
        }
        let (us, vs) = (surface.u().range(), surface.v().range());
        let inside = |x: f64, (low, high): (f64, f64)| (low..=high).contains(&x);
        if !uv.rows().into_iter().all(|p| inside(p[0], us) && inside(p[1], vs)) {
            return Err(PyValueError::new_err("a parameter point is outside of the surface"));
        }
        let rows: Vec<_> = uv.rows().into_iter().map(|p| row(surface, p[0], p[1])).collect();
        arrays::points(py, &rows)
    }
}

#[pymethods]
impl Face {
    #[getter]
    fn control_points<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let surface = slf.get().surface();
        arrays::net(slf, surface.poles(), [surface.u().poles(), surface.v().poles()])
    }

    #[getter]
    fn knots_u<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        arrays::view(slf, slf.get().surface().u().knots())
    }

    #[getter]
    fn knots_v<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        arrays::view(slf, slf.get().surface().v().knots())
    }

    #[getter]
    fn degree(&self) -> (usize, usize) {
        (self.surface().u().degree(), self.surface().v().degree())
    }

    /// For each loop its arcs: the curve in the parameter plane, the curve in space, and whether the loop runs
    /// along them.
    #[getter]
    fn loops<'py>(&self, py: Python<'py>) -> PyResult<Vec<Vec<Arc<'py>>>> {
        let brep = self.conversion.get().brep();
        let arc = |used: &brep::EdgeUse| {
            let BrepCurve::Spline(edge) = &brep.edges[used.edge.0].curve else {
                unreachable!("the pipeline makes splines only")
            };
            let PCurve::Spline(pcurve) = &used.pcurve else {
                unreachable!("the pipeline makes splines only")
            };
            Ok((curve(py, pcurve)?, curve(py, edge)?, used.forward))
        };
        let ring = |ring: &Vec<brep::EdgeUse>| ring.iter().map(arc).collect();
        self.face().loops.iter().map(ring).collect()
    }

    fn points<'py>(
        &self,
        py: Python<'py>,
        uv: PyReadonlyArray2<f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.at(py, &uv, SplineSurface::point)
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

/// Degree, knots and control points of a curve.
type Curve<'py> = (usize, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

/// An edge in the parameter plane and in space, and whether its loop runs along it.
type Arc<'py> = (Curve<'py>, Curve<'py>, bool);

fn curve<'py, const D: usize>(py: Python<'py>, spline: &SplineCurve<D>) -> PyResult<Curve<'py>> {
    let poles: Vec<Vec<f64>> = spline.poles().iter().map(|pole| pole.to_vec()).collect();
    let knots = PyArray1::from_slice(py, spline.knots().knots());
    Ok((spline.knots().degree(), knots, PyArray2::from_vec2(py, &poles)?))
}
