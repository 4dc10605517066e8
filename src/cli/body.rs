//! `convert` for bodies: the components that become solids or shells.

use formats::Brep;
use scan2step::report::BodyReport;
use scan2step::words::{mm, plain_mm, plural};
use scan2step::{BodyConversion, Options};

use super::args::{CadKind, Convert, Iges};
use super::convert::{Run, output, stage};
use super::input::{self, Scan};
use super::output::Pending;
use super::progress::{self, ProgressDisplay};
use super::{Failure, Outcome, cad, messages, report, settings, streams};

/// Writes all files of solids and shells, and says how good they are.
pub fn write(
    mut run: Run,
    scan: &Scan,
    named: &Options,
    bodies: &[BodyConversion],
    fallback: Option<&str>,
) -> Result<Outcome, Failure> {
    let args = run.args;
    let all = scan2step::joined_bodies(args.part_name(), bodies)
        .map_err(|e| input::stopped(&args.piece.scan.name, &e))?;
    let written = cad::write_brep(args, &all, scan.colour)?;
    run.progress.ended("write", "");
    let mut figures = BodyReport::of(bodies, &scan.source, settings::settings(args, named, scan));
    let shapes = figures.solids.iter_mut().map(|solid| &mut solid.shape);
    shapes.for_each(|shape| shape.fallback = fallback.map(str::to_owned));
    figures.hints.extend(loose_surfaces(args, &all));
    figures.command.clone_from(&args.again);
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
    figures.hints.iter().for_each(|hint| run.progress.hint(hint));
    Ok(outcome)
}

/// Says so if an IGES file has the faces of a solid or shell, but not what joins them.
fn loose_surfaces(args: &Convert, all: &Brep) -> Option<String> {
    let is_iges = args.out.iter().any(|file| file.kind == CadKind::Iges);
    (is_iges && matches!(args.how.iges, Iges::Trimmed)).then(|| {
        let faces = plural(all.faces.len(), "trimmed surface");
        format!("the IGES file holds {faces} that nothing joins; --iges brep writes them joined")
    })
}

/// The result in one line.
fn result(progress: &ProgressDisplay, args: &Convert, body: &BodyConversion) {
    let out: Vec<_> = args.out.iter().map(|f| streams::shown(&f.path)).collect();
    let gaps = match (body.fill.holes.len(), body.volume) {
        (0, _) => String::new(),
        (count, Some(_)) => format!(", {} filled", plural(count, "gap")),
        (count, None) => format!(", {} open", plural(count, "boundary loop")),
    };
    let volume = body.volume.map_or(String::new(), |volume| format!(" {} mm³,", plain_mm(volume)));
    let of = messages::of_piece(args, &body.input);
    progress.result(&format!(
        "{of}a {} of {},{volume} rms {}, max {}{gaps} → {}",
        body.shape.word(),
        plural(body.brep.faces.len(), "face"),
        mm(body.fit_deviation.rms),
        mm(body.fit_deviation.max),
        out.join(", ")
    ));
}

/// Says so if the solid or shell misses a tolerance that the user named.
fn verdict(args: &Convert, body: &BodyConversion) -> Outcome {
    if args.how.tolerance.is_none() || body.tolerance_met(args.how.outliers / 100.0) {
        return Outcome::Done;
    }
    let of = messages::of_piece(args, &body.input);
    streams::say(format_args!("tolerance not met: {of}{}", body.beyond()));
    Outcome::Missed
}
