//! Arrays of numpy: copied in, and views out.

use numpy::ndarray::{ArrayView1, ArrayView2, ArrayView3, ShapeError};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Rows of three numbers.
pub fn rows(array: &PyReadonlyArray2<f64>) -> PyResult<Vec<[f64; 3]>> {
    let array = array.as_array();
    if array.ncols() != 3 {
        let found = array.ncols();
        return Err(PyValueError::new_err(format!("points have 3 coordinates each, not {found}")));
    }
    Ok(array.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect())
}

fn unshaped(error: ShapeError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// An array of its own with three columns.
pub fn points<'py>(py: Python<'py>, points: &[[f64; 3]]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let view = ArrayView2::from_shape((points.len(), 3), points.as_flattened());
    Ok(PyArray2::from_array(py, &view.map_err(unshaped)?))
}

/// A read-only view of numbers that `owner` keeps.
///
/// `numbers` must be a part of what `owner` keeps, and must never change or move.
pub fn view<'py, T>(owner: &Bound<'py, T>, numbers: &[f64]) -> Bound<'py, PyArray1<f64>> {
    let view = ArrayView1::from(numbers);
    // SAFETY: the array holds a reference to `owner`, so that the numbers live as long as it. They belong to
    // a frozen class, which never changes them, and the array is made read-only.
    let array = unsafe { PyArray1::borrow_from_array(&view, owner.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    array
}

/// A read-only view of a net of points that `owner` keeps, as [`view`].
pub fn net<'py, T>(
    owner: &Bound<'py, T>,
    points: &[[f64; 3]],
    [rows, columns]: [usize; 2],
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let view = ArrayView3::from_shape((rows, columns, 3), points.as_flattened());
    let view = view.map_err(unshaped)?;
    // SAFETY: as in `view`.
    let array = unsafe { PyArray3::borrow_from_array(&view, owner.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    Ok(array)
}
