//! The triangulation of least area of a closed polygon (Barequet & Sharir 1995, "Filling gaps
//! in the boundary of a polyhedron"), with a cost for folded edges (as in Liepa 2003, "Filling
//! holes in meshes").

use crate::geometry::{Point, Vector};

/// The most corners that are triangulated at once, because the time grows with the cube of
/// their number. Of a larger polygon every second corner, or third and so on, is triangulated,
/// and then the corners between two of these.
const MOST_CORNERS: usize = 600;

/// The most corners of a polygon whose filling is only measured. They follow a slit that is a hundredth of its
/// rim wide, and take a twentieth of a second.
const MEASURED_CORNERS: usize = 200;

/// The area of the filling of least area of a closed polygon. Unlike the area vector, it does not vanish for a
/// polygon whose parts face each other, such as the rim of a tube with a slit along it.
pub(crate) fn filling_area(rim: &[Point]) -> f64 {
    if rim.len() < 3 {
        return 0.0;
    }
    let beside = vec![Vector::zeros(); rim.len()];
    let polygon = RimPolygon { rim, beside: &beside, joined: &|_, _| false };
    let triangles = polygon.least(&polygon.corners(MEASURED_CORNERS)).unwrap_or_default();
    let area = |t: &[usize; 3]| {
        let [a, b, c] = t.map(|i| rim[i]);
        0.5 * (b - a).cross(&(c - a)).norm()
    };
    triangles.iter().map(area).sum()
}

/// A closed polygon, which is counter-clockwise seen from the outer side of the surface.
pub(crate) struct RimPolygon<'a> {
    pub rim: &'a [Point],
    /// The unit normal of the surface beside each side. It may be zero.
    pub beside: &'a [Vector],
    /// Whether two corners are joined by an edge already, or are the same vertex.
    pub joined: &'a dyn Fn(usize, usize) -> bool,
}

/// The part of a polygon between two corners: the least cost of its triangulation, and the
/// third corner and the normal of its triangle at the chord between the two.
#[derive(Clone, Copy)]
struct SubPolygon {
    cost: f64,
    apex: usize,
    normal: Vector,
}

impl RimPolygon<'_> {
    /// The triangles of the filling. `None` if every triangulation would join two corners that are joined already.
    pub(crate) fn triangles(&self) -> Option<Vec<[usize; 3]>> {
        let n = self.rim.len();
        let corners = self.corners(MOST_CORNERS);
        let mut triangles = self.least(&corners)?;
        for (k, &first) in corners.iter().enumerate() {
            let last = corners.get(k + 1).map_or(n, |&next| next);
            let along: Vec<usize> = (first..=last).map(|i| i % n).collect();
            if along.len() > 2 {
                if (self.joined)(first, last % n) {
                    return None;
                }
                triangles.extend(self.least(&along)?);
            }
        }
        Some(triangles)
    }

    /// Every corner, or every second one and so on, so that they are no more than `most`.
    fn corners(&self, most: usize) -> Vec<usize> {
        let n = self.rim.len();
        (0..n).step_by(n.div_ceil(most).max(1)).collect()
    }

    /// The triangulation of least cost over some of the corners.
    fn least(&self, corners: &[usize]) -> Option<Vec<[usize; 3]>> {
        let n = corners.len();
        let at = |i: usize| self.rim[corners[i]];
        let beside = |i: usize| {
            let (v, w) = (corners[i], corners[(i + 1) % n]);
            if (v + 1) % self.rim.len() == w { self.beside[v] } else { Vector::zeros() }
        };
        let side = |i: usize| SubPolygon { cost: 0.0, apex: 0, normal: beside(i) };
        let mut best =
            vec![SubPolygon { cost: f64::INFINITY, apex: 0, normal: Vector::zeros() }; n * n];
        (0..n).for_each(|i| best[i * n + (i + 1) % n] = side(i));
        let last = side(n - 1);
        for (i, j) in (2..n).flat_map(|gap| (0..n - gap).map(move |i| (i, i + gap))) {
            let whole = (i, j) == (0, n - 1);
            if !whole && (self.joined)(corners[i], corners[j]) {
                continue;
            }
            let chord = at(j) - at(i);
            let mut least = SubPolygon { cost: f64::INFINITY, ..last };
            for k in i + 1..j {
                let (left, right) = (&best[i * n + k], &best[k * n + j]);
                let cross = (at(k) - at(i)).cross(&chord);
                let area = cross.norm();
                let bound = left.cost + right.cost + area;
                if bound >= least.cost {
                    continue;
                }
                let normal = cross / area.max(f64::MIN_POSITIVE);
                let fold = |other: &Vector, from: usize, to: usize| {
                    (at(to) - at(from)).norm_squared() * (-normal.dot(other)).max(0.0)
                };
                let closing = if whole { fold(&last.normal, j, i) } else { 0.0 };
                let cost = bound + fold(&left.normal, i, k) + fold(&right.normal, k, j) + closing;
                if cost < least.cost {
                    least = SubPolygon { cost, apex: k, normal };
                }
            }
            best[i * n + j] = least;
        }
        let mut triangles = Vec::with_capacity(n - 2);
        let mut open = vec![(0, n - 1)];
        while let Some((i, j)) = open.pop() {
            if j - i > 1 {
                let SubPolygon { cost, apex, .. } = best[i * n + j];
                if !cost.is_finite() {
                    return None;
                }
                triangles.push([i, apex, j].map(|k| corners[k]));
                open.extend([(i, apex), (apex, j)]);
            }
        }
        Some(triangles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rim of a tube of radius 1 and length 4 with a narrow slit along it, each side divided into `n` parts.
    fn slit_tube(n: usize) -> Vec<Point> {
        let angle = |i: usize| 0.01 + (std::f64::consts::TAU - 0.02) * i as f64 / n as f64;
        let on = |angle: f64, z: f64| Point::new(angle.cos(), angle.sin(), z);
        let up = |i: usize| 4.0 * i as f64 / n as f64;
        let lower = (0..n).map(|i| on(angle(i), 0.0));
        let first = (0..n).map(|i| on(angle(n), up(i)));
        let upper = (0..n).map(|i| on(angle(n - i), 4.0));
        let second = (0..n).map(|i| on(angle(0), up(n - i)));
        lower.chain(first).chain(upper).chain(second).collect()
    }

    #[test]
    fn a_slit_tube_has_the_area_of_its_ends_and_its_slit() {
        for n in [30, 200] {
            let area = filling_area(&slit_tube(n));
            let expected = 2.0 * std::f64::consts::PI + 0.08;
            assert!((area / expected - 1.0).abs() < 0.05, "{n}: {area}, not {expected}");
        }
    }

    #[test]
    fn rims_without_an_area_have_none() {
        assert_eq!(filling_area(&[]), 0.0);
        assert_eq!(filling_area(&[Point::origin(), Point::new(1.0, 0.0, 0.0)]), 0.0);
    }
}
