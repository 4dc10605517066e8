//! Edge flips that bring a triangulation in space closer to a Delaunay triangulation.

use smallvec::SmallVec;

use crate::geometry::{Point, ROUNDING};

/// The triangle to the left of each directed side.
pub(crate) struct Sides {
    /// For each vertex, the ends of the sides that start there and the triangles to their left.
    leaving: Vec<SmallVec<[(u32, u32); 8]>>,
}

impl Sides {
    /// The sides of the triangles. If two triangles have the same directed side, the later one is
    /// stored.
    pub(crate) fn of(triangles: &[[usize; 3]]) -> Self {
        let count = triangles.iter().flatten().max().map_or(0, |last| last + 1);
        let mut sides = Sides { leaving: vec![SmallVec::new(); count] };
        triangles.iter().enumerate().for_each(|(number, &t)| sides.insert(t, number));
        sides
    }

    /// The triangle to the left of the side from `a` to `b`.
    pub(crate) fn get(&self, a: usize, b: usize) -> Option<usize> {
        let leaving = &self.leaving[a];
        leaving.iter().find(|side| side.0 as usize == b).map(|side| side.1 as usize)
    }

    /// All sides between two triangles, each in one direction, with both triangles. The triangle to
    /// the left comes first.
    pub(crate) fn inner(&self) -> impl Iterator<Item = ([usize; 2], [usize; 2])> + '_ {
        let leaving = self.leaving.iter().enumerate();
        let all = leaving.flat_map(|(a, to)| to.iter().map(move |&(b, s)| (a, b as usize, s)));
        all.filter(|&(a, b, _)| a < b)
            .filter_map(|(a, b, s)| Some(([a, b], [s as usize, self.get(b, a)?])))
    }

    /// All sides with a triangle to the left only.
    pub(crate) fn outer(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        let leaving = self.leaving.iter().enumerate();
        let all = leaving.flat_map(|(a, to)| to.iter().map(move |side| [a, side.0 as usize]));
        all.filter(|&[a, b]| self.get(b, a).is_none())
    }

    fn insert(&mut self, t: [usize; 3], number: usize) {
        for k in 0..3 {
            let leaving = &mut self.leaving[t[k]];
            let side = (t[(k + 1) % 3] as u32, number as u32);
            match leaving.iter_mut().find(|old| old.0 == side.0) {
                Some(old) => *old = side,
                None => leaving.push(side),
            }
        }
    }

    fn remove(&mut self, a: usize, b: usize) {
        self.leaving[a].retain(|side| side.0 as usize != b);
    }
}

/// The cotangent of the angle at `v` between `p` and `q`.
pub(crate) fn cotangent(v: Point, p: Point, q: Point) -> f64 {
    let (x, y) = (p - v, q - v);
    x.dot(&y) / x.cross(&y).norm().max(f64::MIN_POSITIVE)
}

/// Two triangles that a flip would replace.
pub(crate) struct EdgeFlip {
    /// The numbers of the triangles.
    pub numbers: [usize; 2],
    /// The triangles before the flip.
    pub old: [[usize; 3]; 2],
    /// The triangles after the flip.
    pub new: [[usize; 3]; 2],
}

/// Flips every side whose opposite angles sum to more than π. A flip is made only if `may` accepts
/// it, and if the ends of the new side are not `joined` outside this triangulation.
pub(crate) fn flip(
    points: &[Point],
    triangles: &mut [[usize; 3]],
    sides: &mut Sides,
    joined: impl Fn(usize, usize) -> bool,
    may: impl Fn(&EdgeFlip) -> bool,
) {
    let each = triangles.iter().flat_map(|t| (0..3).map(|k| (t[k], t[(k + 1) % 3])));
    let mut open: Vec<_> = each.filter(|&(a, b)| a < b && sides.get(b, a).is_some()).collect();
    // The number of flips is limited, because flips in space could continue in a cycle.
    let mut most = 10 * open.len();
    while let Some((a, b)) = open.pop() {
        let (Some(s), Some(t)) = (sides.get(a, b), sides.get(b, a)) else { continue };
        let old = [triangles[s], triangles[t]];
        let [c, d] = old.map(|t| opposite(t, a, b));
        let is_new = sides.get(c, d).or(sides.get(d, c)).is_none() && !joined(c, d);
        let new = [[c, a, d], [d, b, c]];
        if most == 0
            || !is_new
            || !gains(points, [a, b, c, d])
            || !may(&EdgeFlip { numbers: [s, t], old, new })
        {
            continue;
        }
        most -= 1;
        sides.remove(a, b);
        sides.remove(b, a);
        for (number, n) in [s, t].into_iter().zip(new) {
            triangles[number] = n;
            sides.insert(n, number);
        }
        let around = [(a, d), (d, b), (b, c), (c, a)];
        open.extend(around.iter().filter(|e| sides.get(e.1, e.0).is_some()).copied());
    }
}

/// The corner of a triangle that is neither `a` nor `b`.
fn opposite(t: [usize; 3], a: usize, b: usize) -> usize {
    t.into_iter().find(|&v| v != a && v != b).unwrap_or(t[0])
}

/// Whether the side a b between c and d clearly violates the Delaunay criterion.
fn gains(points: &[Point], corners: [usize; 4]) -> bool {
    let [a, b, c, d] = corners.map(|v| points[v]);
    cotangent(c, a, b) + cotangent(d, b, a) < -ROUNDING
}
