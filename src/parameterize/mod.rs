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
mod bays;
mod bicgstab;
mod chords;
mod coarse;
mod corners;
mod crushed;
mod gaps;
mod hierarchy;
mod layout;
mod level;
mod lu;
mod map;
mod mean_value;
mod mend;
mod multigrid;
mod outline;
mod rectangle;
mod relax;
mod skirt;
mod solve;
mod sparse;
mod stars;
mod stretch;
mod weights;

use crate::error::{Result, of};
use crate::geometry::Point;
use crate::mesh::Patch;
use crate::progress::{self, Progress};
use crate::rules;

pub use crate::mesh::{Outline, Parameterized, Skirt};
pub use bays::Bays;
pub use crushed::{Crushed, crushed};
pub use stretch::Stretch;

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
    /// The bays of the outer boundary that the map goes around.
    pub bays: Bays,
}

/// Maps a patch to the unit square.
///
/// # Errors
/// [`Error::Corners`](crate::Error::Corners), [`Error::TooSmall`](crate::Error::TooSmall):
/// the outer boundary cannot be four sides with these corners.
/// [`Error::Folded`](crate::Error::Folded): triangles stay inverted.
/// [`Error::Option`](crate::Error::Option): a corner that is no point.
pub fn parameterize(patch: Patch, options: &Options) -> Result<(Parameterized, Report)> {
    parameterize_with(patch, options, &mut progress::ignore)
}

/// The same, telling how far it has come.
///
/// # Errors
/// Those of [`parameterize`], and what `progress` answers.
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
    let share = |round: u32| f64::from(round) / f64::from(AGAIN + 1);
    let (mut map, mut report) =
        outline::map(patch, options, &mut progress::part(progress, share(0), share(1)))?;
    report.bays = bays;
    let free = Options { outline: Some(Outline::Free), ..options.clone() };
    for round in 1..=AGAIN {
        if map.outline != Outline::Free || report.split_edges > 0 {
            break;
        }
        let open = map.patch.without_bays().unwrap_or_else(|| map.patch.clone());
        let (patch, bays) = bays::close(open, Some(&map.uv));
        if patch.outer == map.patch.outer && patch.mesh.triangles == map.patch.mesh.triangles {
            break;
        }
        let mut part = progress::part(progress, share(round), share(round + 1));
        let (next, how) = outline::map(patch, &free, &mut part)?;
        if how.stretch.l2 > WORSE * report.stretch.l2 {
            break;
        }
        (map, report) = (next, Report { bays, ..how });
    }
    if map.outline == Outline::Sides {
        report.bays = Bays::default();
    }
    Ok((map, report))
}

/// How often bays are closed anew as the map shows them: with those the map has another form.
const AGAIN: u32 = 2;

/// A map that stretches so much more than the one before is worse.
const WORSE: f64 = 1.02;
