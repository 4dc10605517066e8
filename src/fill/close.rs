//! The ways to close a hole, from the one that follows the surface best to the
//! one that hardly can fail, until one neither folds nor cuts anything.

use std::cell::LazyCell;
use std::collections::HashMap;

use super::band::Measured;
use super::fair::{Seen, Shaper, View};
use super::faults::{self, Faults};
use super::front::{self, Fill, SUPPORTS, Surroundings, Way};
use super::smoothing_spline::Held;
use super::{Method, Options};
use crate::geometry::{Point, VertexId};
use crate::mesh::remesh::{Sizes, Triangulation};

/// A hole's fill, and how it came to be.
pub struct Closed {
    pub fill: Fill,
    pub method: Method,
    pub faults: Faults,
}

/// Closes one hole. The front's fill is shaped by the points around it, as a
/// height if all of these can be seen from one side, or over a layout in the
/// plane. Where the front went astray, or overlaps itself, it is led over the
/// surface that the points make likely; then fronts with other supports are
/// tried, what can be seen from one side, and the triangulation of least area. The
/// first fill without a fault is taken, or the one with the fewest. `None` where the
/// numbers allow none.
pub fn close(
    around: &Surroundings,
    measured: &Measured,
    rims: &[&[VertexId]],
    options: &Options,
) -> Option<Closed> {
    let points = |rim: &&[VertexId]| rim.iter().map(|&v| around.mesh.point(v)).collect();
    let sizes = Sizes::new(&rims.iter().map(points).collect::<Vec<_>>());
    let hole = front::Hole { around, rims, sizes: &sizes };
    let built: [_; SUPPORTS.len()] = std::array::from_fn(|i| {
        LazyCell::new(move || front::advance(hole, options, Way::Mls(SUPPORTS[i])))
    });
    let first = || (0..built.len()).find(|&i| built[i].is_some());
    let ways = Ways { hole, options, shaper: LazyCell::new(|| Shaper::new(hole, measured)) };
    let all = LazyCell::new(|| ways.shaper.as_ref()?.view(Seen::All));
    let part = LazyCell::new(|| ways.shaper.as_ref()?.view(Seen::Part));
    let least = LazyCell::new(|| front::span(hole, options));
    let fronts = |fill: Fill| {
        let method = if fill.wide_ears == 0 { Method::Front } else { Method::WideEars };
        (fill, method)
    };
    let by = |method: Method| move |fill: Fill| (fill, method);
    let front_over = |view: Option<&View>| ways.over(built[first()?].as_ref()?, view).map(fronts);
    let small = || built[0].clone().filter(|fill| fill.points.is_empty()).map(fronts);
    let developed = |i: usize, held| ways.developed(built[i].as_ref(), held).map(fronts);
    let tries: [&dyn Fn() -> Option<(Fill, Method)>; 11] = [
        &small,
        &|| front_over(all.as_ref()),
        &|| ways.led(all.as_ref()).map(by(Method::Led)),
        &|| developed(0, Held::Both),
        &|| developed(1, Held::Both),
        &|| developed(2, Held::Both),
        &|| developed(first()?, Held::Flat),
        &|| front_over(part.as_ref()),
        &|| ways.led(part.as_ref()).map(by(Method::Led)),
        &|| ways.developed(least.as_ref(), Held::Flat).map(by(Method::LeastArea)),
        &|| least.clone().map(by(Method::LeastArea)),
    ];
    let mut best: Option<Closed> = None;
    // Triangulated anew in a plane, a fill can join what the mesh joins at a rim's tips.
    let sound = |(fill, _): &(Fill, Method)| !faults::joins_twice(around, fill, rims);
    for (fill, method) in tries.iter().filter_map(|way| way()).filter(sound) {
        let faults = faults::find(around, &fill);
        if best.as_ref().is_none_or(|best| faults.count() < best.faults.count()) {
            best = Some(Closed { fill, method, faults });
        }
        if faults.count() == 0 {
            break;
        }
    }
    let mut best = best?;
    if best.faults.folds > 0 {
        let fill = unfolded(hole, &best.fill);
        let faults = faults::find(around, &fill);
        if faults.count() < best.faults.count() {
            best = Closed { fill, faults, ..best };
        }
    }
    Some(best)
}

/// A fill with its points moved where it folds.
fn unfolded(hole: front::Hole, fill: &Fill) -> Fill {
    let (mesh, rim) = (hole.around.mesh, hole.rims.concat());
    let place: HashMap<VertexId, usize> = rim.iter().enumerate().map(|(i, &v)| (v, i)).collect();
    let local = |v: VertexId| match v.index().checked_sub(mesh.points.len()) {
        None => place[&v],
        Some(new) => rim.len() + new,
    };
    let global = |v: usize| match v.checked_sub(rim.len()) {
        None => rim[v],
        Some(new) => VertexId::from(mesh.points.len() + new),
    };
    let sides = hole.rims.iter().flat_map(|r| r.iter().zip(r.iter().cycle().skip(1)));
    // The hole lies to the right of its rims.
    let beside =
        sides.filter_map(|(&v, &w)| Some(((place[&w], place[&v]), hole.around.normal_at(v, w)?)));
    let of_rim = rim.iter().map(|&v| mesh.point(v));
    let mut surface = Triangulation {
        points: of_rim.chain(fill.points.iter().copied()).collect(),
        triangles: fill.triangles.iter().map(|t| t.map(local)).collect(),
        rim: rim.len(),
        beside: beside.collect(),
    };
    surface.unfold(|i, j| i.max(j) < rim.len() && hole.around.joined(rim[i], rim[j]));
    let triangles = surface.triangles.iter().map(|t| t.map(global)).collect();
    Fill { points: surface.points.split_off(rim.len()), triangles, ..*fill }
}

/// What the ways to close a hole have in common.
struct Ways<'a, F: FnOnce() -> Option<Shaper<'a>>> {
    hole: front::Hole<'a>,
    options: &'a Options,
    shaper: LazyCell<Option<Shaper<'a>>, F>,
}

impl<'a, F: FnOnce() -> Option<Shaper<'a>>> Ways<'a, F> {
    /// A fill as a height over a view's plane.
    fn over(&self, fill: &Fill, view: Option<&View>) -> Option<Fill> {
        self.shaper.as_ref()?.over_plane(fill, view?)
    }

    /// A front led over the surface that is seen in a view.
    fn led(&self, view: Option<&View>) -> Option<Fill> {
        let view = view?;
        let surface = |p: Point| view.under(p, 1e-3 * self.hole.sizes.mean);
        let led = front::advance(self.hole, self.options, Way::Led(view.lead(&surface)))?;
        self.over(&led, Some(view))
    }

    /// A fill over its own layout in the plane.
    fn developed(&self, fill: Option<&Fill>, held: Held) -> Option<Fill> {
        self.shaper.as_ref()?.developed(fill?, held)
    }
}
