//! A layout of quads on a closed scan.
//!
//! A closed triangle mesh goes in, and a [`QuadMesh`] in square blocks on it comes out. The mesh is
//! coarsened to a few triangles with an exact map back (`coarsen.rs`, `base.rs`), the triangles are
//! joined in pairs (`pair.rs`), each pair gets a grid of quads (`grid.rs`), and all vertices are
//! relaxed on the scan (`relax.rs`). The idea of a base complex whose triangles are joined is that of
//! Eck and Hoppe, "Automatic reconstruction of B-spline surfaces of arbitrary topological type"
//! (1996).

mod base;
mod coarsen;
mod grid;
mod matching;
mod pair;
mod relax;
mod walk;

use std::collections::BTreeMap;

use crate::error::{Error, Result};
use crate::geometry::{Point, Vector};
use crate::mesh::{Mesh, QuadMesh, VertexRings};
use crate::progress::{self, Progress};
use base::{Base, TrianglePlace};
use pair::Pairs;
use relax::Relaxed;
use walk::Ground;

/// The options of the layout.
#[derive(Debug, Clone)]
pub struct Options {
    /// The largest angle in degrees between the normals of the scan in a triangle of the base and
    /// their mean. Smaller angles give more blocks; 45° gives about twice as many as 65°. Beyond 75°
    /// quads turn away from the scan.
    pub spread: f64,
}

impl Default for Options {
    fn default() -> Self {
        Options { spread: 65.0 }
    }
}

/// The results of the layout.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Report {
    /// The number of blocks.
    pub blocks: usize,
    /// The number of irregular vertices for each number of quads.
    pub irregular: BTreeMap<usize, usize>,
    /// Quads that face the scan at more than 60°, and the place of one.
    pub bad: Vec<Point>,
}

impl Report {
    /// The report with all lengths multiplied by a factor.
    pub(crate) fn scaled(mut self, factor: f64) -> Self {
        self.bad.iter_mut().for_each(|p| *p *= factor);
        self
    }
}

/// The number of quads along a side of a block. With half as many the fit starts too coarse for
/// narrow parts, and with twice as many relaxation takes four times as long.
const SIDE: usize = 8;

/// The rounds of coarsening and flips. Later ones change little.
const COARSENINGS: usize = 3;

/// The most rounds in which edges are flipped or split for the valences of the pairs.
const FLIPS: usize = 20;

/// Sweeps of relaxation without and with the barrier.
const PLAIN: usize = 20;
const BARRIER: usize = 40;

/// Rounds in which the weight of bad quads grows, the factor, and the sweeps around them in each.
const REPAIRS: usize = 12;
const HEAVIER: f64 = 3.0;
const LOCAL: usize = 6;

/// Lays out a closed mesh.
///
/// # Errors
/// [`Error::Layout`] if the mesh is not closed, or has too few triangles.
pub fn layout(mesh: &Mesh, options: &Options) -> Result<(QuadMesh, Report)> {
    layout_with(mesh, options, &mut progress::ignore)
}

/// The same, telling how far it has come.
///
/// # Errors
/// Those of [`layout`], and what `progress` returns.
pub fn layout_with(
    mesh: &Mesh,
    options: &Options,
    progress: &mut Progress,
) -> Result<(QuadMesh, Report)> {
    let normals = smoothed_normals(mesh);
    let mut base = Base::new(mesh);
    let spread = options.spread.to_radians().cos();
    let quadrics = coarsen::quadrics(&base);
    for round in 0..COARSENINGS {
        progress(0.3 * round as f64 / COARSENINGS as f64)?;
        coarsen::coarsen(&mut base, &normals, &quadrics, spread);
        coarsen::flip(&mut base, &normals, spread);
    }
    progress(0.3)?;
    let pairs = paired(&mut base, &normals)?;
    let (mut quads, places) = grid::grid(&base, &pairs, SIDE);
    drop(base);
    let ground = Ground::new(mesh, &normals);
    let (places, bad) = relax_all(&quads, &ground, places, progress)?;
    quads.points = places.iter().map(|place| ground.point(place)).collect();
    quads.normals = places.iter().map(|place| ground.normal(place)).collect();
    if let Some(fault) = quads.fault() {
        return Err(Error::Layout(fault));
    }
    let mut irregular = BTreeMap::new();
    quads
        .valences()
        .into_iter()
        .filter(|&n| n != 4)
        .for_each(|n| *irregular.entry(n).or_default() += 1);
    let bad = bad.into_iter().map(|q| quads.points[quads.quads[q][0].index()]).collect();
    let report = Report { blocks: quads.blocks(), irregular, bad };
    Ok((quads, report))
}

/// Joins the triangles of the base in pairs. Where a vertex keeps fewer than three quads, an edge of
/// its link is flipped or split, so that it has a triangle more.
fn paired(base: &mut Base, normals: &[Vector]) -> Result<Pairs> {
    let unpaired = || Error::Layout("its triangles cannot be joined in pairs");
    let mut pairs = Pairs::new(base).ok_or_else(unpaired)?;
    for _ in 0..FLIPS {
        let few = (0..pairs.valence.len()).filter(|&v| (1..3).contains(&pairs.valence[v]));
        let few: Vec<usize> = few.collect();
        let raise = |&&v: &&usize| {
            coarsen::flip_link(base, normals, v as u32) || coarsen::split_link(base, v as u32)
        };
        if few.iter().filter(raise).count() == 0 {
            break;
        }
        pairs = Pairs::new(base).ok_or_else(unpaired)?;
    }
    Ok(pairs)
}

