//! What the front checks in a local parameter plane.

use crate::geometry::{LocalPlane, Point, Uv, orient2d, segments_cross};

impl LocalPlane {
    /// The counter-clockwise angle from `from − at` to `to − at`, in [0, 2π).
    pub(crate) fn angle(&self, from: Point, at: Point, to: Point) -> f64 {
        let at = self.flat(at);
        let (d, e) = (self.flat(from) - at, self.flat(to) - at);
        (e.y.atan2(e.x) - d.y.atan2(d.x)).rem_euclid(std::f64::consts::TAU)
    }

    /// Whether the triangle `a b c` is counter-clockwise, has no end of `edges` inside, and
    /// crosses none of them. An edge may end at a corner of the triangle.
    pub(crate) fn is_free(&self, corners: [Point; 3], edges: &[(Point, Point)]) -> bool {
        let [a, b, c] = corners.map(|p| self.flat(p));
        if orient2d(a, b, c) <= 0.0 {
            return false;
        }
        let inside = |p: Uv| {
            orient2d(a, b, p) >= 0.0 && orient2d(b, c, p) >= 0.0 && orient2d(c, a, p) >= 0.0
        };
        edges.iter().all(|&(p, q)| {
            let ends = [p, q].map(|e| corners.contains(&e));
            let (p, q) = (self.flat(p), self.flat(q));
            let holds = (!ends[0] && inside(p)) || (!ends[1] && inside(q));
            let crosses = |s: Uv, t: Uv| segments_cross(s, t, p, q);
            !holds && !crosses(a, b) && !crosses(b, c) && !crosses(c, a)
        })
    }
}
