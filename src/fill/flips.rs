//! Flips of a triangulation's sides towards Delaunay's, measured in space.

use foldhash::HashMap;

use crate::geometry::Point;

/// The triangle to the left of each directed side.
pub type Sides = HashMap<(usize, usize), usize>;

/// The sides of triangles.
pub fn sides(triangles: &[[usize; 3]]) -> Sides {
    let numbered = triangles.iter().enumerate();
    numbered.flat_map(|(number, t)| (0..3).map(move |k| ((t[k], t[(k + 1) % 3]), number))).collect()
}

/// The cotangent of the angle at `v` between `p` and `q`.
pub fn cotangent(v: Point, p: Point, q: Point) -> f64 {
    let (x, y) = (p - v, q - v);
    x.dot(&y) / x.cross(&y).norm().max(f64::MIN_POSITIVE)
}

/// Flips every side whose opposite angles sum to more than π, if two new
/// triangles `may` be in the place of two old ones, and their new side's ends are
/// not `joined` elsewhere.
pub fn flip(
    points: &[Point],
    triangles: &mut [[usize; 3]],
    sides: &mut Sides,
    joined: impl Fn(usize, usize) -> bool,
    may: impl Fn([[usize; 3]; 2], [[usize; 3]; 2]) -> bool,
) {
    let each = triangles.iter().flat_map(|t| (0..3).map(|k| (t[k], t[(k + 1) % 3])));
    let mut open: Vec<_> = each.filter(|&(a, b)| a < b && sides.contains_key(&(b, a))).collect();
    // In space flips could go round in circles.
    let mut most = 10 * open.len();
    while let Some((a, b)) = open.pop() {
        let (Some(&s), Some(&t)) = (sides.get(&(a, b)), sides.get(&(b, a))) else { continue };
        let old = [triangles[s], triangles[t]];
        let [c, d] = old.map(|t| opposite(t, a, b));
        let is_new = !sides.contains_key(&(c, d)) && !sides.contains_key(&(d, c)) && !joined(c, d);
        let new = [[c, a, d], [d, b, c]];
        if most == 0 || !is_new || !gains(points, [a, b, c, d]) || !may(old, new) {
            continue;
        }
        most -= 1;
        sides.remove(&(a, b));
        sides.remove(&(b, a));
        for (number, n) in [s, t].into_iter().zip(new) {
            triangles[number] = n;
            (0..3).for_each(|k| _ = sides.insert((n[k], n[(k + 1) % 3]), number));
        }
        let around = [(a, d), (d, b), (b, c), (c, a)];
        open.extend(around.iter().filter(|e| sides.contains_key(&(e.1, e.0))).copied());
    }
}

/// The corner of a triangle that is neither `a` nor `b`.
fn opposite(t: [usize; 3], a: usize, b: usize) -> usize {
    t.into_iter().find(|&v| v != a && v != b).unwrap_or(t[0])
}

/// Whether the side a b between c and d is not Delaunay's, clearly.
fn gains(points: &[Point], corners: [usize; 4]) -> bool {
    let [a, b, c, d] = corners.map(|v| points[v]);
    cotangent(c, a, b) + cotangent(d, b, a) < -1e-9
}
