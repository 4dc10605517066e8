//! Writer of colours (ISO 10303-46).

use std::io;

use super::part21::{Id, List, Part21, add, share};
use crate::number::StepReal;

/// Gives items their colours, on both of their sides. Returns the `STYLED_ITEM` of each.
pub(super) fn write(
    file: &mut Part21<'_>,
    items: &[(Id, [u8; 3])],
    context: Id,
) -> io::Result<Vec<Id>> {
    let mut styled = Vec::with_capacity(items.len());
    let mut style = None;
    for &(item, colour) in items {
        let of_item = match style {
            Some((of, style)) if of == colour => style,
            _ => styles(file, colour)?,
        };
        style = Some((colour, of_item));
        styled.push(add!(file, "STYLED_ITEM('color',({of_item}),{item})")?);
    }
    let kind = "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION";
    add!(file, "{kind}('',{},{context})", List(&styled))?;
    Ok(styled)
}

/// Gives items another colour where `place` is their representation. `items` are with their `STYLED_ITEM`.
pub(super) fn override_at(
    file: &mut Part21<'_>,
    items: &[[Id; 2]],
    (colour, place, context): ([u8; 3], Id, Id),
) -> io::Result<()> {
    let usage = usage(file, colour)?;
    let style = add!(file, "PRESENTATION_STYLE_BY_CONTEXT(({usage}),{place})")?;
    let mut styled = Vec::with_capacity(items.len());
    for [item, overridden] in items {
        let kind = "OVER_RIDING_STYLED_ITEM";
        styled.push(add!(file, "{kind}('overriding color',({style}),{item},{overridden})")?);
    }
    let kind = "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION";
    add!(file, "{kind}('',{},{context})", List(&styled)).map(drop)
}

/// Writes a colour, or returns the style of the same colour that is there.
fn styles(file: &mut Part21<'_>, colour: [u8; 3]) -> io::Result<Id> {
    let usage = usage(file, colour)?;
    share!(file, "PRESENTATION_STYLE_ASSIGNMENT(({usage}))")
}

/// The same for both sides of a surface.
fn usage(file: &mut Part21<'_>, colour: [u8; 3]) -> io::Result<Id> {
    let [r, g, b] = colour.map(|channel| StepReal(f64::from(channel) / f64::from(u8::MAX)));
    let colour = share!(file, "COLOUR_RGB('',{r},{g},{b})")?;
    let colour = share!(file, "FILL_AREA_STYLE_COLOUR('',{colour})")?;
    let area = share!(file, "FILL_AREA_STYLE('',({colour}))")?;
    let area = share!(file, "SURFACE_STYLE_FILL_AREA({area})")?;
    let side = share!(file, "SURFACE_SIDE_STYLE('',({area}))")?;
    share!(file, "SURFACE_STYLE_USAGE(.BOTH.,{side})")
}
