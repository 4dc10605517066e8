//! Lines over a canvas, with those parts hidden that lie behind a sheet.

use scan2step::geometry::Vector;

use crate::canvas::{Canvas, SAMPLES};
use crate::colour::{Rgb, mix};

/// How much of a line's colour every sample takes. Lines that cross or
/// overlap do not add up.
pub struct Lines {
    width: usize,
    height: usize,
    cover: Vec<f32>,
}

/// How to draw a line.
#[derive(Debug, Clone, Copy)]
pub struct Pen {
    /// Width in pixels.
    pub width: f64,
    /// Opacity where nothing is in front.
    pub seen: f32,
    /// Opacity behind a sheet.
    pub hidden: f32,
}

/// How far, in samples, a line that lies on a sheet may be behind it: the
/// sheet is drawn as flat triangles.
const TOLERANCE: f32 = 2.0;

/// Samples around a point of a line of which the farthest decides whether it
/// is seen: on a steep sheet depth changes much from one to the next.
const AROUND: usize = 2;

impl Lines {
    /// No lines yet.
    pub fn over(canvas: &Canvas) -> Lines {
        let (width, height) = (canvas.width, canvas.height);
        Lines { width, height, cover: vec![0.0; width * height] }
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
                let at = pair[0] + step * (i as f64 / count);
                let opacity = if self.is_seen(canvas, at) { pen.seen } else { pen.hidden };
                self.dot(at, 0.5 * pen.width * SAMPLES as f64, opacity);
            }
        }
    }

    /// Draws a dot, in pixels and depth, of a pen's width.
    pub fn point(&mut self, canvas: &Canvas, at: Vector, pen: Pen) {
        let at = at * SAMPLES as f64;
        let opacity = if self.is_seen(canvas, at) { pen.seen } else { pen.hidden };
        self.dot(at, 0.5 * pen.width * SAMPLES as f64, opacity);
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

    fn is_seen(&self, canvas: &Canvas, at: Vector) -> bool {
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
        at.z as f32 <= farthest + TOLERANCE
    }

    fn dot(&mut self, at: Vector, radius: f64, opacity: f32) {
        let span = |x: f64, end: usize| {
            let low = (x - radius - 0.5).ceil().max(0.0);
            low as usize
                ..(x + radius + 0.5).floor().clamp(low, end.max(low as usize) as f64) as usize
        };
        for y in span(at.y, self.height) {
            for x in span(at.x, self.width) {
                let (dx, dy) = (x as f64 + 0.5 - at.x, y as f64 + 0.5 - at.y);
                if dx * dx + dy * dy <= radius * radius && x < self.width && y < self.height {
                    let cover = &mut self.cover[y * self.width + x];
                    *cover = cover.max(opacity);
                }
            }
        }
    }
}
