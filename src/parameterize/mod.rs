//! Parameterization (Tekumalla & Cohen 2005, section 3.3): the boundary goes
//! to the unit square, the inside follows by mean value coordinates (Floater
//! 2003), and what stretch that leaves is taken out.
//!
//! Mean value coordinates on a fixed square crush what sticks out of the patch,
//! down to where double precision loses it. So they are solved on a mesh of a
//! few vertices, and the stretch is taken out while the others come back, coarse
//! to fine.

mod chords;
mod coarse;
mod corners;
mod crushed;
mod hierarchy;
mod layout;
mod mend;
mod rectangle;
mod relax;
mod solve;
mod stars;
mod stretch;
mod weights;

use hierarchy::Hierarchy;
use layout::Layout;
use rectangle::Rectangle;
use stars::Stars;
use weights::Weights;

use crate::error::{Error, Result};
use crate::geometry::{Point, Uv};
use crate::mesh::Patch;

pub use crushed::{Crushed, crushed};
pub use stretch::Stretch;

/// How to parameterize.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Points next to which the four corners of the domain lie, in any
    /// direction around; the first becomes (0, 0). `None`: found.
    pub corners: Option<[Point; 4]>,
}

/// How good the map is.
#[derive(Debug, Clone, Default)]
pub struct Report {
    /// Inverted triangles, by an exact predicate.
    pub flipped: usize,
    /// Triangles that rounding had inverted and that were mended.
    pub mended: usize,
    /// Vertices put on inner edges that joined two boundary vertices.
    pub split_edges: usize,
    /// How the measured triangles are stretched.
    pub stretch: Stretch,
}

/// A patch with a parameter point for every vertex.
#[derive(Debug, Clone)]
pub struct Parameterized {
    /// The patch, with the vertices that mending added.
    pub patch: Patch,
    /// Parameter points in [0, 1]², one a vertex.
    pub uv: Vec<Uv>,
}

/// Maps a patch to the unit square.
pub fn parameterize(mut patch: Patch, options: &Options) -> Result<(Parameterized, Report)> {
    let split_edges = chords::split_chords(&mut patch);
    let sets = match &options.corners {
        Some(points) => vec![corners::given(&patch, points)?],
        None => corners::likely(&patch)?,
    };
    let sets: Vec<[u32; 4]> = sets.iter().map(|set| set.map(|i| patch.outer[i].0)).collect();
    let Map { uv, corners, mended } = map(&patch, &sets)?;
    let first = patch.outer.iter().position(|v| v.0 == corners[0]);
    patch.outer.rotate_left(first.unwrap_or(0));
    let stretch = stretch::measure(&patch, &uv);
    let report = Report { flipped: 0, mended, split_edges, stretch };
    Ok((Parameterized { patch, uv }, report))
}

struct Map {
    uv: Vec<Uv>,
    corners: [u32; 4],
    mended: usize,
}

/// The map with the best of some sets of four corners.
fn map(patch: &Patch, sets: &[[u32; 4]]) -> Result<Map> {
    let points = &patch.mesh.points;
    let outer: Vec<u32> = patch.outer.iter().map(|v| v.0).collect();
    let mut kept = vec![false; points.len()];
    sets.iter().flatten().for_each(|&v| kept[v as usize] = true);
    let mut hierarchy = Hierarchy::new(Stars::new(patch));
    hierarchy.coarsen(points, &kept, WEIGHED, |_| ());
    let area = stretch::area(points, layout::triangles(&hierarchy.stars, &hierarchy.left));
    let weighed = hierarchy.left.len();
    let mut weights = Weights::by_curvature(points, &hierarchy, area);
    hierarchy.coarsen(points, &kept, COARSE, |removal| weights.lump(removal));
    let first = coarse::least_stretched(points, &outer, &hierarchy, &weights, sets)?;
    let rectangle = Rectangle::new(&outer, &sets[first.set]);
    let mut at = vec![Uv::origin(); points.len()];
    hierarchy.left.iter().zip(&first.at).for_each(|(&v, &place)| at[v as usize] = place);
    let freedom = rectangle.freedom(points.len());
    let mut layout = Layout { points, weights, weighed, freedom, size: first.size, at };
    layout.refine(&mut hierarchy);
    let mut uv = rectangle.to_unit_square(layout.size, &layout.at);
    let triangles = patch.mesh.triangles.iter().map(|t| t.map(|v| v.0));
    let (mended, folded) = mend::mend(&hierarchy.stars, triangles, &mut uv);
    match folded.first() {
        Some(t) => Err(Error::Folded { count: folded.len(), at: points[t[0] as usize] }),
        None => Ok(Map { uv, corners: sets[first.set], mended }),
    }
}

/// Vertices of the mesh whose curvature counts: fewer than a scan has, so that
/// its noise does not.
const WEIGHED: usize = 30_000;

/// Vertices of the mesh on which corners are tried.
const COARSE: usize = 400;
