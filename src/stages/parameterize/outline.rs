//! Decides whether the outer boundary is mapped to the sides of the square or left free inside it,
//! and maps the patch.

use super::square_map::{CoarseMap, SquareMap};
use super::{Options, Outline, Parameterized, Report, Scaffold};
use super::{chords, insertion, mend, scaffold, stretch};
use crate::error::{Error, Result};
use crate::mesh::one_rings::OneRings;
use crate::mesh::{Bound, Mesh, Patch};
use crate::progress::Progress;

/// Maps a patch to the unit square. Bays of the patch must already be closed.
pub(super) fn map(
    patch: Patch,
    options: &Options,
    progress: &mut Progress,
) -> Result<(Parameterized, Report)> {
    let must_be_free = options.outline == Some(Outline::Free);
    let may_be_free = options.may_be_free() && !must_be_free;
    let is_ragged = || scaffold::is_ragged(&patch.mesh, patch.loop_of(Bound::Outer));
    if must_be_free || may_be_free && is_ragged() {
        return left_free(patch, options, progress);
    }
    // A map to the sides uses the measured boundary. A free boundary uses that with closed bays.
    let (mut patch, with_bays) = match patch.without_bays() {
        Some(without) => (without, Some(patch)),
        None => (patch, None),
    };
    let split_edges = chords::split_chords(&mut patch);
    let sides =
        CoarseMap::new(&patch.mesh, &patch.outer, patch.mesh.points.len(), options, progress);
    let sides = match sides {
        // A boundary that cannot be divided into four sides can still be mapped to a free curve.
        Err(Error::TooSmall(_) | Error::Singular(_)) if may_be_free => {
            return left_free(with_bays.unwrap_or(patch), options, progress);
        }
        sides => sides?,
    };
    if may_be_free && sides.excess() > NEGLIGIBLE_EXCESS {
        let around = with_bays.as_ref().unwrap_or(&patch);
        let (mesh, outer) = scaffold::surround(around);
        let free = CoarseMap::new(&mesh, &outer, around.mesh.points.len(), options, progress)?;
        if free.excess() < MAX_REMAINING_EXCESS * sides.excess() {
            let map = free.map(options.method, MARGIN, progress)?;
            let (patch, split_edges) = with_bays.map_or((patch, split_edges), |whole| (whole, 0));
            return Ok(reported(with_scaffold(patch, &mesh, &map), &map, split_edges));
        }
    }
    let map = sides.map(options.method, 0.0, progress)?;
    let first = patch.outer.iter().position(|v| v.0 == map.corners[0]);
    patch.outer.rotate_left(first.unwrap_or(0));
    let (uv, outline, scaffold) = (map.uv.clone(), Outline::Sides, Scaffold::default());
    Ok(reported(Parameterized { patch, uv, outline, scaffold }, &map, split_edges))
}

/// The map of a patch whose boundary is left free inside the square.
fn left_free(
    patch: Patch,
    options: &Options,
    progress: &mut Progress,
) -> Result<(Parameterized, Report)> {
    let (mesh, outer) = scaffold::surround(&patch);
    let start = CoarseMap::new(&mesh, &outer, patch.mesh.points.len(), options, progress)?;
    let map = start.map(options.method, MARGIN, progress)?;
    Ok(reported(with_scaffold(patch, &mesh, &map), &map, 0))
}

/// The boundary is mapped to the sides without further trials if the stretch exceeds 1 by less than
/// this.
const NEGLIGIBLE_EXCESS: f64 = 0.03;

/// The boundary is left free if this reduces the excess of the stretch over 1 to less than this
/// share.
const MAX_REMAINING_EXCESS: f64 = 0.5;

/// Combines a patch and its scaffold with their common map.
fn with_scaffold(patch: Patch, mesh: &Mesh, map: &SquareMap) -> Parameterized {
    let mut uv = map.uv.clone();
    let scaffold = Scaffold {
        uv: uv.split_off(patch.mesh.points.len()),
        triangles: mesh.triangles[patch.mesh.triangles.len()..].to_vec(),
    };
    Parameterized { patch, uv, outline: Outline::Free, scaffold }
}

/// The patch with its map and report. Vertices are inserted where the map stretches it strongly.
fn reported(
    mut patch: Parameterized,
    map: &SquareMap,
    mut split_edges: usize,
) -> (Parameterized, Report) {
    let mut mended = map.mended;
    if map.is_drawn_out {
        split_edges += insertion::insert_vertices(&mut patch);
        mended += mend_after_insertion(&mut patch);
    }
    let stretch = stretch::measure(&patch.patch, &patch.uv);
    let flipped = flipped(&patch).len();
    (patch, Report { flipped, mended, split_edges, stretch, ..Report::default() })
}

