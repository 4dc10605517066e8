//! The assembly of a scene, after its forms have become parts.

use std::collections::BTreeMap;

use super::{Assembly, AssemblyGroup, AssemblyPart, Member, Product};
use crate::scene::{FormId, NodeContent, NodeId, Placement, Scene, SceneNode};

/// What tells one group from another: the name of the product and the members, each with its colour and the bits of
/// its place.
type GroupKey = (Option<String>, Vec<(String, Product, Option<[u8; 3]>, [u64; 12])>);

/// Makes groups of nodes, and each only once.
struct Groups<'a> {
    scene: &'a Scene,
    mm: f64,
    /// The part of each form.
    part_of: Vec<Option<usize>>,
    groups: Vec<AssemblyGroup>,
    known: BTreeMap<GroupKey, usize>,
}

impl Assembly {
    /// The assembly with the tree of a scene, whose unit has so many `mm`. `parts` has one part for each form of the scene,
    /// or none where the form has not become one: its places are left out. Groups that are the same are one. The root of the
    /// scene is the whole assembly, or a group called `name` of all roots.
    ///
    /// `None` if no place remains.
    pub fn of_scene(
        scene: &Scene,
        mm: f64,
        parts: Vec<Option<AssemblyPart>>,
        name: &str,
    ) -> Option<Assembly> {
        let mut count = 0;
        let number = |part: &Option<AssemblyPart>| {
            part.as_ref().map(|_| {
                count += 1;
                count - 1
            })
        };
        let part_of = parts.iter().map(number).collect();
        let groups = Vec::new();
        let mut making = Groups { scene, mm, part_of, groups, known: BTreeMap::new() };
        making.make(name)?;
        let Groups { groups, .. } = making;
        Some(Assembly { parts: parts.into_iter().flatten().collect(), groups })
    }
}

impl Groups<'_> {
    /// Makes all groups, and the whole one last.
    fn make(&mut self, name: &str) -> Option<()> {
        let (children, roots) = self.scene.children();
        let mut products: Vec<Option<Product>> = vec![None; self.scene.nodes().len()];
        let whole = match roots[..] {
            [NodeId(root)] if self.is_whole(root) => Some(root),
            _ => None,
        };
        // Children have greater numbers than their parents.
        for (number, node) in self.scene.nodes().iter().enumerate().rev() {
            products[number] = match node.content {
                NodeContent::Form(FormId(form)) => {
                    self.part_of.get(form).copied().flatten().map(Product::Part)
                }
                NodeContent::Group => {
                    let members = self.members(&children[number], &products);
                    let own = (Some(number) != whole).then_some(node.group_name.as_ref()).flatten();
                    let called =
                        node.group_name.as_deref().or(node.name.as_deref()).unwrap_or(name);
                    self.group(own, called, members)
                }
            };
        }
        if let Some(root) = whole {
            return products[root].map(|_| ());
        }
        let members = self.members(&roots, &products);
        (!members.is_empty()).then(|| {
            self.groups.push(AssemblyGroup {
                name: name.to_owned(),
                description: String::new(),
                members,
            });
        })
    }

    /// Whether a root can be the whole assembly: a group that is not moved.
    fn is_whole(&self, root: usize) -> bool {
        let node = &self.scene.nodes()[root];
        node.content == NodeContent::Group && node.placement == Placement::IDENTITY
    }

    fn members(&self, children: &[NodeId], products: &[Option<Product>]) -> Vec<Member> {
        let member = |&NodeId(child): &NodeId| {
            let node = &self.scene.nodes()[child];
            let product = products[child]?;
            // A place without a name has that of what is there, as CAD programs do.
            let name = self.scene.name(NodeId(child)).unwrap_or_default().to_owned();
            let colour = node.colour.filter(|_| matches!(product, Product::Part(_)));
            Some(Member { name, placement: self.placement(node), colour, product })
        };
        children.iter().filter_map(member).collect()
    }

    fn placement(&self, node: &SceneNode) -> Placement {
        let translation = node.placement.translation.map(|x| self.mm * x);
        Placement { translation, ..node.placement }
    }

    /// The group with these members, which may be there. `None` if there are no members.
    fn group(
        &mut self,
        own: Option<&String>,
        called: &str,
        members: Vec<Member>,
    ) -> Option<Product> {
        if members.is_empty() {
            return None;
        }
        let key = |member: &Member| {
            let mut bits = [0; 12];
            let numbers = member.placement.axes.iter().chain([&member.placement.translation]);
            for (bits, x) in bits.iter_mut().zip(numbers.flatten()) {
                // Zero has two signs.
                *bits = (x + 0.0).to_bits();
            }
            (member.name.clone(), member.product, member.colour, bits)
        };
        let key = (own.cloned(), members.iter().map(key).collect());
        let next = self.groups.len();
        let number = *self.known.entry(key).or_insert(next);
        // Nodes come in reverse, so that the name that remains is that of the first place.
        match self.groups.get_mut(number) {
            Some(group) => called.clone_into(&mut group.name),
            None => {
                let name = called.to_owned();
                self.groups.push(AssemblyGroup { name, description: String::new(), members });
            }
        }
        Some(Product::Group(number))
    }
}
