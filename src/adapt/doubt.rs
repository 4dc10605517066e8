//! Points that no surface explains, nor their neighbours: a scanner's outliers. Smoothing
//! takes them back; where it is off a fit must not follow them.
//!
//! They are told from the shape by what is around them: along an edge that the net
//! cannot follow, neighbours are off, too.

use std::borrow::Cow;

use super::search::{Attempt, Search};
use super::target::{Feet, Target};
use crate::geometry::{Point, Vector, VertexId};
use crate::spline::Samples;

/// Where nobody named a tolerance, so many standard deviations of the noise make a point
/// an outlier that is alone with it.
const OUTLYING: f64 = 5.0;

/// So many times as far off as the neighbours.
const ALONE: f64 = 4.0;

/// How often outliers are looked for without those found before among the neighbours.
const ROUNDS: usize = 2;

impl Search<'_> {
    /// Takes up the weights of an attempt, and looks which samples are outliers of it.
    pub fn doubt(&mut self, from: &Attempt) {
        let (limit, most) = self.doubts();
        self.target.weigh(&from.weights, &from.feet, limit, most);
    }

    /// From which distance on, in mm, a sample may be an outlier, and how many may be: none
    /// that smoothing has taken back, nor any that the user wants the face to follow.
    pub fn doubts(&self) -> (f64, usize) {
        if !self.options.noisy {
            return (f64::INFINITY, 0);
        }
        match self.goal.named {
            true => (self.goal.tolerance, self.spared()),
            false => (OUTLYING * self.noise(), self.target.measured()),
        }
    }
}

impl Target<'_> {
    /// Takes up the weights that the samples had in an earlier fit, but for those that are
    /// outliers of that, farther than `limit`, and `most` of them.
    pub fn weigh(&mut self, weights: &[f64], feet: &Feet, limit: f64, most: usize) {
        self.weights.clear();
        self.weights.extend_from_slice(weights);
        self.doubt(&feet.distances, limit, most);
    }

    /// The same before there has been a fit: by how far samples are from their neighbours.
    pub fn doubt_unseen(&mut self, limit: f64, most: usize) {
        if most > 0 {
            let mesh = &self.map.patch.mesh;
            let distances = from_neighbours(&mesh.points, &mesh.triangles);
            self.doubt(&distances, limit, most);
        }
    }

    /// Looks which measured samples are outliers, corners left out.
    pub fn doubt(&mut self, distances: &[f64], limit: f64, most: usize) {
        self.outliers.clear();
        if most > 0 {
            let triangles = &self.map.patch.mesh.triangles;
            let may = |v: usize| v < self.measured() && !self.is_corner(v);
            self.outliers = outliers(distances, limit, triangles, may);
            self.outliers.truncate(most);
        }
        self.give_weights();
    }

    /// The samples that are no outliers.
    pub fn trusted(&self) -> Cow<'_, Samples> {
        if self.outliers.is_empty() {
            return Cow::Borrowed(&self.samples);
        }
        let mut left = vec![true; self.samples.len()];
        self.outliers.iter().for_each(|&v| left[v] = false);
        let left = || (0..left.len()).filter(|&v| left[v]);
        let Samples { points, uv, weights, open } = &self.samples;
        Cow::Owned(Samples {
            points: left().map(|v| points[v]).collect(),
            uv: left().map(|v| uv[v]).collect(),
            weights: left().map(|v| weights[v]).collect(),
            open: *open,
        })
    }
}

/// Which of the vertices that `may` be outliers are farther off than `limit` while their
/// neighbours are not, the farthest first: from their distances and the triangles.
fn outliers(
    distances: &[f64],
    limit: f64,
    triangles: &[[VertexId; 3]],
    may: impl Fn(usize) -> bool,
) -> Vec<usize> {
    let far: Vec<bool> = (0..distances.len()).map(|v| distances[v] > limit && may(v)).collect();
    let mut suspects: Vec<usize> = (0..far.len()).filter(|&v| far[v]).collect();
    if suspects.is_empty() {
        return suspects;
    }
    let mut out = vec![false; far.len()];
    for _ in 0..ROUNDS {
        let mut around = vec![(0.0, 0.0); far.len()];
        for t in triangles.iter().map(|t| t.map(VertexId::index)) {
            for (k, v) in t.into_iter().enumerate().filter(|(_, v)| far[*v]) {
                for w in [t[(k + 1) % 3], t[(k + 2) % 3]].into_iter().filter(|w| !out[*w]) {
                    around[v].0 += distances[w];
                    around[v].1 += 1.0;
                }
            }
        }
        for &v in &suspects {
            out[v] = distances[v] * around[v].1 > ALONE * around[v].0;
        }
    }
    suspects.retain(|&v| out[v]);
    suspects.sort_by(|&a, &b| distances[b].total_cmp(&distances[a]));
    suspects
}

/// How far each vertex is from the mean of its neighbours: what there is to go by before
/// there is a surface.
fn from_neighbours(points: &[Point], triangles: &[[VertexId; 3]]) -> Vec<f64> {
    let mut sums = vec![(Vector::zeros(), 0.0); points.len()];
    for t in triangles.iter().map(|t| t.map(VertexId::index)) {
        let [a, b, c] = t.map(|v| points[v].coords);
        for (v, others) in t.into_iter().zip([b + c, c + a, a + b]) {
            sums[v].0 += others;
            sums[v].1 += 2.0;
        }
    }
    let off = |(p, (sum, count)): (&Point, (Vector, f64))| match count > 0.0 {
        true => (p.coords - sum / count).norm(),
        false => 0.0,
    };
    points.iter().zip(sums).map(off).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of 9 × 9 vertices, some of them off.
    fn found(off: &[(usize, usize)]) -> Vec<usize> {
        let vertex = |k: usize| VertexId::from(k);
        let cell = |k: usize| (k / 8) * 9 + k % 8;
        let halves = |a: usize| [[a, a + 9, a + 10], [a, a + 10, a + 1]].map(|t| t.map(vertex));
        let triangles: Vec<_> = (0..64).map(cell).flat_map(halves).collect();
        let mut distances = vec![0.02; 81];
        off.iter().for_each(|&(i, j)| distances[9 * i + j] = 1.0);
        outliers(&distances, 0.1, &triangles, |v| v != 80)
    }

    #[test]
    fn single_points_and_pairs_are_outliers_edges_and_patches_are_not() {
        assert!(found(&[(8, 8)]).is_empty());
        assert_eq!(found(&[(4, 4)]), [40]);
        assert_eq!(found(&[(4, 4), (4, 5)]), [40, 41]);
        let edge: Vec<_> = (0..9).map(|j| (4, j)).collect();
        assert!(found(&edge).is_empty());
        let patch: Vec<_> = (0..9).map(|k| (3 + k / 3, 3 + k % 3)).collect();
        assert!(found(&patch).is_empty());
    }
}
