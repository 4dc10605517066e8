//! What a run says on standard error, and how long its stages take.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use scan2step::words::printable;
use serde::Serialize;

use super::args::Steps;
use super::streams;

/// Seconds and memory of one stage.
#[derive(Debug, Clone)]
pub(crate) struct StageTime {
    pub name: &'static str,
    pub seconds: f64,
    pub peak_rss_mb: f64,
}

/// The stages in order, each with its share of the time that most runs take. The
/// first two and the last are passed once, the others for every component. A mesh passes the
/// second at once.
const STAGES: [(&str, u64); 11] = [
    ("read", 3),
    ("cloud", 10),
    ("mesh", 4),
    ("smooth", 15),
    ("fill", 10),
    ("parameterize", 20),
    ("fit", 35),
    ("trim", 3),
    ("brep", 2),
    ("deviation", 5),
    ("write", 3),
];

/// Steps of the bar for each of these.
const FINE: u64 = 100;

/// A line of `--progress json`.
#[derive(Serialize)]
struct Step<'a> {
    /// The stage that goes on, or has ended.
    stage: &'a str,
    /// About what share of its time it has behind it; 1 where it has ended.
    share: f64,
    /// Seconds since it began.
    seconds: f64,
}

/// The clock and the voice of a run.
#[derive(Debug)]
pub(crate) struct ProgressDisplay {
    /// Whether to speak in colours; `None`: not at all.
    voice: Option<bool>,
    verbose: bool,
    steps: Steps,
    begun: Instant,
    stage_begun: Instant,
    /// Shown on a terminal only.
    bar: ProgressBar,
    /// What stages that have ended took of the time.
    passed: u64,
    pub stages: Vec<StageTime>,
}

impl ProgressDisplay {
    /// The clock starts. `voice` says whether to speak in colours, or not at all; `steps` how
    /// to show how far the run has come, which lines of JSON do in a silent run, too.
    pub(super) fn new(voice: Option<bool>, verbose: bool, steps: Steps) -> Self {
        let now = Instant::now();
        let target = match (voice, steps) {
            // Hidden by itself where standard error is no terminal.
            (Some(_), Steps::Bar) => ProgressDrawTarget::stderr(),
            _ => ProgressDrawTarget::hidden(),
        };
        let bar = ProgressBar::with_draw_target(Some(length(1)), target);
        let looks = if voice == Some(true) {
            "{spinner:.cyan} {msg:13} {bar:40.cyan/dim} {elapsed}"
        } else {
            "{spinner} {msg:13} {bar:40} {elapsed}"
        };
        if let Ok(style) = ProgressStyle::with_template(looks) {
            bar.set_style(style.progress_chars("━╸─"));
        }
        bar.set_message(STAGES[0].0);
        bar.enable_steady_tick(Duration::from_millis(120));
        ProgressDisplay {
            voice,
            verbose,
            steps,
            begun: now,
            stage_begun: now,
            bar,
            passed: 0,
            stages: Vec::new(),
        }
    }

    /// So many components will be converted.
    pub(crate) fn expect(&self, components: usize) {
        self.bar.set_length(length(components as u64));
    }

    /// Says a line, unless the run is quiet.
    pub(crate) fn say(&self, line: &str) {
        self.say_as_is(&printable(line));
    }

    /// Says a line whose colours are made here.
    fn say_as_is(&self, line: &str) {
        if self.voice.is_some() {
            self.bar.suspend(|| streams::say_as_is(line));
        }
    }

    /// Says what could be better.
    pub(crate) fn hint(&self, line: &str) {
        self.say_as_is(&format!("{}: {}", self.paint("hint", "1;33"), printable(line)));
    }

    /// Says how it went.
    pub(crate) fn result(&self, line: &str) {
        self.say_as_is(&self.paint(&printable(line), "1"));
    }

    fn paint(&self, text: &str, code: &str) -> String {
        let coloured = self.voice == Some(true);
        if coloured { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_owned() }
    }

    /// Ends a stage, which made what the line says; the next one begins now.
    pub(crate) fn ended(&mut self, name: &'static str, made: &str) {
        let seconds = self.stage_begun.elapsed().as_secs_f64();
        let peak_rss_mb = peak_rss_mb();
        let memory = if self.verbose { format!("{peak_rss_mb:9.0} MB") } else { String::new() };
        match self.steps {
            Steps::Bar => {
                let line = format!("{name:13}{seconds:7.2} s{memory}  {made}");
                self.say_as_is(&self.paint(&printable(line.trim_end()), "2"));
            }
            Steps::Json => self.step(name, 1.0),
        }
        self.stages.push(StageTime { name, seconds, peak_rss_mb });
        if let Some(k) = place(name) {
            self.passed += STAGES[k].1;
            self.bar.set_position(FINE * self.passed);
            self.bar.set_message(STAGES.get(k + 1).map_or("report", |(next, _)| next));
        }
        self.stage_begun = Instant::now();
    }

    /// A stage has come so far.
    pub(crate) fn within(&self, name: &str, share: f64) {
        // The end of a stage has a line of its own.
        if self.steps == Steps::Json && share < 1.0 {
            self.step(name, share);
        }
        let length = place(name).map_or(0, |k| FINE * STAGES[k].1);
        self.bar.set_position(FINE * self.passed + (share * length as f64) as u64);
    }

    /// So many parts of a file are converted.
    pub(crate) fn of_parts(&self, done: usize, all: usize) {
        let share = done as f64 / all.max(1) as f64;
        if self.steps == Steps::Json && done < all {
            self.step("parts", share);
        }
        let each: u64 = STAGES[2..STAGES.len() - 1].iter().map(|(_, share)| share).sum();
        self.bar.set_position(FINE * self.passed + (share * (FINE * each) as f64) as u64);
        self.bar.set_message(format!("part {done} of {all}"));
    }

    /// Writes a line of JSON.
    fn step(&self, stage: &str, share: f64) {
        let seconds = self.stage_begun.elapsed().as_secs_f64();
        let [share, seconds] = [share, seconds].map(|x| (1000.0 * x).floor() / 1000.0);
        // A struct of a name and two numbers can be written as JSON.
        if let Ok(line) = serde_json::to_string(&Step { stage, share, seconds }) {
            streams::say(line);
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// Seconds since the run began.
    pub(crate) fn seconds(&self) -> f64 {
        self.begun.elapsed().as_secs_f64()
    }
}

impl Drop for ProgressDisplay {
    /// A run that failed leaves no bar over its error.
    fn drop(&mut self) {
        self.finish();
    }
}

/// Where a stage stands among all.
fn place(name: &str) -> Option<usize> {
    STAGES.iter().position(|(stage, _)| *stage == name)
}

/// The bar's length for a number of components.
fn length(components: u64) -> u64 {
    let [(_, first), (_, cloud), each @ .., (_, last)] = STAGES;
    FINE * (first + cloud + last + components * each.iter().map(|(_, share)| share).sum::<u64>())
}

/// The process's peak resident memory so far, in MB (10⁶ bytes); 0 where the
/// system does not tell.
pub(crate) fn peak_rss_mb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    let kib = line.and_then(|l| l.trim().trim_end_matches("kB").trim().parse::<f64>().ok());
    kib.unwrap_or(0.0) * 1024.0 / 1e6
}
