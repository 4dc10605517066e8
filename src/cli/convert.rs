//! `scan2step convert`: one scan to one or more files.

use std::io::Write;
use std::path::Path;
use std::time::{Duration, SystemTime};

use formats::{Brep, iges, step};
use scan2step::mesh::{Bound, Components};
use scan2step::parameterize::Crushed;
use scan2step::{Conversion, Cut, KnotOptions, Options, Stage, fit, mesh, parameterize, smooth};

use super::args::{CadFile, CadKind, Component, Convert, Fit, Iges, Outline, Schema};
use super::input::{self, Scan};
use super::output::{self, Pending};
use super::places::Corners;
use super::progress::{Progress, mm};
use super::report;
use super::stages::Stages;
use super::{Failure, Outcome, plural};

/// Reads, converts, writes.
pub fn run(args: &Convert) -> Result<Outcome, Failure> {
    input::use_threads(args.threads)?;
    check_outputs(args)?;
    let mut progress = Progress::new(args.quiet, args.verbose);
    let mut stages = args.stages.as_deref().map(Stages::new).transpose()?;
    let scan = Scan::read(&args.piece)?;
    progress.ended("read");
    if scan.unit_assumed {
        progress.say("units: the file does not say; assuming mm (--units to change)");
    }
    let options = options(args, &scan)?;
    let (scan, components) = scan.components()?;
    let repaired = components.repairs().clone();
    repaired.iter().for_each(|repair| say_repaired(&progress, repair));
    let chosen = chosen(args, &components, options.outer, &progress);
    let mut conversions = Vec::with_capacity(chosen.len());
    for &component in &chosen {
        if let (Some(s), Some(root), true) = (&mut stages, &args.stages, chosen.len() > 1) {
            s.component(root, conversions.len())?;
        }
        let mut watch = |stage: Stage| -> scan2step::Result<()> {
            progress.ended(name(&stage));
            if let Stage::Parameterize(_, Some(crushed)) = &stage {
                say_crushed(&progress, crushed);
            }
            Ok(stages.as_mut().map_or(Ok(()), |s| s.write(&stage))?)
        };
        let options = Options { component, ..options.clone() };
        let converted = scan2step::convert_component(&components, &options, &mut watch);
        conversions.push(converted.map_err(|e| input::stopped(&args.piece.scan, &e))?);
    }
    drop(components);
    let files = write_cad(args, &conversions, scan.colour)?;
    progress.ended("write");
    for c in &conversions {
        let at_rims = c.input.repairs.iter().filter(|(kind, _)| !repaired.contains_key(*kind));
        at_rims.for_each(|repair| say_repaired(&progress, repair));
        describe(&progress, args, c);
    }
    let outputs = args.out.iter().map(|f| f.path.as_path()).zip(&files).collect();
    let context = report::Context {
        scan: &scan,
        tolerance_named: args.tolerance.is_some(),
        outliers_pct: args.outliers,
        outputs,
        progress: &progress,
    };
    let value = report::json(&conversions, &context);
    let text = |out: &mut dyn Write| {
        serde_json::to_writer_pretty(&mut *out, &value)?;
        writeln!(out)
    };
    let mut pending = stages.map_or(Vec::new(), |s| s.pending);
    for path in &args.report {
        pending.push(output::write(path, text)?);
    }
    // Every file is complete by now; putting them in place comes last.
    pending.into_iter().chain(files).try_for_each(Pending::publish)?;
    Ok(conversions.iter().fold(Outcome::Done, |all, c| all.and(verdict(args, c))))
}

/// The components to convert.
fn chosen(
    args: &Convert,
    scan: &Components,
    outer: mesh::Outer,
    progress: &Progress,
) -> Vec<mesh::Choice> {
    match args.component {
        Component::Largest => vec![mesh::Choice::Largest],
        Component::Number(n) => vec![mesh::Choice::Number(n)],
        Component::All => {
            let chosen = scan.without_islands(outer);
            if chosen.len() < scan.count() {
                let rest = match scan.sizeable() - chosen.len() {
                    0 => "the rest is dust",
                    _ if scan.sizeable() == scan.count() => {
                        "the rest are islands in holes of these"
                    }
                    _ => "the rest is dust, and islands in holes of these",
                };
                progress.say(&format!("component: {} of {}; {rest}", chosen.len(), scan.count()));
            }
            chosen.into_iter().map(mesh::Choice::Number).collect()
        }
    }
}

