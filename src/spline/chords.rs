//! Curves as chords.

use crate::geometry::{Point, segment_distance};

/// Halvings of a chord at the most.
const MOST_HALVINGS: usize = 16;

/// Pieces that a curve is cut into at least: a wave may cross its chord in the middle.
const FEWEST: usize = 32;

/// Points of a curve, so near each other that chords keep to it within `chord` mm. It is
/// smooth between its `breaks`; `place` is where a point of it is in space.
///
/// Four pieces of each chord are looked at, so this is measured and not proved.
pub(crate) fn chords<T: Copy>(
    breaks: &[f64],
    at: &dyn Fn(f64) -> T,
    place: impl Fn(&T) -> Point + Copy,
    chord: f64,
) -> Vec<T> {
    let pieces = (FEWEST / breaks.len().max(1)).max(2);
    let mut line = Line { at, place, chord, points: vec![at(breaks[0])] };
    for span in breaks.windows(2) {
        let t = |i: usize| span[0] + (span[1] - span[0]) * i as f64 / pieces as f64;
        for i in 0..pieces {
            let end = if i + 1 == pieces { span[1] } else { t(i + 1) };
            line.refine(t(i), end, MOST_HALVINGS);
        }
    }
    line.points
}

struct Line<'a, T, P> {
    at: &'a dyn Fn(f64) -> T,
    place: P,
    chord: f64,
    points: Vec<T>,
}

impl<T: Copy, P: Fn(&T) -> Point> Line<'_, T, P> {
    /// Goes on from `a`, where the line is, to `b`.
    fn refine(&mut self, a: f64, b: f64, halvings: usize) {
        let end = (self.at)(b);
        let from = self.points.last().map_or_else(|| (self.place)(&(self.at)(a)), &self.place);
        let to = (self.place)(&end);
        let off = |s: f64| segment_distance((self.place)(&(self.at)(a + s * (b - a))), from, to);
        if halvings == 0 || [0.5, 0.25, 0.75].iter().all(|s| off(*s) <= self.chord) {
            self.points.push(end);
            return;
        }
        let middle = 0.5 * (a + b);
        self.refine(a, middle, halvings - 1);
        self.refine(middle, b, halvings - 1);
    }
}
