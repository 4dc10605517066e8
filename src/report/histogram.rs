//! Histograms of signed distances.

/// Counts of signed distances in bins of equal width.
pub(crate) struct Histogram {
    /// The bins go from −`end` to `end`, in mm. The outermost bins have the distances beyond.
    pub end: f64,
    pub counts: Vec<usize>,
}

/// Bins from −end to end: an even number, so that 0 is between two of them.
const BINS: usize = 80;

impl Histogram {
    pub(super) fn of(distances: impl Iterator<Item = f32>, end: f64) -> Histogram {
        let mut counts = vec![0; BINS];
        for d in distances {
            let at = (f64::from(d) / end + 1.0) * 0.5 * BINS as f64;
            counts[(at.max(0.0) as usize).min(BINS - 1)] += 1;
        }
        Histogram { end, counts }
    }

    /// The counts without signs: half as many bins, from 0 to `end`.
    #[cfg(any(test, feature = "html"))]
    pub(crate) fn absolute(&self) -> Vec<usize> {
        let half = self.counts.len() / 2;
        (0..half).map(|k| self.counts[half + k] + self.counts[half - 1 - k]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_distance_is_counted_once() {
        let h = Histogram::of([-9.0, -0.01, 0.01, 0.99, 9.0].into_iter(), 1.0);
        assert_eq!(h.counts.iter().sum::<usize>(), 5);
        assert_eq!([h.counts[0], h.counts[39], h.counts[40], h.counts[79]], [1, 1, 1, 2]);
        assert_eq!(h.absolute()[0], 2);
        assert_eq!(h.absolute()[39], 3);
    }
}
