//! The triangulation of one fill with a chart: a point in the plane for each vertex. Its triangles are improved by edge flips towards a Delaunay triangulation in space
//! and by moving vertices within the surface. Neither inverts a triangle in the chart.

use foldhash::{HashSet, HashSetExt};

use crate::geometry::{Point, Uv, orient2d};
use crate::mesh::remesh::ROUNDS;
use crate::mesh::remesh::flips::{self, EdgeFlip, Sides};

/// A triangulated fill. Its first `fixed` vertices are those of the rims.
#[derive(Debug, Clone)]
pub(crate) struct ChartedFill {
    /// The vertices in the chart.
    pub uv: Vec<Uv>,
    /// The vertices in space.
    pub points: Vec<Point>,
    /// The number of vertices that do not move.
    pub fixed: usize,
    pub triangles: Vec<[usize; 3]>,
}

impl ChartedFill {
    /// The number of triangles that are inverted or have no area in the chart.
    pub(crate) fn inverted(&self) -> usize {
        self.triangles.iter().filter(|t| !self.is_upright(**t)).count()
    }

    /// The area in space.
    pub(super) fn area(&self) -> f64 {
        let area = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|v| self.points[v]);
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        self.triangles.iter().map(area).sum()
    }

    /// A test whether the fill covers a point of the chart, to within the length `within`.
    pub(crate) fn covered(&self, within: f64) -> impl Fn(Uv) -> bool + use<> {
        let key = move |p: Uv| [p.x, p.y].map(|x| (x / within).floor() as i64);
        let mut cells = HashSet::new();
        for t in &self.triangles {
            let [a, b, c] = t.map(|v| self.uv[v].coords);
            let longest = [b - a, c - b, a - c].map(|d| d.norm()).into_iter().fold(0.0, f64::max);
            let steps = (2.0 * longest / within).ceil().clamp(1.0, 1000.0) as usize;
            for (i, j) in (0..=steps).flat_map(|i| (0..=steps - i).map(move |j| (i, j))) {
                let (s, t) = (i as f64 / steps as f64, j as f64 / steps as f64);
                cells.insert(key(Uv::from(a + s * (b - a) + t * (c - a))));
            }
        }
        move |p| cells.contains(&key(p))
    }

    fn is_upright(&self, t: [usize; 3]) -> bool {
        is_upright(t.map(|v| self.uv[v]))
    }

    /// Flips edges and moves the inner vertices to improve the shape of the triangles.
    /// `surface` maps the chart to space; `joined` says whether two vertices are joined by an
    /// edge outside of this fill.
    pub(crate) fn improve(
        &mut self,
        surface: impl Fn(Uv) -> Option<Point>,
        joined: impl Fn(usize, usize) -> bool,
    ) {
        let mut sides = Sides::of(&self.triangles);
        for _ in 0..ROUNDS {
            self.flip(&mut sides, &joined);
            self.relax(&surface);
        }
        self.flip(&mut sides, &joined);
    }

    fn flip(&mut self, sides: &mut Sides, joined: impl Fn(usize, usize) -> bool) {
        let uv = &self.uv;
        let upright = |t: &[usize; 3]| is_upright(t.map(|v| uv[v]));
        // A flip may leave inverted triangles only where there were some before.
        let may = |edge: &EdgeFlip| edge.new.iter().all(upright) || !edge.old.iter().all(upright);
        flips::flip(&self.points, &mut self.triangles, sides, joined, may);
    }

    /// Moves each inner vertex to the mean of the centres of its triangles, weighted by area.
    fn relax(&mut self, surface: impl Fn(Uv) -> Option<Point>) {
        let numbered = self.triangles.iter().enumerate();
        let mut around: Vec<(usize, usize)> = numbered
            .flat_map(|(number, t)| t.map(|v| (v, number)))
            .filter(|a| a.0 >= self.fixed)
            .collect();
        around.sort_unstable();
        for around in around.chunk_by(|x, y| x.0 == y.0) {
            self.move_vertex(around[0].0, around, &surface);
        }
    }

    fn move_vertex(
        &mut self,
        v: usize,
        around: &[(usize, usize)],
        surface: impl Fn(Uv) -> Option<Point>,
    ) {
        let (mut sum, mut total) = (nalgebra::Vector2::zeros(), 0.0);
        for &(_, t) in around {
            let t = self.triangles[t];
            let [a, b, c] = t.map(|v| self.points[v]);
            let area = (b - a).cross(&(c - a)).norm();
            sum += area * t.map(|v| self.uv[v].coords).iter().sum::<nalgebra::Vector2<f64>>() / 3.0;
            total += area;
        }
        if total == 0.0 {
            return;
        }
        let old = (self.uv[v], self.points[v]);
        let inverted = |fill: &ChartedFill| {
            around.iter().filter(|a| !fill.is_upright(fill.triangles[a.1])).count()
        };
        let before = inverted(self);
        let target = Uv::from(sum / total);
        for share in [1.0, 0.5, 0.25] {
            self.uv[v] = old.0 + share * (target - old.0);
            if inverted(self) <= before
                && let Some(point) = surface(self.uv[v])
            {
                self.points[v] = point;
                return;
            }
        }
        (self.uv[v], self.points[v]) = old;
    }
}

