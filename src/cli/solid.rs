//! `convert` for bodies: the components that become solids.

use scan2step::mesh::{Choice, Components};
use scan2step::report::SolidReport;
use scan2step::words::{mm, plural};
use scan2step::{Options, SolidConversion, Stage, TargetShape};

use super::args::{Convert, ShapeChoice};
use super::convert::{chosen, output, stage};
use super::input::{self, Scan};
use super::output::{self as files, Pending};
use super::progress::{self, ProgressDisplay};
use super::report::ReportFormat;
use super::stages::Stages;
use super::{Failure, Outcome, cad, messages, settings, streams};

/// The components that become solids. There are none unless all that were chosen do, or `--shape
/// solid` says so.
pub fn bodies(
    args: &Convert,
    components: &Components,
    options: &Options,
    progress: &ProgressDisplay,
) -> Result<Vec<Choice>, Failure> {
    let none = Ok(Vec::new());
    if args.how.shape == ShapeChoice::Face {
        return none;
    }
    let chosen = chosen(args, components, options.outer(), progress);
    if args.how.shape == ShapeChoice::Solid {
        return Ok(chosen);
    }
    for &component in &chosen {
        let component = match component {
            Choice::Largest => options.component(),
            number => number,
        };
        let shape = scan2step::shape(components, component);
        if shape.map_err(|e| input::stopped(&args.piece.scan, &e))? == TargetShape::Face {
            return none;
        }
    }
    Ok(chosen)
}

/// Converts bodies, and writes all files.
pub fn run(
    args: &Convert,
    (scan, components): (&Scan, &Components),
    (named, options): (&Options, &Options),
    chosen: &[Choice],
    mut progress: ProgressDisplay,
    mut stages: Option<Stages>,
) -> Result<Outcome, Failure> {
    check_reports(args)?;
    progress.say("shape: a solid, as the scan is closed or nearly so (--shape to change)");
    progress.expect(chosen.len());
    let mut solids = Vec::with_capacity(chosen.len());
    for (number, &component) in chosen.iter().enumerate() {
        let mut watch = |stage: Stage| -> scan2step::Result<()> {
            see(&stage, &mut progress, args, &mut stages, (number, chosen.len()))
        };
        let options = options.of_component(component);
        let solid = scan2step::convert_solid(components, &options, &mut watch);
        solids.push(solid.map_err(|e| input::stopped(&args.piece.scan, &e))?);
    }
    let mut all = formats::Brep { name: cad::part_name(&args.piece.scan), ..Default::default() };
    solids.iter().for_each(|solid| all.append(solid.brep.clone()));
    let written = cad::write_brep(args, &all, scan.colour)?;
    progress.ended("write", "");
    let mut report = SolidReport::of(&solids, &scan.source, settings::settings(args, named, scan));
    report.outputs = args.out.iter().zip(&written).map(|(f, file)| output(&f.path, file)).collect();
    report.stages = progress.stages.iter().map(stage).collect();
    report.seconds = progress.seconds();
    report.peak_rss_mb = progress::peak_rss_mb();
    let reports = args.report.iter().map(|f| files::write(&f.path, |out| report.write_json(out)));
    let reports: Vec<Pending> = reports.collect::<Result<_, _>>()?;
    progress.finish();
    let stages = stages.map_or(Vec::new(), |s| s.pending);
    Pending::publish(stages.into_iter().chain(reports).chain(written).collect())?;
    let mut outcome = Outcome::Done;
    for solid in &solids {
        result(&progress, args, solid);
        outcome = outcome.and(verdict(args, solid));
    }
    Ok(outcome)
}

/// Pictures and pages do not show solids.
fn check_reports(args: &Convert) -> Result<(), Failure> {
    match args.report.iter().find(|file| file.kind != ReportFormat::Json) {
        None => Ok(()),
        Some(file) => Err(Failure {
            error: format!(
                "{}: pages and pictures of solids are not made yet",
                file.path.display()
            ),
            help: "name a report that ends in .json".into(),
        }),
    }
}

/// Says what a stage made, and writes its file.
fn see(
    stage: &Stage,
    progress: &mut ProgressDisplay,
    args: &Convert,
    stages: &mut Option<Stages>,
    (number, count): (usize, usize),
) -> scan2step::Result<()> {
    if let Stage::Within(name, share) = stage {
        progress.within(name, *share);
        return Ok(());
    }
    progress.ended(stage.name(), &messages::made(stage));
    let (Some(stages), Some(root)) = (stages, &args.stages) else { return Ok(()) };
    if let (Stage::Mesh(_), true) = (stage, count > 1) {
        stages.component(root, number)?;
    }
    Ok(stages.write(stage)?)
}

/// The result in one line.
fn result(progress: &ProgressDisplay, args: &Convert, solid: &SolidConversion) {
    let out: Vec<_> = args.out.iter().map(|f| f.path.display().to_string()).collect();
    let gaps = match solid.fill.holes.len() {
        0 => String::new(),
        count => format!(", {} filled", plural(count, "gap")),
    };
    progress.result(&format!(
        "a solid of {}, {:.6} mm³, rms {}, max {}{gaps} → {}",
        plural(solid.brep.faces.len(), "face"),
        solid.volume,
        mm(solid.fit_deviation.rms),
        mm(solid.fit_deviation.max),
        out.join(", ")
    ));
    if !solid.tolerance_named && !solid.tolerance_met(0.0) {
        let beyond = solid.fit_deviation.beyond(solid.tolerance);
        progress.say(&format!(
            "tolerance: {beyond} of {} points are farther than {} from the solid",
            solid.fit_deviation.distances.len(),
            mm(solid.tolerance)
        ));
    }
}

/// Says so if the solid misses a tolerance that the user named.
fn verdict(args: &Convert, solid: &SolidConversion) -> Outcome {
    if args.how.tolerance.is_none() || solid.tolerance_met(args.how.outliers / 100.0) {
        return Outcome::Done;
    }
    let [x, y, z] = solid.fit_deviation.max_at;
    streams::say(format_args!(
        "tolerance not met: {} of {} points are farther than {} from the solid; the worst, {}, at ({x:.3}, {y:.3}, {z:.3})",
        solid.fit_deviation.beyond(solid.tolerance),
        solid.fit_deviation.distances.len(),
        mm(solid.tolerance),
        mm(solid.fit_deviation.max),
    ));
    Outcome::Missed
}
