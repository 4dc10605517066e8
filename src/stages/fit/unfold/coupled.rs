//! The equations of one connected component of control points: points that couple directly or
//! through other points. They are solved by sparse Cholesky.

use faer::Mat;
use nalgebra::Matrix3;

use super::system::CouplingBlocks;
use crate::geometry::Vector;
use crate::solve::cholesky::{Pattern, least_degree};

/// A connected component of the free control points. The sparsity pattern of its equations is
/// analysed once, because rounds change only the entries.
pub(crate) struct CoupledPoints {
    /// The indices of the control points among the free ones, in ascending order.
    pub points: Vec<u32>,
    /// The blocks of each point that are not empty. Those of a point begin at its entry of
    /// `starts`.
    blocks: Vec<u8>,
    starts: Vec<usize>,
    pattern: Pattern,
    values: Vec<f64>,
}

impl CoupledPoints {
    /// Analyses the pattern. `coupled` returns the points from a point on that it couples with, and
    /// the number of the block for each. `None` if there is not enough memory for the factor.
    pub(super) fn new<I: Iterator<Item = (usize, u32)>>(
        points: Vec<u32>,
        coupled: impl Fn(usize) -> I,
    ) -> Option<Self> {
        let (mut blocks, mut starts, mut others) = (Vec::new(), vec![0], Vec::new());
        for &a in &points {
            for (k, b) in coupled(a as usize) {
                blocks.push(k as u8);
                others.push(points.binary_search(&b).ok()?);
            }
            starts.push(blocks.len());
        }
        let order = least_degree(&starts, &others)?;
        let order: Vec<usize> = order.iter().flat_map(|p| (0..3).map(move |x| 3 * p + x)).collect();
        // Each point has three columns, which begin at the diagonal.
        let (mut columns, mut rows) = (vec![0], Vec::new());
        for of in starts.windows(2) {
            for x in 0..3 {
                let column =
                    others[of[0]..of[1]].iter().flat_map(|b| (0..3).map(move |y| 3 * b + y));
                rows.extend(column.skip(x));
                columns.push(rows.len());
            }
        }
        let pattern = Pattern::new(columns, rows, &order)?;
        Some(CoupledPoints { points, blocks, starts, pattern, values: Vec::new() })
    }

    /// The steps of the points. `None` if the equations are singular.
    pub(crate) fn solve(
        &mut self,
        blocks: &[CouplingBlocks],
        right: &[Vector],
    ) -> Option<Vec<Vector>> {
        self.values.clear();
        for (&a, of) in self.points.iter().zip(self.starts.windows(2)) {
            for x in 0..3 {
                let block = |k: &u8| -> &Matrix3<f64> { &blocks[a as usize][usize::from(*k)] };
                let of = self.blocks[of[0]..of[1]].iter().map(block);
                self.values.extend(of.flat_map(|b| (0..3).map(move |y| b[(x, y)])).skip(x));
            }
        }
        let at = |i: usize| right[self.points[i / 3] as usize][i % 3];
        let mut steps = Mat::from_fn(3 * self.points.len(), 1, |i, _| at(i));
        self.pattern.solve(&self.values, Some(&mut steps))?;
        let step = |k: usize| Vector::from_fn(|x, _| steps[(3 * k + x, 0)]);
        Some((0..self.points.len()).map(step).collect())
    }
}
