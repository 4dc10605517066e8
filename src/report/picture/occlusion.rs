//! Shade in hollows, from depth alone (screen-space ambient occlusion).

use rayon::prelude::*;

use super::canvas::Canvas;

/// How far to look around, as a share of the picture's shorter side.
const REACH: f64 = 0.045;

/// Pairs of samples to look at.
const PAIRS: u32 = 12;

/// Steps in depth above this share of the reach are between sheets.
const FAR: f32 = 2.5;

/// Light that is lost in the deepest hollow.
const STRENGTH: f32 = 0.75;

/// Darkens samples whose surroundings are nearer to the eye than they are.
///
/// Surroundings are looked at in pairs of opposite samples: the mean depth of
/// a pair is that of its middle on every plane, however it is tilted.
pub fn darken(canvas: &mut Canvas) {
    let reach = REACH * canvas.width.min(canvas.height) as f64;
    let (width, height) = (canvas.width, canvas.height);
    let depth = &canvas.depth;
    canvas.colour.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, colour) in row.iter_mut().enumerate() {
            let here = depth[y * width + x];
            if here == f32::INFINITY {
                continue;
            }
            let rise = |dx: i64, dy: i64| {
                let (x, y) = (x as i64 + dx, y as i64 + dy);
                let inside = (0..width as i64).contains(&x) && (0..height as i64).contains(&y);
                let depth = if inside { depth[y as usize * width + x as usize] } else { here };
                (here - depth) / reach as f32
            };
            let start = noise(x as u32, y as u32);
            let lost: f32 = (0..PAIRS)
                .map(|k| {
                    let (dx, dy) = offset(k, start, reach);
                    let (there, opposite) = (rise(dx, dy), rise(-dx, -dy));
                    // What is far in front is another sheet, and casts no
                    // shade here; beyond a rim there is nothing to compare.
                    if there.abs().max(opposite.abs()) > FAR {
                        return 0.0;
                    }
                    (0.5 * (there + opposite) - 0.01).clamp(0.0, 0.6)
                })
                .sum();
            let light = 1.0 - STRENGTH * (2.0 * lost / PAIRS as f32).min(1.0);
            *colour = colour.map(|c| c * light);
        }
    });
}

/// The k-th sample of a spiral with an angle that differs from sample to
/// sample, which turns bands into grain that averages out.
fn offset(k: u32, start: f64, reach: f64) -> (i64, i64) {
    const GOLDEN_ANGLE: f64 = 2.399_963;
    let radius = reach * ((f64::from(k) + 0.5 + start) / f64::from(PAIRS + 1)).sqrt();
    let angle = f64::from(k) * GOLDEN_ANGLE + start * std::f64::consts::TAU;
    ((radius * angle.cos()).round() as i64, (radius * angle.sin()).round() as i64)
}

/// A number from 0 to 1 that looks random (interleaved gradient noise).
fn noise(x: u32, y: u32) -> f64 {
    (52.982_918_9 * (0.067_110_56 * f64::from(x) + 0.005_837_15 * f64::from(y)).fract()).fract()
}
