//! Turning a scene upright.

use super::{NodeContent, NodeId, Placement, Scene};

/// The axis of a result that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UpAxis {
    /// y, as in glTF.
    Y,
    /// z, as in CAD programs and in all other formats.
    Z,
}

impl Scene {
    /// The scene turned about x so that what points up in the file points along an axis.
    #[must_use]
    pub fn with_up(mut self, up: UpAxis) -> Scene {
        let is_y = up == UpAxis::Y;
        if self.is_y_up == is_y {
            return self;
        }
        let s = if is_y { -1.0 } else { 1.0 };
        let turn = Placement::linear([[1.0, 0.0, 0.0], [0.0, 0.0, s], [0.0, -s, 0.0]]);
        // A group at the origin stays there, and what is in it turns: it may be the whole.
        let mut stays = vec![false; self.nodes.len()];
        for number in 0..self.nodes.len() {
            let node = &self.nodes[number];
            let is_top = node.parent.is_none_or(|NodeId(parent)| stays[parent]);
            stays[number] = is_top
                && node.content == NodeContent::Group
                && node.placement == Placement::IDENTITY;
            let moves = is_top && !stays[number];
            let node = &mut self.nodes[number];
            node.as_read = Some(turn.after(&node.as_read.unwrap_or(Placement::IDENTITY)));
            if moves {
                node.placement = turn.after(&node.placement).rounded_to_identity();
            }
        }
        self.turn = Some(self.turn.map_or(turn, |before| turn.after(&before)));
        self.is_y_up = is_y;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Soup;
    use crate::scene::SceneMesh;

    #[test]
    fn y_becomes_z_and_back() {
        let mut scene = Scene::of_mesh("a.glb", SceneMesh::plain(Soup::default()));
        scene.is_y_up = true;
        let up = scene.clone().with_up(UpAxis::Z);
        assert!(!up.is_y_up);
        assert_eq!(up.places()[0].apply([1.0, 2.0, 3.0]), [1.0, -3.0, 2.0]);
        assert_eq!(up.with_up(UpAxis::Y).places(), scene.places());
        assert_eq!(scene.clone().with_up(UpAxis::Y), scene);
    }

    #[test]
    fn a_root_that_undoes_the_turn_is_the_whole() {
        let mut scene = Scene::new("a.glb", 0);
        scene.is_y_up = true;
        let half = 0.5_f64.sqrt();
        // A quarter turn back, from a quaternion.
        let back = 1.0 - 2.0 * half * half;
        let turn = [[1.0, 0.0, 0.0], [0.0, back, -1.0], [0.0, 1.0, back]];
        let root = scene.add_group(None, None, &Placement::linear(turn));
        let mesh = scene.add_mesh(SceneMesh::default());
        scene.add_place(Some(root), None, &Placement::IDENTITY, mesh);
        let up = scene.with_up(UpAxis::Z);
        assert_eq!(up.nodes()[0].placement, Placement::IDENTITY);
        assert_eq!(up.nodes()[1].placement, Placement::IDENTITY);
    }
}
