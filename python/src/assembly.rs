//! What a file with several parts became.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use scan2step::formats::scene::{NodeId, SceneNode};
use scan2step::formats::{Scene, iges, step};
use scan2step::report::{
    AssemblyReport, AssemblyView, Report, ReportView, ScanSource, Settings, ViewRecorder,
    assembly_png,
};
use scan2step::{AssemblyConversion, Error, Memory, Options, SceneParts, Stage, formats};

use crate::conversion::{Conversion, iges_options, step_options};
use crate::errors::Failure;
use crate::options;
use crate::run::{self, Watch};
use crate::scan::Scan;

/// The result of the conversion of an assembly.
#[pyclass(frozen, module = "scan2step._scan2step")]
pub struct Assembly {
    assembly: formats::Assembly,
    report: AssemblyReport,
    view: AssemblyView,
    /// What each part became, if it could be converted.
    parts: Vec<Option<Py<Conversion>>>,
    nodes: Vec<Node>,
    /// The scan's file without its folder.
    file: String,
}

/// A node of the tree: its parent, its name, and the numbers of a part and of its place if one is there.
type Node = (Option<usize>, String, Option<[usize; 2]>);

/// What a conversion made, before it has objects of Python.
struct Made {
    assembly: formats::Assembly,
    report: AssemblyReport,
    view: AssemblyView,
    parts: Vec<Option<Conversion>>,
    nodes: Vec<Node>,
    file: String,
}

#[pymethods]
impl Assembly {
    #[getter]
    fn part_count(&self) -> usize {
        self.parts.len()
    }

    fn part(&self, py: Python, number: usize) -> Option<Py<Conversion>> {
        self.parts.get(number)?.as_ref().map(|part| part.clone_ref(py))
    }

    #[getter]
    fn nodes(&self) -> Vec<Node> {
        self.nodes.clone()
    }

    #[getter]
    fn hints(&self) -> Vec<String> {
        self.report.hints.clone()
    }

    fn report_json(&self) -> String {
        self.report.to_json()
    }

    fn step<'py>(
        &self,
        py: Python<'py>,
        schema: &str,
        time_stamp: String,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let options = step_options(schema, time_stamp)?;
        let bytes = run::run(py, None, None, |_| {
            let mut bytes = Vec::new();
            step::write_assembly(&self.assembly, &options, &mut bytes)?;
            Ok(bytes)
        })?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn iges<'py>(
        &self,
        py: Python<'py>,
        form: &str,
        time_stamp: String,
        file_name: String,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let options = iges_options(form, time_stamp, file_name)?;
        let bytes = run::run(py, None, None, |_| {
            let mut bytes = Vec::new();
            iges::write_assembly(&self.assembly, &options, &mut bytes)?;
            Ok(bytes)
        })?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn html(&self, py: Python) -> PyResult<String> {
        run::run(py, None, None, |_| {
            let still = assembly_png(&self.file, &self.view)?;
            let mut bytes = Vec::new();
            self.report.write_html(&self.view, &still, &mut bytes)?;
            String::from_utf8(bytes).map_err(|e| Failure::Internal(e.to_string()))
        })
    }

    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = run::run(py, None, None, |_| Ok(assembly_png(&self.file, &self.view)?))?;
        Ok(PyBytes::new(py, &bytes))
    }
}

/// Converts the parts of a scan. `None` if it has none: it is a cloud or one mesh, or, unless `keep`, not all of its meshes
/// are closed. `strict` makes the error of a part that of all.
#[pyfunction]
pub fn convert_parts(
    py: Python,
    scan: &Bound<Scan>,
    options: &Bound<PyDict>,
    chosen: (bool, bool, String),
    progress: Option<&Bound<PyAny>>,
) -> PyResult<Option<Assembly>> {
    let (keep, strict, up) = chosen;
    let named = options::named(options)?;
    let up = options::word("up", &up, &[("keep", "keep"), ("y", "y"), ("z", "z")])?;
    let scan = scan.get();
    let Some(scene) = scan.scene.clone() else { return Ok(None) };
    let settings = |settings: Settings| settings.of_scene(keep.then(|| "keep".into()), strict, up);
    let made = run::run(py, named.threads(), progress, |watch| {
        converted(scan, scene, &named, (keep, strict, &settings, watch))
    })?;
    let Some(Made { assembly, report, view, parts, nodes, file }) = made else { return Ok(None) };
    let parts = parts.into_iter().map(|part| part.map(|part| Py::new(py, part)).transpose());
    let parts = parts.collect::<PyResult<_>>()?;
    Ok(Some(Assembly { assembly, report, view, parts, nodes, file }))
}

/// What the stages of one part showed.
#[derive(Default)]
struct Seen {
    /// What pictures of the part and of the whole are made of.
    recorders: Vec<[ViewRecorder; 2]>,
    views: Vec<ReportView>,
    component: usize,
}

