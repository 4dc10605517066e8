//! A maximum matching of a graph (Edmonds, "Paths, trees, and flowers", 1965).

use std::collections::VecDeque;

use crate::geometry::NONE;

/// Extends a matching of a graph to a maximum one. `mate` is the partner of each node or `NONE`.
pub(super) fn extend(neighbours: &[Vec<u32>], mate: &mut [u32]) {
    for root in 0..neighbours.len() {
        if mate[root] == NONE {
            let mut search = Search::new(neighbours, mate, root);
            if let Some(end) = search.run() {
                search.augment(end);
            }
        }
    }
}

/// A search for an augmenting path from a root. Odd cycles (blossoms) are contracted to their bases.
struct Search<'a> {
    neighbours: &'a [Vec<u32>],
    mate: &'a mut [u32],
    root: usize,
    parent: Vec<u32>,
    base: Vec<u32>,
    is_even: Vec<bool>,
    queue: VecDeque<u32>,
}

impl<'a> Search<'a> {
    fn new(neighbours: &'a [Vec<u32>], mate: &'a mut [u32], root: usize) -> Self {
        let n = neighbours.len();
        let mut is_even = vec![false; n];
        is_even[root] = true;
        Search {
            neighbours,
            mate,
            root,
            parent: vec![NONE; n],
            base: (0..n as u32).collect(),
            is_even,
            queue: VecDeque::from([root as u32]),
        }
    }

    /// The free node at which an augmenting path ends.
    fn run(&mut self) -> Option<u32> {
        while let Some(v) = self.queue.pop_front() {
            let neighbours = self.neighbours;
            for &w in &neighbours[v as usize] {
                if self.base[v as usize] == self.base[w as usize] || self.mate[v as usize] == w {
                    continue;
                }
                let partner = self.mate[w as usize];
                let in_tree = partner != NONE && self.parent[partner as usize] != NONE;
                if w as usize == self.root || in_tree {
                    self.contract(v, w);
                } else if self.parent[w as usize] == NONE {
                    self.parent[w as usize] = v;
                    if partner == NONE {
                        return Some(w);
                    }
                    self.is_even[partner as usize] = true;
                    self.queue.push_back(partner);
                }
            }
        }
        None
    }

    /// Contracts the odd cycle that the edge (v, w) closes.
    fn contract(&mut self, v: u32, w: u32) {
        let top = self.common_base(v, w);
        let mut in_blossom = vec![false; self.base.len()];
        self.mark(v, top, w, &mut in_blossom);
        self.mark(w, top, v, &mut in_blossom);
        for i in 0..self.base.len() {
            if in_blossom[self.base[i] as usize] {
                self.base[i] = top;
                if !self.is_even[i] {
                    self.is_even[i] = true;
                    self.queue.push_back(i as u32);
                }
            }
        }
    }

    fn common_base(&self, v: u32, w: u32) -> u32 {
        let mut seen = vec![false; self.base.len()];
        let mut at = v;
        loop {
            at = self.base[at as usize];
            seen[at as usize] = true;
            if at as usize == self.root || self.mate[at as usize] == NONE {
                break;
            }
            at = self.parent[self.mate[at as usize] as usize];
        }
        at = w;
        loop {
            at = self.base[at as usize];
            if seen[at as usize] {
                return at;
            }
            at = self.parent[self.mate[at as usize] as usize];
        }
    }

    fn mark(&mut self, mut v: u32, top: u32, mut child: u32, in_blossom: &mut [bool]) {
        while self.base[v as usize] != top {
            let partner = self.mate[v as usize];
            in_blossom[self.base[v as usize] as usize] = true;
            in_blossom[self.base[partner as usize] as usize] = true;
            self.parent[v as usize] = child;
            child = partner;
            v = self.parent[partner as usize];
        }
    }

    /// Swaps the edges of the augmenting path that ends at a node.
    fn augment(&mut self, end: u32) {
        let mut v = end;
        while v != NONE {
            let before = self.parent[v as usize];
            let next = self.mate[before as usize];
            self.mate[v as usize] = before;
            self.mate[before as usize] = v;
            v = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_petersen_graph_has_a_perfect_matching() {
        let mut neighbours = vec![Vec::new(); 10];
        let mut join = |a: usize, b: usize| {
            neighbours[a].push(b as u32);
            neighbours[b].push(a as u32);
        };
        for k in 0..5 {
            join(k, (k + 1) % 5);
            join(k, k + 5);
            join(k + 5, (k + 2) % 5 + 5);
        }
        // A greedy beginning that must be undone.
        let mut mate = vec![NONE; 10];
        (mate[0], mate[1], mate[2], mate[3]) = (1, 0, 3, 2);
        extend(&neighbours, &mut mate);
        for (v, &w) in mate.iter().enumerate() {
            assert_eq!(mate[w as usize], v as u32);
            assert!(neighbours[v].contains(&w));
        }
    }

    #[test]
    fn blossoms_are_found_in_random_cubic_graphs() {
        // Rings with chords, shuffled by a linear map of their numbers.
        for n in (10..60).step_by(2) {
            let name = |k: usize| (k * 7 + 3) % n;
            if n % 7 == 0 {
                continue;
            }
            let mut neighbours = vec![Vec::new(); n];
            let mut join = |a: usize, b: usize| {
                neighbours[a].push(b as u32);
                neighbours[b].push(a as u32);
            };
            (0..n).for_each(|k| join(name(k), name((k + 1) % n)));
            (0..n / 2).for_each(|k| join(name(k), name(k + n / 2)));
            let mut mate = vec![NONE; n];
            extend(&neighbours, &mut mate);
            assert!(
                mate.iter().enumerate().all(|(v, &w)| w != NONE && mate[w as usize] == v as u32)
            );
        }
    }
}
