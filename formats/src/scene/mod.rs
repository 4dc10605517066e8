//! The scene of a file: a tree of named nodes that place meshes.
//!
//! All readers of meshes return a [`Scene`]. A file with one mesh is a scene with one node. A mesh is held once,
//! however many nodes place it. The scene knows nothing of surfaces.

mod crop;
mod flat;
mod name;
mod note;
mod placement;
mod query;
mod runs;
mod same;
mod split;
mod up;

use std::collections::BTreeMap;
use std::path::PathBuf;

pub(crate) use flat::{budget, soup_bytes};
pub(crate) use name::clean_name;
pub use note::SceneNote;
pub use placement::Placement;
use placement::{MatrixColumns, UNIT};
pub use runs::PolygonRuns;
pub(crate) use runs::{ColourRuns, GroupRuns};
pub use up::UpAxis;

use crate::{LengthUnit, Soup};

/// The most nodes of a scene. A node takes about 400 bytes.
pub(crate) const MOST_NODES: usize = 1 << 17;

/// The greatest depth of groups. Programs that read CAD files go down by recursion.
pub(crate) const MOST_DEPTH: u32 = 256;

crate::numbered::number! {
    /// The number of a node in [`Scene::nodes`].
    NodeId
    /// The number of a mesh in [`Scene::meshes`].
    MeshId
    /// The number of a form in [`Scene::forms`].
    FormId
}

/// A tree of nodes that place meshes. Lengths are in the unit of the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scene {
    nodes: Vec<SceneNode>,
    meshes: Vec<SceneMesh>,
    forms: Vec<SceneForm>,
    /// The forms by their mesh and their stretch in steps of [`STRETCH_STEP`].
    form_of: BTreeMap<(MeshId, [i64; 9]), FormId>,
    /// The unit that the format defines, or that the file or a comment of it names.
    pub unit: Option<LengthUnit>,
    /// The comment that names the unit, if only a comment does.
    pub unit_comment: Option<String>,
    /// Whether the format says that y points up, as glTF does. Coordinates are as the file has them.
    pub is_y_up: bool,
    /// What the user should know about how the file was read.
    pub notes: Vec<SceneNote>,
    /// How the scene was turned after it was read ([`Scene::with_up`]).
    turn: Option<Placement>,
    /// The path of the file, for errors.
    file: PathBuf,
    /// The number of bytes that were read, which bounds what the scene expands to.
    bytes: u64,
}

/// A node of a [`Scene`]: something with a name and a place.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneNode {
    /// The node that has this one among its children. It has a smaller number. `None` for a root.
    pub parent: Option<NodeId>,
    /// The name of this place, for example "left wheel".
    pub name: Option<String>,
    /// The name of what a group is, for example "wheel". Meshes have a name of their own.
    pub group_name: Option<String>,
    /// The colour of this place (sRGB), if it has one of its own. It comes before those of the mesh.
    pub colour: Option<[u8; 3]>,
    /// The place relative to the parent. It is rigid.
    pub placement: Placement,
    /// What is there.
    pub content: NodeContent,
    /// The place in the scene as the file has it. It may scale and mirror. `None` if the format has no places.
    as_read: Option<Placement>,
    /// What is not rigid in the place: the children are stretched by it.
    stretch: Option<MatrixColumns>,
}

/// What a node places.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NodeContent {
    /// Its children, which may be none.
    Group,
    /// A form, which is a mesh.
    Form(FormId),
}

/// A mesh as some places have it: stretched or mirrored, or as it is. Each form becomes one part.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneForm {
    /// The mesh.
    pub mesh: MeshId,
    /// The images of the axes of the mesh. `None` if the mesh stays as it is.
    pub stretch: Option<[[f64; 3]; 3]>,
}

/// A mesh of a [`Scene`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SceneMesh {
    /// Points and polygons, with the unit of the scene.
    pub soup: Soup,
    /// The name of what the mesh is, for example "screw M6".
    pub name: Option<String>,
    /// The colour of the mesh where it has only one (sRGB).
    pub colour: Option<[u8; 3]>,
    /// The colours of polygons (sRGB), if there are several. `None` is no colour.
    pub colours: PolygonRuns<Option<[u8; 3]>>,
    /// The named groups of polygons: objects and groups of OBJ, solids of STL. There are none, or at least two.
    pub groups: PolygonRuns<Option<String>>,
}

/// Stretches of one mesh are the same if their entries agree in steps of this share of the size of the mesh. It is the
/// error of a rotation of six digits.
const STRETCH_STEP: f64 = 1e-5;

