//! Checks of an assembly before it is written.

use std::fmt;
use std::io;

use super::{Assembly, Product};
use crate::brep::ModelFault;
use crate::scene::{MOST_DEPTH, Placement};

/// The axes of a placement may differ from perpendicular unit vectors by so much. It is the error of some products of
/// rotations in double precision, with a reserve.
const RIGID: f64 = 1e-9;

/// What is wrong with an assembly.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum AssemblyFault {
    /// A part is not sound.
    Part(usize, ModelFault),
    /// There is no group, so that there is no whole.
    Empty,
    /// A group has no members.
    EmptyGroup(usize),
    /// A member of a group is a part that does not exist, or a group that is not before it.
    Missing(usize, Product),
    /// A member of a group has a place that is not rigid or not finite.
    Place(usize, usize),
    /// Groups are in each other more than 256 deep.
    Deep,
    /// A face of a part has a colour, but does not exist.
    Face(usize, usize),
}

impl fmt::Display for AssemblyFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            AssemblyFault::Part(part, fault) => write!(f, "part {part}: {fault}"),
            AssemblyFault::Empty => f.write_str("the assembly has no group"),
            AssemblyFault::EmptyGroup(group) => write!(f, "group {group} has no members"),
            AssemblyFault::Missing(group, Product::Part(part)) => {
                write!(f, "group {group} has part {part}, which does not exist")
            }
            AssemblyFault::Missing(group, Product::Group(other)) => {
                write!(f, "group {group} has group {other}, which is not before it")
            }
            AssemblyFault::Place(group, member) => {
                write!(f, "member {member} of group {group} has a place that is not rigid")
            }
            AssemblyFault::Deep => f.write_str("groups are in each other more than 256 deep"),
            AssemblyFault::Face(part, face) => {
                write!(f, "face {face} of part {part} has a colour, but does not exist")
            }
        }
    }
}

impl std::error::Error for AssemblyFault {}

impl From<AssemblyFault> for io::Error {
    fn from(fault: AssemblyFault) -> Self {
        io::Error::new(io::ErrorKind::InvalidInput, fault)
    }
}

impl Assembly {
    /// Checks that each part is sound ([`Brep::check`](crate::Brep::check)), that each group has members that exist, and that
    /// all places are rigid.
    ///
    /// # Errors
    /// The first fault that is found.
    pub fn check(&self) -> Result<(), AssemblyFault> {
        for (number, part) in self.parts.iter().enumerate() {
            part.brep.check().map_err(|fault| AssemblyFault::Part(number, fault))?;
            let faces = part.brep.faces.len();
            if let Some((face, _)) = part.face_colours.iter().find(|(face, _)| face.0 >= faces) {
                return Err(AssemblyFault::Face(number, face.0));
            }
        }
        if self.groups.is_empty() {
            return Err(AssemblyFault::Empty);
        }
        let mut depth = vec![0; self.groups.len()];
        for (number, group) in self.groups.iter().enumerate() {
            if group.members.is_empty() {
                return Err(AssemblyFault::EmptyGroup(number));
            }
            for (at, member) in group.members.iter().enumerate() {
                match member.product {
                    Product::Part(part) if part < self.parts.len() => {}
                    Product::Group(inner) if inner < number => {
                        depth[number] = depth[number].max(depth[inner] + 1);
                    }
                    product => return Err(AssemblyFault::Missing(number, product)),
                }
                if !is_rigid(&member.placement) {
                    return Err(AssemblyFault::Place(number, at));
                }
            }
            if depth[number] > MOST_DEPTH {
                return Err(AssemblyFault::Deep);
            }
        }
        Ok(())
    }
}

/// Whether a placement has right-handed perpendicular unit vectors.
fn is_rigid(placement: &Placement) -> bool {
    let axes = &placement.axes;
    let product = |i: usize, j: usize| (0..3).map(|k| axes[i][k] * axes[j][k]).sum::<f64>();
    let is_near = |i: usize, j: usize| (product(i, j) - f64::from(u8::from(i == j))).abs() <= RIGID;
    placement.is_finite() && !placement.mirrors() && (0..3).all(|i| (0..=i).all(|j| is_near(i, j)))
}
