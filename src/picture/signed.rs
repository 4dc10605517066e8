//! On which side of a face points are.

use rayon::prelude::*;

use crate::geometry::{Point, Uv};
use crate::spline::{Surface, foot_point};

/// The distances with a sign: positive for points above the surface, on the side of
/// its normal as seen from their feet, which are searched from `starts`.
pub fn signed(surface: &Surface, points: &[Point], starts: &[Uv], distances: &[f64]) -> Vec<f32> {
    let each = points.par_iter().zip(starts).zip(distances);
    let side = |((&p, &start), &distance): ((&Point, &Uv), &f64)| {
        let (foot, _) = foot_point(surface, p, start);
        let jet = surface.jet(foot);
        let above = (p - jet.s).dot(&jet.su.cross(&jet.sv)) >= 0.0;
        (if above { distance } else { -distance }) as f32
    };
    each.map(side).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;
    use crate::spline::KnotVector;

    #[test]
    fn above_is_where_the_normal_points() {
        let k = KnotVector::uniform(3, 5);
        let place = |n: usize| Vector::new(k.greville(n / 5), k.greville(n % 5), 0.0);
        let surface = Surface::new(k.clone(), k.clone(), (0..25).map(place).collect());
        let points = [Point::new(0.5, 0.5, 0.25), Point::new(0.2, 0.3, -0.5)];
        let starts = [Uv::new(0.4, 0.4); 2];
        assert_eq!(signed(&surface, &points, &starts, &[0.25, 0.5]), [0.25, -0.5]);
    }
}
