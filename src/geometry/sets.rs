//! Disjoint sets (union-find).

/// Disjoint sets of the numbers below n. The smallest member of a set represents it.
pub(crate) struct Sets(Vec<u32>);

impl Sets {
    /// Makes `n` sets with one member each.
    pub(crate) fn new(n: usize) -> Self {
        Sets((0..n as u32).collect())
    }

    /// The smallest member of the set that contains `i`.
    pub(crate) fn find(&mut self, mut i: usize) -> usize {
        while self.0[i] as usize != i {
            self.0[i] = self.0[self.0[i] as usize];
            i = self.0[i] as usize;
        }
        i
    }

    /// Joins the sets that contain `i` and `j`.
    pub(crate) fn join(&mut self, i: usize, j: usize) {
        let (i, j) = (self.find(i), self.find(j));
        self.0[i.max(j)] = i.min(j) as u32;
    }

    /// The members of each set in ascending order. The sets are ordered by their first members.
    pub(crate) fn members(mut self) -> Vec<Vec<u32>> {
        let (mut sets, mut number) = (Vec::<Vec<u32>>::new(), vec![0; self.0.len()]);
        for i in 0..self.0.len() {
            let first = self.find(i);
            if first == i {
                number[i] = sets.len();
                sets.push(Vec::new());
            }
            sets[number[first]].push(i as u32);
        }
        sets
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_joined_is_one_set() {
        let mut sets = Sets::new(6);
        for (i, j) in [(4, 2), (5, 1), (2, 0)] {
            sets.join(i, j);
        }
        assert_eq!([4, 5, 3].map(|i| sets.find(i)), [0, 1, 3]);
        assert_eq!(sets.members(), [vec![0, 2, 4], vec![1, 5], vec![3]]);
    }
}