/// Two outputs at one place, or one over the scan, would destroy each other; and
/// a folder that is not there is better said before the work than after.
fn check_outputs(args: &Convert) -> Result<(), Failure> {
    let real = |path: &Path| std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let scan = real(&args.piece.scan);
    let mut seen = Vec::new();
    for path in args.out.iter().map(|f| &f.path).chain(&args.report) {
        let place = real(path);
        if place == scan || seen.contains(&place) {
            let error = format!("{}: is named twice", path.display());
            return Err(Failure { error, help: "give every output a name of its own".into() });
        }
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
        if folder.is_some_and(|f| !f.is_dir()) || path.is_dir() {
            let error = format!("{}: cannot be written there", path.display());
            return Err(Failure { error, help: "name a file in a folder that exists".into() });
        }
        seen.push(place);
    }
    Ok(())
}

fn failure(args: &Convert, what: &str, help: &str) -> Failure {
    Failure { error: format!("{}: {what}", args.piece.scan.display()), help: help.into() }
}

fn options(args: &Convert, scan: &Scan) -> Result<Options, Failure> {
    let resolve = |places: &super::places::Places| scan.resolve(places);
    let corners = args.corners.as_ref().map(resolve).transpose()?;
    let corners = corners.map(|c| {
        <[_; 4]>::try_from(c)
            .map_err(|_| failure(args, "--corners: not four corners", "name exactly four"))
    });
    let corners = corners.transpose()?;
    // The loop that has the corners is the outer one, unless another is named.
    let outer = match (scan.outer(&args.piece)?, corners) {
        (mesh::Outer::Auto, Some([first, ..])) => mesh::Outer::Near(first),
        (outer, _) => outer,
    };
    let boundary_corners = match &args.boundary_corners {
        Corners::Auto => smooth::Corners::Auto,
        Corners::None => smooth::Corners::None,
        Corners::At(places) => smooth::Corners::At(resolve(places)?),
    };
    let cut = match (args.keep_fills, args.fill_only_holes_below) {
        (true, _) => Cut::None,
        (false, Some(length)) => Cut::FromLength(length),
        (false, None) => Cut::All,
    };
    Ok(Options {
        name: part_name(&args.piece.scan),
        unit_mm: scan.unit.in_mm(),
        outer,
        smooth: smooth::Options { support: args.smooth, corners: boundary_corners },
        parameterize: parameterize::Options {
            corners,
            outline: match args.outline {
                Outline::Auto => None,
                Outline::Sides => Some(parameterize::Outline::Sides),
                Outline::Trimmed => Some(parameterize::Outline::Free),
            },
        },
        knots: KnotOptions {
            kappa: args.kappa,
            depth: args.depth,
            net: args.net,
            max_net: args.max_net,
        },
        method: match args.fit {
            Fit::Blend => fit::Method::Blend,
            Fit::Refined => fit::Method::Refined,
            Fit::Global => fit::Method::Global,
        },
        tolerance: args.tolerance,
        outliers: args.outliers / 100.0,
        cut,
        ..Options::default()
    })
}

/// The file's name without its folder and extensions.
fn part_name(scan: &Path) -> String {
    let stem = |p: &Path| p.file_stem().map(|s| s.to_string_lossy().into_owned());
    let zipped = scan.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
    let first = stem(scan).unwrap_or_default();
    if zipped { stem(Path::new(&first)).unwrap_or(first) } else { first }
}

fn name(stage: &Stage) -> &'static str {
    match stage {
        Stage::Mesh(_) => "mesh",
        Stage::Smooth(_) => "smooth",
        Stage::Fill(_) => "fill",
        Stage::Parameterize(..) => "parameterize",
        Stage::Fit(_) => "fit",
        Stage::Trim(..) => "trim",
        Stage::Brep => "brep",
        Stage::Deviation => "deviation",
    }
}

fn write_cad(
    args: &Convert,
    conversions: &[Conversion],
    colour: Option<[u8; 3]>,
) -> Result<Vec<Pending>, Failure> {
    let stamp = time_stamp();
    let step_options = step::Options { colour, ..step_options(args, &stamp) };
    let brep = Brep {
        name: part_name(&args.piece.scan),
        faces: conversions.iter().flat_map(|c| c.brep.faces.iter().cloned()).collect(),
        uncertainty_mm: conversions.iter().map(|c| c.brep.uncertainty_mm).fold(0.0, f64::max),
    };
    let mut files = Vec::new();
    for CadFile { path, kind } in &args.out {
        let content = |out: &mut dyn Write| match kind {
            CadKind::Step => step::write(&brep, &step_options, out),
            CadKind::Iges => {
                let options = iges::Options { colour, ..iges_options(args, &stamp, path) };
                iges::write(&brep, &options, out)
            }
        };
        files.push(output::write(path, content)?);
    }
    Ok(files)
}

