//! The map of a disk to the unit square, in two steps: a coarse map, and its refinement.

use super::rectangle::Rectangle;
use super::rectangle_map::{self, ConvexWeight, RectangleMap};
use super::weights::Weights;
use super::{MapMethod, Options, coarse, corners, mend, solve, stretch};
use crate::error::{Error, Result};
use crate::geometry::{Uv, VertexId};
use crate::mesh::Mesh;
use crate::mesh::one_rings::OneRings;
use crate::mesh::progressive_mesh::{Collapsing, ProgressiveMesh, shape_loss};
use crate::progress::{self, Progress};

/// The number of vertices on which the curvature is measured. It is smaller than that of a scan, so
/// that noise does not count as curvature.
const WEIGHED: usize = 30_000;

/// The number of vertices of the mesh on which corners are tried.
const COARSE: usize = 400;

/// A disk simplified to a few vertices, with their map.
pub(crate) struct CoarseMap<'a> {
    mesh: &'a Mesh,
    outer: Vec<u32>,
    hierarchy: ProgressiveMesh,
    weights: Weights,
    weighed: usize,
    corners: [u32; 4],
    first: coarse::CoarseLayout,
}

/// A map to the unit square.
pub(crate) struct SquareMap {
    /// One parameter point for each vertex.
    pub uv: Vec<Uv>,
    /// The vertices at the corners. The first is at (0, 0).
    pub corners: [u32; 4],
    /// The number of triangles that rounding had inverted and that were repaired.
    pub mended: usize,
    /// Whether much of the map is stretched far more in one direction than in the other.
    pub is_drawn_out: bool,
}

impl<'a> CoarseMap<'a> {
    /// The coarse map with the best set of four corners. Vertices with numbers from `scaffold` on
    /// belong to the scaffold.
    pub(super) fn new(
        mesh: &'a Mesh,
        outer: &[VertexId],
        scaffold: usize,
        options: &Options,
        progress: &mut Progress,
    ) -> Result<Self> {
        let sets = match &options.corners {
            Some(points) => vec![corners::given(mesh, outer, points)?],
            None => corners::likely(mesh, outer)?,
        };
        let sets: Vec<[u32; 4]> = sets.iter().map(|set| set.map(|i| outer[i].0)).collect();
        let points = &mesh.points;
        let mut kept = vec![false; points.len()];
        sets.iter().flatten().for_each(|&v| kept[v as usize] = true);
        let mut hierarchy = ProgressiveMesh::new(OneRings::new(mesh, outer));
        let progress = &mut progress::step(progress, 0, 2);
        let loss = |rings: &OneRings, v| shape_loss(points, rings, v);
        let collapsing = Collapsing { points, kept: &kept, loss };
        hierarchy.coarsen(&collapsing, WEIGHED, |_| (), progress)?;
        let area =
            stretch::area(points, rectangle_map::triangles(&hierarchy.rings, &hierarchy.remaining));
        let weighed = hierarchy.remaining.len();
        let mut weights = Weights::by_curvature(points, &hierarchy, area);
        weights.lighten(scaffold);
        hierarchy.coarsen(&collapsing, COARSE, |collapse| weights.lump(collapse), progress)?;
        let outer: Vec<u32> = outer.iter().map(|v| v.0).collect();
        let first = coarse::least_stretched(points, &outer, &hierarchy, &weights, &sets)?;
        let corners = sets[first.set];
        Ok(CoarseMap { mesh, outer, hierarchy, weights, weighed, corners, first })
    }

    /// The amount by which the L² stretch of the coarse map exceeds 1. The scaffold is ignored.
    pub(crate) fn excess(&self) -> f64 {
        self.first.stretch - 1.0
    }

    /// The map of all vertices. `margin` is the share of the square that stays free at each side.
    pub(crate) fn map(
        mut self,
        method: MapMethod,
        margin: f64,
        progress: &mut Progress,
    ) -> Result<SquareMap> {
        let rectangle = Rectangle::new(&self.outer, &self.corners);
        let progress = &mut progress::step(progress, 1, 2);
        let mut uv = match method {
            MapMethod::LeastStretch => self.least_stretch(&rectangle, progress)?,
            MapMethod::MeanValue => self.mean_value(&rectangle)?,
        };
        // This comes before the verification, because rounding may invert slivers here as well.
        if margin > 0.0 {
            uv.iter_mut().for_each(|at| *at = at.map(|t| margin + (1.0 - 2.0 * margin) * t));
        }
        let triangles = self.mesh.triangles.iter().map(|t| t.map(|v| v.0));
        let (mended, folded) = mend::mend(&self.hierarchy.rings, triangles, &mut uv);
        match folded.first() {
            Some(t) => {
                Err(Error::Folded { count: folded.len(), at: self.mesh.points[t[0] as usize] })
            }
            None => {
                let is_drawn_out = self.first.convex_weight == ConvexWeight::FIRM;
                Ok(SquareMap { uv, corners: self.corners, mended, is_drawn_out })
            }
        }
    }

    /// Undoes all collapses and reduces the stretch on the way.
    fn least_stretch(&mut self, rectangle: &Rectangle, progress: &mut Progress) -> Result<Vec<Uv>> {
        let points = &self.mesh.points;
        let mut at = vec![Uv::origin(); points.len()];
        let places = self.hierarchy.remaining.iter().zip(&self.first.at);
        places.for_each(|(&v, &place)| at[v as usize] = place);
        let freedom = rectangle.freedom(points.len());
        let weights = std::mem::take(&mut self.weights);
        let (weighed, size, convex_weight) =
            (self.weighed, self.first.size, self.first.convex_weight);
        let mut layout =
            RectangleMap { points, weights, weighed, freedom, size, at, convex_weight };
        layout.refine(&mut self.hierarchy, progress)?;
        Ok(rectangle.to_unit_square(layout.size, &layout.at))
    }

    /// Undoes all collapses and solves for all vertices at once.
    fn mean_value(&mut self, rectangle: &Rectangle) -> Result<Vec<Uv>> {
        while self.hierarchy.refine(|_| ()) {}
        let mut at = vec![Uv::origin(); self.mesh.points.len()];
        let size = rectangle.lay(&self.mesh.points, 1.0, &mut at);
        let mut uv = rectangle.to_unit_square(size, &at);
        let rings = &self.hierarchy.rings;
        let is_inner = |v: &u32| !rings.on_boundary(*v) && !rings.ring(*v).is_empty();
        let inner: Vec<u32> = (0..uv.len() as u32).filter(is_inner).collect();
        solve::mean_value(&self.mesh.points, rings, &inner, &mut uv)?;
        Ok(uv)
    }
}
