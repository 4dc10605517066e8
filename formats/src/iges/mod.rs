//! Writes IGES files: version 5.3 of the Initial Graphics Exchange
//! Specification, in its fixed 80-column ASCII form.

mod entity;
mod global;
mod parameters;
mod plan;
pub(crate) mod read;
mod section;

use std::io;

use crate::brep::Brep;

/// How a file says that a surface is trimmed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Form {
    /// Trimmed surfaces (entity 144), which every program reads; faces share
    /// no edges.
    #[default]
    Trimmed,
    /// Solids (entity 186) and open shells (entity 514 form 2), whose faces share edges.
    Brep,
}

/// What an IGES file says besides its geometry.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// Trimmed surfaces or a shell.
    pub form: Form,
    /// ISO 8601 date and time, for instance `1970-01-01T00:00:00`.
    pub time_stamp: String,
    /// The file's own name.
    pub file_name: String,
    /// The program the data come from, with its version.
    pub originating_system: String,
    /// The faces' colour (sRGB).
    pub colour: Option<[u8; 3]>,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            form: Form::default(),
            time_stamp: "1970-01-01T00:00:00".into(),
            file_name: String::new(),
            originating_system: "scan2step".into(),
            colour: None,
        }
    }
}

/// Writes `brep` as one root entity: a solid, a shell, a trimmed surface, or a group of
/// these.
///
/// IGES is ASCII, so other characters of names become `_`. The directory
/// stands before the parameters and says how many lines these take; they are
/// composed twice rather than kept. The same input gives the same bytes.
/// Buffer `out`: it gets small pieces.
///
/// # Errors
/// Of kind `InvalidInput`, before anything is written, where `brep` breaks the
/// rules of [`Brep::check`] or is too large for seven
/// digits of line numbers; otherwise those of `out`.
pub fn write(brep: &Brep, options: &Options, out: &mut dyn io::Write) -> io::Result<()> {
    brep.check()?;
    let entities = match options.form {
        Form::Trimmed => plan::trimmed(brep, options.colour),
        Form::Brep => plan::bodies(brep, options.colour),
    };
    let lines = section::count_lines(&entities)?;
    let start = global::start(out)?;
    let global = global::write(brep, options, brep.reach(), out)?;
    section::directory(&entities, &lines, out)?;
    section::parameters(&entities, out)?;
    let counts = [start, global, 2 * entities.len(), lines.iter().sum()];
    section::terminate(counts, out)
}
