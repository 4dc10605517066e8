//! Text in pictures, set in DejaVu Sans Condensed.
//!
//! What the fonts have no letter for is shown as an empty box.

use ab_glyph::{Font, FontRef, Glyph, InvalidFont, PxScale, ScaleFont, point};
use dejavu::sans_condensed;

use super::colour::{encoded, linear, mix};
use super::image::Image;

/// The letters to write with.
#[derive(Debug)]
pub struct Type {
    regular: FontRef<'static>,
    bold: FontRef<'static>,
}

/// How a text looks.
#[derive(Debug, Clone, Copy)]
pub struct Style {
    /// Height of a line, in pixels.
    pub size: f32,
    /// Whether it is bold.
    pub bold: bool,
    /// Its colour.
    pub colour: [u8; 3],
}

impl Type {
    /// The fonts of the program.
    ///
    /// # Errors
    /// They are damaged.
    pub fn new() -> Result<Type, InvalidFont> {
        Ok(Type {
            regular: FontRef::try_from_slice(sans_condensed::regular())?,
            bold: FontRef::try_from_slice(sans_condensed::bold())?,
        })
    }

    /// The width of a text, in pixels.
    pub fn width(&self, text: &str, style: Style) -> f32 {
        let font = self.font(style).as_scaled(PxScale::from(style.size));
        text.chars().map(|c| font.h_advance(font.glyph_id(c))).sum()
    }

    /// As much of a text as `width` pixels hold; what is cut off is the middle.
    pub(crate) fn fit(&self, text: &str, style: Style, width: f32) -> String {
        let letters: Vec<char> = text.chars().collect();
        let cut = |keep: usize| -> String {
            if keep >= letters.len() {
                return text.to_owned();
            }
            let (front, back) = (keep.div_ceil(2), keep / 2);
            let front = letters[..front].iter();
            let back = letters[letters.len() - back..].iter();
            front.chain(&['…']).chain(back).collect()
        };
        let fits = |keep: &usize| self.width(&cut(*keep), style) <= width;
        (0..=letters.len()).rev().find(fits).map(cut).unwrap_or_default()
    }

    /// Writes a text whose baseline begins at (x, y).
    pub fn write(&self, image: &mut Image, text: &str, at: [f32; 2], style: Style) {
        let font = self.font(style).as_scaled(PxScale::from(style.size));
        let ink = linear(style.colour);
        let mut x = at[0];
        for letter in text.chars() {
            let id = font.glyph_id(letter);
            let glyph: Glyph = id.with_scale_and_position(style.size, point(x, at[1]));
            x += font.h_advance(id);
            let Some(outline) = font.outline_glyph(glyph) else { continue };
            let corner = outline.px_bounds().min;
            outline.draw(|dx, dy, cover| {
                let (px, py) = (corner.x + dx as f32, corner.y + dy as f32);
                if px >= 0.0 && py >= 0.0 {
                    let (px, py) = (px as usize, py as usize);
                    let under = linear(image.get(px, py));
                    image.set(px, py, encoded(mix(under, ink, cover.min(1.0))));
                }
            });
        }
    }

    fn font(&self, style: Style) -> &FontRef<'static> {
        if style.bold { &self.bold } else { &self.regular }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fonts_have_the_signs_of_figures() {
        let letters = Type::new().unwrap();
        for sign in "×·–±−³²…".chars() {
            assert!(letters.regular.glyph_id(sign).0 > 0, "{sign:?}");
        }
    }

    #[test]
    fn long_names_lose_their_middle() {
        let letters = Type::new().unwrap();
        let style = Style { size: 20.0, bold: false, colour: [0; 3] };
        let long = "a".repeat(300) + ".ply";
        let short = letters.fit(&long, style, 200.0);
        assert!(letters.width(&short, style) <= 200.0);
        assert!(short.contains('…') && short.ends_with(".ply") && short.starts_with("aa"));
        assert_eq!(letters.fit("scan.ply", style, 200.0), "scan.ply");
    }
}
