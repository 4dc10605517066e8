//! Writer of STEP files.
//!
//! The input is a [`Brep`] or an [`Assembly`]. The output is a file of ISO 10303-21 with the schema of AP203, AP214 or
//! AP242.

mod admin;
mod analytic;
mod assembly;
mod geometry;
mod part21;
mod product;
pub(crate) mod read;
mod seams;
mod shape;
mod style;

use std::io;

use crate::assembly::Assembly;
use crate::brep::{Brep, FaceId};
use part21::{FileHeader, Part21};
use product::{ProductNames, ProductWriter};
use shape::StepColours;

/// The application protocol of a file. The default is AP242.
///
/// The geometry is the same in all three. The header, the contexts and the administrative data
/// differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Schema {
    /// ISO 10303-203 `CONFIG_CONTROL_DESIGN`. It is for old programs.
    Ap203,
    /// ISO 10303-214 `AUTOMOTIVE_DESIGN`.
    Ap214,
    /// ISO 10303-242 managed model-based 3D engineering.
    #[default]
    Ap242,
}

/// The content of a STEP file besides its geometry.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// The application protocol.
    pub schema: Schema,
    /// The ISO 8601 date and time, for example `1970-01-01T00:00:00`.
    pub time_stamp: String,
    /// The name and the version of the program that created the data.
    pub originating_system: String,
    /// The colour of the faces (sRGB). `None` writes no colour. AP203 has no colours, so it is
    /// ignored there.
    pub colour: Option<[u8; 3]>,
    /// The colours of faces that have another one.
    pub face_colours: Vec<(FaceId, [u8; 3])>,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            schema: Schema::default(),
            time_stamp: "1970-01-01T00:00:00".into(),
            originating_system: "scan2step".into(),
            colour: None,
            face_colours: Vec::new(),
        }
    }
}

/// Writes `brep` as one product: its solids, and its sheets as a surface model.
///
/// Each entity instance is written as soon as it has a number, so that only one line is in memory.
/// The same input gives the same bytes. `out` should be buffered, because it receives small pieces.
///
/// # Errors
/// An error of kind `InvalidInput` before anything is written, if `brep` does not satisfy
/// [`Brep::check`]. Otherwise the errors of `out`.
pub fn write(brep: &Brep, options: &Options, out: &mut dyn io::Write) -> io::Result<()> {
    brep.check()?;
    let header = FileHeader {
        name: &brep.name,
        time_stamp: &options.time_stamp,
        originating_system: &options.originating_system,
        schema: product::file_schema(options.schema),
        content: brep.content(),
    };
    let mut file = Part21::begin(out, &header)?;
    let names = ProductNames { id: &brep.name, name: &brep.name, description: &brep.description };
    let product = ProductWriter::begin(&mut file, options)?.write(&mut file, &names)?;
    let colours = match options.schema {
        Schema::Ap203 => StepColours::default(),
        _ => StepColours { part: options.colour, faces: &options.face_colours },
    };
    shape::write(&mut file, brep, (product.shape, colours))?;
    file.end()
}

/// Writes an assembly: a product for each part and each group, and their places. Each part is written once. The colour of
/// `options` is not used, because parts have their own.
///
/// # Errors
/// An error of kind `InvalidInput` before anything is written, if `assembly` does not satisfy
/// [`Assembly::check`]. Otherwise the errors of `out`.
pub fn write_assembly(
    assembly: &Assembly,
    options: &Options,
    out: &mut dyn io::Write,
) -> io::Result<()> {
    assembly.check()?;
    let header = FileHeader {
        name: assembly.name(),
        time_stamp: &options.time_stamp,
        originating_system: &options.originating_system,
        schema: product::file_schema(options.schema),
        content: assembly.content(),
    };
    let mut file = Part21::begin(out, &header)?;
    assembly::write(&mut file, assembly, options)?;
    file.end()
}
