//! What a scan became.

use std::sync::Mutex;

use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use scan2step::Body;
use scan2step::deviation::Deviation;
use scan2step::formats::{Brep, iges, step};
use scan2step::geometry::Point;
use scan2step::report::{Report, ReportView, ViewRecorder, picture_png};

use crate::errors::Failure;
use crate::face::Face;
use crate::{arrays, options, run};

/// The result of a conversion.
#[pyclass(frozen, module = "scan2step._scan2step")]
pub struct Conversion {
    pub made: scan2step::Conversion,
    pub report: Report,
    /// The scan's file without its folder.
    pub file: String,
    /// The number of vertices of the scan, or of points of a cloud.
    pub vertices: usize,
    /// What the views of pictures are made of. It is taken when the views are made.
    pub recorders: Mutex<Vec<ViewRecorder>>,
    pub views: Mutex<Option<Vec<ReportView>>>,
}

impl Conversion {
    /// The model of the only part.
    pub fn brep(&self) -> &Brep {
        &self.made.parts[0].brep
    }

    fn bodies(&self) -> impl Iterator<Item = &Body> {
        self.made.bodies()
    }

    /// The signed distance of each vertex of the scan. It is not a number where a vertex belongs to no part.
    fn by_vertex(&self, of: fn(&Body) -> Vec<f64>) -> Vec<f64> {
        let mut all = vec![f64::NAN; self.vertices];
        for body in self.bodies() {
            let distances = of(body);
            for (vertex, distance) in all.iter_mut().enumerate() {
                let point = body.point_of(vertex).and_then(|point| distances.get(point));
                *distance = point.copied().unwrap_or(*distance);
            }
        }
        all
    }

    fn reporting<R>(
        &self,
        write: impl FnOnce(&Report, &[ReportView], &[u8]) -> std::io::Result<R>,
    ) -> Result<R, Failure> {
        let poisoned = || Failure::Internal("the views were lost in an earlier panic".into());
        let mut views = self.views.lock().map_err(|_| poisoned())?;
        if views.is_none() {
            let recorders = self.recorders.lock().map_err(|_| poisoned())?.split_off(0);
            *views = Some(self.view(recorders)?);
        }
        let views = views.as_deref().unwrap_or_default();
        let still = picture_png(&self.file, views)?;
        Ok(write(&self.report, views, &still)?)
    }

    fn view(&self, recorders: Vec<ViewRecorder>) -> scan2step::Result<Vec<ReportView>> {
        let count = recorders.len();
        let each = recorders.into_iter().zip(self.bodies());
        each.map(|(recorder, body)| recorder.view(body, count)).collect()
    }
}

/// The number of points whose distances are measured between two looks for Ctrl-C.
const AT_ONCE: usize = 5000;

