//! The triangulation of one fill, and how its triangles are made better: by
//! flips towards Delaunay's, measured in space, and by moves within the
//! surface. Neither turns a triangle over in the chart.

use foldhash::{HashMap, HashSet, HashSetExt};

use crate::geometry::{Point, Uv, orient2d};

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

/// The triangle to the left of each directed side.
type Sides = HashMap<(usize, usize), usize>;

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
        let [a, b, c] = t.map(|v| self.uv[v]);
        orient2d(a, b, c) > 0.0
    }

    /// Flips edges and moves the inner vertices until the triangles are well
    /// shaped. `surface` gives the place in space of one in the chart;
    /// `joined` tells of vertices that are joined elsewhere.
    pub fn improve(
        &mut self,
        surface: impl Fn(Uv) -> Option<Point>,
        joined: impl Fn(usize, usize) -> bool,
    ) {
        let mut sides = self.sides();
        for _ in 0..ROUNDS {
            self.flip(&mut sides, &joined);
            self.relax(&surface);
        }
        self.flip(&mut sides, &joined);
    }

    /// Flips every edge whose opposite angles sum to more than π.
    fn flip(&mut self, sides: &mut Sides, joined: impl Fn(usize, usize) -> bool) {
        let each = self.triangles.iter().flat_map(|t| (0..3).map(|k| (t[k], t[(k + 1) % 3])));
        let mut open: Vec<_> =
            each.filter(|&(a, b)| a < b && sides.contains_key(&(b, a))).collect();
        // In space flips could go round in circles.
        let mut most = 10 * open.len();
        while let Some((a, b)) = open.pop() {
            let (Some(&s), Some(&t)) = (sides.get(&(a, b)), sides.get(&(b, a))) else { continue };
            let (c, d) = (self.opposite(s, a, b), self.opposite(t, b, a));
            let may = !sides.contains_key(&(c, d)) && !sides.contains_key(&(d, c)) && !joined(c, d);
            let new = [[c, a, d], [d, b, c]];
            if most == 0
                || !may
                || !self.gains([a, b, c, d])
                || !new.iter().all(|n| self.is_better(*n, [s, t]))
            {
                continue;
            }
            most -= 1;
            self.triangles[s] = new[0];
            self.triangles[t] = new[1];
            sides.remove(&(a, b));
            sides.remove(&(b, a));
            for (number, n) in [s, t].into_iter().zip(new) {
                for k in 0..3 {
                    sides.insert((n[k], n[(k + 1) % 3]), number);
                }
            }
            let around = [(a, d), (d, b), (b, c), (c, a)];
            open.extend(around.iter().filter(|e| sides.contains_key(&(e.1, e.0))).copied());
        }
    }

    /// The triangle to the left of each directed side.
    fn sides(&self) -> Sides {
        let numbered = self.triangles.iter().enumerate();
        numbered
            .flat_map(|(number, t)| (0..3).map(move |k| ((t[k], t[(k + 1) % 3]), number)))
            .collect()
    }

    fn opposite(&self, t: usize, a: usize, b: usize) -> usize {
        let t = self.triangles[t];
        t.into_iter().find(|&v| v != a && v != b).unwrap_or(t[0])
    }

    /// Whether the edge a b between c and d is not Delaunay's, clearly.
    fn gains(&self, [a, b, c, d]: [usize; 4]) -> bool {
        self.cotangent(c, a, b) + self.cotangent(d, b, a) < -1e-9
    }

    /// The cotangent of the angle at `v` between `p` and `q`.
    fn cotangent(&self, v: usize, p: usize, q: usize) -> f64 {
        let (x, y) = (self.points[p] - self.points[v], self.points[q] - self.points[v]);
        x.dot(&y) / x.cross(&y).norm().max(f64::MIN_POSITIVE)
    }

    /// Whether a triangle that shall replace others is upright, or at least
    /// not worse than they.
    fn is_better(&self, new: [usize; 3], old: [usize; 2]) -> bool {
        self.is_upright(new) || old.iter().any(|&t| !self.is_upright(self.triangles[t]))
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
                .map(|k| sheet.cotangent(t[k], t[(k + 1) % 3], t[(k + 2) % 3]))
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
        let sides = |s: &Sheet| s.sides().keys().filter(|e| e.0.max(e.1) < 20).count();
        let before = sides(&sheet);
        sheet.improve(|uv| Some(Point::new(uv.x, uv.y, 0.0)), |_, _| true);
        assert!(sides(&sheet) <= before);
    }
}
