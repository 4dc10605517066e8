//! `scan2step convert`: one scan to one or more files.

use std::path::Path;

use scan2step::mesh::{Choice, Components, Outer};
use scan2step::parameterize::CompressedRegion;
use scan2step::report::{OutputFile, Report, ReportView, ScanSource, StageFigures, ViewRecorder};
use scan2step::{BodyConversion, Conversion, Memory, Options, Stage, TargetShape};

use super::args::{ComponentChoice, Convert, ShapeChoice};
use super::input::{self, Scan};
use super::output::{self, Pending};
use super::progress::{self, ProgressDisplay, StageTime};
use super::report;
use super::stages::Stages;
use super::{Failure, Outcome, body, cad, messages, settings};

/// Reads a scan, converts it and writes all files.
pub fn run(args: &Convert) -> Result<Outcome, Failure> {
    check_outputs(args)?;
    let voice = if args.manner.quiet { None } else { Some(args.manner.color.is_on()) };
    let mut progress = ProgressDisplay::new(voice, args.manner.verbose, args.progress);
    let mut stages = args.stages.as_deref().map(Stages::new).transpose()?;
    let scan = Scan::read(&args.piece)?;
    progress.ended("read", &messages::came_in(&scan));
    scan.notes.iter().for_each(|note| progress.say(&format!("read: {note}")));
    let named = settings::options(args)?;
    check_memory(args, &scan, &named)?;
    let options = scan.resolved(&named)?;
    let (scan, components) = mesh(scan, &options, &mut progress, &mut stages)?;
    messages::assumed(&progress, &scan);
    messages::cloud(&progress, &scan);
    let repaired = components.repairs().clone();
    repaired.iter().for_each(|repair| messages::repaired(&progress, repair));
    let bodies = body::bodies(args, &components, &options, &progress)?;
    let is_tried = args.how.shape == ShapeChoice::Auto;
    let kept = stages.as_ref().map_or(0, |stages| stages.pending.len());
    let mut run = Run {
        args,
        progress,
        stages,
        views: Vec::new(),
        given: Vec::new(),
        kept,
        is_tried,
        crushed: None,
        fallback: None,
    };
    if !bodies.is_empty() {
        if is_tried {
            run.progress.say(body::why(&bodies));
        }
        let made = body::convert(&mut run, &components, &options, &bodies);
        let made = made.map_err(|e| input::stopped(&args.piece.scan, &e))?;
        return body::write(run, &scan, &named, &made);
    }
    let conversions = match run.convert(&components, &options) {
        Err(error) => match run.unsuited(&error) {
            None => Err(error),
            Some(why) => match run.shells(&components, &options, &why) {
                Some(made) => return body::write(run, &scan, &named, &made),
                None => run.convert(&components, &options),
            },
        },
        done => done,
    };
    let conversions = conversions.map_err(|e| input::stopped(&args.piece.scan, &e))?;
    drop(components);
    let Run { mut progress, stages, views, given, fallback, .. } = run;
    let files = cad::write(args, &conversions, scan.colour)?;
    progress.ended("write", "");
    for c in &conversions {
        let at_rims = c.input.repairs.iter().filter(|(kind, _)| !repaired.contains_key(*kind));
        at_rims.for_each(|repair| messages::repaired(&progress, repair));
        messages::found(&progress, args, c);
    }
    let mut report =
        Report::of(&conversions, &scan.source, settings::settings(args, &named, &scan));
    report.faces.iter_mut().for_each(|face| face.shape.fallback = fallback.clone());
    report.outputs = args.out.iter().zip(&files).map(|(f, file)| output(&f.path, file)).collect();
    report.stages = progress.stages.iter().map(stage).collect();
    report.seconds = progress.seconds();
    report.peak_rss_mb = progress::peak_rss_mb();
    let reports = report::write(&args.report, &scan.name(), &report, &views)?;
    progress.finish();
    // Put all files in their places last, when every one is complete.
    let stages = stages.map_or(Vec::new(), |s| s.pending);
    Pending::publish(stages.into_iter().chain(reports).chain(files).collect())?;
    conversions.iter().for_each(|c| messages::result(&progress, args, c));
    let new = report.hints.iter().filter(|hint| !given.iter().any(|given| hint.ends_with(given)));
    new.for_each(|hint| progress.hint(hint));
    Ok(conversions.iter().fold(Outcome::Done, |all, c| all.and(messages::verdict(args, c))))
}

