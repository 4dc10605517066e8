//! A scene without some of its points, in their places.

use std::collections::BTreeMap;

use super::{ColourRuns, FormId, NodeContent, NodeId, Placement, Scene, SceneForm, SceneMesh};
use crate::Result;
use crate::soup::Polygons;

impl Scene {
    /// The points of all meshes in their places, in the order of the nodes.
    ///
    /// # Errors
    /// The nodes repeat their meshes so often that there are many times as many as in the file.
    pub fn placed_points(&self) -> Result<Vec<[f64; 3]>> {
        self.check_expansion()?;
        let mut points = Vec::new();
        for (node, mesh) in self.placed() {
            let placement = node.as_read.unwrap_or(Placement::IDENTITY);
            points.extend(mesh.soup.points.iter().map(|p| placement.apply(*p)));
        }
        Ok(points)
    }

    /// The scene without the polygons that have a point that is not kept. `kept` is about the
    /// [`placed_points`](Self::placed_points). A place that loses all polygons is left out. What is cut in the same
    /// way in several places stays one mesh.
    #[must_use]
    pub fn without_points(mut self, kept: &[bool]) -> Scene {
        let mut first = 0;
        let mut stays = vec![false; self.nodes.len()];
        let mut known: BTreeMap<(FormId, Vec<bool>), Option<FormId>> = BTreeMap::new();
        for (number, stays) in stays.iter_mut().enumerate() {
            let NodeContent::Form(form) = self.nodes[number].content else { continue };
            let mesh = &self.meshes[self.forms[form.0].mesh.0];
            let count = mesh.soup.points.len();
            let own = kept.get(first..first + count).unwrap_or_default();
            first += count;
            let is_kept = |polygon: &[u32]| {
                polygon.iter().all(|&corner| own.get(corner as usize).copied().unwrap_or(false))
            };
            let polygons: Vec<bool> = mesh.soup.polygons.iter().map(is_kept).collect();
            if !polygons.contains(&false) {
                *stays = true;
                continue;
            }
            let key = (form, polygons);
            let cut = match known.get(&key) {
                Some(&known) => known,
                None => {
                    let cut = self.cut(form, &key.1);
                    known.insert(key, cut);
                    cut
                }
            };
            if let Some(cut) = cut {
                self.nodes[number].content = NodeContent::Form(cut);
                *stays = true;
            }
        }
        self.kept(|NodeId(node)| stays[node])
    }

    /// Adds a form with some polygons of another one. `None` if there are none.
    fn cut(&mut self, form: FormId, kept: &[bool]) -> Option<FormId> {
        if !kept.contains(&true) {
            return None;
        }
        let SceneForm { mesh, stretch } = &self.forms[form.0];
        let (whole, stretch) = (&self.meshes[mesh.0], *stretch);
        let mut colours = vec![whole.colour; whole.soup.polygons.len()];
        for (run, value) in whole.colours.iter() {
            colours[run].fill(whole.colours.values()[value]);
        }
        let mut cut = SceneMesh { soup: whole.soup.clone(), ..SceneMesh::default() };
        (cut.name, cut.colour) = (whole.name.clone(), whole.colour);
        let (mut polygons, mut runs) = (Polygons::default(), ColourRuns::default());
        let each = whole.soup.polygons.iter().zip(kept).zip(colours);
        for ((polygon, _), colour) in each.filter(|((_, kept), _)| **kept) {
            polygons.push(polygon.iter().copied());
            runs.extend_to(polygons.len(), colour);
        }
        cut.soup.polygons = polygons;
        runs.give(&mut cut);
        let mesh = self.add_mesh(cut);
        self.forms.push(SceneForm { mesh, stretch });
        Some(FormId(self.forms.len() - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Soup;

    #[test]
    fn places_are_cut_or_left_out_by_their_own_points() {
        let mut scene = Scene::new("a", 0);
        let mut soup = Soup {
            points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 2.0, 0.0]],
            ..Soup::default()
        };
        soup.polygons.push([0, 1, 2]);
        soup.polygons.push([2, 1, 3]);
        let mesh = scene.add_mesh(SceneMesh::plain(soup));
        for x in [0.0, 10.0, 20.0, 30.0] {
            let place = Placement { translation: [x, 0.0, 0.0], ..Placement::IDENTITY };
            scene.add_place(None, None, &place, mesh);
        }
        let points = scene.placed_points().expect("few points");
        // The first place is whole, the second and the third lose a triangle, the last one loses all.
        let kept: Vec<bool> =
            points.iter().map(|p| p[0] < 5.0 || (p[1] < 1.5 && p[0] < 25.0)).collect();
        let left = scene.without_points(&kept);
        let counts: Vec<usize> = left.uses().iter().map(|(_, places)| places.len()).collect();
        assert_eq!(counts, [1, 2]);
        assert_eq!(left.form_mesh(left.uses()[1].0).soup.polygons.len(), 1);
    }
}
