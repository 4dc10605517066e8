//! Samples that are spread evenly over a trimmed face.
//!
//! The input is a face and the wanted distance between samples. The output is points on the face
//! with their parameters.

use super::surface::Domain;
use crate::deviation::TrimmedFace;
use crate::geometry::{Point, Uv};
use crate::spline::ParametricSurface;

/// The samples of a face.
#[derive(Debug, Default)]
pub(super) struct FaceSamples {
    pub(super) points: Vec<Point>,
    pub(super) uv: Vec<Uv>,
    /// The size of the cell around each sample, in the parameter plane.
    pub(super) cells: Vec<[f64; 2]>,
}

/// The largest number of parts into which a cell between break lines is divided along each side.
const MAX_PARTS: usize = 256;

/// The least number of cells along an axis. A plane has only two break lines.
const MIN_CELLS: usize = 4;

/// A cell of the parameter plane: its lower corner, its size, and the numbers of parts into which
/// it is divided.
struct SampleCell {
    from: Uv,
    size: [f64; 2],
    parts: [usize; 2],
}

impl FaceSamples {
    /// Samples at distances of about `spacing` mm. There are at most about `most` of them.
    pub(super) fn of(face: &TrimmedFace<Domain>, spacing: f64, most: f64) -> Self {
        let mut spacing = spacing;
        let mut cells = cells(face.surface(), spacing);
        // Enlarge the spacing if the face is much larger than the scan, perhaps in a wrong unit.
        for _ in 0..64 {
            let count: f64 = cells.iter().map(|c| (c.parts[0] * c.parts[1]) as f64).sum();
            if count <= most || count <= 2.0 * cells.len() as f64 {
                break;
            }
            spacing *= 1.1 * (count / most).sqrt();
            cells = self::cells(face.surface(), spacing);
        }
        let mut samples = FaceSamples::default();
        cells.iter().for_each(|cell| samples.add(face, cell));
        samples
    }

    fn add(&mut self, face: &TrimmedFace<Domain>, cell: &SampleCell) {
        let SampleCell { from, size: [du, dv], parts: [m, n] } = *cell;
        for k in 0..m * n {
            let share = |i: usize, of: usize| (i as f64 + 0.5) / of as f64;
            let at = Uv::new(from.x + du * share(k / n, m), from.y + dv * share(k % n, n));
            let point = face.surface().point(at);
            if face.contains(at) && point.iter().all(|x| x.is_finite()) {
                self.points.push(point);
                self.uv.push(at);
                self.cells.push([du / m as f64, dv / n as f64]);
            }
        }
    }
}

fn cells(surface: &Domain, spacing: f64) -> Vec<SampleCell> {
    let [us, vs] = surface.breaks().map(|breaks| lines(&breaks));
    let mut cells = Vec::with_capacity(us.len() * vs.len());
    for u in us.windows(2) {
        for v in vs.windows(2) {
            let size = [u[1] - u[0], v[1] - v[0]];
            let middle = surface.jet(Uv::new(u[0] + 0.5 * size[0], v[0] + 0.5 * size[1]));
            let parts = |length: f64| ((length / spacing).ceil() as usize).clamp(1, MAX_PARTS);
            let parts = [parts(middle.su.norm() * size[0]), parts(middle.sv.norm() * size[1])];
            cells.push(SampleCell { from: Uv::new(u[0], v[0]), size, parts });
        }
    }
    cells
}

/// The parameters that separate the cells along an axis.
fn lines(breaks: &[f64]) -> Vec<f64> {
    let pieces = MIN_CELLS.div_ceil(breaks.len().saturating_sub(1).max(1));
    let inner = |w: &[f64], i: usize| w[0] + (w[1] - w[0]) * i as f64 / pieces as f64;
    let lines = breaks.windows(2).flat_map(|w| (0..pieces).map(move |i| inner(w, i)));
    lines.chain(breaks.last().copied()).collect()
}
