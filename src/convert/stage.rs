//! What is told of a conversion while it goes on.

use super::{Body, TargetShape};
use crate::error::Result;
use crate::mesh::{Disk, Patch, QuadMesh};
use crate::spline::{Network, NetworkCut, Surface};
use crate::stages::parameterize::{CompressedRegion, Parameterized};
use crate::stages::regions::Regions;
use crate::stages::{cloud, trim};

/// A stage that has just ended, with what it made, or one that goes on.
#[derive(Debug)]
#[non_exhaustive]
pub enum Stage<'a> {
    /// A conversion of components to a shape begins. What was shown
    /// before it led to no result.
    Begin {
        /// The shape that is tried.
        shape: TargetShape,
        /// The number of components, voids included.
        components: usize,
        /// Why this shape is tried, as the end of a sentence, if nobody named it.
        why: Option<&'a str>,
    },
    /// What was found in a cloud of points, of which a mesh was made.
    Cloud(&'a cloud::Report),
    /// The cleaned mesh.
    Mesh(&'a Disk),
    /// The exact regions of a clean mesh.
    Regions(&'a Regions),
    /// The smoothed mesh.
    Smooth(&'a Disk),
    /// The mesh with its holes filled.
    Fill(&'a Patch),
    /// The filled mesh with parameters, and where it leaves too little room for
    /// the tolerance.
    Parameterize(&'a Parameterized, Option<CompressedRegion>),
    /// The fitted surface.
    Fit(&'a Surface),
    /// The loops: the outer one unless it is on the surface's sides, those of the
    /// holes and of the islands in them.
    Trim(&'a Surface, &'a [trim::TrimLoop]),
    /// The quads on a body, one block for each face.
    Layout(&'a QuadMesh),
    /// The surfaces of a body.
    Network(&'a Network),
    /// The loops along the gaps of a shell.
    NetworkTrim(&'a Network, &'a NetworkCut),
    /// The boundary representation.
    Brep,
    /// The deviation.
    Deviation,
    /// The next stages are those of the component at this position.
    Component(usize),
    /// A component is converted.
    Done(&'a Body),
    /// The stage of that name goes on, and has about so large a share of its time behind
    /// it: more than it was told of before.
    Within(&'static str, f64),
}

/// A callback that sees each [`Stage`]. An error of its own stops the conversion, and is what
/// [`convert`](crate::convert) answers: [`Error::Stopped`](crate::error::Error::Stopped) where its
/// caller wants no more. It is called on one of the threads that share the work.
pub type Observer<'a> = dyn FnMut(Stage) -> Result<()> + Send + 'a;

impl Stage<'_> {
    /// Its name, as reports and progress have it.
    pub fn name(&self) -> &'static str {
        match self {
            Stage::Begin { .. } => "begin",
            Stage::Cloud(_) => "cloud",
            Stage::Mesh(_) => "mesh",
            Stage::Regions(_) => "regions",
            Stage::Smooth(_) => "smooth",
            Stage::Fill(_) => "fill",
            Stage::Parameterize(..) => "parameterize",
            Stage::Fit(_) => "fit",
            Stage::Trim(..) | Stage::NetworkTrim(..) => "trim",
            Stage::Layout(_) => "layout",
            Stage::Network(_) => "network",
            Stage::Brep => "brep",
            Stage::Deviation => "deviation",
            Stage::Component(_) => "component",
            Stage::Done(_) => "done",
            Stage::Within(name, _) => name,
        }
    }
}

/// What a stage comes farther by is told from this share on.
const STEP: f64 = 0.01;

/// Tells `watch` how far a stage has come: forwards only, and not at every step.
pub(super) fn within<'a>(
    name: &'static str,
    watch: &'a mut Observer,
) -> impl FnMut(f64) -> Result<()> + 'a {
    let mut reported = 0.0;
    move |share| {
        if share < reported + STEP {
            return Ok(());
        }
        reported = share.min(1.0);
        watch(Stage::Within(name, reported))
    }
}
