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
mod flips;
mod grid;
mod ground;
mod matching;
mod pair;
mod relax;
mod repair;

use std::collections::{BTreeMap, HashMap};

use crate::error::{Error, Result};
use crate::geometry::{MOST_ROUNDS, Point, VertexId};
use crate::mesh::{EdgeMap, Mesh, QuadMesh};
use crate::progress::{self, Progress};
use base::{Base, TrianglePlace};
use grid::{BlockGrid, GridName};
use ground::Ground;
use pair::Pairs;
use repair::RelaxedGrid;

/// The options of the layout.
#[derive(Debug, Clone)]
pub struct Options {
    /// The largest angle in degrees between the normals of the scan in a triangle of the base and
    /// their mean. Smaller angles give more blocks; 45° gives about twice as many as 70°. Beyond 78°
    /// quads turn away from the scan.
    pub spread: f64,
    /// About how many blocks there should be. The spread is then chosen so that there are.
    pub blocks: Option<usize>,
}

impl Default for Options {
    fn default() -> Self {
        Options { spread: 71.0, blocks: None }
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
    /// The places of quads that face the scan at more than 60°.
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

/// The rounds of coarsening and flips, and the rounds in which edges are flipped for the valences of the
/// pairs. Later flips change little, and may go back and forth.
const FLIPPING: usize = 3;

/// The spreads in degrees between which one is searched for a number of blocks, and the halvings. Below,
/// single normals count, and above, quads turn away from the scan.
const SPREADS: [f64; 2] = [15.0, 80.0];
const HALVINGS: usize = 7;

/// The most rounds in which blocks are split. Nothing proves that they end.
const SPLITS: usize = 4;

/// A layout, which can be made finer at chosen places.
pub struct QuadLayout {
    ground: Ground,
    base: Base,
    pairs: Option<Pairs>,
    /// The places of the vertices that the last grid had.
    known: HashMap<GridName, TrianglePlace>,
    /// The grid with the fewest bad quads.
    best: RelaxedGrid,
}

/// Lays out a closed mesh.
///
/// # Errors
/// [`Error::Layout`] if the mesh is not closed, or has too few triangles.
pub fn layout(mesh: &Mesh, options: &Options) -> Result<QuadLayout> {
    layout_with(mesh, options, &mut progress::ignore)
}

/// The same, telling how far it has come.
///
/// # Errors
/// Those of [`layout`], and what `progress` returns.
pub fn layout_with(mesh: &Mesh, options: &Options, progress: &mut Progress) -> Result<QuadLayout> {
    let ground = Ground::new(mesh, &mut progress::step(progress, 0, 6))?;
    let mut coarsening = |share: f64| progress((1.0 + share) / 6.0);
    let base = match options.blocks {
        None => few(mesh, coarsened(&ground, options.spread, &mut coarsening)?)?,
        Some(blocks) => with_blocks(&ground, blocks, &mut coarsening)?,
    };
    let known = HashMap::new();
    let mut layout = QuadLayout { ground, base, pairs: None, known, best: RelaxedGrid::default() };
    layout.make_quads(&mut |share| progress((2.0 + 4.0 * share) / 6.0))?;
    Ok(layout)
}

/// The triangles of which blocks are made: about two for each block, with the handles of the mesh. It takes
/// a small part of the time of [`layout`].
///
/// # Errors
/// Those of [`layout`].
pub(crate) fn base(mesh: &Mesh, options: &Options) -> Result<Mesh> {
    let ground = Ground::new(mesh, &mut progress::ignore)?;
    let base = coarsened(&ground, options.spread, &mut progress::ignore)?;
    let alive = (0..base.triangles.len()).filter(|&t| base.alive[t]);
    let triangles: Vec<_> = alive.map(|t| base.triangles[t].map(VertexId)).collect();
    let count = triangles.len();
    Ok(Mesh { points: ground.mesh.points, triangles }.part(0..count).0)
}

/// The most faces that nobody asked for. Scans of statues with 100,000 triangles have up to 500. Rough terrains
/// and trees have thousands, which take hours.
const MOST_FACES: usize = 2000;

/// The base, if it makes no more faces than anyone wants. That of an open mesh, which has no layout, is not coarse.
fn few(mesh: &Mesh, base: Base) -> Result<Base> {
    let faces = base.alive.iter().filter(|alive| **alive).count() / 2;
    let is_closed = || EdgeMap::new(mesh).open_sides().next().is_none();
    if faces > MOST_FACES && is_closed() { Err(Error::ManyFaces(faces)) } else { Ok(base) }
}

/// The base of a spread in degrees.
fn coarsened(ground: &Ground, spread: f64, progress: &mut Progress) -> Result<Base> {
    let mut base = Base::new(ground);
    let spread = spread.to_radians().cos();
    let quadrics = coarsen::quadrics(&base);
    for round in 0..FLIPPING {
        progress(round as f64 / FLIPPING as f64)?;
        coarsen::coarsen(&mut base, &quadrics, spread);
        flips::flip(&mut base, spread);
    }
    Ok(base)
}

/// The base whose number of triangles is nearest to two for each block. The spread is halved between
/// bounds, as wider spreads give fewer triangles.
fn with_blocks(ground: &Ground, blocks: usize, progress: &mut Progress) -> Result<Base> {
    let [mut low, mut high] = SPREADS;
    let mut best: Option<(usize, Base)> = None;
    for step in 0..HALVINGS {
        let spread = 0.5 * (low + high);
        let mut progress = |share: f64| progress((step as f64 + share) / HALVINGS as f64);
        let base = coarsened(ground, spread, &mut progress)?;
        let count = base.alive.iter().filter(|&&alive| alive).count() / 2;
        *(if count > blocks { &mut low } else { &mut high }) = spread;
        let off = count.abs_diff(blocks);
        if best.as_ref().is_none_or(|best| off < best.0) {
            best = Some((off, base));
        }
    }
    best.map(|best| best.1).ok_or(Error::Layout("there is none"))
}

impl QuadLayout {
    /// The quads. Their points lie on the scan, or near it where it is rough.
    pub fn quads(&self) -> &QuadMesh {
        &self.best.grid.mesh
    }

    /// The results.
    pub fn report(&self) -> Report {
        let quads = self.quads();
        let mut irregular = BTreeMap::new();
        let valences = quads.valences().into_iter().filter(|&n| n != 4);
        valences.for_each(|n| *irregular.entry(n).or_default() += 1);
        let bad = self.best.bad.iter().map(|&q| quads.points[quads.quads[q][0].index()]).collect();
        Report { blocks: quads.blocks(), irregular, bad }
    }

    /// Makes the layout finer in some blocks. Far from them it stays as it is. Returns whether any block
    /// could be split.
    ///
    /// # Errors
    /// Those of [`layout`], and what `progress` returns.
    pub(crate) fn split(&mut self, blocks: &[usize], progress: &mut Progress) -> Result<bool> {
        if !repair::split_blocks(&mut self.base, &self.ground, &self.best.grid, blocks) {
            return Ok(false);
        }
        self.best = RelaxedGrid::default();
        self.make_quads(progress)?;
        Ok(true)
    }

    /// Joins the triangles of the base, puts grids into the pairs and relaxes them. Where bad quads are
    /// left, blocks are split. Keeps the state with the fewest bad quads.
    fn make_quads(&mut self, progress: &mut Progress) -> Result<()> {
        let mut fewest = usize::MAX;
        for round in 0..=SPLITS {
            let pairs = paired(&mut self.base, &self.ground, self.pairs.as_ref())?;
            let mut grid = grid::grid(&self.base, &pairs, SIDE);
            self.pairs = Some(pairs);
            let chosen = (!self.known.is_empty()).then(|| grid.keep(&self.known));
            let left = 0.5f64.powi(round as i32);
            let mut progress = |done: f64| progress(1.0 - left * (1.0 - 0.5 * done));
            let made = repair::relaxed(grid, &mut self.ground, chosen.as_deref(), &mut progress)?;
            let grid = &made.grid;
            self.known = grid.names.iter().copied().zip(grid.places.iter().copied()).collect();
            // A split that is never laid out would part the base from the grid.
            let done = made.bad.is_empty()
                || round == SPLITS
                || !repair::split_blocks(&mut self.base, &self.ground, grid, &made.coarse());
            if made.bad.len() < fewest {
                fewest = made.bad.len();
                self.best = made;
            }
            if done {
                break;
            }
        }
        self.finish()
    }

    /// Sets the points and the normals of the quads, and checks that they are closed and that they have as
    /// many handles as the scan.
    fn finish(&mut self) -> Result<()> {
        let BlockGrid { mesh, places, .. } = &mut self.best.grid;
        mesh.points = places.iter().map(|place| self.ground.point(place)).collect();
        mesh.normals = places.iter().map(|place| self.ground.normal(place)).collect();
        let scan = &self.ground.mesh;
        // A closed mesh of triangles has three edges for two of them.
        let euler = scan.points.len() as i64 - scan.triangles.len() as i64 / 2;
        if mesh.euler() != euler {
            return Err(Error::Layout("its quads have another number of handles than the scan"));
        }
        mesh.fault().map_or(Ok(()), |fault| Err(Error::Layout(fault)))
    }
}

/// Joins the triangles of the base in pairs. Where a vertex keeps fewer than three quads, an edge of
/// its link is flipped or split, so that it has a triangle more.
fn paired(base: &mut Base, ground: &Ground, earlier: Option<&Pairs>) -> Result<Pairs> {
    let unpaired = || Error::Layout("its triangles cannot be joined in pairs");
    let mut pairs = Pairs::new(base, earlier).ok_or_else(unpaired)?;
    for round in 0..MOST_ROUNDS {
        let few = (0..pairs.valence.len()).filter(|&v| (1..3).contains(&pairs.valence[v]));
        let few: Vec<usize> = few.collect();
        let raise = |&&v: &&usize| {
            (round < FLIPPING && flips::flip_link(base, v as u32))
                || flips::split_link(base, ground, v as u32)
        };
        if few.iter().filter(raise).count() == 0 {
            break;
        }
        pairs = Pairs::new(base, Some(&pairs)).ok_or_else(unpaired)?;
    }
    Ok(pairs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;

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
        let made = layout(&torus(90, 40), &Options::default()).unwrap();
        let (quads, report) = (made.quads(), made.report());
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
        let blocks =
            |spread: f64| layout(&mesh, &Options { spread, blocks: None }).unwrap().report().blocks;
        assert!(blocks(35.0) > blocks(65.0));
    }

    #[test]
    fn about_as_many_blocks_come_out_as_are_asked_for() {
        let mesh = torus(90, 40);
        for blocks in [30, 60, 120] {
            let options = Options { blocks: Some(blocks), ..Options::default() };
            let report = layout(&mesh, &options).unwrap().report();
            assert!(report.blocks.abs_diff(blocks) <= blocks / 5, "{blocks}: {report:?}");
        }
    }

    #[test]
    fn a_split_makes_the_layout_finer_there_and_keeps_the_rest() {
        let mut made = layout(&torus(90, 40), &Options::default()).unwrap();
        let before = made.quads().clone();
        let place = before.points[before.corner(0, 2).index()];
        assert!(made.split(&[0], &mut progress::ignore).unwrap());
        let (after, report) = (made.quads(), made.report());
        assert!(report.bad.is_empty(), "{report:?}");
        assert_eq!((after.fault(), after.euler()), (None, 0));
        assert!((1..4).contains(&(after.blocks() - before.blocks())), "{}", after.blocks());
        let far = before.points.iter().filter(|p| (*p - place).norm() > 60.0);
        let kept = far.clone().filter(|p| after.points.contains(p)).count();
        assert!(kept > 50 && 2 * kept > far.count(), "{kept}");
    }

    #[test]
    fn a_block_that_was_split_since_its_grid_was_made_counts_as_split() {
        let QuadLayout { ground, mut base, best, .. } =
            layout(&torus(90, 40), &Options::default()).unwrap();
        let is_split = |base: &Base, block: usize| {
            best.grid.triangles[block].iter().all(|&t| !base.alive[t as usize])
        };
        let mut split = |block: usize| {
            let split = repair::split_blocks(&mut base, &ground, &best.grid, &[block]);
            (split, is_split(&base, block))
        };
        // Splits in their other sides leave one of the triangles.
        let block = (0..best.grid.mesh.blocks()).find(|&block| split(block).1).unwrap();
        assert_eq!(split(block), (true, true));
    }

    #[test]
    fn the_map_leads_back_to_the_scan() {
        let mesh = torus(40, 24);
        let ground = Ground::new(&mesh, &mut progress::ignore).unwrap();
        let mesh = &ground.mesh;
        let mut base = Base::new(&ground);
        let quadrics = coarsen::quadrics(&base);
        coarsen::coarsen(&mut base, &quadrics, 0.4);
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
        let found = layout(&mesh, &Options::default()).map(|layout| layout.report());
        assert!(matches!(found, Err(Error::Layout(_))), "{found:?}");
    }
}
