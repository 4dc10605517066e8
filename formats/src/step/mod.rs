//! Writes STEP files: ISO 10303-21 with the schema of AP203, AP214 or AP242.

mod admin;
mod geometry;
mod part21;
mod product;
pub(crate) mod read;
mod shape;
mod style;

use std::io;

use crate::brep::Brep;
use part21::{FileHeader, Part21};

/// Which application protocol a file claims to follow.
///
/// The geometry is the same in all three; header, contexts and administrative
/// data differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Schema {
    /// ISO 10303-203 `CONFIG_CONTROL_DESIGN`, for old programs.
    Ap203,
    /// ISO 10303-214 `AUTOMOTIVE_DESIGN`.
    Ap214,
    /// ISO 10303-242 managed model based 3D engineering.
    #[default]
    Ap242,
}

/// What a STEP file says besides its geometry.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// The application protocol.
    pub schema: Schema,
    /// ISO 8601 date and time, for instance `1970-01-01T00:00:00`.
    pub time_stamp: String,
    /// The program the data come from, with its version.
    pub originating_system: String,
    /// The faces' colour (sRGB). AP203 knows none, and its files have none.
    pub colour: Option<[u8; 3]>,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            schema: Schema::default(),
            time_stamp: "1970-01-01T00:00:00".into(),
            originating_system: "scan2step".into(),
            colour: None,
        }
    }
}

/// Writes `brep` as one product: its solids, and its sheets as a surface model.
///
/// Entities leave as they are numbered; nothing is kept but one line. The same
/// input gives the same bytes. Buffer `out`: it gets small pieces.
///
/// # Errors
/// Of kind `InvalidInput`, before anything is written, where `brep` breaks the
/// rules of [`Brep::check`]; otherwise those of `out`.
pub fn write(brep: &Brep, options: &Options, out: &mut dyn io::Write) -> io::Result<()> {
    brep.check()?;
    let header = FileHeader {
        name: &brep.name,
        time_stamp: &options.time_stamp,
        originating_system: &options.originating_system,
        schema: product::file_schema(options.schema),
    };
    let mut file = Part21::begin(out, &header)?;
    let definition = product::write(&mut file, &brep.name, options)?;
    let colour = options.colour.filter(|_| options.schema != Schema::Ap203);
    shape::write(&mut file, brep, (definition, colour))?;
    file.end()
}
