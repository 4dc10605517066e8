//! Approximation of curves by polylines.

use crate::geometry::{Point, segment_distance};

/// The largest number of times that a chord is halved.
const MOST_HALVINGS: usize = 16;

/// The smallest number of chords for a whole curve. A wave may cross a single chord in its middle,
/// where the error would then appear to be zero.
const FEWEST: usize = 32;

/// Points of a curve such that the chords between them stay within `chord` mm of the curve. The
/// curve must be smooth between its `breaks`; `place` gives the position of a point in space.
///
/// The distance is measured at three inner points of each chord, so the bound is not proved.
pub(crate) fn chords<T: Copy>(
    breaks: &[f64],
    at: &dyn Fn(f64) -> T,
    place: impl Fn(&T) -> Point + Copy,
    chord: f64,
) -> Vec<T> {
    let pieces = (FEWEST / breaks.len().max(1)).max(2);
    let mut line = ChordPolyline { at, place, chord, points: vec![at(breaks[0])] };
    for span in breaks.windows(2) {
        let t = |i: usize| span[0] + (span[1] - span[0]) * i as f64 / pieces as f64;
        for i in 0..pieces {
            let end = if i + 1 == pieces { span[1] } else { t(i + 1) };
            line.refine(t(i), end, MOST_HALVINGS);
        }
    }
    line.points
}

struct ChordPolyline<'a, T, P> {
    at: &'a dyn Fn(f64) -> T,
    place: P,
    chord: f64,
    points: Vec<T>,
}

impl<T: Copy, P: Fn(&T) -> Point> ChordPolyline<'_, T, P> {
    /// Continues the polyline from `a`, where it ends, to `b`.
    fn refine(&mut self, a: f64, b: f64, halvings: usize) {
        let end = (self.at)(b);
        let from = self.points.last().map_or_else(|| (self.place)(&(self.at)(a)), &self.place);
        let to = (self.place)(&end);
        let off = |s: f64| segment_distance((self.place)(&(self.at)(a + s * (b - a))), from, to);
        if halvings == 0 || [0.5, 0.25, 3.0 / 4.0].iter().all(|s| off(*s) <= self.chord) {
            self.points.push(end);
            return;
        }
        let middle = 0.5 * (a + b);
        self.refine(a, middle, halvings - 1);
        self.refine(middle, b, halvings - 1);
    }
}
