//! How objects refer to each other, and the scene that the build makes of them.

use std::collections::BTreeMap;

use super::fault::PackageFault;
use super::model::{Model, Object, ObjectKey, ObjectType, ObjectUse, Shaped};
use crate::scene::{MOST_NODES, MeshId, NodeId, Placement, Scene, SceneNote};

/// The greatest depth of components. Assemblies are some ten deep.
const MOST_DEPTH: u32 = 64;

/// All objects of all parts.
struct Objects {
    all: Vec<Object>,
    /// The number of each object's part.
    model: Vec<usize>,
    number: BTreeMap<(usize, u32), usize>,
    /// The length of each part's unit in that of the root.
    units: Vec<f64>,
}

/// Makes the scene of the models. The build of the first one counts.
pub(super) fn make(mut models: Vec<Model>, scene: &mut Scene) -> Result<(), PackageFault> {
    let Some(root) = models.first_mut() else { return Err(PackageFault::no_model()) };
    let (unit, items) = (root.unit, std::mem::take(&mut root.items));
    scene.unit = Some(unit);
    let units = models.iter().map(|model| model.unit.in_mm() / unit.in_mm()).collect();
    let mut objects =
        Objects { all: Vec::new(), model: Vec::new(), number: BTreeMap::new(), units };
    let mut odd = BTreeMap::new();
    for (model, part) in models.into_iter().enumerate() {
        for (what, count) in part.odd.0 {
            *odd.entry(what).or_insert(0) += count;
        }
        for (id, object) in part.objects {
            objects.number.insert((model, id), objects.all.len());
            objects.all.push(object);
            objects.model.push(model);
        }
    }
    let counts = objects.counts(&items)?;
    objects.notes(&counts, scene)?;
    scene.notes.extend(odd.into_iter().map(|(what, count)| SceneNote::Irregular(what, count)));
    objects.place(items, scene)
}

impl Objects {
    fn find(&self, key: &ObjectKey, by: &str) -> Result<usize, PackageFault> {
        let found = self.number.get(&(key.model, key.id)).copied();
        found.ok_or_else(|| {
            PackageFault::new(format!("has {by} of object {}, which does not exist", key.id))
        })
    }

    fn components(&self, object: usize) -> &[ObjectUse] {
        match &self.all[object].shape {
            Shaped::Components(uses) => uses,
            Shaped::Mesh(_) | Shaped::Unread(_) => &[],
        }
    }

    /// How often the build places each object. Objects that are components of themselves, too deep or too many are
    /// refused. Each object is visited once, after all that use it.
    fn counts(&self, items: &[ObjectUse]) -> Result<Vec<u64>, PackageFault> {
        let count = self.all.len();
        let mut waiting = vec![0u32; count];
        let mut children = vec![Vec::new(); count];
        for (object, children) in children.iter_mut().enumerate() {
            for used in self.components(object) {
                let child = self.find(&used.object, "a component")?;
                children.push(child);
                waiting[child] += 1;
            }
        }
        let (mut placed, mut depth) = (vec![0u64; count], vec![0u32; count]);
        for item in items {
            placed[self.find(&item.object, "an item")?] += 1;
        }
        let mut ready: Vec<usize> = (0..count).filter(|&object| waiting[object] == 0).collect();
        let (mut done, mut total) = (0, 0u64);
        while let Some(object) = ready.pop() {
            done += 1;
            total = total.saturating_add(placed[object]);
            for &child in &children[object] {
                placed[child] = placed[child].saturating_add(placed[object]);
                depth[child] = depth[child].max(depth[object] + 1);
                if depth[child] > MOST_DEPTH {
                    return Err(PackageFault::new(
                        "has components in each other, more than 64 deep",
                    ));
                }
                waiting[child] -= 1;
                if waiting[child] == 0 {
                    ready.push(child);
                }
            }
        }
        if done < count {
            return Err(PackageFault::new("has an object that is a component of itself"));
        }
        if total > MOST_NODES as u64 {
            let help = "Export its parts in several files.";
            return Err(PackageFault::helped(
                format!("places more than {MOST_NODES} objects"),
                help,
            ));
        }
        Ok(placed)
    }

