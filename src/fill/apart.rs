//! Fills that cut each other. Holes are filled each by itself; where two are near
//! each other, on both sides of a thin wall, say, their fills can meet. The later
//! one is made again then, with the other as if it had been measured.

use std::collections::BTreeMap;

use foldhash::{HashMap, HashMapExt};

use super::blocks::{Blocks, Numbered, around, meet};
use super::close::Closed;
use super::faults::{self, cut, extent};
use super::front::{Fill, Surroundings};
use crate::error::Result;
use crate::geometry::{Point, VertexId};
use crate::mesh::Mesh;

/// Makes fills that cut earlier ones anew by `again`, which closes holes of a mesh
/// with measured points. What is left is among the later one's faults.
pub fn part(
    known: &Surroundings,
    measured: &[Point],
    fills: &mut [Closed],
    again: impl Fn(&Mesh, &[Point], &[usize]) -> Result<Vec<Closed>>,
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
    // One that cannot be made anew stays as it is.
    let anew = again(&mesh, &points, &later).unwrap_or_default();
    for (hole, closed) in later.into_iter().zip(anew) {
        if closed.faults.count() < fills[hole].faults.count() + before[&hole] {
            let triangles = shifted(&closed.fill, mesh.points.len(), |v| v - added).collect();
            let fill = Fill { triangles, ..closed.fill };
            let faults = faults::find(known, &fill);
            fills[hole] = Closed { fill, faults, method: closed.method };
        }
    }
    for (hole, count) in cuts(known.mesh, fills) {
        fills[hole].faults.cuts += count;
    }
}

/// A fill's triangles, its own vertices, those from `first` on, numbered anew.
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

/// How many triangles of each hole's fill cut those of an earlier hole's, or join
/// what these join.
fn cuts(mesh: &Mesh, fills: &[Closed]) -> BTreeMap<usize, usize> {
    let first = mesh.points.len();
    let mut begun = 0;
    let mut numbered = Vec::with_capacity(fills.len());
    for closed in fills {
        numbered.push(shifted(&closed.fill, first, |v| v + begun).collect::<Vec<_>>());
        begun += closed.fill.points.len();
    }
    let new: Vec<Point> = fills.iter().flat_map(|f| f.fill.points.iter().copied()).collect();
    let at = |v: VertexId| faults::place(mesh, &new, v);
    let extents: Vec<Vec<Numbered>> = numbered
        .iter()
        .map(|triangles| (0..).zip(triangles.iter().map(|t| extent(t.map(at)))).collect())
        .collect();
    let boxes: Vec<Numbered> = (0..).zip(extents.iter().map(|e| around(e))).collect();
    let mut near = Vec::new();
    Blocks::new(boxes.clone()).pairs(|i, j| near.push([i.min(j), i.max(j)].map(|i| i as usize)));
    let mut found = joined_twice(&numbered, first);
    for [i, j] in near {
        let [of_i, of_j] = [boxes[i].1, boxes[j].1];
        let reaching = |k: usize, other: [Point; 2]| {
            extents[k].iter().filter(move |e| meet(&e.1, &other)).copied()
        };
        let count = numbered[i].len() as u32;
        let beyond = reaching(j, of_i).map(|(t, place)| (t + count, place));
        let both: Vec<Numbered> = reaching(i, of_j).chain(beyond).collect();
        Blocks::new(both).pairs(|s, t| {
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

/// How many sides each fill has in common with an earlier one.
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