impl Seen {
    fn see(&mut self, stage: &Stage, parts: usize) -> scan2step::Result<()> {
        match stage {
            Stage::Component(number) => self.component = *number,
            Stage::Begin { components, .. } => {
                (self.component, self.views) = (0, Vec::new());
                self.recorders.clear();
                self.recorders.resize_with(*components, Default::default);
            }
            _ => {}
        }
        let count = self.recorders.len();
        if let Some([own, of_whole]) = self.recorders.get_mut(self.component) {
            own.see(stage);
            of_whole.see(stage);
            if let Stage::Done(body) = stage {
                self.views.push(std::mem::take(of_whole).view(body, parts * count)?);
            }
        }
        Ok(())
    }
}

type Chosen<'a> = (bool, bool, &'a (dyn Fn(Settings) -> Settings + Sync), &'a Watch<'a>);

fn converted(
    scan: &Scan,
    scene: Scene,
    named: &Options,
    (keep, strict, settings, watch): Chosen,
) -> Result<Option<Made>, Failure> {
    let begin = Instant::now();
    if let Some(most) = named.max_memory() {
        let memory = Memory { is_drawn: true, ..Memory::of_scene(&scene, named) };
        memory.check(most)?;
    }
    let parts = SceneParts::of(scene, named)?;
    if !keep && !parts.are_bodies(named)? {
        return Ok(None);
    }
    let parts = match named.keeps_all() {
        true => parts,
        false => SceneParts::of(scan2step::cropped(parts.into_scene(), named)?, named)?,
    };
    let seen: Vec<Mutex<Seen>> = (0..parts.count()).map(|_| Mutex::default()).collect();
    let done = std::sync::atomic::AtomicUsize::new(0);
    let name = named.name().to_owned();
    let count = seen.len();
    let tell = Mutex::new(watch);
    let (scene, made) = scan2step::convert_scene(parts, named, &name, &|part, stage| {
        seen[part].lock().unwrap_or_else(PoisonError::into_inner).see(&stage, count)?;
        let before = match stage {
            Stage::Done(_) => done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1,
            _ => done.load(std::sync::atomic::Ordering::Relaxed),
        };
        let share = (before as f64 / count.max(1) as f64).min(1.0);
        tell.lock().unwrap_or_else(PoisonError::into_inner).tell("parts", share)
    })?;
    let (mut views, mut recorders) = (Vec::new(), Vec::new());
    for seen in seen {
        let seen = seen.into_inner().unwrap_or_else(PoisonError::into_inner);
        views.push(seen.views);
        recorders.push(seen.recorders.into_iter().map(|[own, _]| own).collect::<Vec<_>>());
    }
    let file = std::path::Path::new(&scan.file);
    let file = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
    let soup = scene.meshes().first().map(|mesh| mesh.soup.clone()).unwrap_or_default();
    let of_scan = ScanSource::of(scan.file.clone(), &soup, named);
    let all = settings(Settings::of(named, &of_scan));
    let mut report = AssemblyReport::of(&scene, &made, (&scan.file, named), all);
    report.seconds = begin.elapsed().as_secs_f64();
    let view = AssemblyView::of(&scene, &made, views, named);
    let node = |(number, node): (usize, &SceneNode)| {
        let name = scene.name(NodeId(number)).unwrap_or_default().to_owned();
        (node.parent.map(|NodeId(parent)| parent), name, None)
    };
    let mut nodes: Vec<Node> = scene.nodes().iter().enumerate().map(node).collect();
    for (number, part) in made.parts.iter().enumerate().filter(|(_, part)| part.made.is_ok()) {
        for (place, NodeId(node)) in part.part.places.iter().enumerate() {
            nodes[*node].2 = Some([number, place]);
        }
    }
    let AssemblyConversion { assembly, parts, .. } = made;
    let mut objects = Vec::with_capacity(parts.len());
    for (part, recorders) in parts.into_iter().zip(recorders) {
        let mesh = scene.form_mesh(part.part.form);
        let mut made = match part.made {
            Ok(made) => made,
            Err(error) if strict => return Err(error.into()),
            Err(_) => {
                objects.push(None);
                continue;
            }
        };
        made.colour = part.colours.part;
        let source = ScanSource::of(scan.file.clone(), &mesh.soup, named);
        let report = Report::of(&made, &source, settings(Settings::of(named, &source)));
        let vertices = mesh.soup.points.len();
        let (recorders, views) = (Mutex::new(recorders), Mutex::new(None));
        let file = file.clone();
        objects.push(Some(Conversion { made, report, file, vertices, recorders, views }));
    }
    let assembly = assembly.ok_or(Error::Input("none of the parts can be converted"))?;
    Ok(Some(Made { assembly, report, view, parts: objects, nodes, file }))
}