    /// Says what is left out. It is an error if nothing remains.
    fn notes(&self, counts: &[u64], scene: &mut Scene) -> Result<(), PackageFault> {
        let objects = || self.all.iter().zip(counts);
        let built = || objects().filter(|(_, count)| **count > 0).map(|(object, _)| object);
        let of = |kind| built().filter(|object| object.kind == kind).count() as u64;
        let (supports, others) = (of(ObjectType::Support), of(ObjectType::Other));
        let unbuilt = objects()
            .filter(|(object, count)| **count == 0 && matches!(object.shape, Shaped::Mesh(_)));
        let unbuilt = unbuilt.count() as u64;
        let mut unread: BTreeMap<&'static str, u64> = BTreeMap::new();
        let has_faces = |object: &Object| matches!(&object.shape, Shaped::Mesh(mesh) if !mesh.soup.polygons.is_empty());
        for object in built() {
            let shape = match object.shape {
                Shaped::Unread(kind) => Some(kind),
                _ => None,
            };
            if let Some(kind) = shape.or(object.unread) {
                *unread.entry(kind).or_default() += 1;
            }
        }
        if !built().any(|object| object.kind == ObjectType::Model && has_faces(object)) {
            let help = "Export the object itself as a mesh, as 3MF or STL.";
            return Err(match (unread.first_key_value(), supports + others) {
                (Some((kind, _)), _) => {
                    PackageFault::helped(format!("has only {kind}, which are not read"), help)
                }
                (None, 1..) => PackageFault::helped(
                    "has only supports and objects of the type \u{201c}other\u{201d}",
                    help,
                ),
                (None, 0) => {
                    PackageFault::helped("has no object with triangles in its build", help)
                }
            });
        }
        let counted = [
            (supports, SceneNote::Supports(supports)),
            (others, SceneNote::OtherObjects(others)),
            (unbuilt, SceneNote::NotBuilt(unbuilt)),
        ];
        scene
            .notes
            .extend(counted.into_iter().filter(|(count, _)| *count > 0).map(|(_, note)| note));
        scene.notes.extend(unread.into_iter().map(|(kind, count)| SceneNote::NotRead(kind, count)));
        Ok(())
    }

    /// Adds the items and all that they are made of to the scene.
    fn place(mut self, items: Vec<ObjectUse>, scene: &mut Scene) -> Result<(), PackageFault> {
        let unit = scene.unit;
        let mut meshes: Vec<Option<MeshId>> = Vec::with_capacity(self.all.len());
        for object in &mut self.all {
            meshes.push(match &mut object.shape {
                Shaped::Mesh(mesh) if !mesh.soup.polygons.is_empty() => {
                    let mut mesh = std::mem::take(&mut **mesh);
                    mesh.name.clone_from(&object.name);
                    mesh.soup.unit = unit;
                    Some(scene.add_mesh(mesh))
                }
                _ => None,
            });
        }
        // What waits: a use, the part that it is in, and the node that it belongs to.
        let mut open: Vec<(&ObjectUse, usize, Option<NodeId>)> = Vec::new();
        open.extend(items.iter().rev().map(|item| (item, 0, None)));
        while let Some((used, by, parent)) = open.pop() {
            let object = self.find(&used.object, "a use")?;
            let Object { name, kind, .. } = &self.all[object];
            if *kind != ObjectType::Model {
                continue;
            }
            let of = self.model[object];
            let scale = self.units[of] / self.units[by];
            // A part in another unit is scaled before it is placed.
            let in_unit =
                Placement::linear([[scale, 0.0, 0.0], [0.0, scale, 0.0], [0.0, 0.0, scale]]);
            let place = if scale == 1.0 { used.placement } else { used.placement.after(&in_unit) };
            if let Some(mesh) = meshes[object] {
                scene.add_place(parent, used.name.clone(), &place, mesh);
            } else if let Shaped::Components(uses) = &self.all[object].shape {
                let group = scene.add_group(parent, used.name.clone(), &place);
                scene.node_mut(group).group_name.clone_from(name);
                open.extend(uses.iter().rev().map(|used| (used, of, Some(group))));
            }
        }
        Ok(())
    }
}
