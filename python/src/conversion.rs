//! What a scan became.

use std::sync::Mutex;

use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use scan2step::deviation::{self, Deviation, TrimmedFace};
use scan2step::formats::{Brep, iges, step};
use scan2step::geometry::Point;
use scan2step::report::{BodyReport, Report, ReportView, ViewRecorder, picture_png};
use scan2step::{BodyConversion, Converted};

use crate::errors::Failure;
use crate::face::Face;
use crate::{arrays, options, run};

/// The result of a conversion.
#[pyclass(frozen, module = "scan2step._scan2step")]
pub struct Conversion {
    pub made: Converted,
    pub brep: Brep,
    pub report: AnyReport,
    pub colour: Option<[u8; 3]>,
    /// The scan's file without its folder.
    pub file: String,
    /// The number of vertices of the scan, or of points of a cloud.
    pub vertices: usize,
    /// What the views of pictures are made of. It is taken when the views are made.
    pub recorders: Mutex<Vec<ViewRecorder>>,
    pub views: Mutex<Option<Vec<ReportView>>>,
}

/// The report of faces, or of bodies.
pub enum AnyReport {
    Faces(Box<Report>),
    Bodies(Box<BodyReport>),
}

/// What face and body conversions have in common.
struct Part<'a> {
    tolerance: f64,
    noise: f64,
    fit_deviation: &'a Deviation,
    deviation: &'a Deviation,
    point_of: Box<dyn Fn(usize) -> Option<usize> + 'a>,
}

impl Conversion {
    fn parts(&self) -> Vec<Part<'_>> {
        match &self.made {
            Converted::Faces(faces) => faces
                .iter()
                .map(|face| Part {
                    tolerance: face.tolerance,
                    noise: face.noise,
                    fit_deviation: &face.fit_deviation,
                    deviation: &face.deviation,
                    point_of: Box::new(|vertex| face.point_of(vertex)),
                })
                .collect(),
            Converted::Bodies(bodies) => bodies
                .iter()
                .map(|body| Part {
                    tolerance: body.tolerance,
                    noise: body.noise,
                    fit_deviation: &body.fit_deviation,
                    deviation: &body.deviation,
                    point_of: Box::new(|vertex| body.point_of(vertex)),
                })
                .collect(),
        }
    }

    /// The signed distance of each vertex of the scan. It is not a number where a vertex belongs to no part.
    fn by_vertex(&self, of: fn(&Part) -> Vec<f64>) -> Vec<f64> {
        let mut all = vec![f64::NAN; self.vertices];
        for part in self.parts() {
            let distances = of(&part);
            for (vertex, distance) in all.iter_mut().enumerate() {
                let point = (part.point_of)(vertex).and_then(|point| distances.get(point));
                *distance = point.copied().unwrap_or(*distance);
            }
        }
        all
    }

    fn reporting<R>(
        &self,
        write: impl FnOnce(&AnyReport, &[ReportView], &[u8]) -> std::io::Result<R>,
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
        match &self.made {
            Converted::Faces(faces) => {
                let each = recorders.into_iter().zip(faces);
                each.map(|(recorder, face)| recorder.view(face, count)).collect()
            }
            Converted::Bodies(bodies) => {
                let each = recorders.into_iter().zip(bodies);
                each.map(|(recorder, body)| recorder.view_of_body(body, count)).collect()
            }
        }
    }
}

/// The number of points whose distances are measured between two looks for Ctrl-C.
const AT_ONCE: usize = 5000;

/// The distances of points from bodies.
fn from_bodies(bodies: &[BodyConversion], points: &[Point]) -> Vec<f64> {
    let of =
        |body: &BodyConversion| deviation::of_network(&body.network, &body.cut, points).distances;
    nearest(bodies.iter().map(of), points.len())
}

/// The distances of points from faces.
fn from_faces(faces: &[scan2step::Conversion], points: &[Point]) -> Vec<f64> {
    let of = |face: &scan2step::Conversion| {
        let loops = face.loops.iter().map(|ring| ring.pcurves.as_slice());
        let trimmed = TrimmedFace::new(&face.surface, loops, face.outer.is_some());
        points.iter().map(|&p| trimmed.nearest(p, None).1).collect()
    };
    nearest(faces.iter().map(of), points.len())
}

fn nearest(parts: impl Iterator<Item = Vec<f64>>, count: usize) -> Vec<f64> {
    parts.fold(vec![f64::INFINITY; count], |all, part| {
        all.into_iter().zip(part).map(|(a, b)| a.min(b)).collect()
    })
}

