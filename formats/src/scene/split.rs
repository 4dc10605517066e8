//! The groups of a mesh as meshes of their own. Equal ones become places of one mesh.

use super::same::KnownMeshes;
use super::{ColourRuns, Placement, PolygonRuns, Scene, SceneMesh};
use crate::far::decimal_power;

impl Scene {
    /// The scene in which each named group of the only mesh is a place: objects of OBJ, solids of STL. These formats
    /// have no placements, so groups with the same polygons after a motion become places of one mesh, in whatever order
    /// they have their points and polygons: each vertex must agree within the rounding of the file. Places whose colour
    /// differs have their own. `None` if the scene has several places, or a mesh without groups.
    pub fn split_groups(&self) -> Option<Scene> {
        match self.meshes.as_slice() {
            [mesh] if !mesh.groups.is_empty() && self.place_count() == 1 => Some(self.split()),
            _ => None,
        }
    }

    fn split(&self) -> Scene {
        let mut scene = Scene::new(&self.file, self.bytes);
        (scene.unit, scene.unit_comment) = (self.unit, self.unit_comment.clone());
        (scene.is_y_up, scene.notes) = (self.is_y_up, self.notes.clone());
        scene.turn = self.turn;
        let outer = self.turn.unwrap_or(Placement::IDENTITY);
        let mesh = &self.meshes[0];
        let mut known = KnownMeshes::new(rounding(&mesh.soup.points));
        for group in groups(mesh) {
            let (name, colour) = (group.name.clone(), group.colour);
            let (id, motion) = match known.find(&scene.meshes, &group) {
                Ok(found) => found,
                Err(shape) => {
                    let id = scene.add_mesh(group);
                    known.add(id, shape);
                    (id, Placement::IDENTITY)
                }
            };
            let node = scene.add_place(None, name, &outer.after(&motion), id);
            let own = colour.filter(|_| colour != scene.meshes[id.0].colour);
            scene.node_mut(node).colour = own;
        }
        scene
    }
}

/// The meshes of the groups, in the order in which the groups begin. Points are in the order of their first use.
fn groups(mesh: &SceneMesh) -> Vec<SceneMesh> {
    let count = mesh.groups.values().len();
    let mut group_of = vec![count; mesh.soup.polygons.len()];
    let (mut order, mut is_known) = (Vec::new(), vec![false; count]);
    for (run, group) in mesh.groups.iter() {
        if !std::mem::replace(&mut is_known[group], true) {
            order.push(group);
        }
        group_of[run].fill(group);
    }
    let colour_of = colours(mesh);
    let mut members: Vec<Vec<(&[u32], usize)>> = vec![Vec::new(); count + 1];
    for (at, polygon) in mesh.soup.polygons.iter().enumerate() {
        members[group_of[at]].push((polygon, at));
    }
    let mut numbers = vec![u32::MAX; mesh.soup.points.len()];
    let of_group = |group: usize| {
        let mut part = SceneMesh::default();
        (part.soup.unit, part.soup.unit_comment) = (mesh.soup.unit, mesh.soup.unit_comment.clone());
        part.name.clone_from(&mesh.groups.values()[group]);
        let mut runs = ColourRuns::default();
        let mut used = Vec::new();
        for (polygon, at) in &members[group] {
            let corners: Vec<u32> = polygon
                .iter()
                .map(|&corner| {
                    let number = &mut numbers[corner as usize];
                    if *number == u32::MAX {
                        *number = part.soup.points.len() as u32;
                        part.soup.points.push(mesh.soup.points[corner as usize]);
                        used.push(corner);
                    }
                    *number
                })
                .collect();
            part.soup.polygons.push(corners);
            runs.extend_to(part.soup.polygons.len(), colour_of[*at]);
        }
        used.iter().for_each(|&corner| numbers[corner as usize] = u32::MAX);
        runs.give(&mut part);
        part
    };
    order.into_iter().map(of_group).collect()
}

/// The colour of each polygon.
fn colours(mesh: &SceneMesh) -> Vec<Option<[u8; 3]>> {
    let mut colours = vec![mesh.colour; mesh.soup.polygons.len()];
    let of: &PolygonRuns<_> = &mesh.colours;
    for (run, value) in of.iter() {
        colours[run].fill(of.values()[value]);
    }
    colours
}

/// The step between numbers of the file: that of its decimal digits, or that of single precision.
fn rounding(points: &[[f64; 3]]) -> f64 {
    let reach = points.as_flattened().iter().filter(|x| x.is_finite());
    let reach = reach.fold(0.0, |reach: f64, x| reach.max(x.abs()));
    let single = f64::from(f32::EPSILON) * reach;
    decimal_power(points).map_or(single, |power| single.max(1.0 / power))
}
