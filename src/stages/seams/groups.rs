//! Groups of facets: which hang together, and how a group is divided.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use super::free_form::FEWEST_FACETS;
use super::{FacePatch, FreeForms, Work};
use crate::geometry::sets::Sets;
use crate::geometry::{OrderedFloat, Point, ROUNDING, Vector, VertexId};

/// Neighbouring facets of a curved face are at most so many times as wide as each other.
const MOST_WIDER: f64 = 3.0;

impl Work<'_> {
    /// The facets that hang together. Few facets that do not, though they are turned by little and are no larger than those beside them, are no face of
    /// their own: a mesher that does not lay facets in rows makes narrow ones everywhere. They stay with the facets that they have most of their border with.
    pub(super) fn groups(
        &self,
        facets: &[FacePatch],
        most_sagitta: Option<f64>,
    ) -> Vec<Vec<FacePatch>> {
        let mut sets = Sets::new(facets.len());
        for (k, others) in self.neighbouring(facets, most_sagitta).iter().enumerate() {
            others.keys().for_each(|&other| sets.join(k, other));
        }
        let parts = sets.members();
        let mut of = vec![0; facets.len()];
        for (p, part) in parts.iter().enumerate() {
            part.iter().for_each(|&k| of[k as usize] = p);
        }
        let area = |k: &u32| facets[*k as usize].area(self.mesh);
        let means: Vec<f64> = parts
            .iter()
            .map(|part| part.iter().map(area).sum::<f64>() / part.len() as f64)
            .collect();
        let is_few = |p: usize| parts[p].len() < FEWEST_FACETS;
        let neighbours = self.neighbouring(facets, Some(f64::INFINITY));
        let mut joined = Sets::new(parts.len());
        for (p, part) in parts.iter().enumerate().filter(|of| is_few(of.0)) {
            let mut shared: BTreeMap<usize, f64> = BTreeMap::new();
            for (&other, long) in part.iter().flat_map(|&k| &neighbours[k as usize]) {
                if !is_few(of[other]) {
                    *shared.entry(of[other]).or_default() += long;
                }
            }
            let most = shared.into_iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
            if let Some((other, _)) = most.filter(|of| means[p] <= means[of.0]) {
                joined.join(p, other);
            }
        }
        let pick = |&p: &u32| parts[p as usize].iter().map(|&k| facets[k as usize].clone());
        joined.members().iter().map(|set| set.iter().flat_map(pick).collect()).collect()
    }

    /// Which facets are nearer to one end of a face than to the other. The line between the halves is as short as single facets can make it.
    pub(super) fn halves(&self, facets: &[FacePatch]) -> Vec<bool> {
        let neighbours = self.neighbouring(facets, Some(f64::INFINITY));
        let middles: Vec<Point> = facets.iter().map(|facet| self.middle(facet)).collect();
        let distances = |from: usize| {
            let mut far = vec![f64::INFINITY; facets.len()];
            far[from] = 0.0;
            let mut queue = BinaryHeap::from([(Reverse(OrderedFloat(0.0)), from)]);
            while let Some((Reverse(OrderedFloat(so_far)), k)) = queue.pop() {
                if so_far > far[k] {
                    continue;
                }
                for &other in neighbours[k].keys() {
                    let along = so_far + (middles[other] - middles[k]).norm();
                    if along < far[other] {
                        far[other] = along;
                        queue.push((Reverse(OrderedFloat(along)), other));
                    }
                }
            }
            far
        };
        let farthest_from = |from: usize| {
            let far = distances(from);
            let others = (0..facets.len()).filter(|&k| k != from);
            others.max_by(|&a, &b| far[a].total_cmp(&far[b]).then(a.cmp(&b))).unwrap_or(from)
        };
        let one = farthest_from(0);
        let other = farthest_from(one);
        let [of_one, of_other] = [one, other].map(distances);
        let mut is_first: Vec<bool> = of_one.iter().zip(&of_other).map(|(a, b)| a <= b).collect();
        // Each facet that goes over makes the line shorter. Those at the line alone may, as it runs away along a narrow strip.
        let is_at_line = |k: &usize| neighbours[*k].keys().any(|&n| is_first[n] != is_first[*k]);
        let at_line: Vec<usize> =
            (0..facets.len()).filter(|&k| k != one && k != other).filter(is_at_line).collect();
        loop {
            let mut moved = false;
            for &k in &at_line {
                let shared = |own: bool| -> f64 {
                    let those = neighbours[k].iter().filter(|of| is_first[*of.0] == own);
                    those.map(|of| of.1).sum()
                };
                if shared(!is_first[k]) > (1.0 + ROUNDING) * shared(is_first[k]) {
                    is_first[k] = !is_first[k];
                    moved = true;
                }
            }
            if !moved {
                return is_first;
            }
        }
    }

    fn middle(&self, facet: &FacePatch) -> Point {
        let mut sum = Vector::zeros();
        let mut whole = 0.0;
        for &t in &facet.triangles {
            let triangle = self.mesh.triangles[t as usize];
            let area = self.mesh.area_vector(triangle).norm();
            let [a, b, c] = self.mesh.corners(triangle).map(|p| p.coords);
            sum += area * (a + b + c) / 3.0;
            whole += area;
        }
        Point::from(sum / f64::max(whole, f64::MIN_POSITIVE))
    }

    /// For each facet those that continue it across edges, and how long these are.
    fn neighbouring(
        &self,
        facets: &[FacePatch],
        most_sagitta: Option<f64>,
    ) -> Vec<BTreeMap<usize, f64>> {
        let mut of: BTreeMap<u32, usize> = BTreeMap::new();
        for (k, facet) in facets.iter().enumerate() {
            of.extend(facet.triangles.iter().map(|&t| (t, k)));
        }
        let beside = |facet: &FacePatch, k: usize| {
            let sides = facet.triangles.iter().flat_map(|&t| 3 * t as usize..3 * t as usize + 3);
            let mut others = BTreeMap::new();
            for side in sides {
                let Some(twin) = self.edges.across(side) else { continue };
                let Some(&other) = of.get(&((twin / 3) as u32)) else { continue };
                if other != k && self.is_smooth(side, twin, [facet, &facets[other]], most_sagitta) {
                    let (from, to) = self.mesh.side(side);
                    let long = (self.mesh.point(to) - self.mesh.point(from)).norm();
                    *others.entry(other).or_default() += long;
                }
            }
            others
        };
        facets.iter().enumerate().map(|(k, facet)| beside(facet, k)).collect()
    }

    /// Whether a free-form face may cross the edge between two facets. In a clean mesh it is neither sharp nor the border of a flat face,
    /// which is much wider than the facets of a curved face beside it. A wide facet counts as curved if it leaves a curve across it no farther than
    /// a length.
    fn is_smooth(
        &self,
        side: usize,
        twin: usize,
        facets: [&FacePatch; 2],
        most_sagitta: Option<f64>,
    ) -> bool {
        let FreeForms::Through { turn, .. } = self.free_forms else { return true };
        let (from, to) = self.mesh.side(side);
        let from = self.mesh.point(from);
        let along = (self.mesh.point(to) - from).normalize();
        let width = |facet: &FacePatch| {
            let vertices = facet.triangles.iter().flat_map(|&t| self.mesh.triangles[t as usize]);
            let off = |v: VertexId| (self.mesh.point(v) - from).cross(&along).norm();
            vertices.map(off).fold(0.0, f64::max)
        };
        let [a, b] = facets.map(width);
        let is_usual = |most: f64| {
            let (own, wide) = if a > b { (side, facets[0]) } else { (twin, facets[1]) };
            self.sagitta(own, &wide.triangles, turn) <= most
        };
        self.dihedral(side, twin) <= turn
            && (a.max(b) <= MOST_WIDER * a.min(b) || most_sagitta.is_some_and(is_usual))
    }
}
