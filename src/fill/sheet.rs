//! The triangulation of one fill, and how its triangles are made better: by
//! flips towards Delaunay's, measured in space, and by moves within the
//! surface. Neither turns a triangle over in the chart.

use foldhash::{HashSet, HashSetExt};

use crate::geometry::{Point, Uv, orient2d};
use crate::mesh::remesh::flips::{self, Sides};

/// A triangulated fill. Its first `fixed` vertices are the rims'.
#[derive(Debug, Clone)]
pub struct Sheet {
    /// Places in the chart.
    pub uv: Vec<Uv>,
    /// Places in space.
    pub points: Vec<Point>,
    /// How many of the vertices stay where they are.
    pub fixed: usize,
    pub triangles: Vec<[usize; 3]>,
}

/// Flips and moves follow each other this often.
const ROUNDS: usize = 4;

impl Sheet {
    /// How many triangles are turned over, or flat, in the chart.
    pub fn turned(&self) -> usize {
        self.triangles.iter().filter(|t| !self.is_upright(**t)).count()
    }

    /// The area in space.
    pub fn area(&self) -> f64 {
        let area = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|v| self.points[v]);
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        self.triangles.iter().map(area).sum()
    }

    /// Tells of places in the chart whether the sheet covers them, to within a
    /// length.
    pub fn covered(&self, within: f64) -> impl Fn(Uv) -> bool + use<> {
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

    /// Flips edges and moves the inner vertices until the triangles are well
    /// shaped. `surface` gives the place in space of one in the chart;
    /// `joined` tells of vertices that are joined elsewhere.
    pub fn improve(
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
        // Upright, or at least not worse than they were.
        let may = |old: [[usize; 3]; 2], new: [[usize; 3]; 2]| {
            new.iter().all(upright) || !old.iter().all(upright)
        };
        flips::flip(&self.points, &mut self.triangles, sides, joined, may);
    }

    /// Moves each inner vertex towards the mean of its triangles' centres.
    fn relax(&mut self, surface: impl Fn(Uv) -> Option<Point>) {
        let numbered = self.triangles.iter().enumerate();
        let mut around: Vec<(usize, usize)> = numbered
            .flat_map(|(number, t)| t.map(|v| (v, number)))
            .filter(|a| a.0 >= self.fixed)
            .collect();
        around.sort_unstable();
        for around in around.chunk_by(|x, y| x.0 == y.0) {
            self.centre(around[0].0, around, &surface);
        }
    }

    fn centre(
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
        let turned = |sheet: &Sheet| {
            around.iter().filter(|a| !sheet.is_upright(sheet.triangles[a.1])).count()
        };
        let before = turned(self);
        let target = Uv::from(sum / total);
        for share in [1.0, 0.5, 0.25] {
            self.uv[v] = old.0 + share * (target - old.0);
            if turned(self) <= before
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

    /// Slivers over a square: a fan from one corner to points on the diagonal's
    /// far side.
    fn fan() -> Sheet {
        let outline = (0..20).map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / 20.0;
            Uv::new(angle.cos(), angle.sin())
        });
        let inner = (0..30).map(|i| Uv::new(0.8 - 0.001 * f64::from(i), 0.01 * f64::from(i)));
        let uv: Vec<Uv> = outline.chain(inner).collect();
        let outline = uv[..20].to_vec();
        let triangles = crate::mesh::outline::triangulate(&[&outline], &uv[20..]).unwrap();
        let points = uv.iter().map(|p| Point::new(p.x, p.y, 0.0)).collect();
        Sheet { uv, points, fixed: 20, triangles }
    }

    fn least_angle(sheet: &Sheet) -> f64 {
        let cotangents = |t: &[usize; 3]| {
            (0..3)
                .map(|k| [0, 1, 2].map(|i| sheet.points[t[(k + i) % 3]]))
                .map(|[v, p, q]| flips::cotangent(v, p, q))
                .fold(0.0, f64::max)
        };
        let widest = sheet.triangles.iter().map(cotangents).fold(0.0, f64::max);
        (1.0 / widest).atan().to_degrees()
    }

    #[test]
    fn slivers_become_good_triangles() {
        let mut sheet = fan();
        let before = least_angle(&sheet);
        let (count, points) = (sheet.triangles.len(), sheet.points.len());
        for _ in 0..10 {
            sheet.improve(|uv| Some(Point::new(uv.x, uv.y, 0.0)), |_, _| false);
        }
        assert!(before < 2.0 && least_angle(&sheet) > 15.0, "{before} {}", least_angle(&sheet));
        assert_eq!((sheet.turned(), sheet.triangles.len(), sheet.points.len()), (0, count, points));
        let area: f64 = sheet.area();
        assert!((area - 10.0 * (std::f64::consts::TAU / 20.0).sin()).abs() < 1e-12);
    }

    #[test]
    fn vertices_joined_elsewhere_are_not_joined_again() {
        let mut sheet = fan();
        let sides = |s: &Sheet| {
            Sides::of(&s.triangles).inner().filter(|e| e.0.iter().all(|&v| v < 20)).count()
        };
        let before = sides(&sheet);
        sheet.improve(|uv| Some(Point::new(uv.x, uv.y, 0.0)), |_, _| true);
        assert!(sides(&sheet) <= before);
    }
}
