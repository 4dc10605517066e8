//! A disk's map to the unit square, in two steps: coarse, and then fine.

use super::hierarchy::Hierarchy;
use super::layout::{self, Layout, Round};
use super::rectangle::Rectangle;
use super::stars::Stars;
use super::weights::Weights;
use super::{Method, Options, coarse, corners, mean_value, mend, stretch};
use crate::error::{Error, Result};
use crate::geometry::{Uv, VertexId};
use crate::mesh::Mesh;
use crate::progress::{self, Progress};

/// Vertices of the mesh whose curvature counts: fewer than a scan has, so that
/// its noise does not.
const WEIGHED: usize = 30_000;

/// Vertices of the mesh on which corners are tried.
const COARSE: usize = 400;

/// The share of a map's time after which it is usually made for those few.
const STARTED: f64 = 0.35;

/// A disk taken down to a few vertices, and their map.
pub struct Start<'a> {
    mesh: &'a Mesh,
    outer: Vec<u32>,
    hierarchy: Hierarchy,
    weights: Weights,
    weighed: usize,
    corners: [u32; 4],
    first: coarse::First,
}

/// A map to the unit square.
pub struct Map {
    /// One parameter point a vertex.
    pub uv: Vec<Uv>,
    /// The vertices at the corners, the first at (0, 0).
    pub corners: [u32; 4],
    /// Triangles that rounding had inverted and that were mended.
    pub mended: usize,
    /// Whether much of it is stretched far more one way than the other.
    pub is_drawn_out: bool,
}

impl<'a> Start<'a> {
    /// The coarse map with the best of some sets of four corners. Vertices from
    /// `skirt` on are a skirt's.
    pub fn new(
        mesh: &'a Mesh,
        outer: &[VertexId],
        skirt: usize,
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
        let mut hierarchy = Hierarchy::new(Stars::new(mesh, outer));
        let progress = &mut progress::part(progress, 0.0, STARTED);
        hierarchy.coarsen(points, &kept, WEIGHED, |_| (), progress)?;
        let area = stretch::area(points, layout::triangles(&hierarchy.stars, &hierarchy.left));
        let weighed = hierarchy.left.len();
        let mut weights = Weights::by_curvature(points, &hierarchy, area);
        weights.lighten(skirt);
        hierarchy.coarsen(points, &kept, COARSE, |removal| weights.lump(removal), progress)?;
        let outer: Vec<u32> = outer.iter().map(|v| v.0).collect();
        let first = coarse::least_stretched(points, &outer, &hierarchy, &weights, &sets)?;
        let corners = sets[first.set];
        Ok(Start { mesh, outer, hierarchy, weights, weighed, corners, first })
    }

    /// By how much the L² stretch of the coarse map, a skirt left out, is above 1.
    pub fn excess(&self) -> f64 {
        self.first.stretch - 1.0
    }

    /// The map of all vertices, with a margin of this share of the square at each side.
    pub fn map(mut self, method: Method, margin: f64, progress: &mut Progress) -> Result<Map> {
        let rectangle = Rectangle::new(&self.outer, &self.corners);
        let progress = &mut progress::part(progress, STARTED, 1.0);
        let mut uv = match method {
            Method::LeastStretch => self.least_stretch(&rectangle, progress)?,
            Method::MeanValue => self.mean_value(&rectangle)?,
        };
        // Before the map is verified: rounding may turn slivers over here, too.
        if margin > 0.0 {
            uv.iter_mut().for_each(|at| *at = at.map(|t| margin + (1.0 - 2.0 * margin) * t));
        }
        let triangles = self.mesh.triangles.iter().map(|t| t.map(|v| v.0));
        let (mended, folded) = mend::mend(&self.hierarchy.stars, triangles, &mut uv);
        match folded.first() {
            Some(t) => {
                Err(Error::Folded { count: folded.len(), at: self.mesh.points[t[0] as usize] })
            }
            None => {
                let is_drawn_out = self.first.round == Round::FIRM;
                Ok(Map { uv, corners: self.corners, mended, is_drawn_out })
            }
        }
    }

    /// Puts all vertices back and takes the stretch out on the way.
    fn least_stretch(&mut self, rectangle: &Rectangle, progress: &mut Progress) -> Result<Vec<Uv>> {
        let points = &self.mesh.points;
        let mut at = vec![Uv::origin(); points.len()];
        let places = self.hierarchy.left.iter().zip(&self.first.at);
        places.for_each(|(&v, &place)| at[v as usize] = place);
        let freedom = rectangle.freedom(points.len());
        let weights = std::mem::take(&mut self.weights);
        let (weighed, size, round) = (self.weighed, self.first.size, self.first.round);
        let mut layout = Layout { points, weights, weighed, freedom, size, at, round };
        layout.refine(&mut self.hierarchy, progress)?;
        Ok(rectangle.to_unit_square(layout.size, &layout.at))
    }

    /// Puts all vertices back and solves for them.
    fn mean_value(&mut self, rectangle: &Rectangle) -> Result<Vec<Uv>> {
        while self.hierarchy.refine(|_| ()) {}
        let mut at = vec![Uv::origin(); self.mesh.points.len()];
        let size = rectangle.lay(&self.mesh.points, 1.0, &mut at);
        let mut uv = rectangle.to_unit_square(size, &at);
        mean_value::map(&self.mesh.points, &self.hierarchy.stars, &mut uv)?;
        Ok(uv)
    }
}
