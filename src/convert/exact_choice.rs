//! Which components of a scan may get exact faces, and what they become.

use super::Options;
use super::shape::{TargetShape, shape_of};
use crate::error::Result;
use crate::mesh::{Choice, Components};

/// The components that the options choose, each with what becomes of it. There are none if one that is named has one
/// side only.
pub(super) fn chosen(scan: &Components, options: &Options) -> Result<Vec<(Choice, TargetShape)>> {
    let shape = |component: Choice| shape(scan, component, options.shape);
    let one = |component: Choice| {
        Ok(shape(component)?.map(|shape| vec![(component, shape)]).unwrap_or_default())
    };
    if options.component != Choice::Auto {
        return one(options.component);
    }
    let is_whole = options.all_components;
    if !is_whole && shape(Choice::Auto)? != Some(TargetShape::Solid) {
        return one(Choice::Auto);
    }
    let mut all = Vec::new();
    for component in (0..scan.count()).map(Choice::Number) {
        // Dust that is open is no body.
        let is_dust = component.number() >= scan.sizeable() && !scan.is_closed(component);
        match if is_dust && !is_whole { None } else { shape(component)? } {
            Some(shape) if is_whole || shape == TargetShape::Solid => all.push((component, shape)),
            _ if is_whole => return Ok(Vec::new()),
            _ => {}
        }
    }
    Ok(all)
}

/// What a component becomes, if nobody names a shape: a solid if it is closed or its gaps are small, a shell, or a face if
/// one exact face is a sheet. One that has one side only becomes nothing.
pub(super) fn shape(
    scan: &Components,
    component: Choice,
    named: Option<TargetShape>,
) -> Result<Option<TargetShape>> {
    if scan.is_closed(component) {
        return Ok(Some(TargetShape::Solid));
    }
    let taken = scan.take_whole(component)?;
    let shape = named.unwrap_or_else(|| shape_of(&taken));
    Ok(taken.topology.orientable.then_some(shape))
}

/// Why components become what they are, if nobody named a shape and some are open.
pub(super) fn why(
    scan: &Components,
    shapes: &[(Choice, TargetShape)],
    options: &Options,
) -> Option<&'static str> {
    let is_open = shapes.iter().any(|of| of.1 != TargetShape::Void && !scan.is_closed(of.0));
    let is_shell = shapes.iter().any(|of| of.1 == TargetShape::Shell);
    let is_face = shapes.iter().any(|of| of.1 == TargetShape::Face);
    match (options.shape, is_open, is_shell || is_face) {
        (None, true, true) if !is_shell => Some("as it is one sheet"),
        (None, true, true) => Some("as its openings are 5 % of its area or more"),
        (None, true, false) => Some("as its gaps are small"),
        _ => None,
    }
}
