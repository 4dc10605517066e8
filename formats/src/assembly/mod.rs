//! An assembly: parts in their places, in groups, as CAD files have them.
//!
//! Each part is there once, however often it is placed, and so is each group. [`step::write_assembly`](crate::step::write_assembly)
//! writes it. Lengths are in millimetres.

mod check;
mod of_scene;

pub use check::AssemblyFault;

use crate::brep::{Brep, FaceId};
use crate::scene::Placement;

/// Parts, and groups that place them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Assembly {
    /// The parts.
    pub parts: Vec<AssemblyPart>,
    /// The groups. Each one holds only groups before it. The last one is the whole assembly.
    pub groups: Vec<AssemblyGroup>,
}

/// A part. Its name and its description are those of its model.
#[derive(Debug, Clone, PartialEq)]
pub struct AssemblyPart {
    /// The model.
    pub brep: Brep,
    /// The colour of the part (sRGB). `None` for no colour.
    pub colour: Option<[u8; 3]>,
    /// The colours of faces that have another colour than the part.
    pub face_colours: Vec<(FaceId, [u8; 3])>,
}

/// A product that consists of others.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AssemblyGroup {
    /// The name of the product.
    pub name: String,
    /// What a reader of the file should know about it. It may be empty.
    pub description: String,
    /// What is in it.
    pub members: Vec<Member>,
}

/// A part or a group in its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Member {
    /// The name of the place. It may be empty.
    pub name: String,
    /// The place in the group. It is rigid.
    pub placement: Placement,
    /// What is there.
    pub product: Product,
}

/// A part or a group, by its number in [`Assembly::parts`] or [`Assembly::groups`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Product {
    /// A part.
    Part(usize),
    /// A group.
    Group(usize),
}
