//! The groups of a mesh as meshes of their own. Equal ones become places of one mesh.

use super::same::KnownMeshes;
use super::{ColourRuns, Placement, PolygonRuns, Scene, SceneMesh};

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

/// The most coordinates whose digits are counted. They are spread over the file.
const COUNTED: usize = 100_000;

/// The step between numbers of the file at its largest coordinate: that of the significant digits that its numbers have,
/// or four steps of single precision, which are the errors of a product of a matrix and a vertex.
fn rounding(points: &[[f64; 3]]) -> f64 {
    let all = points.as_flattened();
    let reach = all.iter().filter(|x| x.is_finite()).fold(0.0, |reach: f64, x| reach.max(x.abs()));
    let single = 4.0 * f64::from(f32::EPSILON) * reach;
    let counted = all.iter().step_by(all.len().div_ceil(COUNTED).max(1));
    let digits = counted.map(|x| significant_digits(*x)).max().unwrap_or(0);
    if digits > f32::DIGITS as usize + 1 || reach == 0.0 {
        // Whether these are the digits of single or of fixed decimals, the step of the digits may be the larger one.
        return single.max(step(reach, digits)).max(f64::MIN_POSITIVE);
    }
    step(reach, digits)
}

/// The step between numbers of so many significant digits at a number.
fn step(at: f64, digits: usize) -> f64 {
    let exponent = if at > 0.0 { at.log10().floor() } else { 0.0 };
    10f64.powf(exponent + 1.0 - digits as f64)
}

/// The number of digits that a number needs, without zeros at its ends.
fn significant_digits(x: f64) -> usize {
    // The shortest digits that give the number again: d.ddde±x.
    let text = format!("{:e}", x.abs());
    text.bytes().take_while(|b| *b != b'e').filter(u8::is_ascii_digit).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_is_that_of_the_digits() {
        let of = |x: f64| rounding(&[[x, 1.5, 0.0]]);
        assert!((of(2970.12) - 0.01).abs() < 1e-9);
        // %g: the small number has more decimals than the large one.
        assert!((rounding(&[[123.456, 5.12345, 0.0]]) - 1e-3).abs() < 1e-12);
        let single = 4.0 * f64::from(f32::EPSILON);
        assert!((of(f64::from(0.1_f32 * 3.0)) / (1.5 * single) - 1.0).abs() < 1e-9);
        assert_eq!([0.0, 1.5, 2970.12, 1e-7, 100.0].map(significant_digits), [1, 2, 6, 1, 1]);
    }
}
