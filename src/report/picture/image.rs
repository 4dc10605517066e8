//! A finished picture.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Pixels in sRGB, row by row from the top.
#[derive(Debug, Clone)]
pub struct Image {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

impl Image {
    /// A picture of one colour.
    pub fn blank([width, height]: [usize; 2], colour: [u8; 3]) -> Image {
        Image { width, height, pixels: vec![colour; width * height] }
    }

    /// Sets a pixel; one outside is left alone.
    pub(crate) fn set(&mut self, x: usize, y: usize, colour: [u8; 3]) {
        if x < self.width && y < self.height {
            self.pixels[y * self.width + x] = colour;
        }
    }

    /// A pixel; one outside is black.
    pub(crate) fn get(&self, x: usize, y: usize) -> [u8; 3] {
        let inside = x < self.width && y < self.height;
        if inside { self.pixels[y * self.width + x] } else { [0; 3] }
    }

    /// Lays a picture over this one with its upper left corner at (x, y).
    pub(crate) fn lay(&mut self, over: &Image, [x, y]: [usize; 2]) {
        for row in 0..over.height {
            for column in 0..over.width {
                self.set(x + column, y + row, over.pixels[row * over.width + column]);
            }
        }
    }

    /// Fills the rectangle of `size` with its upper left corner at (x, y).
    pub fn fill(&mut self, [x, y]: [usize; 2], size: [usize; 2], colour: [u8; 3]) {
        for row in y..y + size[1] {
            for column in x..x + size[0] {
                self.set(column, row, colour);
            }
        }
    }

    /// This picture with one of the same height at its right.
    pub fn beside(self, right: Image) -> Image {
        let width = self.width + right.width;
        let mut pixels = Vec::with_capacity(width * self.height);
        for y in 0..self.height {
            pixels.extend_from_slice(&self.pixels[y * self.width..][..self.width]);
            pixels.extend_from_slice(&right.pixels[y * right.width..][..right.width]);
        }
        Image { width, height: self.height, pixels }
    }

    /// Writes a PNG into a file.
    pub fn save(&self, path: &Path) -> Result<(), Box<dyn std::error::Error>> {
        let failed = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        let mut file = BufWriter::new(File::create(path).map_err(|e| failed(&e))?);
        self.write(&mut file).map_err(|e| failed(&e))?;
        file.flush().map_err(|e| failed(&e))?;
        Ok(())
    }

    /// Writes a PNG.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut encoder = png::Encoder::new(out, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        Ok(writer.finish()?)
    }
}
