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
    /// The colour of a part in this place (sRGB), if it is another one than that of the part.
    pub colour: Option<[u8; 3]>,
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

impl Assembly {
    /// The name of the whole. It may be empty.
    pub fn name(&self) -> &str {
        self.groups.last().map(|group| group.name.as_str()).unwrap_or_default()
    }

    /// What a file says that it holds.
    pub(crate) fn content(&self) -> &'static str {
        if self.parts.iter().all(|part| part.brep.has_splines_only()) {
            "Assembly of trimmed B-spline surfaces"
        } else {
            "Assembly of trimmed surfaces"
        }
    }

    /// The uncertainty of the least certain part.
    pub(crate) fn uncertainty_mm(&self) -> f64 {
        let uncertainties = self.parts.iter().map(|part| part.brep.uncertainty_mm);
        uncertainties.fold(f64::MIN_POSITIVE, f64::max)
    }

    /// A bound of all coordinates. Turning a part may make its largest coordinate √3 times as large.
    pub(crate) fn reach(&self) -> f64 {
        let of_parts: Vec<f64> =
            self.parts.iter().map(|part| 3.0_f64.sqrt() * part.brep.reach()).collect();
        let mut of_groups: Vec<f64> = Vec::with_capacity(self.groups.len());
        for group in &self.groups {
            let of_member = |member: &Member| {
                let own = match member.product {
                    Product::Part(part) => of_parts.get(part),
                    Product::Group(inner) => of_groups.get(inner),
                };
                let [x, y, z] = member.placement.translation;
                own.copied().unwrap_or(0.0) + (x * x + y * y + z * z).sqrt()
            };
            of_groups.push(group.members.iter().map(of_member).fold(0.0, f64::max));
        }
        of_groups.last().copied().unwrap_or(0.0)
    }
}
