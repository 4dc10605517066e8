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
mod skirt;
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
use crate::geometry::{Point, Uv, VertexId};
use crate::mesh::{Mesh, Patch};

pub use crushed::{Crushed, crushed};
pub use stretch::Stretch;

/// Where the outer boundary of a patch is mapped to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outline {
    /// To the four sides of the square.
    Sides,
    /// Inside the square, to a curve that suits the surface; the face is cut along
    /// it.
    Free,
}

/// How to parameterize.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Points next to which the four corners of the domain lie, in any
    /// direction around; the first becomes (0, 0). `None`: found.
    pub corners: Option<[Point; 4]>,
    /// Where the outer boundary goes. `None`: inside where it is ragged and no
    /// corners are given, else to the sides.
    pub outline: Option<Outline>,
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
    /// Where the outer boundary is.
    pub outline: Outline,
}

/// Maps a patch to the unit square.
pub fn parameterize(mut patch: Patch, options: &Options) -> Result<(Parameterized, Report)> {
    let outline = options.outline.unwrap_or_else(|| {
        let free = options.corners.is_none() && skirt::is_ragged(&patch);
        if free { Outline::Free } else { Outline::Sides }
    });
    let (split_edges, Map { uv, mended, .. }) = match outline {
        Outline::Sides => {
            let split_edges = chords::split_chords(&mut patch);
            let map = map(&patch.mesh, &patch.outer, patch.mesh.points.len(), options)?;
            let first = patch.outer.iter().position(|v| v.0 == map.corners[0]);
            patch.outer.rotate_left(first.unwrap_or(0));
            (split_edges, map)
        }
        Outline::Free => {
            let count = patch.mesh.points.len();
            let (mesh, outer) = skirt::skirted(&patch);
            let mut map = map(&mesh, &outer, count, options)?;
            map.uv.truncate(count);
            map.uv.iter_mut().for_each(|at| *at = inside(*at));
            (0, map)
        }
    };
    let stretch = stretch::measure(&patch, &uv);
    let report = Report { flipped: 0, mended, split_edges, stretch };
    Ok((Parameterized { patch, uv, outline }, report))
}

/// The share of the domain that is left free beside a skirt at each side.
const MARGIN: f64 = 0.02;

fn inside(at: Uv) -> Uv {
    at.map(|t| MARGIN + (1.0 - 2.0 * MARGIN) * t)
}

struct Map {
    uv: Vec<Uv>,
    corners: [u32; 4],
    mended: usize,
}

/// The map of a disk with the best of some sets of four corners. Vertices from
/// `skirt` on are a skirt's.
fn map(mesh: &Mesh, outer: &[VertexId], skirt: usize, options: &Options) -> Result<Map> {
    let sets = match &options.corners {
        Some(points) => vec![corners::given(mesh, outer, points)?],
        None => corners::likely(mesh, outer)?,
    };
    let sets: Vec<[u32; 4]> = sets.iter().map(|set| set.map(|i| outer[i].0)).collect();
    let points = &mesh.points;
    let outline: Vec<u32> = outer.iter().map(|v| v.0).collect();
    let mut kept = vec![false; points.len()];
    sets.iter().flatten().for_each(|&v| kept[v as usize] = true);
    let mut hierarchy = Hierarchy::new(Stars::new(mesh, outer));
    hierarchy.coarsen(points, &kept, WEIGHED, |_| ());
    let area = stretch::area(points, layout::triangles(&hierarchy.stars, &hierarchy.left));
    let weighed = hierarchy.left.len();
    let mut weights = Weights::by_curvature(points, &hierarchy, area);
    weights.lighten(skirt);
    hierarchy.coarsen(points, &kept, COARSE, |removal| weights.lump(removal));
    let first = coarse::least_stretched(points, &outline, &hierarchy, &weights, &sets)?;
    let rectangle = Rectangle::new(&outline, &sets[first.set]);
    let mut at = vec![Uv::origin(); points.len()];
    hierarchy.left.iter().zip(&first.at).for_each(|(&v, &place)| at[v as usize] = place);
    let freedom = rectangle.freedom(points.len());
    let mut layout = Layout { points, weights, weighed, freedom, size: first.size, at };
    layout.refine(&mut hierarchy);
    let mut uv = rectangle.to_unit_square(layout.size, &layout.at);
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| v.0));
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
