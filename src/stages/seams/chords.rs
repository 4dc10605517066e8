//! How far a smooth surface through the vertices of a clean mesh leaves its triangles: the chord error.
//!
//! A surface that turns by an angle from one triangle to the next, across triangles of some width, leaves them by an eighth of the angle times the
//! width. This is all that the mesh tells of the surface between its vertices.

use super::gaps::SAGITTA_RATIO;
use super::{FreeForms, Work};
use crate::geometry::Point;
use crate::primitives::PrimitiveKind;

/// How far a patch is from a smooth surface.
pub(super) struct ChordError {
    /// The largest one of its triangles in mm.
    pub most: f64,
    /// The largest angle between neighbouring triangles.
    pub turn: f64,
}

impl Work<'_> {
    /// The chord error of a patch.
    pub(super) fn chord_error(&self, i: usize) -> ChordError {
        let mut found = ChordError { most: 0.0, turn: 0.0 };
        for &t in &self.patches[i].triangles {
            let double_area = self.mesh.area_vector(self.mesh.triangles[t as usize]).norm();
            for side in 3 * t as usize..3 * t as usize + 3 {
                let twin = self.edges.across(side);
                let Some(twin) = twin.filter(|twin| self.of_triangle[twin / 3] == i) else {
                    continue;
                };
                let (a, b) = self.mesh.side(side);
                let width = double_area / (self.mesh.point(a) - self.mesh.point(b)).norm();
                let turn = self.dihedral(side, twin);
                found.most = found.most.max(turn * width / 8.0);
                found.turn = found.turn.max(turn);
            }
        }
        found
    }

    /// The largest chord error that the mesher of a clean mesh may have allowed itself, from the curved faces that are known.
    pub(super) fn most_sagitta(&self) -> Option<f64> {
        let is_clean = matches!(self.free_forms, FreeForms::Through { .. });
        let curved = (0..self.patches.len())
            .filter(|&i| self.patches[i].surface.kind() != PrimitiveKind::Plane);
        let most = curved.map(|i| self.chord_error(i).most).fold(0.0, f64::max);
        (is_clean && most > 0.0).then_some(SAGITTA_RATIO * most)
    }

    /// How far a smooth curve across a facet, from one of its sides on, leaves the facet. Of the turn at each of its smooth borders it takes one half.
    pub(super) fn sagitta(&self, side: usize, facet: &[u32], smooth: f64) -> f64 {
        let (from, to) = self.mesh.side(side);
        let from = self.mesh.point(from);
        let along = (self.mesh.point(to) - from).normalize();
        let off = |p: Point| (p - from).cross(&along).norm();
        let sides = facet.iter().flat_map(|&t| 3 * t as usize..3 * t as usize + 3);
        let border = sides.filter_map(|side| {
            let twin =
                self.edges.across(side).filter(|twin| !facet.contains(&((twin / 3) as u32)))?;
            let (a, b) = self.mesh.side(side);
            let middle = nalgebra::center(&self.mesh.point(a), &self.mesh.point(b));
            (self.dihedral(side, twin) <= smooth).then(|| (off(middle), self.half_turn(side, twin)))
        });
        let corners = facet.iter().flat_map(|&t| self.mesh.triangles[t as usize]);
        let width = corners.map(|v| off(self.mesh.point(v))).fold(0.0, f64::max);
        let own = self.edges.across(side).map_or(0.0, |twin| self.half_turn(side, twin));
        // A border in the half beside the side is another part of it.
        let other = border.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|other| other.0 > 0.5 * width);
        let other = other.map_or(own, |other| other.1);
        let rise = |k: i32| {
            let t = f64::from(k) / 8.0;
            t * (1.0 - t) * (own * (1.0 - t) + other * t)
        };
        width * (1..8).map(|k| rise(k).abs()).fold(0.0, f64::max)
    }

    /// Half of the angle between the triangles of two sides, negative where they make a groove.
    fn half_turn(&self, side: usize, twin: usize) -> f64 {
        let corner = self.mesh.point(self.mesh.triangles[twin / 3][(twin + 2) % 3]);
        let normal = self.mesh.area_vector(self.mesh.triangles[side / 3]);
        let (on, _) = self.mesh.side(side);
        let is_groove = normal.dot(&(corner - self.mesh.point(on))) > 0.0;
        let half = 0.5 * self.dihedral(side, twin);
        if is_groove { -half } else { half }
    }

    /// The angle between the triangles of two sides.
    pub(super) fn dihedral(&self, side: usize, twin: usize) -> f64 {
        let [a, b] = [side, twin].map(|side| self.mesh.area_vector(self.mesh.triangles[side / 3]));
        a.angle(&b)
    }
}
