//! The wanted edge lengths of a triangulation within rims.

use crate::geometry::{NEGLIGIBLE, Point};
use crate::mesh::Neighbours;

/// Edge lengths graded from the rim. The fill is as fine as the rim beside it. Away from the rim,
/// where nothing was measured, edges become slowly longer.
#[derive(Debug)]
pub(crate) struct Sizes {
    near: Neighbours,
    rim: Vec<Point>,
    sizes: Vec<f64>,
    /// The mean edge length of the rims.
    pub mean: f64,
}

/// The increase of the edge length for each unit of distance from the rim.
const GROWTH: f64 = 0.15;

/// The largest ratio of an edge length to that at the rim.
const MAX_GROWTH: f64 = 5.0;

impl Sizes {
    /// The edge lengths in a hole with these closed rims.
    pub(crate) fn new(rims: &[Vec<Point>]) -> Self {
        let mut sizes = Vec::new();
        for rim in rims {
            let n = rim.len();
            let side = |i: usize| (rim[(i + 1) % n] - rim[i % n]).norm();
            // The length at a vertex is the mean of four edges. A single short edge therefore does
            // not cause small triangles around it.
            let here = (0..n).map(|i| (0..4).map(|k| side(i + n * 2 + k - 2)).sum::<f64>() / 4.0);
            sizes.extend(here);
        }
        let rim: Vec<Point> = rims.concat();
        let mean = sizes.iter().sum::<f64>() / sizes.len() as f64;
        let near = Neighbours::new(&rim);
        // No length may be so small that it is negligible beside the others.
        let sizes = sizes.into_iter().map(|s| s.max(NEGLIGIBLE * mean)).collect();
        Sizes { near, rim, sizes, mean }
    }

    /// The wanted length of an edge at `p`.
    pub(crate) fn at(&self, p: Point) -> f64 {
        let nearest = self.near.nearest(p);
        let size = self.sizes[nearest];
        (size + GROWTH * (p - self.rim[nearest]).norm()).min(MAX_GROWTH * size.max(self.mean))
    }

    /// The numbers and distances of the rim's vertices within `radius` of `p`.
    pub(crate) fn rim_within<'a>(
        &'a self,
        p: Point,
        radius: f64,
        found: &'a mut Vec<u32>,
    ) -> impl Iterator<Item = (usize, f64)> + 'a {
        self.near.within(p, radius, found);
        found.iter().map(move |&i| (i as usize, (p - self.rim[i as usize]).norm()))
    }

    /// The distance from `p` to the nearest rim vertex.
    pub(crate) fn depth(&self, p: Point) -> f64 {
        (p - self.rim[self.near.nearest(p)]).norm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_grow_from_the_rim() {
        let at = |i: i32| {
            let angle = std::f64::consts::TAU * f64::from(i) / 100.0;
            10.0 * Point::new(angle.cos(), angle.sin(), 0.0)
        };
        let sizes = Sizes::new(&[(0..100).map(at).collect()]);
        let edge = 10.0 * std::f64::consts::TAU / 100.0;
        assert!((sizes.mean / edge - 1.0).abs() < 0.01);
        assert!(sizes.at(at(7)) < 1.01 * edge);
        let inner = [8.0, 5.0, 0.0].map(|x| sizes.at(Point::new(x, 0.0, 0.0)));
        assert!(inner[0] < inner[1] && inner[1] < inner[2] && inner[2] < 4.0 * edge);
    }
}
