//! The pieces of a mesh, and the one that is converted.

use std::collections::HashSet;

use super::build::{Build, Repairs};
use super::{EdgeMap, Mesh};
use crate::error::{Error, Result};

/// Which component of the scan becomes the face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Choice {
    /// The one with the most triangles.
    #[default]
    Largest,
    /// The n-th largest, counted from 0.
    Number(usize),
}

/// A scan's mesh and the pieces it falls into.
#[derive(Debug)]
pub struct Components {
    build: Build,
    /// Triangles of each, ascending; the largest component first.
    pieces: Vec<Vec<usize>>,
}

/// One component by itself.
#[derive(Debug)]
pub struct Component {
    /// Its mesh.
    pub mesh: Mesh,
    /// Triangles in the components that are left out.
    pub left_out: usize,
    /// Faces dropped because they hung on the rest by a vertex only.
    pub repairs: Repairs,
}

impl Components {
    /// Finds the components.
    pub fn new(build: Build) -> Self {
        let pieces = pieces(&build.mesh);
        Components { build, pieces }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.pieces.len()
    }

    /// How many triangles each has, the most first.
    pub fn sizes(&self) -> impl Iterator<Item = usize> + '_ {
        self.pieces.iter().map(Vec::len)
    }

    /// What was repaired in the scan.
    pub fn repairs(&self) -> &Repairs {
        &self.build.repairs
    }

    /// Takes one component, and trims what hangs on it by a vertex only
    /// (bow-ties): of the fans at one place the largest stays.
    pub fn take(&self, choice: Choice) -> Result<Component> {
        let asked = match choice {
            Choice::Largest => 0,
            Choice::Number(n) => n,
        };
        let piece =
            self.pieces.get(asked).ok_or(Error::Component { asked, count: self.count() })?;
        if self.build.twisted.iter().any(|t| piece.binary_search(t).is_ok()) {
            return Err(Error::NotOrientable);
        }
        let mut kept = self.build.part(piece);
        while trim_bow_ties(&mut kept) {}
        let mut repairs = Repairs::new();
        if piece.len() > kept.mesh.triangles.len() {
            repairs.insert("faces_dropped_at_bow_ties", piece.len() - kept.mesh.triangles.len());
        }
        let left_out = self.build.mesh.triangles.len() - piece.len();
        Ok(Component { mesh: kept.mesh, left_out, repairs })
    }
}

/// The triangles of each component, ascending; the largest component first.
fn pieces(mesh: &Mesh) -> Vec<Vec<usize>> {
    let glue = EdgeMap::new(mesh);
    let mut seen = vec![false; mesh.triangles.len()];
    let mut pieces: Vec<Vec<usize>> = Vec::new();
    for first in 0..mesh.triangles.len() {
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        let mut piece = vec![first];
        let mut done = 0;
        while done < piece.len() {
            let t = piece[done];
            done += 1;
            for other in (3 * t..3 * t + 3).filter_map(|side| glue.across(side)) {
                if !std::mem::replace(&mut seen[other / 3], true) {
                    piece.push(other / 3);
                }
            }
        }
        piece.sort_unstable();
        pieces.push(piece);
    }
    pieces.sort_by_key(|p| (std::cmp::Reverse(p.len()), p[0]));
    pieces
}

/// One round; says whether anything was dropped.
fn trim_bow_ties(build: &mut Build) -> bool {
    let mut fan_size = vec![0u32; build.mesh.points.len()];
    for v in build.mesh.triangles.iter().flatten() {
        fan_size[v.index()] += 1;
    }
    // The largest fan at each place; of equal ones the first.
    let mut best = std::collections::HashMap::new();
    for (v, &place) in build.place.iter().enumerate() {
        let incumbent = best.entry(place).or_insert(v);
        if fan_size[v] > fan_size[*incumbent] {
            *incumbent = v;
        }
    }
    let loses = |v: usize| best[&build.place[v]] != v;
    let doomed: HashSet<usize> = build
        .mesh
        .triangles
        .iter()
        .enumerate()
        .filter(|(_, t)| t.iter().any(|v| loses(v.index())))
        .map(|(i, _)| i)
        .collect();
    if doomed.is_empty() || doomed.len() == build.mesh.triangles.len() {
        return false;
    }
    build.drop_triangles(&doomed);
    build.open_fans();
    let largest = pieces(&build.mesh).swap_remove(0);
    *build = build.part(&largest);
    true
}
