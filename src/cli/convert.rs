//! `scan2step convert`: one scan to one or more files.

use std::path::{Path, PathBuf};

use scan2step::mesh::{Components, Repairs};
use scan2step::report::{OutputFile, Report, ReportView, ScanSource, StageFigures, ViewRecorder};
use scan2step::words::plural;
use scan2step::{Conversion, Memory, Options, PartColours, Stage, is_same_file};

use super::args::{CadKind, Convert, Iges, ShapeChoice};
use super::input::{self, ReadScan};
use super::output::{self, Pending};
use super::parts::{self, Chosen};
use super::progress::{self, ProgressDisplay, StageTime};
use super::report;
use super::stages::Stages;
use super::{Failure, Outcome, assembly, cad, messages, settings, streams, temp_files};

/// From so many vertices on, a mesh of which every vertex is held takes many minutes.
const CROWDED: usize = 5_000_000;

/// Reads a scan, converts it and writes all files.
pub(crate) fn run(args: &Convert) -> Result<Outcome, Failure> {
    if args.end_with_input {
        temp_files::end_with_input().map_err(|e| Failure {
            error: format!("scan2step: cannot watch its standard input: {e}"),
            help: "check that the program can start threads".into(),
        })?;
    }
    if !args.piece.scan.is_stdin {
        output::protect(&args.piece.scan.name);
    }
    check_outputs(args)?;
    let voice = if args.manner.quiet { None } else { Some(args.manner.color.is_on()) };
    let mut progress = ProgressDisplay::new(voice, args.manner.verbose, args.progress);
    let scan = match parts::chosen(args, input::read_content(&args.piece)?, &progress)? {
        Chosen::Assembly(parts) => return assembly::run(args, parts, progress),
        Chosen::One(content) => ReadScan::of(&args.piece, content)?,
    };
    let mut stages = args.stages.as_deref().map(Stages::new).transpose()?;
    progress.ended("read", &messages::came_in(&scan));
    scan.notes.iter().for_each(|note| progress.say(&format!("read: {note}")));
    let is_crowded = scan.source.cloud.is_none() && scan.source.vertices >= CROWDED;
    if is_crowded && args.how.tolerance.is_some() {
        progress.hint(
            "a --tolerance is held at every vertex, which takes many minutes for so many; without it, means of them are smoothed",
        );
    }
    let named = settings::options(args)?;
    let fitting = fitting(args, &scan, &named)?;
    if let Some(places) = fitting.most_places() {
        let places = plural(places, "place");
        let of = if scan.source.cloud.is_some() { "points" } else { "vertices" };
        progress.say(&format!(
            "memory: --max-memory allows the means of the {of} at {places}, which may lose details"
        ));
    }
    let options = scan.resolved(&fitting)?;
    let (scan, components) = mesh(scan, &options, &mut progress, &mut stages)?;
    messages::assumed(&progress, &scan);
    messages::cloud(&progress, &scan, components.sizeable());
    let repaired = components.repairs().clone();
    repaired.iter().for_each(|repair| messages::repaired(&progress, repair));
    let kept = stages.as_ref().map_or(0, |stages| stages.pending.len());
    let mut run = Run {
        args,
        progress,
        stages,
        views: Vec::new(),
        recorder: None,
        given: Vec::new(),
        kept,
        count: 1,
        component: 0,
    };
    left_out(&options, &components, &run.progress);
    let made = scan2step::convert(&components, &options, &mut |stage| run.see(&stage));
    let conversion = made.map_err(|e| input::stopped(&args.piece.scan.name, &e))?;
    drop(components);
    write(run, &scan, &named, &conversion, &repaired)
}

