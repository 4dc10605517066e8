//! Writer of colours (ISO 10303-46).

use std::io;

use super::part21::{Id, List, Part21, add};
use crate::number::StepReal;

/// Gives items a colour on both of their sides.
pub(super) fn write(
    file: &mut Part21<'_>,
    items: &[Id],
    colour: [u8; 3],
    context: Id,
) -> io::Result<()> {
    let [r, g, b] = colour.map(|channel| StepReal(f64::from(channel) / f64::from(u8::MAX)));
    let colour = add!(file, "COLOUR_RGB('',{r},{g},{b})")?;
    let colour = add!(file, "FILL_AREA_STYLE_COLOUR('',{colour})")?;
    let area = add!(file, "FILL_AREA_STYLE('',({colour}))")?;
    let area = add!(file, "SURFACE_STYLE_FILL_AREA({area})")?;
    let side = add!(file, "SURFACE_SIDE_STYLE('',({area}))")?;
    let usage = add!(file, "SURFACE_STYLE_USAGE(.BOTH.,{side})")?;
    let style = add!(file, "PRESENTATION_STYLE_ASSIGNMENT(({usage}))")?;
    let mut styled = Vec::with_capacity(items.len());
    for item in items {
        styled.push(add!(file, "STYLED_ITEM('color',({style}),{item})")?);
    }
    let kind = "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION";
    add!(file, "{kind}('',{},{context})", List(&styled)).map(drop)
}
