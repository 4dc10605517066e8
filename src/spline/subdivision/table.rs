//! The basis of a Catmull–Clark surface on a quad with one irregular vertex.
//!
//! The surface around the irregular vertex is subdivided until the place lies on a regular piece,
//! which is a bicubic polynomial (Stam, "Exact evaluation of Catmull-Clark subdivision surfaces at
//! arbitrary parameter values", 1998). The products of the subdivision matrices are made once for
//! each valence.

use nalgebra::DMatrix;

use crate::spline::MOST_HALVINGS;

/// The basis functions for quads with one corner of a given valence.
#[derive(Debug, Clone)]
pub(super) struct Table {
    valence: usize,
    /// For each depth, and each of the three regular pieces at that depth: the 16 control points of
    /// the piece as combinations of the quad's control points. Row `4 (j + 1) + i + 1` is the
    /// control point (i, j) of the piece.
    pieces: Vec<[DMatrix<f64>; 3]>,
}

/// The lower left grid points of the pieces' control points after a subdivision.
const PIECES: [[i32; 2]; 3] = [[0, -1], [0, 0], [-1, 0]];

impl Table {
    pub(super) fn new(valence: usize) -> Self {
        let rules = Rules { valence };
        let size = rules.size();
        let mut power = DMatrix::identity(size, size);
        let step = rules.matrix(&rules.order());
        let picks = PIECES.map(|[i, j]| {
            let grid = (0..16).map(|k| [i + k % 4, j + k / 4]).map(Target::Grid);
            rules.matrix(&grid.collect::<Vec<_>>())
        });
        let pieces = (0..MOST_HALVINGS).map(|_| {
            let of_depth = [0, 1, 2].map(|k| &picks[k] * &power);
            power = &step * &power;
            of_depth
        });
        Table { valence, pieces: pieces.collect() }
    }

    /// Puts the value and the first derivatives in u and v of every basis function at (u, v) into
    /// `out`. The irregular vertex is at (0, 0).
    pub(crate) fn basis(&self, u: f64, v: f64, out: &mut Vec<[f64; 3]>) {
        out.clear();
        if self.valence == 4 {
            let values = bicubic(u, v, 1.0);
            out.extend(REGULAR.map(|k| values[k]));
            return;
        }
        let least = 0.5f64.powi(MOST_HALVINGS as i32);
        let (u, v) = if u.max(v) < least { (least, least) } else { (u, v) };
        let mut depth = 0;
        let mut scale = 2.0;
        while scale * u.max(v) < 1.0 && depth + 1 < MOST_HALVINGS {
            scale *= 2.0;
            depth += 1;
        }
        let (x, y) = (scale * u, scale * v);
        let piece = match (x >= 1.0, y >= 1.0) {
            (true, false) => 0,
            (true, true) => 1,
            (false, _) => 2,
        };
        let [i, j] = PIECES[piece];
        let values = bicubic(x - f64::from(i + 1), y - f64::from(j + 1), scale);
        let matrix = &self.pieces[depth][piece];
        out.extend((0..matrix.ncols()).map(|c| {
            let mut sum = [0.0; 3];
            for (value, weight) in values.iter().zip(matrix.column(c).iter()) {
                sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += weight * value);
            }
            sum
        }));
    }
}

/// For each control point of a regular quad, in the order of [`HalfEdges::control`], its number
/// `4 (j + 1) + i + 1` in the grid.
///
/// [`HalfEdges::control`]: super::rings::HalfEdges::control
pub(crate) const REGULAR: [usize; 16] = [5, 6, 10, 9, 8, 4, 0, 1, 2, 3, 7, 11, 15, 14, 13, 12];

/// The uniform bicubic basis functions: value, derivative in u and in v. `scale` multiplies the
/// derivatives.
fn bicubic(u: f64, v: f64, scale: f64) -> [[f64; 3]; 16] {
    let ([bu, du], [bv, dv]) = (cubic(u), cubic(v));
    std::array::from_fn(|k| {
        let (i, j) = (k % 4, k / 4);
        [bu[i] * bv[j], scale * du[i] * bv[j], scale * bu[i] * dv[j]]
    })
}

