//! Parameterization (Tekumalla & Cohen 2005, section 3.3): the boundary goes
//! to the unit square, the inside follows by mean value coordinates (Floater
//! 2003), and what stretch that leaves is taken out.
//!
//! Mean value coordinates on a fixed square crush what sticks out of the patch,
//! down to where double precision loses it. So they are solved on a mesh of a
//! few vertices, and the stretch is taken out while the others come back, coarse
//! to fine.
//!
//! On request mean value coordinates are solved on the whole mesh and left as they are.
//!
//! Where the boundary is ragged, or straight sides would stretch the map far more than
//! the surface asks for, it is left free inside the square.

mod aggregates;
mod chords;
mod coarse;
mod corners;
mod crushed;
mod gaps;
mod hierarchy;
mod layout;
mod level;
mod map;
mod mean_value;
mod mend;
mod multigrid;
mod rectangle;
mod relax;
mod skirt;
mod solve;
mod sparse;
mod stars;
mod stretch;
mod weights;

use map::{Map, Start};

use crate::course::{self, Course};
use crate::error::{Error, Result, of};
use crate::geometry::{Point, Uv, VertexId};
use crate::mesh::{Bound, Mesh, Patch};
use crate::rules;

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

/// Which map is made.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Method {
    /// The one that stretches least, by local moves from coarse to fine.
    #[default]
    LeastStretch,
    /// The paper's: mean value coordinates with the sides by chord length. It crushes
    /// what sticks out.
    MeanValue,
}

/// How to parameterize.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Points next to which the four corners of the domain lie, in any
    /// direction around; the first becomes (0, 0). `None`: found.
    pub corners: Option<[Point; 4]>,
    /// Where the outer boundary goes. `None`: to the sides, unless it is ragged, or
    /// they stretch the map far more than is needed, or cannot be made, and neither
    /// corners nor mean values are asked for.
    pub outline: Option<Outline>,
    /// Which map is made.
    pub method: Method,
}

impl Options {
    /// Whether the outer boundary may, or must, be left free inside the square.
    pub(crate) fn may_be_free(&self) -> bool {
        let unsaid = self.corners.is_none() && self.method == Method::LeastStretch;
        self.outline.map_or(unsaid, |outline| outline == Outline::Free)
    }

    pub(crate) fn check(&self) -> Result<()> {
        self.corners.map_or(Ok(()), |corners| rules::points(&corners)).map_err(of("corners"))
    }
}

/// How good the map is.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Report {
    /// Inverted triangles, by an exact predicate.
    pub flipped: usize,
    /// Triangles that rounding had inverted and that were mended.
    pub mended: usize,
    /// Vertices put on edges that joined two boundary vertices through the inside, or that
    /// the map draws out.
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
    /// What is around it, if it lies inside the square.
    pub skirt: Skirt,
}

impl Parameterized {
    /// The same with all lengths times a factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Parameterized { patch: self.patch.scaled(factor), ..self }
    }
}