/// Makes the mesh of a scan. For a cloud this is a stage with a file and a time of its own.
fn mesh(
    scan: Scan,
    options: &Options,
    progress: &mut ProgressDisplay,
    stages: &mut Option<Stages>,
) -> Result<(Scan, Components), Failure> {
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
pub fn stage(time: &StageTime) -> StageFigures {
    let &StageTime { name, seconds, peak_rss_mb } = time;
    StageFigures { name: name.into(), seconds, peak_rss_mb }
}

/// A CAD file for the report.
pub fn output(path: &Path, file: &Pending) -> OutputFile {
    OutputFile { file: path.display().to_string(), bytes: file.bytes, sha256: file.sha256.clone() }
}

/// Refuses a run that may need more memory than the user allows.
fn check_memory(args: &Convert, scan: &Scan, options: &Options) -> Result<(), Failure> {
    let Some(allowed) = args.manner.max_memory else { return Ok(()) };
    let ScanSource { vertices, triangles, cloud, .. } = &scan.source;
    let memory = match cloud {
        Some(_) => Memory::of_cloud(*vertices, options),
        None => Memory::of_counts([*vertices, *triangles], options),
    };
    let may_be_body = args.how.shape != ShapeChoice::Face;
    let memory = Memory { is_drawn: is_drawn(args), may_be_body, ..memory };
    memory.check(allowed.as_u64()).map_err(|e| input::stopped(&scan.path, &e))
}

/// Whether a report shows the scan.
pub fn is_drawn(args: &Convert) -> bool {
    args.report.iter().any(|file| file.kind.is_picture())
}

/// A run between reading and writing.
pub struct Run<'a> {
    pub args: &'a Convert,
    pub progress: ProgressDisplay,
    pub stages: Option<Stages>,
    /// What the pictures of reports show, one view for each conversion, if any was asked for.
    pub views: Vec<ReportView>,
    /// Hints that were given while stages ran.
    given: Vec<String>,
    /// Why the shape is not the first one that was tried.
    pub fallback: Option<String>,
    /// The number of files of stages before the conversion.
    kept: usize,
    /// Whether a sheet that one face does not hold well may become a shell.
    is_tried: bool,
    /// Where a map to one face has too little room.
    crushed: Option<CompressedRegion>,
}

