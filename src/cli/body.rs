//! `convert` for bodies: the components that become solids or shells.

use scan2step::mesh::{Choice, Components};
use scan2step::report::{BodyReport, ViewRecorder};
use scan2step::words::{mm, plural};
use scan2step::{BodyConversion, Options, Stage, TargetShape};

use super::args::{Convert, ShapeChoice};
use super::convert::{Run, chosen, is_drawn, output, stage};
use super::input::{self, Scan};
use super::output::Pending;
use super::progress::{self, ProgressDisplay};
use super::{Failure, Outcome, cad, messages, report, settings, streams};

/// The components that become solids or shells, and which of them. There are none if all that were
/// chosen become faces. If only some would, these become shells.
pub fn bodies(
    args: &Convert,
    components: &Components,
    options: &Options,
    progress: &ProgressDisplay,
) -> Result<Vec<(Choice, TargetShape)>, Failure> {
    if args.how.shape == ShapeChoice::Face {
        return Ok(Vec::new());
    }
    let shape = |component: Choice| match args.how.shape {
        ShapeChoice::Solid => Ok(TargetShape::Solid),
        ShapeChoice::Shell => Ok(TargetShape::Shell),
        _ => {
            let shape = scan2step::shape(components, component);
            shape.map_err(|e| input::stopped(&args.piece.scan, &e))
        }
    };
    let chosen = chosen(args, components, options.outer(), progress).into_iter();
    let mut shapes: Vec<(Choice, TargetShape)> = chosen
        .map(|component| Ok((component, shape(component)?)))
        .collect::<Result<_, Failure>>()?;
    if shapes.iter().all(|of| of.1 == TargetShape::Face) {
        shapes.clear();
    }
    for of in shapes.iter_mut().filter(|of| of.1 == TargetShape::Face) {
        of.1 = TargetShape::Shell;
    }
    with_voids(components, shapes).map_err(|e| input::stopped(&args.piece.scan, &e))
}

/// The same with the voids of each solid after it. They are not chosen themselves.
fn with_voids(
    components: &Components,
    shapes: Vec<(Choice, TargetShape)>,
) -> scan2step::Result<Vec<(Choice, TargetShape)>> {
    let mut all = Vec::with_capacity(shapes.len());
    let mut voids = Vec::new();
    for (component, shape) in shapes {
        all.push((component, shape));
        if shape == TargetShape::Solid {
            let own = scan2step::voids(components, component)?;
            all.extend(own.iter().map(|&component| (component, TargetShape::Void)));
            voids.extend(own);
        }
    }
    all.retain(|of| of.1 == TargetShape::Void || !voids.contains(&of.0));
    Ok(all)
}

/// Why bodies became what they are, unless the user named a shape.
pub fn why(chosen: &[(Choice, TargetShape)]) -> &'static str {
    match chosen.iter().all(|of| of.1 != TargetShape::Shell) {
        true => "shape: a solid, as the scan is closed or nearly so (--shape to change)",
        false => "shape: a shell, as one face does not hold the scan (--shape to change)",
    }
}

/// Converts the components to solids and shells.
pub fn convert(
    run: &mut Run,
    components: &Components,
    options: &Options,
    chosen: &[(Choice, TargetShape)],
) -> scan2step::Result<Vec<BodyConversion>> {
    run.progress.expect(chosen.len());
    let count = chosen.len();
    let one = |(number, &(component, shape)): (usize, &(Choice, TargetShape))| {
        let options = options.of_component(component);
        let mut recorder = is_drawn(run.args).then(ViewRecorder::default);
        let mut watch = |stage: Stage| {
            recorder.iter_mut().for_each(|recorder| recorder.see(&stage));
            run.see((number, count), &stage)
        };
        let body = scan2step::convert_body(components, shape, &options, &mut watch)?;
        if let Some(recorder) = recorder {
            run.views.push(recorder.view_of_body(&body, count)?);
        }
        Ok(body)
    };
    chosen.iter().enumerate().map(one).collect()
}

