//! Colours and light.

use crate::geometry::Vector;

/// A colour in linear light.
pub type Rgb = [f32; 3];

/// The colour 0xRRGGBB of sRGB.
pub const fn srgb(code: u32) -> [u8; 3] {
    [(code >> 16) as u8, (code >> 8) as u8, code as u8]
}

/// Behind everything.
pub const BACKGROUND: [u8; 3] = srgb(0xf6f7f8);
/// Lines and letters.
pub const INK: [u8; 3] = srgb(0x1c2430);

/// Dots at irregular vertices.
pub const DOTS: [u8; 3] = srgb(0xb3261e);
/// The tints of blocks and faces. Neighbours have different ones nearly everywhere.
pub const TINTS: [u32; 7] =
    [0xd8c9a8, 0xb7cbd6, 0xc6d3b2, 0xdcb9a9, 0xc9bfd9, 0xe6dfb4, 0xa9d2c4];

/// What a sheet is made of.
#[derive(Debug, Clone, Copy)]
pub struct Material {
    /// Colour of the outer side.
    pub front: Rgb,
    /// Colour of the inner side.
    pub back: Rgb,
    /// Strength of the highlight.
    pub gloss: f32,
}

/// The scan: plaster.
pub fn plaster() -> Material {
    Material { front: linear(srgb(0xdccaae)), back: linear(srgb(0xa2705a)), gloss: 0.0 }
}

/// The face: blue lacquer.
pub fn lacquer() -> Material {
    Material { front: linear(srgb(0x86b0dc)), back: linear(srgb(0xdda35a)), gloss: 0.22 }
}

impl Material {
    /// Its light towards the eye. `normal` is in camera coordinates and points
    /// away from the outer side; `front` says which side is seen.
    pub fn lit(&self, normal: Vector, front: bool) -> Rgb {
        let (paint, n) = if front { (self.front, normal) } else { (self.back, -normal) };
        let shade = brightness(&n) as f32;
        // Halfway between key light and eye, Blinn's highlight is brightest.
        let half = (key() + Vector::z()).normalize();
        let highlight = self.gloss * n.dot(&half).max(0.0).powi(36) as f32;
        paint.map(|c| c * shade + highlight)
    }
}

fn key() -> Vector {
    Vector::new(-0.62, 0.62, 0.46).normalize()
}

/// Light on a white sheet of normal `n`: a key light from the upper left, a
/// weaker one from the right, and some from the eye.
pub(crate) fn brightness(n: &Vector) -> f64 {
    let side = Vector::new(0.85, -0.1, 0.5).normalize();
    // Light that wraps around: Lambert's ends in a line that looks like a
    // crease of the surface.
    let wrapped = (0.5 + 0.5 * n.dot(&key())).powf(2.6);
    0.04 + 1.3 * wrapped + 0.16 * n.dot(&side).max(0.0) + 0.1 * n.z.max(0.0)
}

/// From sRGB to linear light.
pub fn linear(code: [u8; 3]) -> Rgb {
    code.map(|c| {
        let c = f32::from(c) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    })
}

/// From linear light to sRGB.
pub fn encoded(light: Rgb) -> [u8; 3] {
    light.map(|c| {
        let c = c.clamp(0.0, 1.0);
        let c = if c <= 0.0031308 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (255.0 * c).round() as u8
    })
}

/// Between `a` (at 0) and `b` (at 1).
pub(crate) fn mix(a: Rgb, b: Rgb, t: f32) -> Rgb {
    std::array::from_fn(|k| a[k] + t * (b[k] - a[k]))
}
