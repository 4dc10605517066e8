//! Parameterization (Tekumalla & Cohen 2005, section 3.3): the boundary goes
//! to the unit square by chord length, the inside follows by mean value
//! coordinates (Floater 2003).
//!
//! Such a map has no inverted triangle as long as no inner edge joins two
//! boundary vertices of one side; those that do are split first.

mod corners;
mod mend;
mod solve;
mod stretch;
mod weights;

use crate::error::{Error, Result};
use crate::geometry::{Point, Uv, VertexId, orient2d};
use crate::mesh::{Patch, boundary};

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
    /// Vertices put on edges that joined two places of one side.
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
///
/// A tongue of the patch that lies on one side of the square all around, and
/// hangs on by a narrow neck, is crushed onto that side, down to beyond what
/// double precision holds. Where corners are not given, such a place gets one,
/// and of the maps that come of it the one that stretches least is taken.
pub fn parameterize(patch: Patch, options: &Options) -> Result<(Parameterized, Report)> {
    if let Some(points) = &options.corners {
        let corners = corners::given(&patch, points)?;
        let attempt = map(patch, corners)?;
        return attempt.verified();
    }
    let mut wanted = Vec::new();
    let mut best: Option<Attempt> = None;
    loop {
        let corners = corners::find(&patch, &wanted)?;
        let attempt = map(patch.clone(), corners)?;
        let place = attempt.tongue.and_then(|v| patch.outer.iter().position(|&w| w == v));
        if best.as_ref().is_none_or(|b| attempt.badness() < b.badness()) {
            best = Some(attempt);
        }
        match place.filter(|place| wanted.len() < MORE_CORNERS && !corners.contains(place)) {
            Some(place) => wanted.push(place),
            None => break,
        }
    }
    best.ok_or(Error::Singular("parameterization"))?.verified()
}

/// Corners that are put on tongues at the most: one of the four stays free.
const MORE_CORNERS: usize = 3;

/// A map, which may fold, and a boundary vertex in the midst of where it folds
/// or is crushed, if it is.
struct Attempt {
    map: Parameterized,
    report: Report,
    folded: Vec<usize>,
    tongue: Option<VertexId>,
}

impl Attempt {
    /// First the number of inverted triangles, then the stretch.
    fn badness(&self) -> (usize, f64) {
        (self.folded.len(), self.report.stretch.l2)
    }

    /// The map, if no triangle of it is inverted.
    fn verified(self) -> Result<(Parameterized, Report)> {
        let Some(&first) = self.folded.first() else { return Ok((self.map, self.report)) };
        let mesh = &self.map.patch.mesh;
        let at = mesh.point(mesh.triangles[first][0]);
        Err(Error::Folded { count: self.folded.len(), at })
    }
}

/// Maps the patch with the given positions of the outer loop as corners.
fn map(mut patch: Patch, corners: [usize; 4]) -> Result<Attempt> {
    patch.outer.rotate_left(corners[0]);
    let sides = corners.map(|c| c - corners[0]);
    let split_edges = mend::split_dividing_edges(&mut patch, &sides);
    let rim = square(&patch, &sides);
    let uv = embed(&patch, &rim)?;
    let folded = inverted(&patch, &uv);
    let stretch = stretch::measure(&patch, &uv);
    let bad = match &folded[..] {
        [] if stretch.l2 > CRUSHED => stretch::worst(&patch, &uv).into_iter().collect(),
        folded => folded.to_vec(),
    };
    let tongue = tongue(&patch, &uv, &rim, &bad);
    let report = Report { flipped: folded.len(), split_edges, stretch };
    Ok(Attempt { map: Parameterized { patch, uv }, report, folded, tongue })
}

/// The boundary vertex nearest, in the plane, to the middle of the triangles;
/// none if there are none.
fn tongue(patch: &Patch, uv: &[Uv], rim: &[Uv], bad: &[usize]) -> Option<VertexId> {
    let corners = bad.iter().flat_map(|&t| patch.mesh.triangles[t]);
    let sum = corners.fold(Uv::origin(), |sum, v| sum + uv[v.index()].coords);
    let middle = sum / (3 * bad.len().max(1)) as f64;
    let distance = |i: &usize| (rim[*i] - middle).norm_squared();
    let nearest = (0..rim.len()).min_by(|i, j| distance(i).total_cmp(&distance(j)));
    nearest.filter(|_| !bad.is_empty()).map(|i| patch.outer[i])
}

/// The mean value map; then, since a fixed square crushes what sticks out of
/// the patch (down to where double precision loses it), maps with weights
/// evened out by the stretch (Yoshizawa, Belyaev, Seidel, "A fast and simple
/// stretch-minimizing mesh parameterization", 2004), as long as each gains.
fn embed(patch: &Patch, rim: &[Uv]) -> Result<Vec<Uv>> {
    let mut weights = weights::mean_value(&patch.mesh);
    let mut best: Option<(usize, f64, Vec<Uv>)> = None;
    let mut idle = 0;
    for _ in 0..ROUNDS {
        let uv = solve::convex_combination(patch, &weights, rim)?;
        let folds = inverted(patch, &uv).len();
        let l2 = stretch::measure(patch, &uv).l2;
        weights.even_stretch(patch, &stretch::of_vertices(patch, &uv));
        let gained = best.as_ref().is_none_or(|(least_folds, least, _)| {
            folds < *least_folds || (folds == *least_folds && l2 < WORTHWHILE * least)
        });
        idle = if gained { 0 } else { idle + 1 };
        if gained {
            best = Some((folds, l2, uv));
        }
        if idle > PATIENCE || (idle > 0 && l2 < CRUSHED) {
            break;
        }
    }
    best.map(|(_, _, uv)| uv).ok_or(Error::Singular("parameterization"))
}

/// Maps made at the most.
const ROUNDS: usize = 24;

/// A round gains if it lowers the stretch to this share.
const WORTHWHILE: f64 = 0.99;

/// A map that stretches more is crushed somewhere, and the figure hangs on a
/// few triangles; there a round that does not gain need not be the last.
const CRUSHED: f64 = 4.0;

/// How many such rounds may follow each other.
const PATIENCE: usize = 5;

fn inverted(patch: &Patch, uv: &[Uv]) -> Vec<usize> {
    let flipped = |&t: &usize| {
        let [a, b, c] = patch.mesh.triangles[t].map(|v| uv[v.index()]);
        orient2d(a, b, c) <= 0.0
    };
    (0..patch.mesh.triangles.len()).filter(flipped).collect()
}

/// Parameter points of the boundary loop, whose corners stand at the positions
/// `sides` (the first at 0): each side by chord length on a side of the square,
/// counter-clockwise from (0, 0).
fn square(patch: &Patch, sides: &[usize; 4]) -> Vec<Uv> {
    let n = patch.outer.len();
    let lengths: Vec<f64> = boundary::sides(&patch.mesh, &patch.outer).collect();
    let mut rim = Vec::with_capacity(n);
    for k in 0..4 {
        let end = if k < 3 { sides[k + 1] } else { n };
        let total: f64 = lengths[sides[k]..end].iter().sum();
        let mut walked = 0.0;
        for &length in &lengths[sides[k]..end] {
            let t = walked / total;
            rim.push(match k {
                0 => Uv::new(t, 0.0),
                1 => Uv::new(1.0, t),
                2 => Uv::new(1.0 - t, 1.0),
                _ => Uv::new(0.0, 1.0 - t),
            });
            walked += length;
        }
    }
    rim
}
