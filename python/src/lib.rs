//! What the Python package `scan2step` is made of: the library's functions with arrays of numpy, exceptions of
//! Python, progress and interrupts. The package's own Python files add types, documents and conversions
//! to the objects of other packages.

mod arrays;
mod assembly;
mod conversion;
mod errors;
mod face;
mod options;
mod run;
mod scan;
mod tasks;

/// The compiled part of scan2step. Use the package's functions instead.
#[pyo3::pymodule]
mod _scan2step {
    #[pymodule_export]
    use super::assembly::{Assembly, convert_parts};
    #[pymodule_export]
    use super::conversion::Conversion;
    #[pymodule_export]
    use super::face::Face;
    #[pymodule_export]
    use super::scan::Scan;
    #[pymodule_export]
    use super::tasks::{check, convert, inspect};

    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        use pyo3::prelude::*;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