impl Scene {
    /// An empty scene of a file of so many bytes.
    pub(crate) fn new(file: impl Into<PathBuf>, bytes: u64) -> Self {
        Scene { file: file.into(), bytes, ..Scene::default() }
    }

    /// The scene of a file with one mesh.
    pub(crate) fn of_mesh(file: impl Into<PathBuf>, mesh: SceneMesh) -> Self {
        let mut scene = Scene::new(file, 0);
        scene.unit = mesh.soup.unit;
        scene.unit_comment.clone_from(&mesh.soup.unit_comment);
        let mesh = scene.add_mesh(mesh);
        let node = scene.add_place(None, None, &Placement::IDENTITY, mesh);
        scene.nodes[node.0].as_read = None;
        scene
    }

    /// The nodes. Parents come before their children, and children are in the order of the file.
    pub fn nodes(&self) -> &[SceneNode] {
        &self.nodes
    }

    /// The meshes.
    pub fn meshes(&self) -> &[SceneMesh] {
        &self.meshes
    }

    /// The distinct forms of meshes.
    pub fn forms(&self) -> &[SceneForm] {
        &self.forms
    }

    pub(crate) fn add_mesh(&mut self, mesh: SceneMesh) -> MeshId {
        self.meshes.push(mesh);
        MeshId(self.meshes.len() - 1)
    }

    /// Adds a node that holds others. Its place is relative to its parent, and may scale and mirror.
    pub(crate) fn add_group(
        &mut self,
        parent: Option<NodeId>,
        name: Option<String>,
        place: &Placement,
    ) -> NodeId {
        self.add(parent, name, place, NodeContent::Group)
    }

    /// Adds a node that places a mesh.
    pub(crate) fn add_place(
        &mut self,
        parent: Option<NodeId>,
        name: Option<String>,
        place: &Placement,
        mesh: MeshId,
    ) -> NodeId {
        let node = self.add(parent, name, place, NodeContent::Group);
        let form = self.form(mesh, self.nodes[node.0].stretch);
        self.nodes[node.0].content = NodeContent::Form(form);
        node
    }

    /// Says how many bytes were read.
    pub(crate) fn set_bytes(&mut self, bytes: u64) {
        self.bytes = bytes;
    }

    pub(crate) fn node_mut(&mut self, NodeId(node): NodeId) -> &mut SceneNode {
        &mut self.nodes[node]
    }

    fn add(
        &mut self,
        parent: Option<NodeId>,
        name: Option<String>,
        place: &Placement,
        content: NodeContent,
    ) -> NodeId {
        let parent_node = parent.map(|NodeId(parent)| &self.nodes[parent]);
        let outer = parent_node.and_then(|node| node.as_read);
        let outer = outer.unwrap_or(Placement::IDENTITY);
        let outer_stretch = parent_node.and_then(|node| node.stretch);
        let stretched = outer_stretch.map(|axes| Placement::linear(axes).after(place));
        let (placement, stretch) = stretched.as_ref().unwrap_or(place).split();
        self.nodes.push(SceneNode {
            parent,
            name,
            group_name: None,
            colour: None,
            placement,
            content,
            as_read: Some(outer.after(place)),
            stretch,
        });
        NodeId(self.nodes.len() - 1)
    }

    /// The form of a mesh with this stretch.
    fn form(&mut self, mesh: MeshId, stretch: Option<MatrixColumns>) -> FormId {
        let size = stretch.iter().flatten().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        // The exponent of the size tells stretches of other orders apart.
        let order = if size > 0.0 { size.log2().floor() } else { 0.0 };
        let unit = STRETCH_STEP * order.exp2();
        let columns = stretch.unwrap_or(UNIT);
        let mut key = [0; 9];
        for (key, x) in key.iter_mut().zip(columns.as_flattened()) {
            // A quotient beyond its range becomes the end of it.
            *key = (x / unit).round() as i64;
        }
        key[0] = key[0].wrapping_add((order as i64) << 32);
        let next = FormId(self.forms.len());
        let form = *self.form_of.entry((mesh, key)).or_insert(next);
        if form == next {
            self.forms.push(SceneForm { mesh, stretch });
        }
        form
    }
}

impl SceneMesh {
    /// A mesh that has nothing but points and polygons.
    pub(crate) fn plain(soup: Soup) -> Self {
        SceneMesh { soup, ..SceneMesh::default() }
    }
}
