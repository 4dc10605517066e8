//! The options of a conversion, by their names in Python.

use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use scan2step::formats::LengthUnit;
use scan2step::mesh::Choice;
use scan2step::stages::{fit, parameterize, smooth};
use scan2step::{Builder, Cut, EdgeChoice, Options, ScanPlace, SurfaceChoice, TargetShape};

use crate::errors::Failure;

/// The options that a dictionary names. Words are checked here, and numbers by the library.
pub fn named(values: &Bound<PyDict>) -> PyResult<Options> {
    let py = values.py();
    let mut builder = Options::builder();
    for (key, value) in values {
        let key: String = key.extract()?;
        if key == "component" && value.extract::<String>().is_ok_and(|word| word == "all") {
            builder = builder.all_components(true);
        } else {
            builder = set(builder, &key, &value).map_err(|error| told(py, &key, error))?;
        }
    }
    Ok(builder.build().map_err(Failure::from)?)
}

/// The error of a value with the name of its option.
fn told(py: Python, option: &str, error: PyErr) -> PyErr {
    let value = error.value(py).to_string();
    if error.is_instance_of::<PyOverflowError>(py) {
        return wrong(option, &format!("{option}: {value}"), "give another value");
    }
    if error.is_instance_of::<PyTypeError>(py) {
        return PyTypeError::new_err(format!("{option}: {value}"));
    }
    // Not one of its subclasses, which name the option already.
    if error.get_type(py).is(py.get_type::<PyValueError>()) {
        return PyValueError::new_err(format!("{option}: {value}"));
    }
    error
}

/// An `OptionError`.
fn wrong(option: &str, message: &str, help: &str) -> PyErr {
    Python::attach(|py| {
        let raise = || -> PyResult<PyErr> {
            let class = py.import("scan2step._errors")?.getattr("OptionError")?;
            let named = PyDict::new(py);
            named.set_item("option", option)?;
            Ok(PyErr::from_value(class.call((message, help), Some(&named))?))
        };
        raise().unwrap_or_else(|error| error)
    })
}