#[pymethods]
impl Conversion {
    #[getter]
    fn kind(&self) -> &'static str {
        self.bodies().next().map_or("face", |body| body.shape.word())
    }

    #[getter]
    fn tolerance(&self) -> f64 {
        self.bodies().map(|body| body.tolerance).fold(0.0, f64::max)
    }

    #[getter]
    fn tolerance_met(&self) -> bool {
        self.report.bodies.iter().all(|body| body.tolerance_met)
    }

    #[getter]
    fn noise(&self) -> f64 {
        self.bodies().map(|body| body.noise).fold(0.0, f64::max)
    }

    /// Root mean square of the deviation of all points as measured.
    #[getter]
    fn rms(&self) -> f64 {
        let all = || self.bodies().map(|body| &body.deviation);
        let count: usize = all().map(|all| all.distances.len()).sum();
        let square = |all: &Deviation| all.rms.powi(2) * all.distances.len() as f64;
        (all().map(square).sum::<f64>() / count.max(1) as f64).sqrt()
    }

    /// The largest deviation of a point as measured.
    #[getter]
    fn max(&self) -> f64 {
        self.bodies().map(|body| body.deviation.max).fold(0.0, f64::max)
    }

    #[getter]
    fn volume(&self) -> Option<f64> {
        self.bodies().map(Body::volume).sum()
    }

    #[getter]
    fn area(&self) -> f64 {
        let brep = self.brep();
        let shells = 0..brep.shells.len();
        shells.map(|shell| brep.area(scan2step::formats::brep::ShellId(shell))).sum()
    }

    #[getter]
    fn origin(&self) -> [f64; 3] {
        self.bodies().next().map_or([0.0; 3], |body| body.origin)
    }

    #[getter]
    fn placement(&self) -> Option<[[f64; 4]; 3]> {
        self.report.placement
    }

    #[getter]
    fn hints(&self) -> Vec<String> {
        self.report.hints.clone()
    }

    fn report_json(&self) -> String {
        self.report.to_json()
    }

    #[getter]
    fn face_count(&self) -> usize {
        self.brep().faces.len()
    }

    fn face(slf: Bound<Self>, number: usize) -> PyResult<Face> {
        if number >= slf.get().brep().faces.len() {
            return Err(PyIndexError::new_err(format!("there is no face {number}")));
        }
        Ok(Face::new(slf.unbind(), number))
    }

    fn deviations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let signed = |body: &Body| body.deviation.signed().unwrap_or_default();
        PyArray1::from_vec(py, self.by_vertex(signed))
    }

    fn smoothed_deviations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, self.by_vertex(Body::smoothed_distances))
    }

    fn distance<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let points: Vec<Point> = arrays::rows(&points)?.into_iter().map(Point::from).collect();
        if !points.iter().all(|p| p.iter().all(|x| x.is_finite())) {
            return Err(PyValueError::new_err("a point is not finite"));
        }
        let distances = run::run(py, None, None, |watch| {
            let mut distances = Vec::with_capacity(points.len());
            for some in points.chunks(AT_ONCE) {
                watch.tell("distance", distances.len() as f64 / points.len() as f64)?;
                let mut nearest = vec![f64::INFINITY; some.len()];
                for all in self.bodies().map(|body| body.distances(some)) {
                    nearest.iter_mut().zip(all).for_each(|(nearest, d)| *nearest = nearest.min(d));
                }
                distances.extend(nearest);
            }
            Ok(distances)
        })?;
        Ok(PyArray1::from_vec(py, distances))
    }

    fn step<'py>(
        &self,
        py: Python<'py>,
        schema: &str,
        colour: Option<[u8; 3]>,
        time_stamp: String,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let colour = colour.or(self.made.colour);
        let options = step::Options { colour, ..step_options(schema, time_stamp)? };
        let bytes = run::run(py, None, None, |_| {
            let mut bytes = Vec::new();
            step::write(self.brep(), &options, &mut bytes)?;
            Ok(bytes)
        })?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn iges<'py>(
        &self,
        py: Python<'py>,
        form: &str,
        colour: Option<[u8; 3]>,
        time_stamp: String,
        file_name: String,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let colour = colour.or(self.made.colour);
        let options = iges::Options { colour, ..iges_options(form, time_stamp, file_name)? };
        let bytes = run::run(py, None, None, |_| {
            let mut bytes = Vec::new();
            iges::write(self.brep(), &options, &mut bytes)?;
            Ok(bytes)
        })?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn html(&self, py: Python) -> PyResult<String> {
        run::run(py, None, None, |_| {
            let bytes = self.reporting(|report, views, still| {
                let mut bytes = Vec::new();
                report.write_html(views, still, &mut bytes)?;
                Ok(bytes)
            })?;
            String::from_utf8(bytes).map_err(|e| Failure::Internal(e.to_string()))
        })
    }

    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = run::run(py, None, None, |_| self.reporting(|_, _, still| Ok(still.to_vec())))?;
        Ok(PyBytes::new(py, &bytes))
    }
}

/// The options of a STEP file without a colour.
pub fn step_options(schema: &str, time_stamp: String) -> PyResult<step::Options> {
    let schemas = [
        ("ap203", step::Schema::Ap203),
        ("ap214", step::Schema::Ap214),
        ("ap242", step::Schema::Ap242),
    ];
    let schema = options::word("schema", schema, &schemas)?;
    let originating_system = system();
    Ok(step::Options { schema, time_stamp, originating_system, ..Default::default() })
}

/// The options of an IGES file without a colour.
pub fn iges_options(form: &str, time_stamp: String, file_name: String) -> PyResult<iges::Options> {
    let forms = [("trimmed", iges::Form::Trimmed), ("brep", iges::Form::Brep)];
    let form = options::word("form", form, &forms)?;
    let originating_system = system();
    Ok(iges::Options { form, time_stamp, file_name, originating_system, ..Default::default() })
}

/// The system that files name as theirs.
fn system() -> String {
    format!("scan2step {}", env!("CARGO_PKG_VERSION"))
}
