//! What a conversion will make of a body, estimated without the long stages: fill → layout.

use super::TargetShape;
use crate::error::Result;
use crate::mesh::{self, Disk, Handle};
use crate::stages::{fill, layout};

/// An estimate of a body. Lengths are mm.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct BodyEstimate {
    /// About how many faces it gets.
    pub faces: usize,
    /// Its handles, shortest loops first. The loops run along the edges of a coarse mesh.
    pub handles: Vec<Handle>,
}

/// Estimates a body with this noise, in the lengths of its mesh.
pub(super) fn estimate(body: Disk, shape: TargetShape, noise: f64) -> Result<BodyEstimate> {
    let points = body.mesh.points.clone();
    let options = fill::Options { noise, ..fill::Options::default() };
    let (patch, _) = match shape {
        TargetShape::Shell => {
            fill::fill_of_shell(body, &points, &options, &mut crate::progress::ignore)?
        }
        _ => fill::fill(body, &points, &options)?,
    };
    let base = layout::base(&patch.even().mesh, &layout::Options::default())?;
    Ok(BodyEstimate { faces: base.triangles.len() / 2, handles: mesh::handles(&base) })
}
