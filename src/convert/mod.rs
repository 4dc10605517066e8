//! The ways from a scan to CAD. Each calls stages in its order, and has a file of its own: a sheet
//! becomes one face (`face.rs`), and a body becomes a solid or a shell of several faces (`body.rs`).

mod body;
mod cloud;
mod components;
mod conversion;
pub mod cut;
mod estimate;
mod face;
mod face_options;
mod faces;
mod file;
mod goal;
mod hints;
mod input;
mod lengths;
mod memory;
mod options;
mod places;
mod refined;
mod scan;
mod shape;
mod stage;

pub use body::{BodyConversion, Seams, convert_body, joined_bodies};
pub use cloud::{cloud_components, convert_cloud, mesh_components};
pub use components::{convert_components, joined};
pub use conversion::{Conversion, Missed};
pub use cut::Cut;
pub use estimate::BodyEstimate;
pub use file::convert_file;
pub use input::{InputReport, Inspection, Measured, PieceReport, inspect, measured};
pub use memory::Memory;
pub use options::{Builder, Options};
pub use places::ScanPlace;
pub use scan::{Converted, ScanConversion, ScanObserver, convert_scan};
pub use shape::{TargetShape, shape, voids};
pub use stage::{Observer, Stage};

use formats::Soup;

use crate::error::Result;
use crate::mesh::Components;
use crate::threads;

/// Converts one component of a scan. `watch` is shown what each stage made, and how far
/// long ones have come. It stops the conversion with an error of its own, such as
/// [`Error::Stopped`](crate::error::Error::Stopped).
///
/// The work is shared by as many threads as [`Builder::threads`] says. `watch` is called on
/// one of them.
///
/// # Errors
/// What stops a stage, or what `watch` answers.
pub fn convert(soup: &Soup, options: &Options, watch: &mut Observer) -> Result<Conversion> {
    options.max_memory.map_or(Ok(()), |most| Memory::of(soup, options).check(most))?;
    let options = options.resolved(soup)?;
    threads::run(options.threads, || component(&mesh_components(soup, &options)?, &options, watch))?
}

/// Converts one component of a mesh: readers → **mesh → smooth → fill →
/// parameterize → knots → fit → trim → brep** → writers. Many of one mesh share it; its
/// unit is that which it was made with.
///
/// # Errors
/// Those of [`convert`], but for the mesh. [`Error::Input`]: the options name places in the terms
/// of the scan's file, and [`Options::resolved`] was not called.
pub fn convert_component(
    scan: &Components,
    options: &Options,
    watch: &mut Observer,
) -> Result<Conversion> {
    options.places.check()?;
    threads::run(options.threads, || component(scan, options, watch))?
}

/// The same on the thread that calls.
fn component(scan: &Components, options: &Options, watch: &mut Observer) -> Result<Conversion> {
    let mut shown = lengths::Shown::new(watch, scan.mm());
    let own = options.in_lengths(scan.mm());
    match face::face(scan, &own, &mut |stage| shown.see(stage)) {
        Ok(conversion) => {
            let conversion = conversion.with_named(options);
            let hints = hints::of(&conversion, options);
            let brep = conversion::placed(conversion.brep, conversion.origin, options.keeps_origin);
            Ok(Conversion { brep, hints, ..conversion })
        }
        Err(error) => Err(shown.in_mm(error).with_named(options)),
    }
}
