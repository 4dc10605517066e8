//! The order of seeds, and the pieces in which they count their failures.

use super::exact::MOST_TURN;
use super::facets::Border;
use super::search::SeedSearch;
use crate::geometry::sets::Sets;

impl SeedSearch<'_> {
    /// For each facet the number of the smooth piece of the mesh that has it.
    pub(super) fn smooth_pieces(&self) -> Vec<usize> {
        let facets = &self.evidence.facets.all;
        let mut sets = Sets::new(facets.len());
        for (f, facet) in facets.iter().enumerate().filter(|&(f, _)| self.pool[f]) {
            for b in facet.borders.iter().filter(|b| b.dihedral <= MOST_TURN) {
                if self.pool[b.facet as usize] {
                    sets.join(f, b.facet as usize);
                }
            }
        }
        (0..facets.len()).map(|f| sets.find(f)).collect()
    }

    /// Seeds: facets of several triangles first, which are ruled, then those with many neighbours, then large ones.
    pub(super) fn order(&self) -> Vec<u32> {
        let facets = &self.evidence.facets.all;
        let mut seeds: Vec<u32> =
            (0..facets.len() as u32).filter(|&f| self.pool[f as usize]).collect();
        let neighbours: Vec<usize> = facets
            .iter()
            .map(|f| {
                let near = |b: &&Border| b.dihedral <= MOST_TURN && self.pool[b.facet as usize];
                f.borders.iter().filter(near).count()
            })
            .collect();
        seeds.sort_by(|&a, &b| {
            let [x, y] = [a, b].map(|f| self.evidence.facets.get(f));
            (x.triangles.len() < 2)
                .cmp(&(y.triangles.len() < 2))
                .then(neighbours[b as usize].cmp(&neighbours[a as usize]))
                .then(y.area.total_cmp(&x.area))
        });
        seeds
    }
}