/// SOURCE_DATE_EPOCH, or the epoch itself: the same input gives the same bytes.
fn time_stamp() -> String {
    let seconds = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|s| s.parse().ok());
    // Past the year 9999 there is no such time stamp.
    let seconds = seconds.filter(|s| *s < 253_402_300_800_u64).unwrap_or(0);
    let time = SystemTime::UNIX_EPOCH + Duration::from_secs(seconds);
    humantime::format_rfc3339_seconds(time).to_string().trim_end_matches('Z').to_string()
}

fn system() -> String {
    format!("scan2step {}", env!("CARGO_PKG_VERSION"))
}

fn step_options(args: &Convert, stamp: &str) -> step::Options {
    step::Options {
        schema: match args.schema {
            Schema::Ap203 => step::Schema::Ap203,
            Schema::Ap214 => step::Schema::Ap214,
            Schema::Ap242 => step::Schema::Ap242,
        },
        time_stamp: stamp.to_owned(),
        originating_system: system(),
        ..Default::default()
    }
}

fn iges_options(args: &Convert, stamp: &str, path: &Path) -> iges::Options {
    let file_name = path.file_name().map(|n| n.to_string_lossy().into_owned());
    iges::Options {
        form: match args.iges {
            Iges::Trimmed => iges::Form::Trimmed,
            Iges::Brep => iges::Form::Brep,
        },
        time_stamp: stamp.to_owned(),
        file_name: file_name.unwrap_or_default(),
        originating_system: system(),
        ..Default::default()
    }
}

fn say_repaired(progress: &Progress, (kind, count): (&&str, &usize)) {
    progress.say(&format!("repaired: {count} {}", kind.replace('_', " ")));
}

fn describe(progress: &Progress, args: &Convert, c: &Conversion) {
    if c.input.left_out > 0 && args.component != Component::All {
        progress.say(&format!(
            "component: 1 of {}, {} triangles; left out {} triangles in the others",
            c.input.components, c.input.triangles, c.input.left_out
        ));
    }
    if c.input.islands > 0 {
        let triangles = c.input.island_triangles;
        progress.say(&format!("islands: {} kept, {triangles} triangles", c.input.islands));
    }
    if c.smooth.outliers > 0 {
        progress
            .say(&format!("smooth: {} left out of the fits", plural(c.smooth.outliers, "outlier")));
    }
    if args.tolerance.is_none() {
        progress.say(&format!(
            "tolerance: {}, from a noise of {} (--tolerance to change)",
            mm(c.tolerance),
            mm(c.smooth.noise)
        ));
    }
    let [m, n] = c.surface.shape();
    let files: Vec<_> = args.out.iter().map(|f| f.path.display().to_string()).collect();
    progress.say(&format!(
        "{m} × {n} control points, rms {}, max {}, {} cut out → {}",
        mm(c.fit_deviation.rms),
        mm(c.fit_deviation.max),
        plural(c.loops.iter().filter(|l| matches!(l.of, Bound::Hole(_))).count(), "hole"),
        files.join(", ")
    ));
}

/// Says where no affordable net can follow, before the time for it is spent.
fn say_crushed(progress: &Progress, crushed: &Crushed) {
    let ([m, n], at) = (crushed.spans, crushed.at);
    progress.say(&format!(
        "the map crushes what sticks out: near ({:.3}, {:.3}, {:.3}) the tolerance needs knots as close as in a net of {m:.0} × {n:.0}; cut the scan there and convert the pieces, or raise --tolerance or --max-net",
        at.x, at.y, at.z
    ));
}

/// Says it where a tolerance that the user named is not met.
fn verdict(args: &Convert, c: &Conversion) -> Outcome {
    if c.tolerance_met(args.outliers / 100.0) {
        return Outcome::Done;
    }
    let [x, y, z] = c.fit_deviation.max_at;
    let what = format!(
        "{} of {} points are farther than {} from the face; the worst, {}, at ({x:.3}, {y:.3}, {z:.3})",
        c.fit_deviation.beyond(c.tolerance),
        c.fit_deviation.distances.len(),
        mm(c.tolerance),
        mm(c.fit_deviation.max),
    );
    if args.tolerance.is_some() {
        eprintln!("tolerance not met: {what}");
        return Outcome::Missed;
    }
    if !args.quiet {
        eprintln!("note: {what}");
    }
    Outcome::Done
}
