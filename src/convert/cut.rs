//! What is cut out of the surface, and the faces that this leaves.

use std::ops::Range;

use crate::mesh::{Bound, Patch};
use crate::mesh::{Outline, Parameterized};
use crate::stages::brep::{Arcs, FaceBounds};
use crate::stages::trim::{Rim, TrimLoop};

/// Which of the scan's holes are cut out of the face.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Cut {
    /// Every hole.
    #[default]
    All,
    /// Holes whose rim is at least this long, in mm.
    FromLength(f64),
    /// None: all stay filled.
    None,
}

impl Cut {
    /// The same in lengths of so many `mm`.
    pub(crate) fn in_lengths(self, mm: f64) -> Self {
        match self {
            Cut::FromLength(least) => Cut::FromLength(least / mm),
            other => other,
        }
    }

    /// Whether a hole is cut out whose rim is so long, in mm.
    pub(crate) fn cuts(self, rim_length: f64) -> bool {
        match self {
            Cut::All => true,
            Cut::FromLength(least) => rim_length >= least,
            Cut::None => false,
        }
    }
}

/// The rims to cut along: the outer one unless it lies on the sides, those of the
/// holes that are `trimmed`, and of the islands in these. An island in a hole that
/// stays filled is part of the face around the hole.
pub fn rims(map: &Parameterized, trimmed: &[bool]) -> Vec<Rim> {
    let mut cutter = Cutter { map, trimmed, rims: Vec::new() };
    let outer = (map.outline == Outline::Free).then(|| cutter.add(Bound::Outer, None));
    cutter.piece(map.patch.own_holes(), outer);
    cutter.rims
}

struct Cutter<'a> {
    map: &'a Parameterized,
    trimmed: &'a [bool],
    rims: Vec<Rim>,
}

impl Cutter<'_> {
    /// Goes through the holes of a piece of the scan that is part of the face
    /// `within` a rim, and into the islands in them.
    fn piece(&mut self, holes: Range<usize>, within: Option<usize>) {
        for hole in holes {
            let cut = self.trimmed[hole].then(|| self.add(Bound::Hole(hole), within));
            let patch: &Patch = &self.map.patch;
            for (number, island) in patch.islands.iter().enumerate() {
                if island.hole == hole {
                    let of = Bound::Island { hole, number };
                    let own = cut.map(|cut| self.add(of, Some(cut)));
                    self.piece(island.holes.clone(), own.or(within));
                }
            }
        }
    }

    /// Adds a rim; returns its position.
    fn add(&mut self, of: Bound, within: Option<usize>) -> usize {
        let Parameterized { patch, uv, .. } = self.map;
        let rim = patch.loop_of(of);
        self.rims.push(Rim {
            of,
            within,
            points: rim.iter().map(|&v| patch.mesh.point(v)).collect(),
            uv: rim.iter().map(|v| uv[v.index()]).collect(),
        });
        self.rims.len() - 1
    }
}

/// The faces that the loops bound: that within the outer boundary first, which is
/// a loop or the surface's sides, then each island's.
pub fn faces(loops: &[TrimLoop]) -> Vec<FaceBounds<'_>> {
    let is_hole = |l: &TrimLoop| matches!(l.of, Bound::Hole(_));
    let face = |outer: Option<usize>| {
        let inner = loops.iter().filter(|l| is_hole(l) && l.within == outer);
        FaceBounds { outer: outer.map(|i| arcs(&loops[i])), inner: inner.map(arcs).collect() }
    };
    let sides = (!has_outline(loops)).then_some(None);
    let outer = (0..loops.len()).filter(|&i| !is_hole(&loops[i]));
    sides.into_iter().chain(outer.map(Some)).map(face).collect()
}

/// Whether one of the loops is the outer boundary's; else that is on the
/// surface's sides.
pub fn has_outline(loops: &[TrimLoop]) -> bool {
    loops.iter().any(|l| l.of == Bound::Outer)
}

fn arcs(ring: &TrimLoop) -> Arcs<'_> {
    (&ring.pcurves, &ring.edges)
}
