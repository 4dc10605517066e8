//! The entry: from a scan to what became of it.

use std::borrow::Cow;

use formats::{Content, Points, Soup};

use super::{
    Conversion, Memory, Observer, Options, Stage, cloud, components, mesh_components, stage,
};
use crate::error::Result;
use crate::mesh::Components;
use crate::threads;

/// A scan: a mesh or a cloud of points as they were read, or the components of a mesh.
#[derive(Debug)]
pub enum Scan<'a> {
    /// Polygons.
    Mesh(Cow<'a, Soup>),
    /// Points.
    Cloud(Points),
    /// The components of a mesh ([`mesh_components`], [`cloud_components`](super::cloud_components)). The
    /// options must not name places by vertices.
    Components(&'a Components),
}

impl<'a> From<&'a Soup> for Scan<'a> {
    fn from(soup: &'a Soup) -> Self {
        Scan::Mesh(Cow::Borrowed(soup))
    }
}

impl From<Points> for Scan<'_> {
    fn from(cloud: Points) -> Self {
        Scan::Cloud(cloud)
    }
}

impl<'a> From<&'a Components> for Scan<'a> {
    fn from(components: &'a Components) -> Self {
        Scan::Components(components)
    }
}

impl From<Content> for Scan<'_> {
    fn from(content: Content) -> Self {
        match content {
            Content::Mesh(soup) => Scan::Mesh(Cow::Owned(soup)),
            Content::Points(cloud) => Scan::Cloud(cloud),
        }
    }
}

/// Converts a scan to the shape that the options name, or to the one that suits it: a solid if it is closed or
/// nearly so, a shell if it has handles or is a pipe, and otherwise a face. If one face does not hold a sheet
/// well, a shell is tried. If there is no sound shell, a face has to do.
///
/// `watch` is shown [`Stage::Begin`] before each try, and after it what each stage makes of each
/// component. An error of its own stops the conversion, such as [`Error::Stopped`](crate::error::Error::Stopped). The work is shared by
/// as many threads as [`Builder::threads`](super::Builder::threads) says. `watch` is called on one of them.
///
/// The tolerance of a cloud follows the noise of its points, and the deviation is measured against them. Lengths
/// and places of the result are mm from the cloud's origin, unless
/// [`Builder::keeps_origin`](super::Builder::keeps_origin) puts the result into its own place.
///
/// # Errors
/// What stops a stage, or what `watch` answers. [`Error::Piece`](crate::error::Error::Piece) names the component if there are several.
pub fn convert<'a>(
    scan: impl Into<Scan<'a>>,
    options: &Options,
    watch: &mut Observer,
) -> Result<Conversion> {
    let scan = match scan.into() {
        Scan::Mesh(soup) if options.remesh => Scan::Cloud(Points::of_mesh(&soup)),
        other => other,
    };
    let (memory, options) = match &scan {
        Scan::Mesh(soup) => (Some(Memory::of(soup, options)), options.resolved(soup)?),
        Scan::Cloud(cloud) => {
            let memory = Memory::of_cloud(cloud.len(), options);
            (Some(memory), options.resolved_in_cloud(cloud)?)
        }
        Scan::Components(_) => {
            options.places.check()?;
            (None, options.clone())
        }
    };
    let options = match (memory, options.max_memory) {
        (Some(memory), Some(most)) => options.fitting(&memory, most)?,
        _ => options,
    };
    threads::run(options.threads, || match scan {
        Scan::Mesh(soup) => {
            let (components, colour) = (mesh_components(&soup, &options)?, soup.colour);
            drop(soup);
            let made = components::converted(&components, &options, watch)?;
            Ok(Conversion { colour, ..made })
        }
        Scan::Cloud(cloud) => {
            let mut progress = stage::within("cloud", watch);
            let (scan, report) = cloud::components_of(cloud, &options, &mut progress)?;
            drop(progress);
            watch(Stage::Cloud(&report))?;
            components::converted(&scan, &options, watch)
        }
        Scan::Components(scan) => components::converted(scan, &options, watch),
    })?
}
