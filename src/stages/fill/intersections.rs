//! Fills of different holes that intersect. Each hole is filled by itself, so the fills of two
//! holes on both sides of a thin wall can intersect. The later one is then filled again, with
//! the other fill taken as measured.

use std::collections::BTreeMap;

use foldhash::{HashMap, HashMapExt};

use super::faults;
use super::front::{Fill, Surroundings};
use super::strategies::ClosedHole;
use crate::error::Result;
use crate::geometry::{Point, VertexId};
use crate::mesh::Mesh;
use crate::mesh::crossings::{BoxBlocks, NumberedBox, around, cut, extent, overlap};

/// Replaces the fills that intersect earlier ones. `again` closes holes of a mesh with measured
/// points. Intersections that remain are added to the faults of the later fill.
pub(crate) fn separate(
    known: &Surroundings,
    measured: &[Point],
    fills: &mut [ClosedHole],
    again: impl Fn(&Mesh, &[Point], &[usize]) -> Result<Vec<ClosedHole>>,
) {
    let before = cuts(known.mesh, fills);
    if before.is_empty() {
        return;
    }
    let later: Vec<usize> = before.keys().copied().collect();
    let (mut mesh, mut points) = (known.mesh.clone(), measured.to_vec());
    for (_, closed) in fills.iter().enumerate().filter(|f| !before.contains_key(&f.0)) {
        let added = mesh.points.len() - known.mesh.points.len();
        mesh.triangles.extend(shifted(&closed.fill, known.mesh.points.len(), |v| v + added));
        mesh.points.extend(&closed.fill.points);
        points.extend(&closed.fill.points);
    }
    let added = mesh.points.len() - known.mesh.points.len();
    // If a hole cannot be closed again, all fills stay as they are.
    let anew = again(&mesh, &points, &later).unwrap_or_default();
    for (hole, closed) in later.into_iter().zip(anew) {
        if closed.faults.count() < fills[hole].faults.count() + before[&hole] {
            let triangles = shifted(&closed.fill, mesh.points.len(), |v| v - added).collect();
            let fill = Fill { triangles, ..closed.fill };
            let faults = faults::find(known, &fill);
            fills[hole] = ClosedHole { fill, faults, strategy: closed.strategy };
        }
    }
    for (hole, count) in cuts(known.mesh, fills) {
        fills[hole].faults.cuts += count;
    }
}

/// The triangles of a fill. Its own vertices, from `first` on, get the number `anew`.
fn shifted(
    fill: &Fill,
    first: usize,
    anew: impl Fn(usize) -> usize,
) -> impl Iterator<Item = [VertexId; 3]> {
    let number = move |v: VertexId| match v.index() {
        own if own >= first => VertexId::from(anew(own)),
        _ => v,
    };
    fill.triangles.iter().map(move |t| t.map(&number))
}

/// For each hole the number of triangles of its fill that intersect the fill of an earlier
/// hole, and of edges that both fills have.
fn cuts(mesh: &Mesh, fills: &[ClosedHole]) -> BTreeMap<usize, usize> {
    let first = mesh.points.len();
    let mut begun = 0;
    let mut numbered = Vec::with_capacity(fills.len());
    for closed in fills {
        numbered.push(shifted(&closed.fill, first, |v| v + begun).collect::<Vec<_>>());
        begun += closed.fill.points.len();
    }
    let new: Vec<Point> = fills.iter().flat_map(|f| f.fill.points.iter().copied()).collect();
    let at = |v: VertexId| faults::place(mesh, &new, v);
    let extents: Vec<Vec<NumberedBox>> = numbered
        .iter()
        .map(|triangles| (0..).zip(triangles.iter().map(|t| extent(t.map(at)))).collect())
        .collect();
    let boxes: Vec<NumberedBox> = (0..).zip(extents.iter().map(|e| around(e))).collect();
    let mut near = Vec::new();
    BoxBlocks::new(boxes.clone()).pairs(|i, j| near.push([i.min(j), i.max(j)].map(|i| i as usize)));
    let mut found = joined_twice(&numbered, first);
    for [i, j] in near {
        let [of_i, of_j] = [boxes[i].1, boxes[j].1];
        let reaching = |k: usize, other: [Point; 2]| {
            extents[k].iter().filter(move |e| overlap(&e.1, &other)).copied()
        };
        let count = numbered[i].len() as u32;
        let beyond = reaching(j, of_i).map(|(t, place)| (t + count, place));
        let both: Vec<NumberedBox> = reaching(i, of_j).chain(beyond).collect();
        BoxBlocks::new(both).pairs(|s, t| {
            let (s, t) = (s.min(t), s.max(t));
            if s < count && t >= count {
                let pair = [numbered[i][s as usize], numbered[j][(t - count) as usize]];
                if cut(pair, pair.map(|t| t.map(at))) {
                    *found.entry(j).or_default() += 1;
                }
            }
        });
    }
    found
}

/// The number of edges that each fill shares with an earlier one.
fn joined_twice(fills: &[Vec<[VertexId; 3]>], first: usize) -> BTreeMap<usize, usize> {
    let (mut sides, mut found) = (HashMap::new(), BTreeMap::new());
    for (hole, t) in fills.iter().enumerate().flat_map(|(k, fill)| fill.iter().map(move |t| (k, t)))
    {
        let each = (0..3).map(|k| (t[k], t[(k + 1) % 3]));
        for side in each.filter(|(v, w)| v.index().max(w.index()) < first) {
            if *sides.entry(side).or_insert(hole) != hole {
                *found.entry(hole).or_default() += 1;
            }
        }
    }
    found
}
