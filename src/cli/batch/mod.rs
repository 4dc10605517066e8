//! `scan2step batch`: many scans, a CAD file each, and a summary.

pub(crate) mod args;
mod job;
mod record;
mod scans;
mod summary;

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::{ArgMatches, ValueEnum};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use scan2step::words::plural;

use super::{Failure, Outcome, output, streams, temp_files};
use args::Batch;
use job::Job;
use record::Record;
use scans::{FoundScan, UnusedFile};
use summary::{Row, Status};

/// Finds the scans, converts those that need it, and writes the summaries.
pub(crate) fn run(args: &Batch, matches: &ArgMatches) -> Result<Outcome, Failure> {
    let folder = args.out.join(record::FOLDER);
    let (scans, left_out) = scans::find(&args.scans, &args.out)?;
    scans.iter().for_each(|scan| output::protect(&scan.path));
    // The user named the folder that holds it.
    temp_files::folder(&folder).map_err(|e| output::failed(&args.out, e))?;
    let job = job(args, matches)?;
    let mine: Vec<usize> =
        (0..scans.len()).filter(|&k| args.shard.is_none_or(|shard| shard.has(k))).collect();
    let voice = Voice::new(args, mine.len());
    voice.say_left_out(&left_out);
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<Option<Row>>> = Mutex::new(scans.iter().map(|_| None).collect());
    std::thread::scope(|scope| {
        for _ in 0..args.jobs {
            scope.spawn(|| {
                while let Some(&k) = mine.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let row = one(&job, &scans[k], args.force);
                    voice.say(&row);
                    if let Ok(mut done) = done.lock() {
                        done[k] = Some(row);
                    }
                }
            });
        }
    });
    voice.bar.finish_and_clear();
    let done = done.into_inner().unwrap_or_default();
    let rows = summary::write(&args.out, &scans, done, &left_out)?;
    if !args.manner.quiet {
        streams::print(summary::table(&rows).as_bytes())?;
    }
    let mine = mine.iter().filter_map(|&k| rows.get(k)?.record.as_ref().map(Status::of));
    Ok(mine.fold(Outcome::Done, |all, status| match status {
        Status::Failed => all.and(Outcome::Failed),
        Status::Missed => all.and(Outcome::Missed),
        _ => all,
    }))
}

/// Whether a word of a command line names a file among the records of a batch.
pub(crate) fn is_record(word: &str) -> bool {
    let folder = Path::new(word).parent().and_then(Path::file_name);
    folder.is_some_and(|folder| folder == record::FOLDER)
}

/// Converts a scan unless an earlier run has done so.
fn one(job: &Job, scan: &FoundScan, force: bool) -> Row {
    let earlier = Record::read(&job.out, scan).filter(|_| !force);
    let earlier = earlier.filter(|record| record.holds(&job.out, scan, &job.fingerprint));
    let skipped = earlier.is_some();
    let record = earlier.unwrap_or_else(|| job.run(scan));
    let status = if skipped { Status::Skipped } else { Status::of(&record) };
    Row { scan: scan.clone(), status, record: Some(record) }
}

fn job(args: &Batch, matches: &ArgMatches) -> Result<Job, Failure> {
    let program = std::env::current_exe().map_err(|e| Failure {
        error: format!("scan2step: its own place cannot be told: {e}"),
        help: "call scan2step by its path".into(),
    })?;
    let names = args.report.iter().filter_map(ValueEnum::to_possible_value);
    let mut reports: Vec<String> = names.map(|v| format!("report.{}", v.get_name())).collect();
    reports.sort();
    reports.dedup();
    let cad: Vec<String> = args.format.extensions().iter().map(|&e| e.into()).collect();
    let options = args::passed_on(matches);
    let stamp = std::env::var("SOURCE_DATE_EPOCH").map(|s| format!("SOURCE_DATE_EPOCH={s}"));
    let fingerprint = options.iter().chain(&cad).chain(&reports).cloned().chain(stamp.ok());
    let fingerprint = fingerprint.collect();
    let cores = std::thread::available_parallelism().map_or(1, |n| n.get());
    // Scans that run at the same time share the cores, unless the user names the threads.
    let shared = (args.jobs > 1).then(|| (cores / usize::from(args.jobs)).clamp(1, 1024) as u16);
    let threads = args.manner.threads.or(shared);
    let memory = args.manner.max_memory.map(|size| size.as_u64());
    Ok(Job { memory, program, out: args.out.clone(), cad, reports, options, fingerprint, threads })
}

/// The number of files left out that have a line of their own, so that they fit on a screen.
const LISTED: usize = 10;

/// The messages about each scan.
struct Voice {
    bar: ProgressBar,
    quiet: bool,
    verbose: bool,
}

impl Voice {
    fn new(args: &Batch, scans: usize) -> Voice {
        let quiet = args.manner.quiet;
        let target =
            if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(scans as u64), target);
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {elapsed}") {
            bar.set_style(style.progress_chars("━╸─"));
        }
        bar.enable_steady_tick(std::time::Duration::from_millis(500));
        Voice { bar, quiet, verbose: args.manner.verbose }
    }

    /// Names files that are not converted, with the reason.
    fn say_left_out(&self, left_out: &[UnusedFile]) {
        if self.quiet {
            return;
        }
        let most = if self.verbose { left_out.len() } else { LISTED };
        self.bar.suspend(|| {
            for UnusedFile { file, reason } in left_out.iter().take(most) {
                streams::say(format_args!("left out: {file} {reason}"));
            }
            if left_out.len() > most {
                let rest = plural(left_out.len() - most, "other file");
                streams::say(format_args!("left out: {rest}; summary.json names all"));
            }
        });
    }

    /// Prints the status of a scan. A quiet run prints errors only.
    fn say(&self, row: &Row) {
        self.bar.inc(1);
        let (place, of) = (self.bar.position(), self.bar.length().unwrap_or(0));
        let record = row.record.as_ref();
        self.bar.suspend(|| {
            if !self.quiet {
                let seconds = record.map_or(0.0, |r| r.seconds);
                let (name, file) = (row.status.name(), row.scan.path.display());
                let why = match row.status {
                    Status::Skipped => " (converted earlier; --force converts it again)",
                    _ => "",
                };
                streams::say(format_args!("[{place}/{of}] {name:7} {seconds:7.1} s  {file}{why}"));
            }
            let failed = row.status == Status::Failed;
            if let Some(error) = record.and_then(|r| r.error.as_ref()) {
                let word = if failed { "error" } else { "note" };
                streams::say(format_args!("{word}: {error}"));
            }
            if let Some(help) = record.and_then(|r| r.help.as_ref()) {
                streams::say(format_args!("help: {help}"));
            }
            if self.verbose || !self.quiet && row.status != Status::Skipped {
                record
                    .iter()
                    .flat_map(|r| &r.hints)
                    .for_each(|hint| streams::say(format_args!("hint: {hint}")));
            }
        });
    }
}
