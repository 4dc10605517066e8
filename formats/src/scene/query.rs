//! What a scene holds: the tree, places, names, and scenes of some of it.

use std::borrow::Cow;

use super::placement::product;
use super::{FormId, MeshId, NodeContent, NodeId, Placement, Scene, SceneForm, SceneMesh};

impl Scene {
    /// The children of each node, and the roots.
    pub fn children(&self) -> (Vec<Vec<NodeId>>, Vec<NodeId>) {
        let mut children = vec![Vec::new(); self.nodes.len()];
        let mut roots = Vec::new();
        for (number, node) in self.nodes.iter().enumerate() {
            match node.parent {
                Some(NodeId(parent)) => children[parent].push(NodeId(number)),
                None => roots.push(NodeId(number)),
            }
        }
        (children, roots)
    }

    /// Whether there is a face.
    pub(crate) fn has_polygons(&self) -> bool {
        self.meshes.iter().any(|mesh| !mesh.soup.polygons.is_empty())
    }

    /// The names on the way to a node, from the root. A node without a name has that of what is there, or an empty one.
    pub fn path(&self, node: NodeId) -> Vec<&str> {
        let parent = |&NodeId(node): &NodeId| self.nodes[node].parent;
        let upwards = std::iter::successors(Some(node), parent);
        let mut path: Vec<&str> = upwards.map(|node| self.name(node).unwrap_or_default()).collect();
        path.reverse();
        path
    }

    /// The name of a node, or that of what is there if the place has none.
    pub fn name(&self, NodeId(node): NodeId) -> Option<&str> {
        let node = &self.nodes[node];
        let of_product = match node.content {
            NodeContent::Group => node.group_name.as_deref(),
            NodeContent::Form(FormId(form)) => self.meshes[self.forms[form].mesh.0].name.as_deref(),
        };
        node.name.as_deref().or(of_product)
    }

    /// The scene with only those places that `keeps` has, and the groups that lead to them. `keeps` is asked for each node;
    /// a group that is kept keeps all that is in it.
    #[must_use]
    pub fn kept(mut self, keeps: impl Fn(NodeId) -> bool) -> Scene {
        let count = self.nodes.len();
        let mut all = vec![false; count];
        for number in 0..count {
            let by_parent = self.nodes[number].parent.is_some_and(|NodeId(parent)| all[parent]);
            all[number] = by_parent || keeps(NodeId(number));
        }
        let mut leads = vec![false; count];
        for number in (0..count).rev() {
            let is_form = self.nodes[number].content != NodeContent::Group;
            leads[number] |= is_form && all[number];
            if let Some(NodeId(parent)) = self.nodes[number].parent.filter(|_| leads[number]) {
                leads[parent] = true;
            }
        }
        let mut numbers = vec![0; count];
        let mut nodes = Vec::new();
        for (number, mut node) in std::mem::take(&mut self.nodes).into_iter().enumerate() {
            if leads[number] {
                numbers[number] = nodes.len();
                node.parent = node.parent.map(|NodeId(parent)| NodeId(numbers[parent]));
                nodes.push(node);
            }
        }
        self.nodes = nodes;
        self
    }

    /// The forms that have a place, with the nodes that place them.
    pub fn uses(&self) -> Vec<(FormId, Vec<NodeId>)> {
        let mut uses: Vec<_> =
            (0..self.forms.len()).map(|form| (FormId(form), Vec::new())).collect();
        for (number, node) in self.nodes.iter().enumerate() {
            if let NodeContent::Form(FormId(form)) = node.content {
                uses[form].1.push(NodeId(number));
            }
        }
        uses.retain(|(_, places)| !places.is_empty());
        uses
    }

    /// The scene of one form alone, in its own frame.
    #[must_use]
    pub fn form_alone(&self, form: FormId) -> Scene {
        let mut scene = Scene::of_mesh(&self.file, self.form_mesh(form).into_owned());
        (scene.unit, scene.unit_comment) = (self.unit, self.unit_comment.clone());
        (scene.is_y_up, scene.notes) = (self.is_y_up, self.notes.clone());
        if let Some(turn) = self.turn {
            // Its own frame is turned as the scene is.
            (scene.nodes[0].placement, scene.nodes[0].as_read) = (turn, Some(turn));
            scene.turn = Some(turn);
        }
        scene
    }

    /// The number of nodes that place a mesh.
    pub fn place_count(&self) -> usize {
        self.nodes.iter().filter(|node| node.content != NodeContent::Group).count()
    }

    /// The number of groups around the innermost node.
    pub fn depth(&self) -> u32 {
        let mut depths: Vec<u32> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            depths.push(node.parent.map_or(0, |NodeId(parent)| depths[parent] + 1));
        }
        depths.into_iter().max().unwrap_or(0)
    }

    /// The number of parts that are scaled or mirrored in their places. A placement in a CAD file cannot do that.
    pub fn stretched_count(&self) -> usize {
        let uses = self.uses();
        uses.iter().filter(|(form, _)| self.forms[form.0].stretch.is_some()).count()
    }

    /// The place of each node in the scene. All are rigid.
    pub fn places(&self) -> Vec<Placement> {
        let mut places: Vec<Placement> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let outer = node.parent.map_or(Placement::IDENTITY, |NodeId(parent)| places[parent]);
            places.push(outer.after(&node.placement));
        }
        places
    }

    /// The mesh of a form, stretched or mirrored as its places have it.
    pub fn form_mesh(&self, FormId(form): FormId) -> Cow<'_, SceneMesh> {
        let SceneForm { mesh: MeshId(mesh), stretch } = &self.forms[form];
        let mesh = &self.meshes[*mesh];
        let Some(stretch) = stretch else { return Cow::Borrowed(mesh) };
        let mut mesh = mesh.clone();
        for point in &mut mesh.soup.points {
            *point = product(stretch, *point);
        }
        if Placement::linear(*stretch).mirrors() {
            mesh.soup.polygons.turn_over();
        }
        Cow::Owned(mesh)
    }
}
