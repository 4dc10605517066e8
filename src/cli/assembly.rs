//! `scan2step convert` of a file with several parts.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use formats::Scene;
use scan2step::report::{
    AssemblyReport, AssemblySource, AssemblyView, ReportView, ViewRecorder, assembly_png,
};
use scan2step::words::plural;
use scan2step::{AssemblyConversion, Error, Memory, Options, ScenePart, SceneParts, Stage};

use super::args::Convert;
use super::input::{self, ReadScan};
use super::output::{self, Pending};
use super::progress::{self, ProgressDisplay};
use super::report::{ReportFile, ReportFormat};
use super::stages::Stages;
use super::{Failure, Outcome, cad, convert, messages, settings, streams};

/// What is said of the axes of glTF.
pub(super) const Y_UP: &str =
    "y points up, as in all glTF files; coordinates stay as they are (--up z to turn)";

/// Converts each part, and writes all files.
pub(crate) fn run(
    args: &Convert,
    parts: SceneParts,
    mut progress: ProgressDisplay,
) -> Result<Outcome, Failure> {
    let count = plural(parts.count(), "part");
    let file = args.piece.scan.name.display().to_string();
    let places = plural(parts.scene().place_count(), "place");
    progress.ended("read", &format!("{file}: {count} in {places}"));
    let of_scan = ReadScan::options(&args.piece)?;
    let source = AssemblySource::of(parts.scene(), &file, &of_scan);
    source.notes.iter().for_each(|note| progress.say(&format!("read: {note}")));
    if parts.scene().is_y_up {
        progress.say(&format!("axes: {Y_UP}"));
    }
    let options = settings::options(args)?;
    let stopped = |e| input::stopped(&args.piece.scan.name, &e);
    if let Some(allowed) = args.manner.max_memory {
        let memory = Memory::of_scene(parts.scene(), &options);
        let memory = Memory { is_drawn: convert::is_drawn(args), ..memory };
        memory.check(allowed.as_u64()).map_err(stopped)?;
    }
    let watched = WatchedParts::of(args, &parts)?;
    let made = scan2step::convert_scene(parts, &options, &args.part_name(), &|part, stage| {
        watched.see(part, &stage, &progress)
    });
    let (scene, made) = made.map_err(|e| watched.failure().unwrap_or_else(|| stopped(e)))?;
    progress.ended("parts", "");
    let (views, stages) = watched.into_seen();
    let outcome = say_parts(args, &progress, &made)?;
    let Some(assembly) = &made.assembly else {
        return Err(Failure {
            error: format!("{file}: none of its parts can be converted"),
            help: "convert one of them alone: --parts 0".into(),
        });
    };
    let files = cad::write_assembly(args, assembly)?;
    progress.ended("write", "");
    let settings = settings::of_files(args, &options, &scene);
    let mut report = AssemblyReport::of(&scene, &made, (&file, &options), settings);
    report.hints.extend(loose_surfaces(args, &made));
    report.command.clone_from(&args.again);
    let outputs = args.out.iter().zip(&files);
    report.outputs = outputs.map(|(f, file)| convert::output(&f.path, file)).collect();
    report.seconds = progress.seconds();
    report.peak_rss_mb = progress::peak_rss_mb();
    let view = AssemblyView::of(&scene, &made, views, &options);
    let reports = write_reports(args, &report, &view)?;
    progress.finish();
    Pending::publish(stages.into_iter().chain(reports).chain(files).collect())?;
    let names: Vec<String> = args.out.iter().map(|f| streams::shown(&f.path)).collect();
    progress.result(&format!("{count} in {places} → {}", names.join(", ")));
    report.hints.iter().for_each(|hint| progress.hint(hint));
    Ok(outcome)
}

/// Writes the reports that were asked for under temporary names.
fn write_reports(
    args: &Convert,
    report: &AssemblyReport,
    view: &AssemblyView,
) -> Result<Vec<Pending>, Failure> {
    let mut still = Vec::new();
    if let Some(file) = args.report.iter().find(|file| file.kind.is_picture()) {
        let name = args.piece.scan.name.file_name().unwrap_or_default().to_string_lossy();
        let failed = |e| Failure {
            error: format!("{}: cannot be drawn: {e}", file.path.display()),
            help: "please report this as a bug".into(),
        };
        still = assembly_png(&name, view).map_err(failed)?;
    }
    let content = |kind: ReportFormat, out: &mut dyn Write| match kind {
        ReportFormat::Json => report.write_json(out),
        ReportFormat::Html => report.write_html(view, &still, out),
        ReportFormat::Png => out.write_all(&still),
    };
    let write = |f: &ReportFile| Ok(output::write(&f.path, |out| content(f.kind, out))?);
    args.report.iter().map(write).collect()
}

/// Says so if an IGES file has the faces of parts, but not what joins them.
fn loose_surfaces(args: &Convert, made: &AssemblyConversion) -> Option<String> {
    let mut parts = made.assembly.iter().flat_map(|assembly| &assembly.parts);
    let faces = parts.clone().map(|part| part.brep.faces.len()).sum();
    let are_joined = parts.any(|part| part.brep.faces.len() > 1);
    convert::loose_faces(args, are_joined, faces)
}