/// Relaxes all vertices, then those around bad quads. Returns the best places and the bad quads that
/// are left.
fn relax_all(
    quads: &QuadMesh,
    ground: &Ground,
    places: Vec<TrianglePlace>,
    progress: &mut Progress,
) -> Result<(Vec<TrianglePlace>, Vec<usize>)> {
    let mut relaxed = Relaxed::new(quads, ground, places);
    for sweep in 0..PLAIN + BARRIER {
        progress(0.3 + 0.7 * sweep as f64 / (PLAIN + BARRIER) as f64)?;
        relaxed.sweep(None, sweep >= PLAIN);
    }
    let mut bad = relaxed.bad();
    let mut best = relaxed.places.clone();
    for _ in 0..REPAIRS {
        if bad.is_empty() {
            break;
        }
        let now = relaxed.bad();
        now.iter().for_each(|&q| relaxed.weights[q] *= HEAVIER);
        let mut chosen = vec![false; quads.points.len().max(relaxed.points.len())];
        now.iter().flat_map(|&q| quads.quads[q]).for_each(|v| chosen[v.index()] = true);
        let near: Vec<usize> = (0..quads.quads.len())
            .filter(|&q| quads.quads[q].iter().any(|v| chosen[v.index()]))
            .collect();
        near.iter().flat_map(|&q| quads.quads[q]).for_each(|v| chosen[v.index()] = true);
        (0..LOCAL).for_each(|_| relaxed.sweep(Some(&chosen), true));
        let left = relaxed.bad();
        if left.len() < bad.len() {
            bad = left;
            best = relaxed.places.clone();
        }
    }
    Ok((best, bad))
}

/// The mean normals of the two-ring of every vertex.
fn smoothed_normals(mesh: &Mesh) -> Vec<Vector> {
    let rings = VertexRings::new(mesh);
    let mut normals = mesh.vertex_normals();
    for _ in 0..2 {
        let mean = |v: usize| {
            let around = rings.neighbours(mesh, v.into()).map(|w| normals[w.index()]);
            let sum: Vector = std::iter::once(normals[v]).chain(around).sum();
            sum.try_normalize(0.0).unwrap_or(normals[v])
        };
        normals = (0..normals.len()).map(mean).collect();
    }
    normals
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::VertexId;

    /// A torus of `n` × `m` squares, each divided into two triangles.
    fn torus(n: usize, m: usize) -> Mesh {
        let at = |k: usize| {
            let [u, v] = [(k / m, n), (k % m, m)]
                .map(|(i, count)| std::f64::consts::TAU * i as f64 / count as f64);
            let reach = 40.0 + 15.0 * v.cos();
            Point::new(reach * u.cos(), reach * u.sin(), 15.0 * v.sin())
        };
        let name = |i: usize, j: usize| VertexId::from((i % n) * m + j % m);
        let triangles = (0..n * m).map(|k| (k / m, k % m)).flat_map(|(i, j)| {
            let [a, b] = [name(i, j), name(i + 1, j)];
            let [c, d] = [name(i + 1, j + 1), name(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        Mesh { points: (0..n * m).map(at).collect(), triangles: triangles.collect() }
    }

    #[test]
    fn a_torus_gets_good_quads_and_keeps_its_handle() {
        let (quads, report) = layout(&torus(90, 40), &Options::default()).unwrap();
        assert_eq!((quads.fault(), quads.euler()), (None, 0));
        assert!(report.bad.is_empty(), "{report:?}");
        assert!((4..60).contains(&report.blocks), "{report:?}");
        let excess = |(&n, &count): (&usize, &usize)| (4 - n as i64) * count as i64;
        assert_eq!(report.irregular.iter().map(excess).sum::<i64>(), 0);
        let off = |p: &Point| (p.x.hypot(p.y) - 40.0).hypot(p.z) - 15.0;
        assert!(quads.points.iter().all(|p| off(p).abs() < 0.1));
        let inward = quads.points.iter().zip(&quads.normals).filter(|(p, n)| {
            let middle = p.coords.xy().normalize() * 40.0;
            n.dot(&(p.coords - Vector::new(middle.x, middle.y, 0.0))) < 0.0
        });
        assert_eq!(inward.count(), 0);
    }

    #[test]
    fn narrower_spreads_give_more_blocks() {
        let mesh = torus(90, 40);
        let blocks = |spread: f64| layout(&mesh, &Options { spread }).unwrap().1.blocks;
        assert!(blocks(35.0) > blocks(65.0));
    }

    #[test]
    fn the_map_leads_back_to_the_scan() {
        let mesh = torus(40, 24);
        let mut base = Base::new(&mesh);
        let quadrics = coarsen::quadrics(&base);
        let normals = smoothed_normals(&mesh);
        coarsen::coarsen(&mut base, &normals, &quadrics, 0.4);
        let mut members = 0;
        for t in (0..base.triangles.len()).filter(|&t| base.alive[t]) {
            for &(v, weights) in &base.members[t] {
                let place = base.on_scan(TrianglePlace { triangle: t as u32, weights });
                let corners = mesh.corners(mesh.triangles[place.triangle as usize]);
                let terms = corners.iter().zip(place.weights).map(|(c, w)| c.coords * w);
                let off = terms.sum::<Vector>() - mesh.point(VertexId(v)).coords;
                assert!(off.norm() < 1e-6, "vertex {v} is {} off", off.norm());
                members += 1;
            }
        }
        let kept = base.around.iter().filter(|around| !around.is_empty()).count();
        assert_eq!(members + kept, mesh.points.len(), "every vertex is in one triangle");
        assert!(kept < 60, "{kept}");
    }

    #[test]
    fn an_open_mesh_is_refused() {
        let mut mesh = torus(12, 8);
        mesh.triangles.pop();
        assert!(matches!(layout(&mesh, &Options::default()), Err(Error::Layout(_))));
    }
}
