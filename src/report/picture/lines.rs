//! Lines over a canvas, with those parts hidden that lie behind a sheet.

use crate::geometry::Vector;

use super::canvas::{Canvas, SAMPLES};
use super::colour::{Rgb, mix};

/// How much of a line's colour every sample takes. Lines that cross or
/// overlap do not add up.
pub struct Lines {
    width: usize,
    height: usize,
    /// Samples for a unit of a pen's width.
    unit: f64,
    cover: Vec<f32>,
}

/// How to draw a line.
#[derive(Debug, Clone, Copy)]
pub struct Pen {
    /// Width in pixels; in a picture beyond the usual size, in proportion.
    pub width: f64,
    /// Opacity where nothing is in front.
    pub seen: f32,
    /// Opacity behind a sheet.
    pub hidden: f32,
    /// How far, in pixels, the line may be behind a sheet and is still seen.
    pub sunk: f64,
}

impl Pen {
    /// An opaque pen for lines that lie on a sheet. The sheet is drawn as flat
    /// triangles, so that lines may be a little behind it.
    pub const fn solid(width: f64) -> Pen {
        Pen { width, seen: 1.0, hidden: 0.0, sunk: 0.7 }
    }

    /// A pen for the plane, where nothing hides anything.
    pub const fn flat(width: f64, opacity: f32) -> Pen {
        Pen { width, seen: opacity, hidden: opacity, sunk: 0.0 }
    }
}

/// Pixels along the shorter side of a picture that shows lines as wide as their
/// pens.
const USUAL_SIDE: f64 = 1000.0;

/// Samples around a point of a line of which the farthest decides whether it
/// is seen: on a steep sheet depth changes much from one to the next.
const AROUND: usize = 2;

impl Lines {
    /// No lines yet.
    pub fn over(canvas: &Canvas) -> Lines {
        let (width, height) = (canvas.width, canvas.height);
        let pixels = (width.min(height) / SAMPLES) as f64;
        let unit = SAMPLES as f64 * (pixels / USUAL_SIDE).max(1.0);
        Lines { width, height, unit, cover: vec![0.0; width * height] }
    }

    /// Draws a polyline, in pixels and depth. What is seen is decided at its
    /// middle, for the whole width: a line along a rim half on a sheet would
    /// lose that half otherwise.
    pub fn polyline(&mut self, canvas: &Canvas, points: impl Iterator<Item = Vector>, pen: Pen) {
        let points: Vec<Vector> = points.map(|p| p * SAMPLES as f64).collect();
        for pair in points.windows(2) {
            let step = pair[1] - pair[0];
            let count = step.xy().norm().ceil().max(1.0);
            for i in 0..=count as usize {
                self.dot(canvas, pair[0] + step * (i as f64 / count), pen);
            }
        }
    }

    /// Draws a dot, in pixels and depth, of a pen's width.
    pub fn point(&mut self, canvas: &Canvas, at: Vector, pen: Pen) {
        self.dot(canvas, at * SAMPLES as f64, pen);
    }

    /// Puts the lines onto the canvas.
    pub fn ink(&self, canvas: &mut Canvas, colour: Rgb) {
        for (sample, &cover) in canvas.colour.iter_mut().zip(&self.cover) {
            if cover > 0.0 {
                // Beyond white, a highlight would shine through.
                *sample = mix(sample.map(|c| c.min(1.0)), colour, cover);
            }
        }
    }

    fn is_seen(&self, canvas: &Canvas, at: Vector, sunk: f64) -> bool {
        let near = |x: f64, end: usize| {
            let first = (x.floor().max(0.0) as usize).saturating_sub(AROUND);
            first.min(end)..(first + 2 * AROUND + 1).min(end)
        };
        let mut farthest = f32::NEG_INFINITY;
        for y in near(at.y, self.height) {
            for x in near(at.x, self.width) {
                farthest = farthest.max(canvas.depth[y * self.width + x]);
            }
        }
        at.z - sunk <= f64::from(farthest)
    }

    /// A dot, in samples and depth.
    fn dot(&mut self, canvas: &Canvas, at: Vector, pen: Pen) {
        let seen = self.is_seen(canvas, at, pen.sunk * SAMPLES as f64);
        let opacity = if seen { pen.seen } else { pen.hidden };
        let radius = 0.5 * pen.width * self.unit;
        let span = |x: f64, end: usize| {
            let low = (x - radius - 1.0).floor().max(0.0) as usize;
            let high = (x + radius + 1.0).ceil().max(0.0) as usize;
            low.min(end)..high.min(end)
        };
        for y in span(at.y, self.height) {
            for x in span(at.x, self.width) {
                let off = (x as f64 + 0.5 - at.x).hypot(y as f64 + 0.5 - at.y);
                // A soft rim: a thin line keeps its weight wherever it falls
                // between the samples.
                let share = (radius + 0.5 - off).clamp(0.0, 1.0) as f32;
                let cover = &mut self.cover[y * self.width + x];
                *cover = cover.max(share * opacity);
            }
        }
    }
}
