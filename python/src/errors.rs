//! Errors of the library as exceptions of Python.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use scan2step::Error;

/// What stops a task.
pub enum Failure {
    /// An error of the library.
    Error(Error),
    /// A fault of scan2step itself, such as a panic.
    Internal(String),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Failure::Error(error)
    }
}

impl From<scan2step::formats::Error> for Failure {
    fn from(error: scan2step::formats::Error) -> Self {
        Failure::Error(error.into())
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Failure::Internal(error.to_string())
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        Python::attach(|py| exception(py, &failure).unwrap_or_else(|error| error))
    }
}

/// The exception of a failure. Its class is one of `scan2step._errors`.
fn exception(py: Python, failure: &Failure) -> PyResult<PyErr> {
    let places = PyDict::new(py);
    let (class, message, help) = match failure {
        Failure::Internal(what) => {
            ("InternalError", what.clone(), "please report this scan as a bug".to_owned())
        }
        Failure::Error(error) => {
            set_places(&places, error)?;
            (class(error), error.to_string(), error.help())
        }
    };
    let class = py.import("scan2step._errors")?.getattr(class)?;
    Ok(PyErr::from_value(class.call((message, help), Some(&places))?))
}

fn class(error: &Error) -> &'static str {
    match error {
        Error::Scan { error, .. } | Error::Piece { error, .. } | Error::Splines { error, .. } => {
            class(error)
        }
        Error::File(_) => "FileError",
        Error::Option { .. } | Error::Component { .. } | Error::Vertex { .. } => "OptionError",
        Error::NotOrientable | Error::NotADisk { .. } => "TopologyError",
        Error::Trim { .. } => "TrimError",
        Error::Fill { .. } => "FillError",
        Error::MaxMemory { .. } => "MemoryBoundError",
        Error::Brep(_) | Error::Input(_) | Error::Threads(_) | Error::Stopped => "InternalError",
        _ => "ScanError",
    }
}

fn set_places(places: &Bound<PyDict>, error: &Error) -> PyResult<()> {
    let at = |p: &scan2step::geometry::Point| (p.x, p.y, p.z);
    match error {
        Error::Scan { error, .. } | Error::Piece { error, .. } | Error::Splines { error, .. } => {
            set_places(places, error)
        }
        Error::File(error) => {
            places.set_item("path", error.file.display().to_string())?;
            places.set_item("place", error.place.map(|place| place.to_string()))
        }
        Error::Option { option, .. } => places.set_item("option", option),
        Error::Component { .. } => places.set_item("option", "component"),
        Error::Folded { at: p, .. } | Error::BodyFolds { at: p, .. } => {
            places.set_item("point", at(p))
        }
        Error::Fill { at: p, .. } => places.set_item("point", at(p)),
        Error::Trim { of, at: p, .. } => {
            places.set_item("point", at(p))?;
            places.set_item("hole", of.hole())
        }
        _ => Ok(()),
    }
}
