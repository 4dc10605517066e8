//! A patch with parameters: what the parameterization makes, and knots, fit and trim take.

use super::Patch;
use crate::geometry::{Uv, VertexId};

/// Where the outer boundary of a patch is mapped to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outline {
    /// To the four sides of the square.
    Sides,
    /// Inside the square, to a curve that suits the surface; the face is cut along
    /// it.
    Free,
}

/// A patch with a parameter point for every vertex.
#[derive(Debug, Clone)]
pub struct Parameterized {
    /// The patch, with the vertices that mending added.
    pub patch: Patch,
    /// Parameter points in [0, 1]², one a vertex.
    pub uv: Vec<Uv>,
    /// Where the outer boundary is.
    pub outline: Outline,
    /// What is around it, if it lies inside the square.
    pub skirt: Skirt,
}

impl Parameterized {
    /// The same with all lengths times a factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Parameterized { patch: self.patch.scaled(factor), ..self }
    }

    /// The numbers of the triangles that were measured.
    pub(crate) fn measured_triangles(&self) -> Vec<usize> {
        self.patch.measured_triangles().collect()
    }
}

/// The domain around an outer boundary that lies inside it: as long as none of these
/// triangles turns over, nor any of the patch, the boundary does not cross itself.
#[derive(Debug, Clone, Default)]
pub struct Skirt {
    /// Triangles; their vertices are the patch's and then the skirt's.
    pub triangles: Vec<[VertexId; 3]>,
    /// Parameter points of the skirt's vertices.
    pub uv: Vec<Uv>,
}
