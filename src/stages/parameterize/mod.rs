//! Parameterization (Tekumalla & Cohen 2005, section 3.3). A patch goes in; the same patch with a
//! parameter point in the unit square for every vertex comes out. The boundary is mapped to the
//! square, the inside follows by mean value coordinates (Floater 2003), and the remaining stretch
//! is reduced.
//!
//! Mean value coordinates on a fixed square compress protruding parts of the patch, down to the
//! limits of double precision. They are therefore solved on a coarse mesh of a few vertices. The
//! other vertices are added from coarse to fine, and the stretch is reduced on the way.
//!
//! With [`MapMethod::MeanValue`] the coordinates are solved on the whole mesh and not changed
//! further.
//!
//! The boundary may also be left free inside the square. This is done where it is ragged, and where
//! straight sides would stretch the map far more than the surface requires.

mod bays;
mod chords;
mod coarse;
mod compressed;
mod corners;
mod insertion;
mod lu;
mod mend;
mod outline;
mod rectangle;
mod rectangle_map;
mod relax;
mod scaffold;
mod solve;
mod square_map;
mod stretch;
mod sweep_mesh;
mod weights;

use crate::error::{Result, of};
use crate::geometry::Point;
use crate::mesh::Patch;
use crate::progress::{self, Progress};
use crate::rules;

pub use crate::mesh::{Outline, Parameterized, Scaffold};
pub use bays::Bays;
pub use compressed::{CompressedRegion, compressed_region};
pub(crate) use scaffold::is_ragged;
pub use stretch::Stretch;

/// The kind of map.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum MapMethod {
    /// The map with the least stretch, found by local moves from coarse to fine.
    #[default]
    LeastStretch,
    /// The map of the paper: mean value coordinates, with the boundary placed by chord length. It
    /// compresses protruding parts.
    MeanValue,
}

/// The options of parameterization.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Four points, in mm, near the corners of the domain, in either direction around it. The
    /// vertex nearest to the first point is mapped to (0, 0). With `None`, the default, the corners
    /// are found.
    pub corners: Option<[Point; 4]>,
    /// The place of the outer boundary. With `None`, the default, it is mapped to the sides of the
    /// square unless it is ragged, or the sides stretch the map far more than necessary, or the
    /// boundary cannot be divided into four sides; it is then left free. It is never left free by
    /// default if `corners` are given or `method` is [`MapMethod::MeanValue`].
    pub outline: Option<Outline>,
    /// The kind of map. The default is [`MapMethod::LeastStretch`].
    pub method: MapMethod,
}

impl Options {
    /// Whether the outer boundary may, or must, be left free inside the square.
    pub(crate) fn may_be_free(&self) -> bool {
        let unsaid = self.corners.is_none() && self.method == MapMethod::LeastStretch;
        self.outline.map_or(unsaid, |outline| outline == Outline::Free)
    }

    pub(crate) fn check(&self) -> Result<()> {
        self.corners.map_or(Ok(()), |corners| rules::points(&corners)).map_err(of("corners"))
    }
}

/// The quality of the map.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Report {
    /// The number of inverted triangles, by an exact predicate.
    pub flipped: usize,
    /// The number of triangles that rounding had inverted and that were repaired.
    pub mended: usize,
    /// The number of vertices that were inserted into edges. These edges joined two boundary
    /// vertices through the inside, or the map stretched them strongly.
    pub split_edges: usize,
    /// The stretch of the measured triangles.
    pub stretch: Stretch,
    /// The bays of the outer boundary that were closed for the map.
    pub bays: Bays,
}

/// Maps a patch to the unit square.
///
/// # Errors
/// - [`Error::Corners`](crate::error::Error::Corners) or [`Error::TooSmall`](crate::error::Error::TooSmall) if
///   the outer boundary cannot be divided into four sides with these corners.
/// - [`Error::Folded`](crate::error::Error::Folded) if triangles stay inverted.
/// - [`Error::Option`](crate::error::Error::Option) if a corner is not a finite point.
pub fn parameterize(patch: Patch, options: &Options) -> Result<(Parameterized, Report)> {
    parameterize_with(patch, options, &mut progress::ignore)
}

/// Like [`parameterize`], and reports progress to `progress`.
///
/// # Errors
/// Those of [`parameterize`], and any error that `progress` returns.
pub fn parameterize_with(
    patch: Patch,
    options: &Options,
    progress: &mut Progress,
) -> Result<(Parameterized, Report)> {
    options.check()?;
    if !options.may_be_free() {
        return outline::map(patch, options, progress);
    }
    let (patch, bays) = bays::close(patch.without_bays().unwrap_or(patch), None);
    let (mut map, mut report) =
        outline::map(patch, options, &mut progress::step(progress, 0, MAX_REMAPS + 1))?;
    report.bays = bays;
    let free = Options { outline: Some(Outline::Free), ..options.clone() };
    for round in 1..=MAX_REMAPS {
        if map.outline != Outline::Free || report.split_edges > 0 {
            break;
        }
        let open = map.patch.without_bays().unwrap_or_else(|| map.patch.clone());
        let (patch, bays) = bays::close(open, Some(&map.uv));
        if patch.outer == map.patch.outer && patch.mesh.triangles == map.patch.mesh.triangles {
            break;
        }
        let mut part = progress::step(progress, round, MAX_REMAPS + 1);
        let (next, how) = outline::map(patch, &free, &mut part)?;
        if how.stretch.l2 > MAX_STRETCH_GROWTH * report.stretch.l2 {
            break;
        }
        (map, report) = (next, Report { bays, ..how });
    }
    if map.outline == Outline::Sides {
        report.bays = Bays::default();
    }
    Ok((map, report))
}

/// The largest number of times that bays are closed again as the latest map shows them. The map
/// changes with the bays.
const MAX_REMAPS: usize = 2;

/// A new map is rejected if its stretch exceeds that of the map before by this factor.
const MAX_STRETCH_GROWTH: f64 = 1.02;
