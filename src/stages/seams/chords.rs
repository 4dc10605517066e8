//! How far a smooth surface through the vertices of a clean mesh leaves its triangles: the chord error.
//!
//! A surface that turns by an angle from one triangle to the next, across triangles of some width, leaves them by an eighth of the angle times the
//! width. This is all that the mesh tells of the surface between its vertices.

use super::Work;

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

    /// The angle between the triangles of two sides.
    pub(super) fn dihedral(&self, side: usize, twin: usize) -> f64 {
        let [a, b] = [side, twin].map(|side| self.mesh.area_vector(self.mesh.triangles[side / 3]));
        a.angle(&b)
    }
}