/// Writes all files of solids and shells, and says how good they are.
pub fn write(
    mut run: Run,
    scan: &Scan,
    named: &Options,
    bodies: &[BodyConversion],
) -> Result<Outcome, Failure> {
    let args = run.args;
    let all = scan2step::joined_bodies(cad::part_name(&args.piece.scan), bodies)
        .map_err(|e| input::stopped(&args.piece.scan, &e))?;
    let written = cad::write_brep(args, &all, scan.colour)?;
    run.progress.ended("write", "");
    let mut figures = BodyReport::of(bodies, &scan.source, settings::settings(args, named, scan));
    let shapes = figures.solids.iter_mut().map(|solid| &mut solid.shape);
    shapes.for_each(|shape| shape.fallback = run.fallback.clone());
    figures.outputs =
        args.out.iter().zip(&written).map(|(f, file)| output(&f.path, file)).collect();
    figures.stages = run.progress.stages.iter().map(stage).collect();
    figures.seconds = run.progress.seconds();
    figures.peak_rss_mb = progress::peak_rss_mb();
    let reports = report::write(&args.report, &scan.name(), &figures, &run.views)?;
    run.progress.finish();
    let stages = run.stages.map_or(Vec::new(), |s| s.pending);
    Pending::publish(stages.into_iter().chain(reports).chain(written).collect())?;
    let mut outcome = Outcome::Done;
    for body in bodies {
        messages::found_of_body(&run.progress, args, body);
        result(&run.progress, args, body);
        outcome = outcome.and(verdict(args, body));
    }
    Ok(outcome)
}

/// The result in one line.
fn result(progress: &ProgressDisplay, args: &Convert, body: &BodyConversion) {
    let out: Vec<_> = args.out.iter().map(|f| f.path.display().to_string()).collect();
    let gaps = match (body.fill.holes.len(), body.volume) {
        (0, _) => String::new(),
        (count, Some(_)) => format!(", {} filled", plural(count, "gap")),
        (count, None) => format!(", {} open", plural(count, "boundary loop")),
    };
    let volume = body.volume.map_or(String::new(), |volume| format!(" {volume:.6} mm³,"));
    progress.result(&format!(
        "a {} of {},{volume} rms {}, max {}{gaps} → {}",
        word(body),
        plural(body.brep.faces.len(), "face"),
        mm(body.fit_deviation.rms),
        mm(body.fit_deviation.max),
        out.join(", ")
    ));
    if !body.tolerance_named && !body.tolerance_met(0.0) {
        let beyond = body.fit_deviation.beyond(body.tolerance);
        progress.say(&format!(
            "tolerance: {beyond} of {} points are farther than {} from the {}",
            body.fit_deviation.distances.len(),
            mm(body.tolerance),
            word(body)
        ));
    }
}

/// What a body became, in a word.
fn word(body: &BodyConversion) -> &'static str {
    match body.shape {
        TargetShape::Solid => "solid",
        TargetShape::Void => "void",
        TargetShape::Shell | TargetShape::Face => "shell",
    }
}

/// Says so if the solid or shell misses a tolerance that the user named.
fn verdict(args: &Convert, body: &BodyConversion) -> Outcome {
    if args.how.tolerance.is_none() || body.tolerance_met(args.how.outliers / 100.0) {
        return Outcome::Done;
    }
    let place = |[x, y, z]: [f64; 3]| format!("({x:.3}, {y:.3}, {z:.3})");
    let (points, back) = (&body.fit_deviation, &body.face_to_scan);
    streams::say(format_args!(
        "tolerance not met: {} of {} points are farther than {} from the {}; the worst, {}, at {}; and {} of {} places of the {} are farther from the scan's triangles; the worst, {}, at {}",
        points.beyond(body.tolerance),
        points.distances.len(),
        mm(body.tolerance),
        word(body),
        mm(points.max),
        place(points.max_at),
        back.beyond,
        back.deviation.distances.len(),
        word(body),
        mm(back.deviation.max),
        place(back.deviation.max_at),
    ));
    Outcome::Missed
}
