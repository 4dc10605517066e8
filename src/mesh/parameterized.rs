//! A patch with a parameter point for every vertex. The stage `parameterize` makes it; the stages
//! that place knots, fit and trim take it.

use super::Patch;
use crate::geometry::{Uv, VertexId};

/// Where the outer boundary of a patch is mapped to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outline {
    /// The outer boundary is mapped to the four sides of the unit square.
    Sides,
    /// The outer boundary is mapped to a curve inside the unit square that suits the surface. The
    /// face is trimmed along this curve.
    Free,
}

/// A patch with a parameter point for every vertex.
#[derive(Debug, Clone)]
pub struct Parameterized {
    /// The patch, including the vertices that `parameterize` added to repair the map.
    pub patch: Patch,
    /// Parameter points in [0, 1]², one for each vertex.
    pub uv: Vec<Uv>,
    /// Where the outer boundary is mapped to.
    pub outline: Outline,
    /// The triangles between the outer boundary and the square; empty for [`Outline::Sides`].
    pub scaffold: Scaffold,
}

impl Parameterized {
    /// The patch with all lengths multiplied by a factor. The parameters stay.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Parameterized { patch: self.patch.scaled(factor), ..self }
    }

    /// The numbers of the measured triangles.
    pub(crate) fn measured_triangles(&self) -> Vec<usize> {
        self.patch.measured_triangles().collect()
    }
}

/// Triangles that cover the domain around an outer boundary that lies inside the square (scaffold:
/// Jiang, Schaefer, Panozzo, "Simplicial Complex Augmentation Framework for Bijective Maps", 2017).
/// As long as no triangle of the scaffold or of the patch is inverted, the boundary does not cross
/// itself.
#[derive(Debug, Clone, Default)]
pub struct Scaffold {
    /// The triangles. Vertex numbers count the vertices of the patch first and those of the
    /// scaffold after them.
    pub triangles: Vec<[VertexId; 3]>,
    /// Parameter points of the scaffold's own vertices.
    pub uv: Vec<Uv>,
}