impl Parameterized {
    /// The numbers of the triangles that were measured.
    pub(crate) fn measured_triangles(&self) -> Vec<usize> {
        stretch::measured(&self.patch).collect()
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

/// Maps a patch to the unit square.
///
/// # Errors
/// [`Error::Corners`], [`Error::TooSmall`]:
/// the outer boundary cannot be four sides with these corners.
/// [`Error::Folded`]: triangles stay inverted.
/// [`Error::Option`]: a corner that is no point.
pub fn parameterize(patch: Patch, options: &Options) -> Result<(Parameterized, Report)> {
    parameterize_with(patch, options, &mut course::untold)
}

/// The same, telling how far it has come.
///
/// # Errors
/// Those of [`parameterize`], and what `course` answers.
pub fn parameterize_with(
    patch: Patch,
    options: &Options,
    course: &mut Course,
) -> Result<(Parameterized, Report)> {
    options.check()?;
    let must_be_free = options.outline == Some(Outline::Free);
    let may_be_free = options.may_be_free() && !must_be_free;
    let is_ragged = || skirt::is_ragged(&patch.mesh, patch.loop_of(Bound::Outer));
    if must_be_free || may_be_free && is_ragged() {
        return left_free(patch, options, course);
    }
    // Sides are the measured boundary's; what is free goes around its bays.
    let (mut patch, with_bays) = match patch.without_bays() {
        Some(without) => (without, Some(patch)),
        None => (patch, None),
    };
    let split_edges = chords::split_chords(&mut patch);
    let sides = Start::new(&patch.mesh, &patch.outer, patch.mesh.points.len(), options, course);
    let sides = match sides {
        // A boundary that cannot be four sides can be a loop.
        Err(Error::TooSmall(_) | Error::Singular(_)) if may_be_free => {
            return left_free(with_bays.unwrap_or(patch), options, course);
        }
        sides => sides?,
    };
    if may_be_free && sides.excess() > LITTLE {
        let around = with_bays.as_ref().unwrap_or(&patch);
        let (mesh, outer) = skirt::skirted(around);
        let free = Start::new(&mesh, &outer, around.mesh.points.len(), options, course)?;
        if free.excess() < WORTH * sides.excess() {
            let map = free.map(options.method, MARGIN, course)?;
            let (patch, split_edges) = with_bays.map_or((patch, split_edges), |whole| (whole, 0));
            return Ok(reported(with_skirt(patch, &mesh, &map), &map, split_edges));
        }
    }
    let map = sides.map(options.method, 0.0, course)?;
    let first = patch.outer.iter().position(|v| v.0 == map.corners[0]);
    patch.outer.rotate_left(first.unwrap_or(0));
    let (uv, outline, skirt) = (map.uv.clone(), Outline::Sides, Skirt::default());
    Ok(reported(Parameterized { patch, uv, outline, skirt }, &map, split_edges))
}

/// The map of a patch whose boundary is left free inside the square.
fn left_free(
    patch: Patch,
    options: &Options,
    course: &mut Course,
) -> Result<(Parameterized, Report)> {
    let (mesh, outer) = skirt::skirted(&patch);
    let start = Start::new(&mesh, &outer, patch.mesh.points.len(), options, course)?;
    let map = start.map(options.method, MARGIN, course)?;
    Ok(reported(with_skirt(patch, &mesh, &map), &map, 0))
}

/// Sides that stretch a map by less are kept.
const LITTLE: f64 = 0.03;

/// A boundary is left free if no more than this share of the stretch remains.
const WORTH: f64 = 0.5;

/// A patch and its skirt on the map of both.
fn with_skirt(patch: Patch, mesh: &Mesh, map: &Map) -> Parameterized {
    let mut uv = map.uv.clone();
    let skirt = Skirt {
        uv: uv.split_off(patch.mesh.points.len()),
        triangles: mesh.triangles[patch.mesh.triangles.len()..].to_vec(),
    };
    Parameterized { patch, uv, outline: Outline::Free, skirt }
}

/// The patch on its map, with vertices where that draws it out.
fn reported(
    mut patch: Parameterized,
    map: &Map,
    mut split_edges: usize,
) -> (Parameterized, Report) {
    let mut mended = map.mended;
    if map.is_drawn_out {
        split_edges += gaps::bridge(&mut patch);
        mended += mend_again(&mut patch);
    }
    let stretch = stretch::measure(&patch.patch, &patch.uv);
    let flipped = flipped(&patch).len();
    (patch, Report { flipped, mended, split_edges, stretch })
}

/// The triangles of a patch that its map turns over, by an exact predicate.
fn flipped(map: &Parameterized) -> Vec<[u32; 3]> {
    let triangles = map.patch.mesh.triangles.iter().map(|t| t.map(|v| v.0));
    mend::inverted(triangles, &map.uv)
}

/// Mends what rounding turns over where vertices are put in the middle of edges. Returns
/// how many triangles that were.
fn mend_again(map: &mut Parameterized) -> usize {
    if flipped(map).is_empty() {
        return 0;
    }
    let Patch { mesh, outer, .. } = &map.patch;
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| v.0));
    mend::mend(&stars::Stars::new(mesh, outer), triangles, &mut map.uv).0
}

/// The share of the domain that is left free beside a skirt at each side.
const MARGIN: f64 = 0.02;

#[cfg(test)]
mod tests {
    use super::*;
    use stars::tests::grid;

    /// A grid on the square with some vertices thrown onto others, as the map of a patch.
    fn thrown(n: u32, swapped: [usize; 2], is_drawn_out: bool) -> (Parameterized, Map) {
        let patch = grid(n);
        let side = f64::from(n - 1);
        let mut uv: Vec<Uv> = patch.mesh.points.iter().map(|p| Uv::new(p.x, p.y) / side).collect();
        uv.swap(swapped[0], swapped[1]);
        let map = Map { uv: uv.clone(), corners: [0; 4], mended: 0, is_drawn_out };
        (Parameterized { patch, uv, outline: Outline::Sides, skirt: Skirt::default() }, map)
    }

    #[test]
    fn the_report_counts_what_the_map_turns_over() {
        let (patch, map) = thrown(12, [2, 3], false);
        assert!(reported(patch, &map, 0).1.flipped > 0);
        let (patch, map) = thrown(12, [40, 40], false);
        assert_eq!(reported(patch, &map, 0).1.flipped, 0);
    }

    #[test]
    fn what_is_turned_over_where_a_map_is_drawn_out_is_mended() {
        let (patch, map) = thrown(12, [40, 41], true);
        let before = flipped(&patch).len();
        let (patch, report) = reported(patch, &map, 0);
        assert!(before > 0 && report.mended > 0);
        assert_eq!((report.flipped, flipped(&patch).len()), (0, 0));
    }
}
