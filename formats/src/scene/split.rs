//! The groups of a mesh as meshes of their own. Equal ones become places of one mesh.

use std::collections::BTreeMap;

use super::placement::rotation_of;
use super::{ColourRuns, MeshId, Placement, PolygonRuns, Scene, SceneMesh};
use crate::far::decimal_power;
use crate::soup::Polygons;

impl Scene {
    /// The scene in which each named group of the only mesh is a place: objects of OBJ, solids of STL. These formats
    /// have no placements, so groups with the same triangles after a motion become places of one mesh: each vertex must
    /// agree within the rounding of the file. `None` if the scene has several places, or a mesh without groups.
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
        let mesh = &self.meshes[0];
        let rounding = rounding(&mesh.soup.points);
        let mut known: BTreeMap<(usize, u64), Vec<MeshId>> = BTreeMap::new();
        for group in groups(mesh) {
            let name = group.name.clone();
            let key = (group.soup.points.len(), digest(&group.soup.polygons));
            let same = known.entry(key).or_default();
            let found = same.iter().find_map(|&id| {
                let motion = motion_of(&scene.meshes[id.0], &group, rounding)?;
                Some((id, motion))
            });
            let (id, placement) = found.unwrap_or_else(|| {
                let id = scene.add_mesh(group);
                same.push(id);
                (id, Placement::IDENTITY)
            });
            scene.add_place(None, name, &placement, id);
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

/// The motion that takes `a` to `b`, if they have the same polygons and each vertex agrees within twice the rounding:
/// the coordinates of both have it. The rotation is that of the least squares of all vertices (Kabsch, 1976).
fn motion_of(a: &SceneMesh, b: &SceneMesh, rounding: f64) -> Option<Placement> {
    let is_same = a.soup.polygons == b.soup.polygons
        && a.colour == b.colour
        && a.colours == b.colours
        && a.soup.points.len() == b.soup.points.len();
    let count = a.soup.points.len() as f64;
    if !is_same || count == 0.0 {
        return None;
    }
    let mean = |points: &[[f64; 3]]| {
        let sum = points.iter().fold([0.0; 3], |sum, p| [0, 1, 2].map(|k| sum[k] + p[k]));
        sum.map(|x| x / count)
    };
    let [from, to] = [mean(&a.soup.points), mean(&b.soup.points)];
    let mut covariance = [[0.0; 3]; 3];
    for (p, q) in a.soup.points.iter().zip(&b.soup.points) {
        for (j, column) in covariance.iter_mut().enumerate() {
            let along = p[j] - from[j];
            *column = [0, 1, 2].map(|i| column[i] + (q[i] - to[i]) * along);
        }
    }
    let axes = rotation_of(&covariance)?;
    let turn = Placement::linear(axes);
    let turned = turn.apply(from);
    let motion = Placement { axes, translation: [0, 1, 2].map(|i| to[i] - turned[i]) };
    let is_near = |(p, q): (&[f64; 3], &[f64; 3])| {
        let moved = motion.apply(*p);
        (0..3).all(|i| (moved[i] - q[i]).abs() <= 2.0 * rounding)
    };
    a.soup.points.iter().zip(&b.soup.points).all(is_near).then_some(motion)
}

/// The step between numbers of the file: that of its decimal digits, or that of single precision.
fn rounding(points: &[[f64; 3]]) -> f64 {
    let reach = points.as_flattened().iter().filter(|x| x.is_finite());
    let reach = reach.fold(0.0, |reach: f64, x| reach.max(x.abs()));
    let single = f64::from(f32::EPSILON) * reach;
    decimal_power(points).map_or(single, |power| single.max(1.0 / power))
}

/// A number that differs for most other polygons (FNV-1a).
fn digest(polygons: &Polygons) -> u64 {
    let numbers = polygons.iter().flat_map(|polygon| {
        std::iter::once(polygon.len() as u64).chain(polygon.iter().map(|&corner| corner.into()))
    });
    numbers.fold(0xcbf2_9ce4_8422_2325, |digest, number| {
        (digest ^ number).wrapping_mul(0x0100_0000_01b3)
    })
}
