//! The functions of the package: convert, inspect, check.

use std::path::PathBuf;
use std::sync::Mutex;
use std::time::Instant;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use scan2step::formats::{Content, cad};
use scan2step::mesh::Components;
use scan2step::report::{
    CheckFigures, InspectionFigures, MeasuredComponents, Report, ScanSource, Settings,
    StageFigures, ViewRecorder,
};
use scan2step::{Memory, Options, Stage, report, rules};

use crate::conversion::Conversion;
use crate::errors::Failure;
use crate::options;
use crate::run::{self, Watch};
use crate::scan::Scan;

/// Converts a scan.
#[pyfunction]
pub fn convert(
    py: Python,
    scan: &Bound<Scan>,
    options: &Bound<PyDict>,
    progress: Option<&Bound<PyAny>>,
) -> PyResult<Conversion> {
    let named = options::named(options)?;
    let scan = scan.get();
    run::run(py, named.threads(), progress, |watch| converted(scan, &named, watch))
}

/// The scan's mesh with what is known of it.
struct Meshed {
    components: Components,
    source: ScanSource,
    options: Options,
}

fn meshed(scan: &Scan, options: &Options, watch: &Watch) -> Result<Meshed, Failure> {
    let file = scan.file.clone();
    match &scan.content {
        Content::Mesh(soup) => {
            let source = ScanSource::of(file, soup, options);
            let options = options.resolved(soup)?;
            let components = scan2step::mesh_components(soup, &options)?;
            Ok(Meshed { components, source, options })
        }
        Content::Points(cloud) => {
            let source = ScanSource::of_cloud(file, cloud, options);
            let options = options.resolved_in_cloud(cloud)?;
            let mut progress = |share| watch.tell("cloud", share);
            let cloud = cloud.clone();
            let (components, report) = scan2step::cloud_components(cloud, &options, &mut progress)?;
            Ok(Meshed { components, source: source.meshed(&report), options })
        }
    }
}

/// The times of stages, and what pictures show, while a conversion runs.
struct Recorded {
    last: Instant,
    stages: Vec<StageFigures>,
    recorders: Vec<ViewRecorder>,
    /// The position of the component whose stages run.
    component: usize,
}

impl Recorded {
    fn see(&mut self, stage: &Stage) {
        match stage {
            Stage::Component(number) => self.component = *number,
            Stage::Begin { components, .. } => {
                self.recorders.clear();
                self.recorders.resize_with(*components, ViewRecorder::default);
            }
            Stage::Within(..) | Stage::Done(_) => {}
            _ => {
                let seconds = self.last.elapsed().as_secs_f64();
                let name = stage.name().to_owned();
                self.stages.push(StageFigures { name, seconds, peak_rss_mb: 0.0 });
                self.last = Instant::now();
            }
        }
        if let Some(recorder) = self.recorders.get_mut(self.component) {
            recorder.see(stage);
        }
    }
}

fn converted(scan: &Scan, named: &Options, watch: &Watch) -> Result<Conversion, Failure> {
    let begin = Instant::now();
    let Meshed { components, source, options } = meshed(scan, &fitting(scan, named)?, watch)?;
    let recorders = Vec::new();
    let mut recorded = Recorded { last: begin, stages: Vec::new(), recorders, component: 0 };
    let mut made = scan2step::convert(&components, &options, &mut |stage| {
        recorded.see(&stage);
        match stage {
            Stage::Within(name, share) => watch.tell(name, share),
            stage => watch.tell(stage.name(), 1.0),
        }
    })?;
    let mut report = Report::of(&made, &source, Settings::of(named, &source));
    report.stages = recorded.stages;
    report.seconds = begin.elapsed().as_secs_f64();
    let (colour, vertices) = match &scan.content {
        Content::Mesh(soup) => (soup.colour, soup.points.len()),
        Content::Points(cloud) => (None, cloud.len()),
    };
    made.colour = colour;
    let file = std::path::Path::new(&scan.file);
    let file = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
    let (recorders, views) = (Mutex::new(recorded.recorders), Mutex::new(None));
    Ok(Conversion { made, report, file, vertices, recorders, views })
}

/// The same options, with which the conversion needs no more memory than they allow.
fn fitting(scan: &Scan, options: &Options) -> Result<Options, Failure> {
    let Some(most) = options.max_memory() else { return Ok(options.clone()) };
    let memory = match &scan.content {
        Content::Mesh(soup) => Memory::of(soup, options),
        Content::Points(cloud) => Memory::of_cloud(cloud.len(), options),
    };
    Ok(options.fitting(&Memory { is_drawn: true, may_be_body: true, ..memory }, most)?)
}

/// Looks at a scan. Returns the JSON text of the program's `inspect --json`.
#[pyfunction]
pub fn inspect(py: Python, scan: &Bound<Scan>, options: &Bound<PyDict>) -> PyResult<String> {
    let named = options::named(options)?;
    let scan = scan.get();
    run::run(py, named.threads(), None, |watch| {
        let Meshed { components, source, options } = meshed(scan, &named, watch)?;
        let found = scan2step::inspect(components, options.component(), options.outer())?;
        Ok(InspectionFigures::of(&found, &source).to_json())
    })
}

/// Measures a CAD file against a scan. Returns the JSON text of the program's `check --json`.
#[pyfunction]
pub fn check(
    py: Python,
    path: PathBuf,
    scan: &Bound<Scan>,
    options: &Bound<PyDict>,
    placement: Option<[[f64; 4]; 3]>,
    tolerance: Option<f64>,
    outliers: f64,
) -> PyResult<String> {
    let named = options::named(options)?;
    let placement = placement.map(report::placement_of_rows);
    let of = |option| move |fault| Failure::from(scan2step::Error::Option { option, fault });
    tolerance.map_or(Ok(()), rules::length).map_err(of("tolerance"))?;
    rules::share(outliers).map_err(of("outliers"))?;
    let scan = scan.get();
    run::run(py, named.threads(), None, |watch| {
        let model = cad::read_cad(&path)?;
        let Meshed { components, source, options } = meshed(scan, &named, watch)?;
        let chosen = options.chosen(&components);
        let measured = scan2step::measured(&components, &chosen, options.outer())?;
        let parts = MeasuredComponents {
            all: components.count(),
            measured: chosen.len(),
            left_out: measured.left_out,
        };
        drop(components);
        let measured = match (placement, options.keeps_origin()) {
            (Some(by), _) => measured.translated(source.origin_mm).placed(&by),
            (None, true) => measured.translated(source.origin_mm),
            (None, false) => measured,
        };
        let found = scan2step::check::check(&model, &measured.mesh, measured.points.as_deref())?;
        let cad = (path.display().to_string(), &model);
        Ok(CheckFigures::of(&found, cad, (&source, parts), tolerance, 100.0 * outliers).to_json())
    })
}
