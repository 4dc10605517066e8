//! Pictures without a graphics card: a scan, coloured by its deviation, and the
//! face that it becomes, drawn with depth into an image.
//!
//! What is here is for looking at; nothing of it goes into a CAD file. The same
//! conversion gives the same pixels on any number of threads.

pub mod camera;
pub mod canvas;
pub mod colour;
pub mod image;
pub mod lines;
pub mod occlusion;
pub mod scale;
pub mod sheet;
pub mod text;
mod thin;
mod trimmed;

pub use camera::Camera;
pub use canvas::Canvas;
pub use image::Image;
pub use thin::{Thinned, thin};
pub use trimmed::{outlines, polyline, tessellate};
