//! What the faces of a body shall be like.

use crate::error::{Result, of};
use crate::mesh::QuadMesh;
use crate::rules::Fault;
use crate::stages::adapt::KnotOptions;
use crate::stages::{net, patches};

/// What the faces shall be like.
pub(super) struct FaceOptions {
    /// About how many there should be.
    pub wanted: Option<usize>,
    pub knots: KnotOptions,
    /// The distance that the points may have from the faces.
    pub tolerance: f64,
    /// Whether the tolerance holds also for places on the faces.
    pub both_ways: bool,
    /// The share of points that may exceed the tolerance.
    pub outliers: f64,
}

impl FaceOptions {
    /// The options of a net. All faces together keep the bound on control points, unless nobody named one and the
    /// layout needs more.
    pub(super) fn net(&self, layout: &QuadMesh) -> Result<net::Options> {
        let (faces, most) = (layout.blocks(), self.knots.largest_net());
        let least = faces * patches::control_points(layout.side);
        if self.knots.max_net.is_some() && least > most {
            return Err(of("max_net")(Fault::LargeLayout { faces, least, most }));
        }
        let max_side = patches::largest_side(most / faces.max(1));
        Ok(net::Options { tolerance: self.tolerance, outliers: self.outliers, max_side })
    }
}
