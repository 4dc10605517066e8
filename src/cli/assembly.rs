//! `scan2step convert` of a file with several parts.

use formats::Scene;
use scan2step::report::AssemblyReport;
use scan2step::words::plural;
use scan2step::{AssemblyConversion, ScenePart};

use super::args::Convert;
use super::input;
use super::output::{self, Pending};
use super::progress::{self, ProgressDisplay};
use super::{Failure, Outcome, cad, convert, messages, settings, streams};

/// What is said of the axes of glTF.
pub(super) const Y_UP: &str = "y points up, as in all glTF files; coordinates stay as they are";

/// Converts each part, and writes all files.
pub(crate) fn run(
    args: &Convert,
    scene: &Scene,
    mut progress: ProgressDisplay,
) -> Result<Outcome, Failure> {
    let count = plural(scene.uses().len(), "part");
    let file = args.piece.scan.name.display().to_string();
    progress.ended("read", &format!("{file}: {count} in {}", plural(scene.place_count(), "place")));
    scene.notes.iter().for_each(|note| progress.say(&format!("read: {note}")));
    if scene.is_y_up {
        progress.say(&format!("axes: {Y_UP}"));
    }
    let options = settings::options(args)?;
    let made = scan2step::convert_scene(scene, &options, &args.part_name());
    let made = made.map_err(|e| input::stopped(&args.piece.scan.name, &e))?;
    progress.ended("parts", "");
    let outcome = say_parts(args, &progress, &made)?;
    let Some(assembly) = &made.assembly else {
        return Err(Failure {
            error: format!("{file}: none of its parts can be converted"),
            help: "convert one of them alone: --parts 0".into(),
        });
    };
    let files = cad::write_assembly(args, assembly)?;
    progress.ended("write", "");
    let settings = settings::of_files(args, &options, scene);
    let mut report = AssemblyReport::of(scene, &made, (&file, &options), settings);
    report.command.clone_from(&args.again);
    let outputs = args.out.iter().zip(&files);
    report.outputs = outputs.map(|(f, file)| convert::output(&f.path, file)).collect();
    report.seconds = progress.seconds();
    report.peak_rss_mb = progress::peak_rss_mb();
    let write =
        |file: &super::report::ReportFile| output::write(&file.path, |out| report.write_json(out));
    let reports = args.report.iter().map(write).collect::<Result<Vec<_>, _>>()?;
    progress.finish();
    Pending::publish(reports.into_iter().chain(files).collect())?;
    let names: Vec<String> = args.out.iter().map(|f| streams::shown(&f.path)).collect();
    let places = plural(scene.place_count(), "place");
    progress.result(&format!("{count} in {places} → {}", names.join(", ")));
    report.hints.iter().for_each(|hint| progress.hint(hint));
    Ok(outcome)
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
