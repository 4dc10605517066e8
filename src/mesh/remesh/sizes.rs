//! How long the edges of a triangulation within rims shall be.

use crate::geometry::Point;
use crate::mesh::Neighbours;

/// Edge lengths graded from the rim: where the rim is fine so is the fill, and
/// away from it, where nothing was measured, edges grow slowly.
#[derive(Debug)]
pub struct Sizes {
    near: Neighbours,
    rim: Vec<Point>,
    sizes: Vec<f64>,
    /// The mean over the rim: a in the paper.
    pub mean: f64,
}

/// By how much an edge may be longer a unit of length farther from the rim.
const GROWTH: f64 = 0.15;

/// How much longer than at the rim it becomes at most.
const LONGEST: f64 = 5.0;

impl Sizes {
    /// The sizes in a hole with these closed rims.
    pub fn new(rims: &[Vec<Point>]) -> Self {
        let mut sizes = Vec::new();
        for rim in rims {
            let n = rim.len();
            let side = |i: usize| (rim[(i + 1) % n] - rim[i % n]).norm();
            // The mean of four edges: one short edge shall not be answered by
            // as small triangles all around it.
            let here = (0..n).map(|i| (0..4).map(|k| side(i + n * 2 + k - 2)).sum::<f64>() / 4.0);
            sizes.extend(here);
        }
        let rim: Vec<Point> = rims.concat();
        let mean = sizes.iter().sum::<f64>() / sizes.len() as f64;
        let near = Neighbours::new(&rim);
        // None so small that it would count for nothing among the others.
        let sizes = sizes.into_iter().map(|s| s.max(1e-3 * mean)).collect();
        Sizes { near, rim, sizes, mean }
    }

    /// The length that an edge at `p` shall have.
    pub fn at(&self, p: Point) -> f64 {
        let nearest = self.near.nearest(p);
        let size = self.sizes[nearest];
        (size + GROWTH * (p - self.rim[nearest]).norm()).min(LONGEST * size.max(self.mean))
    }

    /// The numbers and distances of the rim's vertices within `radius` of `p`.
    pub fn rim_within<'a>(
        &'a self,
        p: Point,
        radius: f64,
        found: &'a mut Vec<u32>,
    ) -> impl Iterator<Item = (usize, f64)> + 'a {
        self.near.within(p, radius, found);
        found.iter().map(move |&i| (i as usize, (p - self.rim[i as usize]).norm()))
    }

    /// The distance from the rim's vertices.
    pub fn depth(&self, p: Point) -> f64 {
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