fn set(builder: Builder, key: &str, value: &Bound<PyAny>) -> PyResult<Builder> {
    Ok(match key {
        "name" => builder.name(value.extract::<String>()?),
        "units" => match value.extract::<Option<String>>()? {
            None => builder,
            Some(unit) => builder.unit(word(
                "units",
                &unit,
                &[
                    ("mm", LengthUnit::Millimetre),
                    ("cm", LengthUnit::Centimetre),
                    ("m", LengthUnit::Metre),
                    ("in", LengthUnit::Inch),
                    ("ft", LengthUnit::Foot),
                ],
            )?),
        },
        "shape" => {
            let shape = value.extract::<String>()?;
            builder.shape(word(
                "shape",
                &shape,
                &[
                    ("auto", None),
                    ("face", Some(TargetShape::Face)),
                    ("shell", Some(TargetShape::Shell)),
                    ("solid", Some(TargetShape::Solid)),
                ],
            )?)
        }
        "surfaces" => builder.surfaces(word(
            "surfaces",
            &value.extract::<String>()?,
            &[("auto", SurfaceChoice::Auto), ("spline", SurfaceChoice::Spline)],
        )?),
        "keep_polygons" => builder.keep_polygons(value.extract()?),
        "regularize" => builder.regularize(value.extract()?),
        "bias" => builder.bias(value.extract()?),
        "align" => builder.align(value.extract()?),
        "edges" => builder.edges(match value.extract::<f64>() {
            Ok(degrees) => EdgeChoice::Degrees(degrees),
            Err(_) => word(
                "edges",
                &value.extract::<String>()?,
                &[("auto", EdgeChoice::Auto), ("off", EdgeChoice::Off)],
            )?,
        }),
        "face_count" => builder.faces(value.extract::<Option<usize>>()?),
        "remesh" => builder.remesh(value.extract()?),
        "weld" => builder.weld(value.extract::<Option<f64>>()?),
        "handles" => builder.handles(value.extract::<Option<f64>>()?),
        "component" => match value.extract::<usize>() {
            Ok(number) => builder.component(Choice::Number(number)),
            Err(_) => {
                let largest = value.extract::<String>()?;
                let words = [("auto", Choice::Auto), ("largest", Choice::Largest)];
                builder.component(word("component", &largest, &words)?)
            }
        },
        "outer" => builder
            .outer_place(value.extract::<Option<Bound<PyAny>>>()?.map(|v| place(&v)).transpose()?),
        "smooth" => builder.smooth(match value.extract::<f64>() {
            Ok(length) => smooth::Support::Fixed(length),
            Err(_) => word(
                "smooth",
                &value.extract::<String>()?,
                &[("auto", smooth::Support::Auto), ("off", smooth::Support::Off)],
            )?,
        }),
        "boundary_corners" => match value.extract::<String>() {
            Ok(text) => builder.boundary_corners(word(
                "boundary_corners",
                &text,
                &[("auto", smooth::Corners::Auto), ("none", smooth::Corners::None)],
            )?),
            Err(_) => builder.boundary_corner_places(places(value)?),
        },
        "corners" => match value.is_none() {
            true => builder,
            false => builder.corner_places(places(value)?),
        },
        "outline" => builder.outline(word(
            "outline",
            &value.extract::<String>()?,
            &[
                ("auto", None),
                ("sides", Some(parameterize::Outline::Sides)),
                ("trimmed", Some(parameterize::Outline::Free)),
            ],
        )?),
        "map" => builder.map(word(
            "map",
            &value.extract::<String>()?,
            &[
                ("least-stretch", parameterize::MapMethod::LeastStretch),
                ("mean-value", parameterize::MapMethod::MeanValue),
            ],
        )?),
        "kappa" => builder.kappa(value.extract::<Option<f64>>()?),
        "depth" => builder.depth(value.extract::<Option<u32>>()?),
        "net" => builder.net(value.extract::<Option<[usize; 2]>>()?),
        "max_net" => match value.is_none() {
            true => builder,
            false => builder.max_net(value.extract()?),
        },
        "fit" => builder.fit(word(
            "fit",
            &value.extract::<String>()?,
            &[
                ("blend", fit::Method::Blend),
                ("refined", fit::Method::Refined),
                ("global", fit::Method::Global),
            ],
        )?),
        "tolerance" => builder.tolerance(value.extract::<Option<f64>>()?),
        "rim_tolerance" => builder.rim_tolerance(value.extract::<Option<f64>>()?),
        "outliers" => builder.outliers(value.extract()?),
        "keep_fills" => match value.extract::<bool>()? {
            true => builder.cut(Cut::None),
            false => builder,
        },
        "fill_only_holes_below" => match value.extract::<Option<f64>>()? {
            Some(length) => builder.cut(Cut::FromLength(length)),
            None => builder,
        },
        "box" => builder.within(value.extract::<Option<[[f64; 3]; 2]>>()?),
        "above" => builder.above(value.extract::<Option<[f64; 4]>>()?),
        "remove_plane" => builder.without_plane(value.extract()?),
        "spacing" => builder.spacing(value.extract::<Option<f64>>()?),
        "max_points" => builder.max_points(value.extract::<Option<usize>>()?),
        "scan_number" => builder.scan_number(value.extract::<Option<usize>>()?),
        "origin" => builder.keeps_origin(word(
            "origin",
            &value.extract::<String>()?,
            &[("local", false), ("keep", true)],
        )?),
        "threads" => builder.threads(value.extract::<Option<usize>>()?),
        "max_memory" => builder.max_memory(value.extract::<Option<u64>>()?),
        unknown => return Err(PyTypeError::new_err(format!("there is no option {unknown}"))),
    })
}

/// What a word stands for.
pub fn word<T: Clone>(option: &str, given: &str, words: &[(&str, T)]) -> PyResult<T> {
    let found = words.iter().find(|(word, _)| *word == given);
    if let Some((_, value)) = found {
        return Ok(value.clone());
    }
    let words: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
    let message = format!("{option}: {given:?} is not known");
    Err(wrong(option, &message, &format!("name one of {}", words.join(", "))))
}

/// A vertex by its index, or a point.
fn place(value: &Bound<PyAny>) -> PyResult<ScanPlace> {
    match value.extract::<usize>() {
        Ok(vertex) => Ok(ScanPlace::Vertex(vertex)),
        Err(_) => {
            let point: [f64; 3] = value.extract()?;
            if !point.iter().all(|x| x.is_finite()) {
                return Err(PyValueError::new_err("a place has finite coordinates"));
            }
            Ok(ScanPlace::Point(point))
        }
    }
}

fn places(value: &Bound<PyAny>) -> PyResult<Vec<ScanPlace>> {
    value.try_iter()?.map(|each| place(&each?)).collect()
}
