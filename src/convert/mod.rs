//! The way from a scan to CAD. [`convert`] is the one entry. `components.rs` chooses what becomes of each component,
//! and each way from a component to a body has a file of its own, which calls the stages in its order: a sheet
//! becomes one face (`face.rs`), and anything else a solid or a shell of several faces (`body.rs`).

mod align;
mod assembly;
mod body;
mod cloud;
mod components;
mod conversion;
pub mod cut;
mod estimate;
mod exact;
mod exact_body;
mod exact_choice;
mod exact_distances;
mod face;
mod face_colours;
mod face_options;
mod faces;
mod file;
mod gaps;
mod goal;
mod hints;
mod input;
mod lengths;
mod memory;
mod options;
mod places;
mod refined;
mod scan;
mod scanned;
mod shape;
mod smoothed;
mod stage;

pub use assembly::{
    AssemblyConversion, ConvertedPart, InspectedPart, MeasuredPlace, MeasuredScene, PartObserver,
    ScenePart, SceneParts, convert_scene, cropped,
};
pub use cloud::{cloud_components, mesh_components};
pub use conversion::{
    Body, BodyFit, Conversion, ExactFace, ExactFit, FaceSize, LeftFilled, Missed, NetworkFit, Part,
    Seams, SurfaceFit,
};
pub use cut::Cut;
pub use estimate::BodyEstimate;
pub use exact::ExactEstimate;
pub use face_colours::PartColours;
pub use file::{convert_file, is_same_file};
pub use input::{InputReport, Inspection, Measured, PieceReport, inspect, measured};
pub use memory::{MeansOf, Memory};
pub use options::{Builder, EdgeChoice, Options, SurfaceChoice};
pub use places::ScanPlace;
pub use scan::{Scan, convert};
pub use shape::{TargetShape, shape, voids};
pub use stage::{Observer, Stage};
