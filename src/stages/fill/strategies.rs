//! The strategies that close a hole. They are tried in a fixed order, from the one that follows
//! the surface best to the one that fails least, until a fill has no fault. How often each one
//! wins is in `docs/stages/fill.md`.

use std::cell::LazyCell;

use super::band::MeasuredPoints;
use super::faults::{self, Faults};
use super::front::{self, Advance, Fill, OpenHole, SUPPORTS, Surroundings};
use super::numbering::Numbering;
use super::shape::Shaper;
use super::smoothing_spline::Energies;
use super::{Options, Strategy};
use crate::geometry::{Point, VertexId};
use crate::mesh::remesh::{RimTriangulation, Sizes};

/// The fill of a hole, and how it was made.
pub(crate) struct ClosedHole {
    pub fill: Fill,
    pub strategy: Strategy,
    pub faults: Faults,
}

/// Closes one hole by the first strategy whose fill has no fault, or else by that with the
/// fewest faults. `None` if every strategy fails, which takes numbers that are too large or not
/// finite.
pub(crate) fn close(
    around: &Surroundings,
    measured: &MeasuredPoints,
    rims: &[&[VertexId]],
    options: &Options,
) -> Option<ClosedHole> {
    let points = |rim: &&[VertexId]| rim.iter().map(|&v| around.mesh.point(v)).collect();
    let sizes = Sizes::new(&rims.iter().map(points).collect::<Vec<_>>());
    let hole = OpenHole { around, rims, sizes: &sizes };
    let lazy = LazyCell::new(|| Shaper::new(hole, measured));
    let shaper = || lazy.as_ref();
    let least_area = || front::least_area(hole, options);
    let attempts: [(Strategy, &dyn Fn() -> Option<Fill>); 4] = [
        (Strategy::Front, &|| {
            let fill = first_front(hole, options)?;
            if fill.points.is_empty() { Some(fill) } else { shaper()?.shaped(&fill) }
        }),
        (Strategy::GuidedFront, &|| guided_front(hole, options, shaper()?)),
        // Where both fronts fail, a surface that continues the curvature can swing out.
        (Strategy::LeastArea, &|| shaper()?.over_layout(&least_area()?, Energies::Second)),
        (Strategy::LeastArea, &least_area),
    ];
    let mut best: Option<ClosedHole> = None;
    for (strategy, attempt) in attempts {
        let Some(fill) = attempt() else { continue };
        // A triangulation in a plane can join two vertices that the mesh joins elsewhere.
        if faults::joins_twice(around, &fill, rims) {
            continue;
        }
        let strategy = match strategy {
            Strategy::Front if fill.wide_ears > 0 => Strategy::WideEars,
            other => other,
        };
        let faults = faults::find(around, &fill);
        if best.as_ref().is_none_or(|best| faults.count() < best.faults.count()) {
            best = Some(ClosedHole { fill, strategy, faults });
        }
        if faults.count() == 0 {
            break;
        }
    }
    let best = best?;
    Some(if best.faults.folds > 0 { unfolded(hole, best) } else { best })
}

/// The fill by a front with the first support with which it comes to an end.
fn first_front(hole: OpenHole, options: &Options) -> Option<Fill> {
    SUPPORTS.into_iter().find_map(|s| front::advance(hole, options, Advance::Mls(s)))
}

/// The fill by a front that is guided by the height field, with its vertices placed on it.
fn guided_front(hole: OpenHole, options: &Options, shaper: &Shaper) -> Option<Fill> {
    let field = shaper.height_field()?;
    let surface = |p: Point| field.foot(p, 1e-3 * hole.sizes.mean);
    let guide = Advance::Guided(field.guide(&surface));
    shaper.over_plane(&front::advance(hole, options, guide)?, &field)
}

/// A fill with its vertices moved where it folds, if it has fewer faults then.
fn unfolded(hole: OpenHole, best: ClosedHole) -> ClosedHole {
    let numbering = Numbering::new(hole);
    // The hole is to the right of its rims.
    let sides = hole.rims.iter().flat_map(|rim| rim.iter().zip(rim.iter().cycle().skip(1)));
    let beside = sides.filter_map(|(&v, &w)| {
        Some(((numbering.local(w), numbering.local(v)), hole.around.normal_at(v, w)?))
    });
    let (points, triangles) = numbering.numbered(&best.fill);
    let rim = numbering.rim.len();
    let mut surface = RimTriangulation { points, triangles, rim, beside: beside.collect() };
    surface.unfold(|i, j| numbering.joined(i, j));
    let fill = numbering.fill(surface.points, &surface.triangles, &best.fill);
    let faults = faults::find(hole.around, &fill);
    if faults.count() < best.faults.count() { ClosedHole { fill, faults, ..best } } else { best }
}
