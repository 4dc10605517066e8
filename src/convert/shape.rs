//! What becomes of a component: a face, a shell, a solid, or a void in a solid.

use std::cell::LazyCell;

use crate::error::Result;
use crate::mesh::{Choice, Component, Components, Nested};

/// What becomes of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TargetShape {
    /// One face: the component is a sheet.
    Face,
    /// A shell of several faces with open boundaries: one face does not hold the component.
    Shell,
    /// A solid of several faces: the component is closed, or nearly so.
    Solid,
    /// A void in the solid before it: a closed component inside another one, facing the opposite way. A component
    /// in a void is a solid again.
    Void,
}

impl TargetShape {
    /// Its name in reports and messages.
    pub fn word(self) -> &'static str {
        match self {
            TargetShape::Face => "face",
            TargetShape::Shell => "shell",
            TargetShape::Solid => "solid",
            TargetShape::Void => "void",
        }
    }
}

/// A component is a body if fillings of its gaps add less than this share to its area. Scanned
/// bodies have gaps of 0.1 to 3.5 %, pipes with open ends 11 to 13 %, busts with an open base 8 to
/// 25 %.
const GAPS: f64 = 0.05;

/// A component with several ends of similar size is a pipe if the fillings of all its loops have less than
/// this share of its area. A pipe as long as its diameter has 0.5. A plate with a hole, which one face
/// holds, has more than 1.
const PIPE: f64 = 0.5;

/// Two ends are similar if the filling of one has at least this share of the other's area. The holes in the
/// sheets of real scans have at most a twentieth of the outer loop's.
const SIMILAR: f64 = 0.25;

/// Says what a component becomes if nobody names a shape: a solid if it is closed or has small gaps, a
/// shell if it has handles or is a pipe with several ends, and otherwise a face.
///
/// # Errors
/// [`Error::Component`](crate::error::Error::Component): there is no such component.
pub fn shape(scan: &Components, component: Choice) -> Result<TargetShape> {
    Ok(shape_of(&scan.take(component)?))
}

/// The components that are voids in a component: closed ones that face the opposite way, and around which it is the
/// nearest closed one.
///
/// # Errors
/// [`Error::Component`](crate::error::Error::Component): there is no such component.
pub fn voids(scan: &Components, component: Choice) -> Result<Vec<Choice>> {
    scan.take(component)?;
    let is_own = |of: &Nested| of.is_opposite && of.around == component.number();
    let own = scan.nested()?.into_iter().filter(is_own);
    Ok(own.map(|of| Choice::Number(of.component)).collect())
}

/// What one component becomes.
pub(super) fn shape_of(component: &Component) -> TargetShape {
    shape_and_reason(component).0
}

/// What one component becomes, and why.
pub(super) fn shape_and_reason(component: &Component) -> (TargetShape, &'static str) {
    let topology = &component.topology;
    let ends = LazyCell::new(|| component.filling_shares());
    match topology.orientable {
        true if topology.loops == 0 => (TargetShape::Solid, "as it is closed"),
        true if ends.iter().sum::<f64>() < GAPS => (TargetShape::Solid, "as its gaps are small"),
        true if topology.genus() > 0.0 => (TargetShape::Shell, "as one face holds no handles"),
        true if is_pipe(&ends) => (TargetShape::Shell, "as one face holds no pipe with open ends"),
        _ => (TargetShape::Face, "as it is one sheet"),
    }
}

/// Whether these shares of the area, largest first, are those of the ends of a pipe.
fn is_pipe(ends: &[f64]) -> bool {
    let [first, second, ..] = ends else { return false };
    ends.iter().sum::<f64>() < PIPE && *second > SIMILAR * first
}