/// The four uniform cubic basis functions on [0, 1] and their derivatives.
fn cubic(t: f64) -> [[f64; 4]; 2] {
    let s = 1.0 - t;
    let value = [
        s * s * s / 6.0,
        (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
        (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
        t * t * t / 6.0,
    ];
    [value, [-0.5 * s * s, 1.5 * t * t - 2.0 * t, 2.0 * s - 1.5 * s * s, 0.5 * t * t]]
}

/// The rules of Catmull and Clark (1978) around a vertex of this valence, in the order and the grid
/// of [`HalfEdges::control`](super::rings::HalfEdges::control).
struct Rules {
    valence: usize,
}

/// A point of the subdivided surface.
#[derive(Clone, Copy)]
enum Target {
    /// The irregular vertex.
    Vertex,
    /// The new point on the spoke with this number.
    Spoke(usize),
    /// The new point in the quad between a spoke and the next one.
    Quad(usize),
    /// The point at a place of the grid of half the width.
    Grid([i32; 2]),
}

impl Rules {
    fn size(&self) -> usize {
        2 * self.valence + 8
    }

    fn spoke(&self, k: usize) -> usize {
        1 + 2 * (k % self.valence)
    }

    fn quad(&self, k: usize) -> usize {
        2 + 2 * (k % self.valence)
    }

    /// The control points after a subdivision, in the same order.
    fn order(&self) -> Vec<Target> {
        let mut order = vec![Target::Vertex];
        order.extend((0..self.valence).flat_map(|k| [Target::Spoke(k), Target::Quad(k)]));
        let outer = [[2, -1], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [-1, 2]];
        order.extend(outer.map(Target::Grid));
        order
    }

    /// The matrix that makes these points of the control points.
    fn matrix(&self, targets: &[Target]) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(targets.len(), self.size());
        for (row, &target) in targets.iter().enumerate() {
            for (column, weight) in self.weights(target) {
                matrix[(row, column)] += weight;
            }
        }
        matrix
    }

    fn weights(&self, target: Target) -> Vec<(usize, f64)> {
        let n = self.valence;
        match target {
            Target::Vertex => {
                let n2 = (n * n) as f64;
                let mut all = vec![(0, 1.0 - 7.0 / (4 * n) as f64)];
                all.extend((0..n).map(|k| (self.spoke(k), 1.5 / n2)));
                all.extend((0..n).map(|k| (self.quad(k), 0.25 / n2)));
                all
            }
            Target::Spoke(k) => {
                let mut all = vec![(0, 3.0 / 8.0), (self.spoke(k), 3.0 / 8.0)];
                let beside = [self.spoke(k + 1), self.spoke(k + n - 1)];
                let quads = [self.quad(k), self.quad(k + n - 1)];
                all.extend(beside.into_iter().chain(quads).map(|at| (at, 0.5 / 8.0)));
                all
            }
            Target::Quad(k) => {
                [0, self.spoke(k), self.quad(k), self.spoke(k + 1)].map(|at| (at, 0.25)).to_vec()
            }
            Target::Grid(place) => match place {
                [0, 0] => self.weights(Target::Vertex),
                [1, 0] => self.weights(Target::Spoke(0)),
                [1, 1] => self.weights(Target::Quad(0)),
                [0, 1] => self.weights(Target::Spoke(1)),
                [-1, 1] => self.weights(Target::Quad(1)),
                [-1, 0] => self.weights(Target::Spoke(2)),
                [0, -1] => self.weights(Target::Spoke(n - 1)),
                [1, -1] => self.weights(Target::Quad(n - 1)),
                place => self.regular(place),
            },
        }
    }

    /// A point of the finer grid as a tensor product of the rules for curves. It is not in the ring
    /// of the irregular vertex.
    fn regular(&self, [i, j]: [i32; 2]) -> Vec<(usize, f64)> {
        let along = |i: i32| -> Vec<(i32, f64)> {
            let half = i.div_euclid(2);
            match i.rem_euclid(2) {
                0 => vec![(half - 1, 1.0 / 8.0), (half, 6.0 / 8.0), (half + 1, 1.0 / 8.0)],
                _ => vec![(half, 0.5), (half + 1, 0.5)],
            }
        };
        let (columns, rows) = (along(i), along(j));
        let pairs =
            columns.iter().flat_map(|&(a, x)| rows.iter().map(move |&(b, y)| (a, b, x * y)));
        pairs.map(|(a, b, weight)| (self.at(a, b), weight)).collect()
    }

    /// The number of the control point at a place of the grid.
    fn at(&self, i: i32, j: i32) -> usize {
        let outer = 2 * self.valence + 1;
        match (i, j) {
            (0, 0) => 0,
            (1, 0) => self.spoke(0),
            (1, 1) => self.quad(0),
            (0, 1) => self.spoke(1),
            (-1, 1) => self.quad(1),
            (-1, 0) => self.spoke(2),
            (0, -1) => self.spoke(self.valence - 1),
            (1, -1) => self.quad(self.valence - 1),
            (2, -1) => outer,
            (2, 0) => outer + 1,
            (2, 1) => outer + 2,
            (2, 2) => outer + 3,
            (1, 2) => outer + 4,
            (0, 2) => outer + 5,
            _ => outer + 6,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_with_four_quads_is_subdivided_as_a_b_spline() {
        let rules = Rules { valence: 4 };
        // The rules around a vertex, and the tensor product of the rules for curves.
        for place in [[1, 0], [1, 1], [0, 1]] {
            let mut ring = vec![0.0; 16];
            let mut grid = ring.clone();
            rules.weights(Target::Grid(place)).iter().for_each(|&(k, w)| ring[k] += w);
            rules.regular(place).iter().for_each(|&(k, w)| grid[k] += w);
            assert!(ring.iter().zip(&grid).all(|(a, b)| (a - b).abs() < 1e-15), "{place:?}");
        }
    }

    #[test]
    fn pieces_join_and_derivatives_are_those_of_differences() {
        for valence in [3, 5, 6, 8] {
            let table = Table::new(valence);
            let at = |u: f64, v: f64| {
                let mut out = Vec::new();
                table.basis(u, v, &mut out);
                out
            };
            for (u, v) in [(0.5, 0.2), (0.25, 0.25), (0.7, 0.5), (0.01, 0.125), (0.3, 0.7)] {
                let sum: f64 = at(u, v).iter().map(|w| w[0]).sum();
                assert!((sum - 1.0).abs() < 1e-12);
                let e = 1e-6 * u;
                let (here, left, right) = (at(u, v), at(u - e, v), at(u + e, v));
                for k in 0..here.len() {
                    let slope = (right[k][0] - left[k][0]) / (2.0 * e);
                    assert!((slope - here[k][1]).abs() < 1e-5, "{valence} {u} {v} {k}");
                }
                let (down, up) = (at(u, v - e), at(u, v + e));
                for k in 0..here.len() {
                    let slope = (up[k][0] - down[k][0]) / (2.0 * e);
                    assert!((slope - here[k][2]).abs() < 1e-5, "{valence} {u} {v} {k}");
                }
            }
        }
    }
}
