//! The bounding box of a face at a place.
//!
//! The input is a face, its samples, and the corners of its loops. The output is its lowest and its highest
//! coordinates: those of the samples and corners, each improved by a descent on the surface.

use formats::cad::CadPlace;
use nalgebra::{Matrix2, Vector2};

use super::samples::FaceSamples;
use super::surface::Domain;
use crate::deviation::TrimmedFace;
use crate::geometry::{Point, Uv, Vector, bounds};
use crate::spline::ParametricSurface;

/// The largest number of steps to a highest point.
const STEPS: usize = 30;

/// The corners of the bounding box of a face at a place.
pub(super) fn extent(
    face: &TrimmedFace<Domain>,
    samples: &FaceSamples,
    corners: &[Point],
    place: &CadPlace,
) -> Option<[Point; 2]> {
    if samples.points.is_empty() && corners.is_empty() {
        return None;
    }
    let here = |p: Point| Point::from(place.point(p.into()));
    let all = samples.points.iter().chain(corners);
    let [mut low, mut high] = bounds(all.map(|p| here(*p)));
    let origin = here(Point::origin());
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            // The direction in the coordinates of the face.
            let mut direction = Vector::zeros();
            for k in 0..3 {
                let mut unit = Point::origin();
                unit[k] = 1.0;
                direction[k] = side * (here(unit) - origin)[axis];
            }
            let height = |p: &Point| direction.dot(&p.coords);
            let order = |a: &usize, b: &usize| {
                height(&samples.points[*a]).total_cmp(&height(&samples.points[*b]))
            };
            let Some(best) = (0..samples.points.len()).max_by(order) else { continue };
            let at = highest(face, direction, samples.uv[best], samples.cells[best]);
            let p = here(face.surface().point(at));
            (low, high) = (low.inf(&p), high.sup(&p));
        }
    }
    Some([low, high])
}

/// The place of a face that is highest in a direction, near a start. Newton's method is applied to the height. A step
/// that does not go up, or leaves the face or the cell around the start, is halved.
fn highest(face: &TrimmedFace<Domain>, direction: Vector, start: Uv, cell: [f64; 2]) -> Uv {
    let surface = face.surface();
    let mut at = start;
    for _ in 0..STEPS {
        let jet = surface.jet(at);
        let gradient = Vector2::new(direction.dot(&jet.su), direction.dot(&jet.sv));
        let [a, b, c] = [jet.suu, jet.suv, jet.svv].map(|d| direction.dot(&d));
        let newton = Matrix2::new(a, b, b, c).try_inverse().map(|inverse| -(inverse * gradient));
        // Without a peak the step goes up to the border of the cell.
        let steepest = Vector2::new(cell[0] * gradient.x.signum(), cell[1] * gradient.y.signum());
        let mut step = newton.filter(|step| step.dot(&gradient) > 0.0).unwrap_or(steepest);
        let longest = (step.x.abs() / cell[0]).max(step.y.abs() / cell[1]);
        if longest > 1.0 {
            step /= longest;
        }
        let height = direction.dot(&jet.s.coords);
        let goes_up = |step: Vector2<f64>| {
            let there = surface.clamp(at + step);
            face.contains(there) && direction.dot(&surface.point(there).coords) > height
        };
        let mut tries = 0;
        while tries < STEPS && !goes_up(step) {
            step *= 0.5;
            tries += 1;
        }
        if tries == STEPS {
            break;
        }
        at = surface.clamp(at + step);
    }
    at
}
