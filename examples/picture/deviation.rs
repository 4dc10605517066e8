//! The scan, coloured by its distance from the face, and the colour bar.

use scan2step::geometry::VertexId;

use crate::camera::Camera;
use crate::colour::{BACKGROUND, INK, Rgb, brightness, encoded, linear, mix, srgb};
use crate::font;
use crate::image::Image;
use crate::lines::Pen;
use crate::scan;
use crate::scene::Scene;

/// The scan beside the colour bar.
pub fn picture(scene: &Scene, [width, height]: [usize; 2]) -> Image {
    let legend = Legend::new(scene, height);
    let size = [width.saturating_sub(legend.width()).max(1), height];
    let camera = Camera::facing(&scene.measured.mesh, scene.extent(), size);
    let mesh = &scene.measured.mesh;
    let distance = |v: VertexId| scene.conversion.deviation.distances[v.index()];
    let mut scan = scan::draw(scene, &camera, size, |number, w, normal, front| {
        let [a, b, c] = mesh.triangles[number].map(distance);
        let d = w[0] * a + w[1] * b + w[2] * c;
        let (n, light) = if front { (normal, 1.0) } else { (-normal, BACK) };
        // Much shade would change the colours that the bar explains.
        let shade = (light * (0.6 + 0.4 * brightness(&n))) as f32;
        scale(d / legend.end).map(|c| c * shade)
    });
    // One sheet behind another has the same colours.
    scan::rims(&scan, scene, &camera, Pen::solid(1.3)).ink(&mut scan, linear(INK));
    scan.image().beside(legend.image())
}

/// Light on the inner side.
const BACK: f64 = 0.5;

/// The scale viridis: colours that the colour-blind tell apart too, their
/// lightness growing evenly.
const VIRIDIS: [u32; 9] =
    [0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725];

/// The colour for a share of the scale.
fn scale(share: f64) -> Rgb {
    let at = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let k = (at as usize).min(VIRIDIS.len() - 2);
    // Neighbours are so near each other that linear light does for mixing.
    mix(linear(srgb(VIRIDIS[k])), linear(srgb(VIRIDIS[k + 1])), (at - k as f64) as f32)
}

/// The colour bar.
struct Legend {
    /// The distance at its upper end, in mm.
    end: f64,
    high: String,
    height: usize,
    /// Pixels for a dot of the font.
    dot: usize,
}

const LOW: &str = "0 mm";

impl Legend {
    /// A scale up to the 99th percentile: one stray point would make all
    /// others look alike.
    fn new(scene: &Scene, height: usize) -> Legend {
        let (end, decimals) = rounded_up(scene.conversion.deviation.p99);
        let high = format!("{end:.decimals$} mm");
        Legend { end, high, height, dot: (height / 350).max(1) }
    }

    fn width(&self) -> usize {
        font::width(&self.high).max(font::width(LOW)) * self.dot + 2 * self.margin()
    }

    fn margin(&self) -> usize {
        6 * self.dot
    }

    fn image(&self) -> Image {
        let mut image = Image::blank([self.width(), self.height], BACKGROUND);
        let x = self.margin();
        let (top, length, thickness) = (self.height / 5, 3 * self.height / 5, 8 * self.dot);
        for y in 0..length {
            let share = 1.0 - (y as f64 + 0.5) / length as f64;
            image.fill([x, top + y], [thickness, 1], encoded(scale(share)));
        }
        let line = (font::HEIGHT + 4) * self.dot;
        font::write(&mut image, &self.high, [x, top.saturating_sub(line)], self.dot, INK);
        font::write(&mut image, LOW, [x, top + length + 4 * self.dot], self.dot, INK);
        image
    }
}

/// A number of two digits not below `x`, and its decimals.
fn rounded_up(x: f64) -> (f64, usize) {
    if !(x > 1e-9 && x.is_finite()) {
        return (1e-9, 9);
    }
    let decimals = (1 - x.log10().floor() as i32).max(0);
    let unit = 10f64.powi(-decimals);
    ((x / unit).ceil() * unit, decimals as usize)
}
