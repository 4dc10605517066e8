//! The gaps of a body that are cut out of its faces.

use super::conversion::LeftFilled;
use super::{Options, TargetShape};
use crate::geometry::Bound;
use crate::mesh::boundary::Loop;
use crate::mesh::{Mesh, Patch};
use crate::spline::{Network, NetworkCut};
use crate::stages::trim;
use crate::stages::trim::network::{CutFault, NetworkRim};

/// The gaps that are cut out of the faces.
pub(super) struct Gaps {
    rims: Vec<NetworkRim>,
    options: trim::Options,
    /// Those that stay filled, as they cannot be cut out.
    pub left_filled: Vec<LeftFilled>,
}

impl Gaps {
    /// All gaps of a shell, and none of a solid.
    pub(super) fn of(patch: &Patch, shape: TargetShape, tolerance: f64, options: &Options) -> Self {
        let triangles = patch.measured_triangles().map(|t| patch.mesh.triangles[t]).collect();
        let normals = Mesh { points: patch.mesh.points.clone(), triangles }.vertex_normals();
        let rim = |(hole, rim): (usize, &Loop)| NetworkRim {
            of: Bound::Hole(hole),
            points: rim.iter().map(|&v| patch.mesh.point(v)).collect(),
            normals: rim.iter().map(|v| normals[v.index()]).collect(),
        };
        let rims: Vec<_> = match shape {
            TargetShape::Shell => patch.rims.iter().enumerate().map(rim).collect(),
            _ => Vec::new(),
        };
        let options = options.trim(tolerance, rims.iter().map(|rim| rim.points.as_slice()));
        Gaps { rims, options, left_filled: Vec::new() }
    }

    /// Cuts the gaps out of the faces.
    pub(super) fn cut(&self, network: &Network) -> Result<NetworkCut, CutFault> {
        trim::network::cut(network, &self.rims, &self.options)
    }

    /// Leaves the gap of a fault filled. Returns whether it may be: the longest rim is that of the scan as a
    /// whole, and what fills it is no part of a hole.
    pub(super) fn leave(&mut self, fault: &CutFault) -> bool {
        let longest = self.rims.iter().max_by(|a, b| a.length().total_cmp(&b.length()));
        let Some(at) = self.rims.iter().position(|rim| rim.of == fault.of) else { return false };
        let Bound::Hole(hole) = fault.of else { return false };
        if longest.is_some_and(|longest| longest.of == fault.of) {
            return false;
        }
        self.rims.remove(at);
        let at = fault.at.coords.into();
        self.left_filled.push(LeftFilled { hole, fault: fault.fault, at });
        true
    }

    /// Whether a gap is cut out of the faces.
    pub(super) fn is_cut(&self, hole: usize) -> bool {
        self.rims.iter().any(|rim| rim.of == Bound::Hole(hole))
    }
}
