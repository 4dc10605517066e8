//! `scan2step convert`: one scan to one or more files.

use std::path::Path;

use scan2step::mesh::Components;
use scan2step::{Conversion, Options, Stage, mesh};

use super::args::{Component, Convert};
use super::input::{self, Scan};
use super::output::{self, Pending};
use super::progress::Progress;
use super::report::{self, Shown};
use super::stages::Stages;
use super::{Failure, Outcome, cad, hints, memory, messages, settings};

/// Reads, converts, writes.
pub fn run(args: &Convert) -> Result<Outcome, Failure> {
    check_outputs(args)?;
    let voice = if args.manner.quiet { None } else { Some(args.manner.color.is_on()) };
    let mut progress = Progress::new(voice, args.manner.verbose);
    let stages = args.stages.as_deref().map(Stages::new).transpose()?;
    let scan = Scan::read(&args.piece)?;
    progress.ended("read", &messages::came_in(&scan));
    memory::check(args, &scan)?;
    let options = settings::options(args, &scan)?;
    let (scan, components) = scan.components()?;
    messages::assumed(&progress, &scan);
    let repaired = components.repairs().clone();
    repaired.iter().for_each(|repair| messages::repaired(&progress, repair));
    let mut run = Run {
        args,
        progress,
        stages,
        conversions: Vec::new(),
        shown: Vec::new(),
        said: Vec::new(),
    };
    run.convert(&components, &options)?;
    drop(components);
    let Run { mut progress, stages, conversions, shown, said, .. } = run;
    let files = cad::write(args, &conversions, scan.colour)?;
    progress.ended("write", "");
    for c in &conversions {
        let at_rims = c.input.repairs.iter().filter(|(kind, _)| !repaired.contains_key(*kind));
        at_rims.for_each(|repair| messages::repaired(&progress, repair));
        messages::found(&progress, args, c);
    }
    let hints = hints::all(args, &scan, &conversions);
    let context = report::Context {
        scan: &scan,
        options: settings::as_json(args),
        hints: hints.clone(),
        tolerance_named: args.how.tolerance.is_some(),
        outliers_pct: args.how.outliers,
        outputs: args.out.iter().map(|f| f.path.as_path()).zip(&files).collect(),
        progress: &progress,
    };
    let reports = report::write(&args.report, &conversions, &shown, &context)?;
    progress.finish();
    // Every file is complete by now; putting them in place comes last.
    let stages = stages.map_or(Vec::new(), |s| s.pending);
    Pending::publish(stages.into_iter().chain(reports).chain(files).collect())?;
    conversions.iter().for_each(|c| messages::result(&progress, args, c));
    let new = hints.iter().filter(|hint| !said.iter().any(|said| hint.ends_with(said)));
    new.for_each(|hint| progress.hint(hint));
    Ok(conversions.iter().fold(Outcome::Done, |all, c| all.and(messages::verdict(args, c))))
}

/// A run between reading and writing.
struct Run<'a> {
    args: &'a Convert,
    progress: Progress,
    stages: Option<Stages>,
    conversions: Vec<Conversion>,
    /// What the pictures of reports show, where any was asked for.
    shown: Vec<Shown>,
    /// Hints that were given on the way.
    said: Vec<String>,
}

impl Run<'_> {
    /// Converts the components that were asked for.
    fn convert(&mut self, components: &Components, options: &Options) -> Result<(), Failure> {
        let chosen = chosen(self.args, components, options.outer(), &self.progress);
        self.progress.expect(chosen.len());
        let pictured = self.args.report.iter().any(|file| file.kind.is_picture());
        for &component in &chosen {
            if let (Some(s), Some(root), true) =
                (&mut self.stages, &self.args.stages, chosen.len() > 1)
            {
                s.component(root, self.conversions.len())?;
            }
            let mut seen = pictured.then(report::Watch::default);
            let mut watch = |stage: Stage| -> scan2step::Result<()> {
                if let Stage::Within(name, share) = stage {
                    self.progress.within(name, share);
                    return Ok(());
                }
                self.progress.ended(stage.name(), &messages::made(&stage));
                if let Stage::Parameterize(_, Some(found)) = &stage {
                    // Before the time for it is spent.
                    let hint = found.to_string();
                    self.progress.hint(&hint);
                    self.said.push(hint);
                }
                if let Some(seen) = &mut seen {
                    seen.see(&stage);
                }
                Ok(self.stages.as_mut().map_or(Ok(()), |s| s.write(&stage))?)
            };
            let options = options.of_component(component);
            let converted = scan2step::convert_component(components, &options, &mut watch);
            let converted = converted.map_err(|e| input::stopped(&self.args.piece.scan, &e))?;
            self.shown.extend(seen.map(|seen| seen.shown(&converted, chosen.len())));
            self.conversions.push(converted);
        }
        Ok(())
    }
}

/// The components to convert.
fn chosen(
    args: &Convert,
    scan: &Components,
    outer: mesh::Outer,
    progress: &Progress,
) -> Vec<mesh::Choice> {
    let chosen = args.how.component.of(scan, outer);
    if args.how.component == Component::All && chosen.len() < scan.count() {
        let rest = match scan.sizeable() - chosen.len() {
            0 => "the rest is dust",
            _ if scan.sizeable() == scan.count() => "the rest are islands in holes of these",
            _ => "the rest is dust, and islands in holes of these",
        };
        progress.say(&format!("component: {} of {}; {rest}", chosen.len(), scan.count()));
    }
    chosen
}

/// Two outputs at one place, or one over the scan, would destroy each other; and
/// a folder that cannot be written to is better said before the work than after.
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