#[pymethods]
impl Conversion {
    #[getter]
    fn kind(&self) -> &'static str {
        match &self.made {
            Converted::Faces(_) => "face",
            Converted::Bodies(bodies) => bodies.first().map_or("solid", |body| body.shape.word()),
        }
    }

    #[getter]
    fn tolerance(&self) -> f64 {
        self.parts().iter().map(|part| part.tolerance).fold(0.0, f64::max)
    }

    #[getter]
    fn tolerance_met(&self) -> bool {
        match &self.report {
            AnyReport::Faces(report) => report.faces.iter().all(|face| face.tolerance_met),
            AnyReport::Bodies(report) => report.solids.iter().all(|solid| solid.tolerance_met),
        }
    }

    #[getter]
    fn noise(&self) -> f64 {
        self.parts().iter().map(|part| part.noise).fold(0.0, f64::max)
    }

    /// Root mean square of the deviation of all points as measured.
    #[getter]
    fn rms(&self) -> f64 {
        let parts = self.parts();
        let count: usize = parts.iter().map(|part| part.deviation.distances.len()).sum();
        let square =
            |part: &Part| part.deviation.rms.powi(2) * part.deviation.distances.len() as f64;
        (parts.iter().map(square).sum::<f64>() / count.max(1) as f64).sqrt()
    }

    /// The largest deviation of a point as measured.
    #[getter]
    fn max(&self) -> f64 {
        self.parts().iter().map(|part| part.deviation.max).fold(0.0, f64::max)
    }

    #[getter]
    fn volume(&self) -> Option<f64> {
        match &self.made {
            Converted::Faces(_) => None,
            Converted::Bodies(bodies) => bodies.iter().map(|body| body.volume).sum(),
        }
    }

    #[getter]
    fn area(&self) -> f64 {
        let shells = 0..self.brep.shells.len();
        shells.map(|shell| self.brep.area(scan2step::formats::brep::ShellId(shell))).sum()
    }

    #[getter]
    fn origin(&self) -> [f64; 3] {
        match &self.made {
            Converted::Faces(faces) => faces.first().map_or([0.0; 3], |face| face.origin),
            Converted::Bodies(bodies) => bodies.first().map_or([0.0; 3], |body| body.origin),
        }
    }

    #[getter]
    fn hints(&self) -> Vec<String> {
        match &self.report {
            AnyReport::Faces(report) => report.hints.clone(),
            AnyReport::Bodies(report) => report.hints.clone(),
        }
    }

    fn report_json(&self) -> String {
        match &self.report {
            AnyReport::Faces(report) => report.to_json(),
            AnyReport::Bodies(report) => report.to_json(),
        }
    }

    #[getter]
    fn face_count(&self) -> usize {
        self.brep.faces.len()
    }

    fn face(slf: Bound<Self>, number: usize) -> PyResult<Face> {
        if number >= slf.get().brep.faces.len() {
            return Err(PyIndexError::new_err(format!("there is no face {number}")));
        }
        Ok(Face::new(slf.unbind(), number))
    }

    fn deviations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let signed = |part: &Part| part.deviation.signed().unwrap_or_default();
        PyArray1::from_vec(py, self.by_vertex(signed))
    }

    fn smoothed_deviations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let signed = |part: &Part| part.fit_deviation.signed().unwrap_or_default();
        PyArray1::from_vec(py, self.by_vertex(signed))
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
                distances.extend(match &self.made {
                    Converted::Faces(faces) => from_faces(faces, some),
                    Converted::Bodies(bodies) => from_bodies(bodies, some),
                });
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
        let schemas = [
            ("ap203", step::Schema::Ap203),
            ("ap214", step::Schema::Ap214),
            ("ap242", step::Schema::Ap242),
        ];
        let options = step::Options {
            schema: options::word("schema", schema, &schemas)?,
            colour: colour.or(self.colour),
            time_stamp,
            originating_system: system(),
        };
        let bytes = run::run(py, None, None, |_| {
            let mut bytes = Vec::new();
            step::write(&self.brep, &options, &mut bytes)?;
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
        let forms = [("trimmed", iges::Form::Trimmed), ("brep", iges::Form::Brep)];
        let options = iges::Options {
            form: options::word("form", form, &forms)?,
            colour: colour.or(self.colour),
            time_stamp,
            file_name,
            originating_system: system(),
        };
        let bytes = run::run(py, None, None, |_| {
            let mut bytes = Vec::new();
            iges::write(&self.brep, &options, &mut bytes)?;
            Ok(bytes)
        })?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn html(&self, py: Python) -> PyResult<String> {
        run::run(py, None, None, |_| {
            let bytes = self.reporting(|report, views, still| {
                let mut bytes = Vec::new();
                match report {
                    AnyReport::Faces(report) => report.write_html(views, still, &mut bytes)?,
                    AnyReport::Bodies(report) => report.write_html(views, still, &mut bytes)?,
                }
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

/// The system that files name as theirs.
fn system() -> String {
    format!("scan2step {}", env!("CARGO_PKG_VERSION"))
}