impl Run<'_> {
    /// Converts the components that were asked for.
    fn convert(
        &mut self,
        components: &Components,
        options: &Options,
    ) -> scan2step::Result<Vec<Conversion>> {
        let chosen = chosen(self.args, components, options.outer(), &self.progress);
        self.progress.expect(chosen.len());
        let mut recorder = is_drawn(self.args).then(ViewRecorder::default);
        let mut watch = |number: usize, stage: Stage| -> scan2step::Result<()> {
            if let Some(recorder) = &mut recorder {
                recorder.see(&stage);
                if let Stage::Done(conversion) = stage {
                    let recorder = std::mem::take(recorder);
                    self.views.push(recorder.view(conversion, chosen.len())?);
                }
            }
            self.see((number, chosen.len()), &stage)
        };
        scan2step::convert_components(components, &chosen, options, &mut watch)
    }

    /// Why one face does not hold a sheet, if the sheet may become a shell instead.
    fn unsuited(&self, error: &scan2step::Error) -> Option<String> {
        use scan2step::Error;
        match (self.is_tried, &self.crushed, error) {
            (true, Some(crushed), _) => {
                let p = crushed.at;
                Some(format!("the map compresses a part near ({:.3}, {:.3}, {:.3})", p.x, p.y, p.z))
            }
            (true, None, Error::Folded { .. } | Error::Trim { .. }) => Some(error.to_string()),
            _ => None,
        }
    }

    /// Forgets the files of stages that did not lead to a result.
    fn restart(&mut self) {
        if let Some(stages) = &mut self.stages {
            stages.pending.truncate(self.kept);
        }
    }

    /// Converts sheets to shells because one face does not hold them: `why`. `None` if there are no
    /// sound shells, either. Then a face has to do.
    fn shells(
        &mut self,
        components: &Components,
        options: &Options,
        why: &str,
    ) -> Option<Vec<BodyConversion>> {
        self.progress.say(&format!(
            "shape: a shell, as one face does not hold the scan: {why} (--shape to change)"
        ));
        let chosen = chosen(self.args, components, options.outer(), &self.progress).into_iter();
        let chosen: Vec<_> = chosen.map(|component| (component, TargetShape::Shell)).collect();
        self.restart();
        self.fallback = Some(format!("one face does not hold the scan: {why}"));
        match body::convert(self, components, options, &chosen) {
            Ok(made) => Some(made),
            Err(error) => {
                let why = format!("no sound shell was found: {error}");
                self.progress.say(&format!("shape: a face, as {why}"));
                self.fallback = Some(why);
                self.restart();
                self.is_tried = false;
                None
            }
        }
    }

    /// Says what a stage made of one of several components, and writes its file.
    pub fn see(&mut self, (number, count): (usize, usize), stage: &Stage) -> scan2step::Result<()> {
        match stage {
            Stage::Within(name, share) => {
                self.progress.within(name, *share);
                return Ok(());
            }
            Stage::Done(_) => return Ok(()),
            _ => self.progress.ended(stage.name(), &messages::made(stage)),
        }
        if let Stage::Parameterize(_, Some(found)) = stage {
            if self.is_tried {
                self.crushed = Some(*found);
                return Err(scan2step::Error::Stopped);
            }
            // Tell the user before the long fit begins.
            let hint = found.to_string();
            self.progress.hint(&hint);
            self.given.push(hint);
        }
        let (Some(stages), Some(root)) = (&mut self.stages, &self.args.stages) else {
            return Ok(());
        };
        if let (Stage::Mesh(_), true) = (stage, count > 1) {
            stages.component(root, number)?;
        }
        Ok(stages.write(stage)?)
    }
}

/// The components to convert.
pub fn chosen(
    args: &Convert,
    scan: &Components,
    outer: Outer,
    progress: &ProgressDisplay,
) -> Vec<Choice> {
    let chosen = args.how.component.of(scan, outer);
    if args.how.component == ComponentChoice::All && chosen.len() < scan.count() {
        let rest = match scan.sizeable() - chosen.len() {
            0 => "the rest is dust",
            _ if scan.sizeable() == scan.count() => "the rest are islands in holes of these",
            _ => "the rest is dust, and islands in holes of these",
        };
        progress.say(&format!("component: {} of {}; {rest}", chosen.len(), scan.count()));
    }
    chosen
}

/// Refuses two outputs of the same name, an output that would replace the scan, and a folder
/// that cannot be written to, before the long work begins.
fn check_outputs(args: &Convert) -> Result<(), Failure> {
    let real = |path: &Path| std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let scan = real(&args.piece.scan);
    let mut seen = Vec::new();
    let reports = args.report.iter().map(|f| &f.path);
    for path in args.out.iter().map(|f| &f.path).chain(reports) {
        let place = real(path);
        if place == scan || seen.contains(&place) {
            let error = format!("{}: is named twice", path.display());
            return Err(Failure { error, help: "give every output a name of its own".into() });
        }
        output::check(path)?;
        seen.push(place);
    }
    Ok(())
}
