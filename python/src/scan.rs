//! Scans: read from files, or made of arrays.

use std::path::PathBuf;

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use scan2step::formats::points::{PointScan, ReadOptions};
use scan2step::formats::scene::UpAxis;
use scan2step::formats::{Content, LengthUnit, Points, Scene, SceneContent, Soup};

use crate::{arrays, run};

/// A scan as it was read: a mesh or a cloud of points.
#[pyclass(frozen, module = "scan2step._scan2step")]
pub struct Scan {
    pub content: Content,
    /// The scene of a file with several meshes or groups.
    pub scene: Option<Scene>,
    /// Whether y points up in its format.
    pub is_y_up: bool,
    /// The file's name, or a name for arrays.
    pub file: String,
}

#[pymethods]
impl Scan {
    /// Reads a scan.
    #[staticmethod]
    fn read(
        py: Python,
        path: PathBuf,
        classes: Vec<u8>,
        min_intensity: Option<f64>,
        columns: Option<&str>,
    ) -> PyResult<Self> {
        let columns =
            columns.map(str::parse).transpose().map_err(PyValueError::new_err::<String>)?;
        let options = ReadOptions { classes, min_intensity, columns };
        let (content, scene, is_y_up) = run::run(py, None, None, |_| {
            let content = options.read_scene(&path)?;
            let scene = match &content {
                SceneContent::Scene(scene) => {
                    Some(scene.split_groups().unwrap_or_else(|| scene.clone()))
                }
                SceneContent::Points(_) => None,
            };
            let is_y_up = scene.as_ref().is_some_and(|scene| scene.is_y_up);
            let scene = scene.filter(|scene| scene.place_count() > 1);
            Ok((content.into_content()?, scene, is_y_up))
        })?;
        Ok(Scan { content, scene, is_y_up, file: path.display().to_string() })
    }

    /// Makes a mesh of vertices and polygons.
    #[staticmethod]
    fn mesh(
        vertices: PyReadonlyArray2<f64>,
        faces: PyReadonlyArray2<u32>,
        file: String,
    ) -> PyResult<Self> {
        let mut soup = Soup { points: arrays::rows(&vertices)?, ..Soup::default() };
        let (faces, count) = (faces.as_array(), soup.points.len());
        if faces.ncols() < 3 {
            return Err(PyValueError::new_err("faces have at least 3 vertices each"));
        }
        if let Some(index) = faces.iter().find(|&&index| index as usize >= count) {
            let message = format!("a face has vertex {index}, and there are {count} vertices");
            return Err(PyValueError::new_err(message));
        }
        faces.rows().into_iter().for_each(|row| soup.polygons.push(row.iter().copied()));
        Ok(Scan { content: Content::Mesh(soup), scene: None, is_y_up: false, file })
    }

    /// Makes a cloud of points.
    #[staticmethod]
    fn cloud(points: PyReadonlyArray2<f64>, file: String) -> PyResult<Self> {
        let positions = arrays::rows(&points)?;
        if !positions.iter().flatten().all(|x| x.is_finite()) {
            return Err(PyValueError::new_err("a point is not finite"));
        }
        let scan = PointScan { points: 0..positions.len(), ..PointScan::default() };
        let cloud = Points { positions, scans: vec![scan], ..Points::default() };
        Ok(Scan { content: Content::Points(cloud), scene: None, is_y_up: false, file })
    }

    /// The vertices of a mesh, or the points of a cloud, in the file's unit.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        match &self.content {
            Content::Mesh(soup) => arrays::points(py, &soup.points),
            Content::Points(cloud) => {
                let all: Vec<_> = (0..cloud.len()).map(|index| cloud.absolute(index)).collect();
                arrays::points(py, &all)
            }
        }
    }

    /// The triangles of a mesh, with polygons cut into fans.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<u32>>>> {
        let Content::Mesh(soup) = &self.content else { return Ok(None) };
        let count = soup.polygons.triangle_count();
        let mut indices = Vec::with_capacity(3 * count);
        for corners in soup.polygons.iter() {
            let pairs = corners.get(1..).unwrap_or_default().windows(2);
            indices.extend(pairs.flat_map(|pair| [corners[0], pair[0], pair[1]]));
        }
        Ok(Some(PyArray1::from_vec(py, indices).reshape([count, 3])?))
    }

    /// The unit that the file declares.
    #[getter]
    fn unit(&self) -> Option<&'static str> {
        let unit = match &self.content {
            Content::Mesh(soup) => soup.unit,
            Content::Points(cloud) => cloud.unit,
        };
        unit.map(LengthUnit::symbol)
    }

    /// The mean colour of the vertices.
    #[getter]
    fn colour(&self) -> Option<(u8, u8, u8)> {
        match &self.content {
            Content::Mesh(soup) => soup.colour.map(|[r, g, b]| (r, g, b)),
            Content::Points(_) => None,
        }
    }

    /// The scan turned so that an axis points up. Clouds are not turned.
    fn turned(&self, up: &str) -> PyResult<Scan> {
        let up = crate::options::word("up", up, &[("y", UpAxis::Y), ("z", UpAxis::Z)])?;
        let mut content = self.content.clone();
        let is_y = up == UpAxis::Y;
        if let (Content::Mesh(soup), true) = (&mut content, is_y != self.is_y_up) {
            for point in &mut soup.points {
                let [x, y, z] = *point;
                *point = if is_y { [x, z, -y] } else { [x, -z, y] };
            }
        }
        let scene = self.scene.clone().map(|scene| scene.with_up(up));
        Ok(Scan { content, scene, is_y_up: is_y, file: self.file.clone() })
    }

    /// The points of the scan without the triangles between them.
    fn points_alone(&self) -> Scan {
        let content = match &self.content {
            Content::Mesh(soup) => Content::Points(Points::of_mesh(soup)),
            Content::Points(cloud) => Content::Points(cloud.clone()),
        };
        Scan { content, scene: None, is_y_up: self.is_y_up, file: self.file.clone() }
    }

    /// The number of places of meshes in the file.
    #[getter]
    fn place_count(&self) -> usize {
        self.scene.as_ref().map_or(1, Scene::place_count)
    }

    /// What the user should know about how the file was read.
    #[getter]
    fn notes(&self) -> Vec<String> {
        match &self.content {
            Content::Mesh(_) => Vec::new(),
            Content::Points(cloud) => cloud.remarks(),
        }
    }

    #[getter]
    fn file(&self) -> &str {
        &self.file
    }
}