/// The triangles of a patch that its map inverts, by an exact predicate.
fn flipped(map: &Parameterized) -> Vec<[u32; 3]> {
    let triangles = map.patch.mesh.triangles.iter().map(|t| t.map(|v| v.0));
    mend::inverted(triangles, &map.uv)
}

/// Repairs triangles that rounding inverts when vertices are inserted into edges. Returns their
/// number.
fn mend_after_insertion(map: &mut Parameterized) -> usize {
    if flipped(map).is_empty() {
        return 0;
    }
    let Patch { mesh, outer, .. } = &map.patch;
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| v.0));
    mend::mend(&OneRings::new(mesh, outer), triangles, &mut map.uv).0
}

/// The share of the domain outside the scaffold that stays free at each side.
const MARGIN: f64 = 0.02;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Uv, VertexId};
    use crate::mesh::one_rings::tests::grid;
    use crate::mesh::{self, Choice, Components, Outer, Repairs};
    use crate::progress;
    use crate::stages::fill;
    use formats::Soup;

    /// A grid on the square with some vertices moved onto others, as the map of a patch.
    fn thrown(n: u32, swapped: [usize; 2], is_drawn_out: bool) -> (Parameterized, SquareMap) {
        let patch = grid(n);
        let side = f64::from(n - 1);
        let mut uv: Vec<Uv> = patch.mesh.points.iter().map(|p| Uv::new(p.x, p.y) / side).collect();
        uv.swap(swapped[0], swapped[1]);
        let map = SquareMap { uv: uv.clone(), corners: [0; 4], mended: 0, is_drawn_out };
        (Parameterized { patch, uv, outline: Outline::Sides, scaffold: Scaffold::default() }, map)
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

    /// A bent pipe, open at one end; the other one is filled.
    fn pipe() -> Patch {
        let (around, along) = (60_u32, 24_u32);
        let mut soup = Soup::default();
        let turn = |k: u32, of: u32| std::f64::consts::TAU * f64::from(k) / f64::from(of);
        for (i, j) in (0..=along).flat_map(|i| (0..around).map(move |j| (i, j))) {
            let (a, b) = (turn(i, 3 * along), turn(j, around));
            let r = 20.0 + 6.0 * b.cos();
            soup.points.push([r * a.cos(), r * a.sin(), 6.0 * b.sin()]);
        }
        for (i, j) in (0..along).flat_map(|i| (0..around).map(move |j| (i, j))) {
            let at = |i: u32, j: u32| i * around + j % around;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            soup.polygons.push([a, b, c]);
            soup.polygons.push([a, c, d]);
        }
        let scan = Components::new(mesh::from_soup(&soup, 1.0).unwrap());
        let disk = scan.take(Choice::Largest).unwrap();
        let disk = disk.into_disk(Outer::Auto, &mut Repairs::new()).unwrap();
        let points = disk.mesh.points.clone();
        fill::fill(disk, &points, &fill::Options::default()).unwrap().0
    }

    /// Without a bay over the open end, which `parameterize` would close, few sides stay that
    /// are drawn out.
    #[test]
    fn a_free_map_of_a_pipe_without_bays_is_hardly_drawn_out() {
        let options = Options { outline: Some(Outline::Free), ..Options::default() };
        let (map, report) = map(pipe(), &options, &mut progress::ignore).unwrap();
        let patch = &map.patch;
        assert!(report.split_edges > 0 && patch.measured_outer.is_none());
        let even = 1.0 / (patch.measured as f64).sqrt();
        let width = report.stretch.aspect.sqrt();
        let is_long = |&(a, b): &(VertexId, VertexId)| {
            let d = map.uv[b.index()] - map.uv[a.index()];
            (d.x * width).hypot(d.y / width) > 2.01 * even
        };
        let is_on_rim =
            |(a, b): &(VertexId, VertexId)| patch.rims[0].contains(a) && patch.rims[0].contains(b);
        let measured = patch.measured_triangles().map(|t| patch.mesh.triangles[t]);
        let sides = measured.flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
        let long = sides.filter(is_long).filter(|side| !is_on_rim(side)).count();
        assert!(long <= patch.measured / 10, "{long} of {}", patch.measured);
    }
}
