//! As many letters as a colour bar needs, five dots wide and seven high.

use crate::image::Image;

/// Dots from the top of a letter to its foot.
pub const HEIGHT: usize = 7;

/// Dots of a letter in width.
const WIDTH: usize = 5;

/// Dots from one letter to the next.
const ADVANCE: usize = WIDTH + 1;

/// Dots of a text in width.
pub fn width(text: &str) -> usize {
    (text.chars().count() * ADVANCE).saturating_sub(1)
}

/// Writes a text with its upper left corner at (x, y), every dot a square of
/// `dot` pixels. Letters that the font does not have stay blank.
pub fn write(image: &mut Image, text: &str, [x, y]: [usize; 2], dot: usize, colour: [u8; 3]) {
    for (k, letter) in text.chars().enumerate() {
        for (row, bits) in glyph(letter).into_iter().enumerate() {
            for column in (0..WIDTH).filter(|c| bits >> (WIDTH - 1 - c) & 1 == 1) {
                let corner = [x + (k * ADVANCE + column) * dot, y + row * dot];
                image.fill(corner, [dot, dot], colour);
            }
        }
    }
}

/// The rows of a letter from the top, a bit a dot.
#[rustfmt::skip]
fn glyph(letter: char) -> [u8; HEIGHT] {
    match letter {
        '0' => [0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110],
        '1' => [0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110],
        '2' => [0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111],
        '3' => [0b01110, 0b10001, 0b00001, 0b00110, 0b00001, 0b10001, 0b01110],
        '4' => [0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010],
        '5' => [0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110],
        '6' => [0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110],
        '7' => [0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000],
        '8' => [0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110],
        '9' => [0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100],
        '.' => [0, 0, 0, 0, 0, 0b01100, 0b01100],
        '-' => [0, 0, 0, 0b11111, 0, 0, 0],
        'm' => [0, 0, 0b11010, 0b10101, 0b10101, 0b10101, 0b10101],
        _ => [0; HEIGHT],
    }
}
