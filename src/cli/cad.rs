//! The CAD files that `convert` writes.

use std::io::Write;
use std::path::Path;
use std::time::{Duration, SystemTime};

use formats::{Assembly, Brep, iges, step};
use scan2step::PartColours;

use super::args::{CadFile, CadKind, Convert, Iges, StepSchema};
use super::output::{self, Pending};
use super::{Failure, streams};

/// Writes a model into every file that was asked for.
pub(super) fn write(
    args: &Convert,
    brep: &Brep,
    colours: &PartColours,
) -> Result<Vec<Pending>, Failure> {
    let stamp = time_stamp()?;
    let (colour, face_colours) = (colours.part, colours.faces.clone());
    let step_options =
        step::Options { colour, face_colours: face_colours.clone(), ..step_options(args, &stamp) };
    let mut files = Vec::new();
    for CadFile { path, kind } in &args.out {
        let content = |out: &mut dyn Write| match kind {
            CadKind::Step => step::write(brep, &step_options, out),
            CadKind::Iges => {
                let face_colours = face_colours.clone();
                let of_file = iges_options(args, &stamp, path);
                let options = iges::Options { colour, face_colours, ..of_file };
                iges::write(brep, &options, out)
            }
        };
        files.push(output::write(path, content)?);
    }
    Ok(files)
}

/// Writes an assembly into every file that was asked for.
pub(crate) fn write_assembly(args: &Convert, assembly: &Assembly) -> Result<Vec<Pending>, Failure> {
    let stamp = time_stamp()?;
    let write = |CadFile { path, kind }: &CadFile| {
        let content = |out: &mut dyn Write| match kind {
            CadKind::Step => step::write_assembly(assembly, &step_options(args, &stamp), out),
            CadKind::Iges => iges::write_assembly(assembly, &iges_options(args, &stamp, path), out),
        };
        Ok(output::write(path, content)?)
    };
    args.out.iter().map(write).collect()
}

/// The last second of the year 9999. A time stamp has four digits for the year.
const LAST: u64 = 253_402_300_799;

/// The time stamp of files: SOURCE_DATE_EPOCH, or 1970 without it, so that the same input gives
/// the same bytes.
pub(crate) fn time_stamp() -> Result<String, Failure> {
    let asked = std::env::var_os("SOURCE_DATE_EPOCH").unwrap_or_else(|| "0".into());
    let seconds = asked.to_str().and_then(|s| s.parse().ok()).filter(|s| *s <= LAST);
    let seconds = seconds.ok_or_else(|| Failure {
        error: format!("SOURCE_DATE_EPOCH: {asked:?} is no number of seconds since 1970"),
        help: format!("set it to a whole number up to {LAST}, or unset it"),
    })?;
    let time = SystemTime::UNIX_EPOCH + Duration::from_secs(seconds);
    Ok(humantime::format_rfc3339_seconds(time).to_string().trim_end_matches('Z').to_string())
}

fn system() -> String {
    format!("scan2step {}", env!("CARGO_PKG_VERSION"))
}

/// The schema as the writer takes it.
pub(crate) fn schema(schema: StepSchema) -> step::Schema {
    match schema {
        StepSchema::Ap203 => step::Schema::Ap203,
        StepSchema::Ap214 => step::Schema::Ap214,
        StepSchema::Ap242 => step::Schema::Ap242,
    }
}

/// The form as the writer takes it.
pub(crate) fn form(form: Iges) -> iges::Form {
    match form {
        Iges::Trimmed => iges::Form::Trimmed,
        Iges::Brep => iges::Form::Brep,
    }
}

fn step_options(args: &Convert, stamp: &str) -> step::Options {
    step::Options {
        schema: schema(args.how.schema),
        time_stamp: stamp.to_owned(),
        originating_system: system(),
        ..Default::default()
    }
}

fn iges_options(args: &Convert, stamp: &str, path: &Path) -> iges::Options {
    let file_name = if streams::is_stdout(path) {
        Some(format!("{}.igs", args.part_name()))
    } else {
        path.file_name().map(|n| n.to_string_lossy().into_owned())
    };
    iges::Options {
        form: form(args.how.iges),
        time_stamp: stamp.to_owned(),
        file_name: file_name.unwrap_or_default(),
        originating_system: system(),
        ..Default::default()
    }
}

/// The file's name without its folder and extensions.
pub(crate) fn part_name(scan: &Path) -> String {
    let stem = |p: &Path| p.file_stem().map(|s| s.to_string_lossy().into_owned());
    let zipped = scan.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
    let first = stem(scan).unwrap_or_default();
    if zipped { stem(Path::new(&first)).unwrap_or(first) } else { first }
}