/// Writes all files, and says how good the result is.
fn write(
    run: Run,
    scan: &ReadScan,
    named: &Options,
    conversion: &Conversion,
    repaired: &Repairs,
) -> Result<Outcome, Failure> {
    let Run { args, mut progress, stages, views, given, .. } = run;
    let part = &conversion.parts[0];
    let colours = match &scan.painted {
        Some(mesh) => PartColours::of(mesh, scan.source.unit.in_mm(), part),
        None => PartColours { part: scan.colour, ..PartColours::default() },
    };
    if colours.mixed > 0 {
        let faces = plural(colours.mixed, "face");
        progress.say(&format!("colours: {faces} of several colours gets that of most of its area"));
    }
    let files = cad::write(args, &part.brep, &colours)?;
    progress.ended("write", "");
    for body in conversion.bodies() {
        let at_rims = body.input.repairs.iter().filter(|(kind, _)| !repaired.contains_key(*kind));
        at_rims.for_each(|repair| messages::repaired(&progress, repair));
        messages::found(&progress, args, body);
    }
    let mut report = Report::of(conversion, &scan.source, settings::settings(args, named, scan));
    report.hints.extend(loose_surfaces(args, conversion));
    report.command.clone_from(&args.again);
    report.outputs = args.out.iter().zip(&files).map(|(f, file)| output(&f.path, file)).collect();
    report.stages = progress.stages.iter().map(stage).collect();
    report.seconds = progress.seconds();
    report.peak_rss_mb = progress::peak_rss_mb();
    let reports = report::write(&args.report, &scan.name(), &report, &views)?;
    progress.finish();
    // Put all files in their places last, when every one is complete.
    let stages = stages.map_or(Vec::new(), |s| s.pending);
    Pending::publish(stages.into_iter().chain(reports).chain(files).collect())?;
    conversion.bodies().for_each(|body| messages::result(&progress, args, body));
    let new = report.hints.iter().filter(|hint| !given.iter().any(|given| hint.ends_with(given)));
    new.for_each(|hint| progress.hint(hint));
    Ok(conversion.bodies().fold(Outcome::Done, |all, body| all.and(messages::verdict(args, body))))
}

/// Says so if an IGES file has the faces of a solid or shell, but not what joins them.
fn loose_surfaces(args: &Convert, conversion: &Conversion) -> Option<String> {
    let is_joined = conversion.bodies().any(|body| body.network().is_some());
    let faces = conversion.bodies().map(|body| body.brep.faces.len()).sum();
    loose_faces(args, is_joined, faces)
}

/// The same for so many faces, which may be joined.
pub(super) fn loose_faces(args: &Convert, are_joined: bool, faces: usize) -> Option<String> {
    let is_iges = args.out.iter().any(|file| file.kind == CadKind::Iges);
    (is_iges && are_joined && matches!(args.how.iges, Iges::Trimmed)).then(|| {
        let faces = plural(faces, "trimmed surface");
        format!("the IGES file holds {faces} that nothing joins; --iges brep writes them joined")
    })
}

/// Makes the mesh of a scan. For a cloud this is a stage with a file and a time of its own.
fn mesh(
    scan: ReadScan,
    options: &Options,
    progress: &mut ProgressDisplay,
    stages: &mut Option<Stages>,
) -> Result<(ReadScan, Components), Failure> {
    let mut within = |share| {
        progress.within("cloud", share);
        Ok(())
    };
    let (scan, components) = scan.components(options, &mut within)?;
    if let Some(raw) = components.raw_points() {
        if let Some(stages) = stages {
            stages.points(raw, components.mm())?;
        }
        progress.ended("cloud", &messages::meshed(&components));
    }
    Ok((scan, components))
}

/// A stage for the report.
fn stage(time: &StageTime) -> StageFigures {
    let &StageTime { name, seconds, peak_rss_mb } = time;
    StageFigures { name: name.into(), seconds, peak_rss_mb }
}

/// A CAD file for the report.
pub(super) fn output(path: &Path, file: &Pending) -> OutputFile {
    OutputFile { file: streams::shown(path), bytes: file.bytes, sha256: file.sha256.clone() }
}

/// The same options, with which the run needs no more memory than the user allows.
fn fitting(args: &Convert, scan: &ReadScan, options: &Options) -> Result<Options, Failure> {
    let Some(allowed) = args.manner.max_memory else { return Ok(options.clone()) };
    let ScanSource { vertices, triangles, cloud, .. } = &scan.source;
    let memory = match cloud {
        Some(_) => Memory::of_cloud(*vertices, options),
        None => Memory::of_counts([*vertices, *triangles], options),
    };
    let may_be_body = args.how.shape != ShapeChoice::Face;
    let memory = Memory { is_drawn: is_drawn(args), may_be_body, ..memory };
    options.fitting(&memory, allowed.as_u64()).map_err(|e| input::stopped(&scan.path, &e))
}

