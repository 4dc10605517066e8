//! The scan in the colours of its distance from the face, and the colour bar.

use scan2step::report::picture::camera::Camera;
use scan2step::report::picture::canvas::Canvas;
use scan2step::report::picture::colour::{BACKGROUND, INK, encoded, linear};
use scan2step::report::picture::image::Image;
use scan2step::report::picture::lines::Pen;
use scan2step::report::picture::scale::{DISTANCE, colour, rounded_up};
use scan2step::report::picture::sheet;
use scan2step::report::picture::text::{Style, Type};

use crate::scene::Scene;

/// The scan beside the colour bar.
pub fn picture(
    scene: &Scene,
    [width, height]: [usize; 2],
) -> Result<Image, Box<dyn std::error::Error>> {
    let legend = Legend::new(scene, height)?;
    let size = [width.saturating_sub(legend.width()).max(1), height];
    let mesh = &scene.measured.mesh;
    let camera = Camera::facing(mesh, scene.extent(), size);
    let mut canvas = Canvas::new(size);
    let distances = &scene.conversion.deviation.distances;
    sheet::draw_coloured(&mut canvas, mesh, &camera, &DISTANCE, |v| {
        distances[v.index()] / legend.end
    });
    // A sheet behind another one has the same colours.
    let rims = sheet::rims(&canvas, mesh, scene.measured.loops(), &camera, Pen::solid(1.3));
    rims.ink(&mut canvas, linear(INK));
    Ok(canvas.image().beside(legend.image()))
}

/// The colour bar.
struct Legend {
    /// The distance at the upper end of the bar, in mm.
    end: f64,
    high: String,
    height: usize,
    letters: Type,
    style: Style,
}

const LOW: &str = "0 mm";

impl Legend {
    /// The scale ends at the 99th percentile, because a single outlier would make all other points
    /// look alike.
    fn new(scene: &Scene, height: usize) -> Result<Legend, Box<dyn std::error::Error>> {
        let end = rounded_up(scene.conversion.deviation.p99);
        let style = Style { size: height as f32 / 40.0, bold: false, colour: INK };
        Ok(Legend { end, high: format!("{end} mm"), height, letters: Type::new()?, style })
    }

    fn width(&self) -> usize {
        let text = self.letters.width(&self.high, self.style);
        text.max(self.letters.width(LOW, self.style)) as usize + 2 * self.margin()
    }

    fn margin(&self) -> usize {
        self.height / 60
    }

    fn image(&self) -> Image {
        let mut image = Image::blank([self.width(), self.height], BACKGROUND);
        let x = self.margin();
        let (top, length) = (self.height / 5, 3 * self.height / 5);
        for y in 0..length {
            let share = 1.0 - (y as f64 + 0.5) / length as f64;
            image.fill([x, top + y], [self.height / 40, 1], encoded(colour(&DISTANCE, share)));
        }
        let gap = self.margin() as f32;
        let at = |y: f32| [x as f32, y];
        self.letters.write(&mut image, &self.high, at(top as f32 - 0.5 * gap), self.style);
        let foot = (top + length) as f32 + self.style.size;
        self.letters.write(&mut image, LOW, at(foot), self.style);
        image
    }
}
