//! Test whether parameter points are cut out of the face.

use scan2step::geometry::{Uv, ray_crosses};

/// The inside of the trim loops. The sides are sorted into rows of v, so that a test examines only
/// a few of them.
pub struct CutOut {
    rows: Vec<Vec<[Uv; 2]>>,
    range: (f64, f64),
}

const ROWS: usize = 2048;

impl CutOut {
    /// The inside of closed polylines that do not cross.
    pub fn new(loops: &[Vec<Uv>], range: (f64, f64)) -> CutOut {
        let mut cut = CutOut { rows: vec![Vec::new(); ROWS], range };
        for outline in loops {
            let next = outline.iter().cycle().skip(1);
            for (&a, &b) in outline.iter().zip(next) {
                for row in cut.row(a.y.min(b.y))..=cut.row(a.y.max(b.y)) {
                    cut.rows[row].push([a, b]);
                }
            }
        }
        cut
    }

    /// Whether a point is inside, which means that a ray from it crosses the loops an odd number of
    /// times.
    pub fn contains(&self, p: Uv) -> bool {
        let over = |[a, b]: &&[Uv; 2]| ray_crosses(p, (*a, *b));
        self.rows[self.row(p.y)].iter().filter(over).count() % 2 == 1
    }

    fn row(&self, v: f64) -> usize {
        let share = (v - self.range.0) / (self.range.1 - self.range.0);
        ((share * ROWS as f64).max(0.0) as usize).min(ROWS - 1)
    }
}
