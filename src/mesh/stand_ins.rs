//! Vertices that stand for several ones of a scan.

/// Which vertex of a thinned patch stands for each vertex of the scan.
#[derive(Debug, Clone)]
pub struct StandIns {
    vertex_of: Vec<u32>,
    counts: Vec<f64>,
}

impl StandIns {
    /// `vertex_of` has the number of a measured vertex for each vertex of the scan. `counts` has the
    /// number of vertices of the scan for each measured vertex. A vertex of the scan may be divided
    /// among several.
    pub(crate) fn new(vertex_of: Vec<u32>, counts: Vec<f64>) -> Self {
        StandIns { vertex_of, counts }
    }

    /// For each measured vertex the number of vertices of the scan for which it stands.
    pub(crate) fn counts(&self) -> &[f64] {
        &self.counts
    }

    /// For each vertex of the scan the measured vertex that stands for it.
    pub(crate) fn vertex_of(&self) -> &[u32] {
        &self.vertex_of
    }

    /// The sum of a value of the vertices of the scan for which each measured vertex stands.
    pub(crate) fn sums(&self, of_scan: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.counts.len()];
        self.vertex_of.iter().zip(of_scan).for_each(|(&v, value)| sums[v as usize] += value);
        sums
    }

    /// The same where other vertices stand for these.
    pub(crate) fn then(&self, next: &StandIns) -> StandIns {
        StandIns { vertex_of: self.of_scan(&next.vertex_of), counts: next.sums(&self.counts) }
    }

    /// A value of each measured vertex, for each vertex of the scan for which it stands.
    pub(crate) fn of_scan<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.vertex_of.iter().map(|&v| values[v as usize]).collect()
    }
}