fn is_upright([a, b, c]: [Uv; 3]) -> bool {
    orient2d(a, b, c) > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A polygon of 20 sides with 30 points in one small place, which makes slivers.
    fn fan() -> ChartedFill {
        let outline = (0..20).map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / 20.0;
            Uv::new(angle.cos(), angle.sin())
        });
        let inner = (0..30).map(|i| Uv::new(0.8 - 0.001 * f64::from(i), 0.01 * f64::from(i)));
        let uv: Vec<Uv> = outline.chain(inner).collect();
        let outline = uv[..20].to_vec();
        let triangles = crate::mesh::outline::triangulate(&[&outline], &uv[20..]).unwrap();
        let points = uv.iter().map(|p| Point::new(p.x, p.y, 0.0)).collect();
        ChartedFill { uv, points, fixed: 20, triangles }
    }

    fn least_angle(fill: &ChartedFill) -> f64 {
        let cotangents = |t: &[usize; 3]| {
            (0..3)
                .map(|k| [0, 1, 2].map(|i| fill.points[t[(k + i) % 3]]))
                .map(|[v, p, q]| flips::cotangent(v, p, q))
                .fold(0.0, f64::max)
        };
        let widest = fill.triangles.iter().map(cotangents).fold(0.0, f64::max);
        (1.0 / widest).atan().to_degrees()
    }

    #[test]
    fn slivers_become_good_triangles() {
        let mut fill = fan();
        let before = least_angle(&fill);
        let (count, points) = (fill.triangles.len(), fill.points.len());
        for _ in 0..10 {
            fill.improve(|uv| Some(Point::new(uv.x, uv.y, 0.0)), |_, _| false);
        }
        assert!(before < 2.0 && least_angle(&fill) > 15.0, "{before} {}", least_angle(&fill));
        assert_eq!((fill.inverted(), fill.triangles.len(), fill.points.len()), (0, count, points));
        let area: f64 = fill.area();
        assert!((area - 10.0 * (std::f64::consts::TAU / 20.0).sin()).abs() < 1e-12);
    }

    #[test]
    fn vertices_joined_elsewhere_are_not_joined_again() {
        let mut fill = fan();
        let sides = |s: &ChartedFill| {
            Sides::of(&s.triangles).inner().filter(|e| e.0.iter().all(|&v| v < 20)).count()
        };
        let before = sides(&fill);
        fill.improve(|uv| Some(Point::new(uv.x, uv.y, 0.0)), |_, _| true);
        assert!(sides(&fill) <= before);
    }
}