/// What the stages of all parts show, while these are converted at once.
struct WatchedParts {
    parts: Vec<Mutex<WatchedPart>>,
    done: Mutex<BTreeSet<usize>>,
    is_drawn: bool,
    /// Why a file of a stage cannot be written.
    failure: Mutex<Option<formats::Error>>,
}

/// What the stages of one part showed.
#[derive(Default)]
struct WatchedPart {
    /// The folder of its files, and the files.
    stages: Option<(PathBuf, Stages)>,
    recorder: ViewRecorder,
    views: Vec<ReportView>,
    /// The number of its components, and the position of the one whose stages run.
    components: usize,
    component: usize,
}

impl WatchedParts {
    /// Makes a folder for the stages of each part.
    fn of(args: &Convert, parts: &SceneParts) -> Result<Self, Failure> {
        let seen = |number: usize| -> Result<Mutex<WatchedPart>, Failure> {
            let folder = args.stages.as_ref().map(|root| root.join(format!("part-{number}")));
            let stages = match folder {
                None => None,
                Some(folder) => Some((folder.clone(), Stages::new(&folder)?)),
            };
            Ok(Mutex::new(WatchedPart { stages, ..WatchedPart::default() }))
        };
        Ok(WatchedParts {
            parts: (0..parts.count()).map(seen).collect::<Result<_, _>>()?,
            done: Mutex::default(),
            is_drawn: convert::is_drawn(args),
            failure: Mutex::default(),
        })
    }

    fn see(&self, part: usize, stage: &Stage, progress: &ProgressDisplay) -> scan2step::Result<()> {
        let mut seen = self.parts[part].lock().unwrap_or_else(PoisonError::into_inner);
        if let Stage::Done(_) = stage {
            let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
            if done.insert(part) {
                progress.of_parts(done.len(), self.parts.len());
            }
        }
        let count = self.parts.len();
        seen.see(stage, (self.is_drawn, count)).map_err(|error| match error {
            Error::File(error) => {
                let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
                failure.get_or_insert(error);
                Error::Stopped
            }
            other => other,
        })
    }

    /// The failure of a file that could not be written.
    fn failure(&self) -> Option<Failure> {
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner).take();
        failure.map(Failure::from)
    }

    /// The views of the bodies of each part, and the files of all stages.
    fn into_seen(self) -> (Vec<Vec<ReportView>>, Vec<Pending>) {
        let (mut views, mut files) = (Vec::new(), Vec::new());
        for seen in self.parts {
            let seen = seen.into_inner().unwrap_or_else(PoisonError::into_inner);
            views.push(seen.views);
            files.extend(seen.stages.into_iter().flat_map(|(_, stages)| stages.pending));
        }
        (views, files)
    }
}

impl WatchedPart {
    /// Keeps what a picture shows, and writes the file of a stage. There are so many parts.
    fn see(&mut self, stage: &Stage, (is_drawn, parts): (bool, usize)) -> scan2step::Result<()> {
        if is_drawn {
            self.recorder.see(stage);
        }
        match stage {
            Stage::Begin { components, .. } => {
                self.components = *components;
                self.views.clear();
                self.recorder = ViewRecorder::default();
                if let Some((_, stages)) = &mut self.stages {
                    stages.pending.clear();
                }
            }
            Stage::Component(number) => self.component = *number,
            Stage::Done(body) if is_drawn => {
                let recorder = std::mem::take(&mut self.recorder);
                self.views.push(recorder.view(body, parts * self.components.max(1))?);
            }
            Stage::Mesh(_) => {
                if let Some((root, stages)) = &mut self.stages
                    && self.components > 1
                {
                    stages.component(root, self.component)?;
                }
            }
            _ => {}
        }
        match &mut self.stages {
            Some((_, stages)) => Ok(stages.write(stage)?),
            None => Ok(()),
        }
    }
}

/// Says what became of each part. A part that fails is an error if the user is strict.
fn say_parts(
    args: &Convert,
    progress: &ProgressDisplay,
    made: &AssemblyConversion,
) -> Result<Outcome, Failure> {
    let mut outcome = Outcome::Done;
    for (number, part) in made.parts.iter().enumerate() {
        let ScenePart { name, places, .. } = &part.part;
        let title = format!("part {number}, {name}, in {}", plural(places.len(), "place"));
        match &part.made {
            Ok(conversion) => {
                for body in conversion.bodies() {
                    progress.say(&format!("{title}: {}", messages::summary(body)));
                    outcome = outcome.and(messages::verdict(args, body));
                }
            }
            Err(e) if args.how.strict => {
                return Err(Failure { error: format!("{title}: {e}"), help: e.help() });
            }
            Err(e) => {
                streams::say(format_args!("left out: {title}: {e}"));
                outcome = outcome.and(Outcome::Missed);
            }
        }
    }
    Ok(outcome)
}

/// The parts of a scene that is an assembly, without what the options leave out of it. If it is none, the scene comes
/// back.
pub(super) fn parts_of(
    scene: Scene,
    options: &Options,
    is_asked: bool,
) -> scan2step::Result<Result<SceneParts, Scene>> {
    let parts = SceneParts::of(scene, options)?;
    if !is_asked && !parts.are_bodies(options)? {
        return Ok(Err(parts.into_scene()));
    }
    if options.keeps_all() {
        return Ok(Ok(parts));
    }
    let left = scan2step::cropped(parts.into_scene(), options)?;
    SceneParts::of(left, options).map(Ok)
}
