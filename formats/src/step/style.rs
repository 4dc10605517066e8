//! Writer of colours (ISO 10303-46).

use std::io;

use super::part21::{Id, List, Part21, add, share};
use crate::number::StepReal;

/// Gives items their colours, on both of their sides.
pub(super) fn write(file: &mut Part21<'_>, items: &[(Id, [u8; 3])], context: Id) -> io::Result<()> {
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
    add!(file, "{kind}('',{},{context})", List(&styled)).map(drop)
}

/// Writes a colour, or returns the style of the same colour that is there.
fn styles(file: &mut Part21<'_>, colour: [u8; 3]) -> io::Result<Id> {
    let [r, g, b] = colour.map(|channel| StepReal(f64::from(channel) / f64::from(u8::MAX)));
    let colour = share!(file, "COLOUR_RGB('',{r},{g},{b})")?;
    let colour = share!(file, "FILL_AREA_STYLE_COLOUR('',{colour})")?;
    let area = share!(file, "FILL_AREA_STYLE('',({colour}))")?;
    let area = share!(file, "SURFACE_STYLE_FILL_AREA({area})")?;
    let side = share!(file, "SURFACE_SIDE_STYLE('',({area}))")?;
    let usage = share!(file, "SURFACE_STYLE_USAGE(.BOTH.,{side})")?;
    share!(file, "PRESENTATION_STYLE_ASSIGNMENT(({usage}))")
}