/// Whether a report shows the scan.
pub(super) fn is_drawn(args: &Convert) -> bool {
    args.report.iter().any(|file| file.kind.is_picture())
}

/// A run between reading and writing.
struct Run<'a> {
    args: &'a Convert,
    progress: ProgressDisplay,
    stages: Option<Stages>,
    /// What the pictures of reports show, one view for each conversion, if any was asked for.
    views: Vec<ReportView>,
    /// Sees the stages for the next view.
    recorder: Option<ViewRecorder>,
    /// Hints that were given while stages ran.
    given: Vec<String>,
    /// The number of files of stages before the conversion.
    kept: usize,
    /// The number of components that are converted.
    count: usize,
    /// The position of the one whose stages run.
    component: usize,
}

impl Run<'_> {
    /// Says what a stage made of a component, writes its file, and keeps what pictures show.
    fn see(&mut self, stage: &Stage) -> scan2step::Result<()> {
        self.recorder.iter_mut().for_each(|recorder| recorder.see(stage));
        match stage {
            Stage::Begin { shape, components, why } => {
                self.begin(*components);
                why.iter().for_each(|why| self.progress.say(&messages::shape(*shape, why)));
                return Ok(());
            }
            Stage::Component(number) => {
                self.component = *number;
                return Ok(());
            }
            Stage::Within(name, share) => {
                self.progress.within(name, *share);
                return Ok(());
            }
            Stage::Done(body) => {
                let next = is_drawn(self.args).then(ViewRecorder::default);
                if let Some(seen) = std::mem::replace(&mut self.recorder, next) {
                    self.views.push(seen.view(body, self.count)?);
                }
                return Ok(());
            }
            _ => self.progress.ended(stage.name(), &messages::made(stage)),
        }
        if let Stage::Parameterize(_, Some(found)) = stage {
            // Tell the user before the long fit begins.
            let hint = found.to_string();
            self.progress.hint(&hint);
            self.given.push(hint);
        }
        let (Some(stages), Some(root)) = (&mut self.stages, &self.args.stages) else {
            return Ok(());
        };
        if let (Stage::Mesh(_), true) = (stage, self.count > 1) {
            stages.component(root, self.component)?;
        }
        Ok(stages.write(stage)?)
    }

    /// Forgets what led to no result, and expects so many components.
    fn begin(&mut self, components: usize) {
        self.count = components;
        self.progress.expect(components);
        self.views.clear();
        self.recorder = is_drawn(self.args).then(ViewRecorder::default);
        if let Some(stages) = &mut self.stages {
            stages.pending.truncate(self.kept);
        }
    }
}

/// Says what is left out where all components are converted.
fn left_out(options: &Options, scan: &Components, progress: &ProgressDisplay) {
    if !options.all_components() {
        return;
    }
    let chosen = options.chosen(scan).len();
    if chosen < scan.count() {
        let rest = match scan.sizeable() - chosen {
            0 => "the rest is dust",
            _ if scan.sizeable() == scan.count() => "the rest are islands in holes of these",
            _ => "the rest is dust, and islands in holes of these",
        };
        progress.say(&format!("component: {chosen} of {}; {rest}", scan.count()));
    }
}

/// Refuses two outputs of the same name, an output that would replace the scan, and a folder
/// that cannot be written to, before the long work begins. The files of stages are checked when their folder is made.
fn check_outputs(args: &Convert) -> Result<(), Failure> {
    let real = |path: &Path| match std::fs::canonicalize(path) {
        Ok(real) if !streams::is_stdout(path) => real,
        _ => path.to_owned(),
    };
    let mut seen: Vec<PathBuf> = Vec::new();
    let reports = args.report.iter().map(|f| &f.path);
    for path in args.out.iter().map(|f| &f.path).chain(reports) {
        let place = real(path);
        output::check_replaces_no_input(path)?;
        if seen.iter().any(|other| *other == place || is_same_file(other, &place)) {
            let error = format!("{}: is named twice", streams::shown(path));
            return Err(Failure { error, help: "give every output a name of its own".into() });
        }
        if args.no_clobber && !streams::is_stdout(path) && path.exists() {
            let error = format!("{}: exists already", path.display());
            return Err(Failure {
                error,
                help: "name another file, or leave out --no-clobber".into(),
            });
        }
        output::check(path)?;
        seen.push(place);
    }
    Ok(())
}
