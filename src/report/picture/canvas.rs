//! A frame buffer with depth, finer than the pixels, and triangles into it.

use crate::geometry::Vector;

use super::colour::{BACKGROUND, Rgb, encoded, linear};
use super::image::Image;

/// Samples along a pixel's side.
pub const SAMPLES: usize = 3;

/// Colour and depth of every sample of a picture.
pub struct Canvas {
    /// Samples in a row.
    pub width: usize,
    /// Rows of samples.
    pub height: usize,
    /// Linear light, row by row from the top.
    pub colour: Vec<Rgb>,
    /// Distance from the eye, in samples; infinite for the background.
    pub depth: Vec<f32>,
}

impl Canvas {
    /// An empty canvas for a picture of that many pixels.
    pub fn new([width, height]: [usize; 2]) -> Canvas {
        let (width, height) = (width * SAMPLES, height * SAMPLES);
        let colour = vec![linear(BACKGROUND); width * height];
        Canvas { width, height, colour, depth: vec![f32::INFINITY; width * height] }
    }

    /// Draws a triangle where it is in front. Corners are in pixels, with
    /// depth; `paint` has the barycentric coordinates of a sample and may
    /// leave it out.
    pub fn triangle(
        &mut self,
        corners: [Vector; 3],
        mut paint: impl FnMut([f64; 3]) -> Option<Rgb>,
    ) {
        let [a, b, c] = corners.map(|p| p * SAMPLES as f64);
        let area = cross(a, b, c);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        for y in rows(a.y, b.y, c.y, self.height) {
            for x in rows(a.x, b.x, c.x, self.width) {
                let p = Vector::new(x as f64 + 0.5, y as f64 + 0.5, 0.0);
                let w = [cross(p, b, c), cross(a, p, c), cross(a, b, p)].map(|w| w / area);
                if w.iter().any(|&w| w < 0.0) {
                    continue;
                }
                let depth = (w[0] * a.z + w[1] * b.z + w[2] * c.z) as f32;
                let i = y * self.width + x;
                if depth < self.depth[i]
                    && let Some(colour) = paint(w)
                {
                    self.depth[i] = depth;
                    self.colour[i] = colour;
                }
            }
        }
    }

    /// The picture: every pixel the mean of its samples.
    pub fn image(&self) -> Image {
        let [width, height] = [self.width, self.height].map(|n| n / SAMPLES);
        let mut image = Image::blank([width, height], BACKGROUND);
        for y in 0..height {
            for x in 0..width {
                image.set(x, y, encoded(self.mean(x * SAMPLES, y * SAMPLES)));
            }
        }
        image
    }

    fn mean(&self, x: usize, y: usize) -> Rgb {
        let mut sum = [0.0; 3];
        for row in y..y + SAMPLES {
            for colour in &self.colour[row * self.width + x..][..SAMPLES] {
                // Beyond white, a highlight would wipe out lines in its pixel.
                sum = std::array::from_fn(|k| sum[k] + colour[k].min(1.0));
            }
        }
        sum.map(|c| c / (SAMPLES * SAMPLES) as f32)
    }
}

/// Whether a triangle, as it stands in the picture, shows its outer side.
pub fn shows_front([a, b, c]: [Vector; 3]) -> bool {
    // The picture's y runs down, which turns counter-clockwise around.
    cross(a, b, c) < 0.0
}

fn cross(a: Vector, b: Vector, c: Vector) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// The samples below `end` whose centres lie between the three coordinates.
fn rows(a: f64, b: f64, c: f64, end: usize) -> std::ops::Range<usize> {
    let low = (a.min(b).min(c) - 0.5).ceil().max(0.0);
    let high = (a.max(b).max(c) + 0.5).floor().min(end as f64);
    low as usize..high.max(low) as usize
}
