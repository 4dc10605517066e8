//! A part with objects: its unit, its resources and its build.

use std::collections::BTreeMap;

use super::properties::Irregularities;
use crate::LengthUnit;
use crate::scene::{Placement, SceneMesh};

/// An object, by the number of its part and its own. `path` is the name of the part, until its number is known.
#[derive(Debug, Clone, Default)]
pub(super) struct ObjectKey {
    pub(super) path: Option<String>,
    pub(super) model: usize,
    pub(super) id: u32,
}

/// A use of an object.
pub(super) struct ObjectUse {
    pub(super) object: ObjectKey,
    pub(super) placement: Placement,
    pub(super) name: Option<String>,
}

/// What an object is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ObjectType {
    Model,
    Support,
    Other,
}

/// What an object is.
pub(super) enum Shaped {
    Mesh(Box<SceneMesh>),
    Components(Vec<ObjectUse>),
    /// A kind of shape that is not read.
    Unread(&'static str),
}

pub(super) struct Object {
    pub(super) name: Option<String>,
    pub(super) kind: ObjectType,
    pub(super) shape: Shaped,
    /// What it has besides, which is not read.
    pub(super) unread: Option<&'static str>,
}

/// What a part holds.
pub(super) struct Model {
    pub(super) unit: LengthUnit,
    pub(super) objects: BTreeMap<u32, Object>,
    pub(super) items: Vec<ObjectUse>,
    /// The names of other parts that it uses, in their order.
    pub(super) paths: Vec<String>,
    pub(super) odd: Irregularities,
}

impl Model {
    /// The keys of all objects that items and components use.
    pub(super) fn keys_mut(&mut self) -> impl Iterator<Item = &mut ObjectKey> {
        let components = self.objects.values_mut().flat_map(|object| match &mut object.shape {
            Shaped::Components(uses) => uses.as_mut_slice(),
            Shaped::Mesh(_) | Shaped::Unread(_) => &mut [],
        });
        self.items.iter_mut().chain(components).map(|used| &mut used.object)
    }
}
