//! Writer of IGES files.
//!
//! The input is a [`Brep`] or an [`Assembly`]. The output is a file of version 5.3 of the Initial Graphics Exchange
//! Specification in the fixed ASCII form with 80 columns.

mod compose;
mod curves;
mod entity;
mod global;
mod parameters;
mod plan;
pub(crate) mod read;
mod section;
mod surfaces;

use std::io;

use crate::assembly::Assembly;
use crate::brep::{Brep, FaceId};
use entity::Entity;
use global::FileSummary;

/// The representation of trimmed surfaces in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Form {
    /// Trimmed surfaces (entity 144), which share no edges. Every program reads them.
    #[default]
    Trimmed,
    /// Solids (entity 186) and open shells (entity 514 form 2), whose faces share edges.
    Brep,
}

/// The content of an IGES file besides its geometry.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// The representation of trimmed surfaces. The default is [`Form::Trimmed`].
    pub form: Form,
    /// The ISO 8601 date and time, for example `1970-01-01T00:00:00`.
    pub time_stamp: String,
    /// The name of the file itself.
    pub file_name: String,
    /// The name and the version of the program that created the data.
    pub originating_system: String,
    /// The colour of the faces (sRGB). `None` writes no colour.
    pub colour: Option<[u8; 3]>,
    /// The colours of faces that have another one.
    pub face_colours: Vec<(FaceId, [u8; 3])>,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            form: Form::default(),
            time_stamp: "1970-01-01T00:00:00".into(),
            file_name: String::new(),
            originating_system: "scan2step".into(),
            colour: None,
            face_colours: Vec::new(),
        }
    }
}

/// Writes `brep` as one root entity: a solid, a shell, a trimmed surface, or a group of these.
///
/// IGES is ASCII, so other characters of names become `_`. The directory comes before the
/// parameters and has their numbers of lines. The parameters are composed twice so that they need
/// not be kept in memory. The same input gives the same bytes. `out` should be buffered, because it
/// receives small pieces.
///
/// # Errors
/// An error of kind `InvalidInput` before anything is written, if `brep` does not satisfy
/// [`Brep::check`] or needs line numbers of more than seven digits. Otherwise the errors of `out`.
pub fn write(brep: &Brep, options: &Options, out: &mut dyn io::Write) -> io::Result<()> {
    brep.check()?;
    let header = FileSummary {
        name: &brep.name,
        content: brep.content(),
        description: &brep.description,
        uncertainty_mm: brep.uncertainty_mm,
        reach: brep.reach(),
    };
    write_entities(&plan::part(brep, options), (&header, options), out)
}

/// Writes an assembly. Each part and each group is a subfigure (entity 308) that is defined once, and each place is an
/// instance of it (408) with a matrix (124). The colour of `options` is not used, because parts have their own.
///
/// # Errors
/// An error of kind `InvalidInput` before anything is written, if `assembly` does not satisfy
/// [`Assembly::check`] or needs line numbers of more than seven digits. Otherwise the errors of `out`.
pub fn write_assembly(
    assembly: &Assembly,
    options: &Options,
    out: &mut dyn io::Write,
) -> io::Result<()> {
    assembly.check()?;
    let header = FileSummary {
        name: assembly.name(),
        content: assembly.content(),
        description: "",
        uncertainty_mm: assembly.uncertainty_mm(),
        reach: assembly.reach(),
    };
    write_entities(&plan::assembly(assembly, options.form), (&header, options), out)
}

fn write_entities(
    entities: &[Entity<'_>],
    (header, options): (&FileSummary<'_>, &Options),
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let lines = section::count_lines(entities)?;
    let start = global::start(header, out)?;
    let global = global::write(header, options, out)?;
    section::directory(entities, &lines, out)?;
    section::parameters(entities, out)?;
    let counts = [start, global, 2 * entities.len(), lines.iter().sum()];
    section::terminate(counts, out)
}
