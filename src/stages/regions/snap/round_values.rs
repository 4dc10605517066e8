//! Offsets, centres, radii and angles at round numbers.

use std::f64::consts::FRAC_PI_2;

use super::lines::at;
use super::{Snap, SnapKind, Snapping};
use crate::geometry::{Point, Vector};
use crate::primitives::Primitive;
use crate::primitives::round_numbers::round;

/// The gate of a value, in errors. All vertices are tested, so a wide gate costs no truth.
const GATE: f64 = 16.0;

/// A place with those coordinates round that may be.
pub(super) fn rounded_place(p: Point, gate: f64, unit: f64, may: impl Fn(usize) -> bool) -> Point {
    let mut place = p;
    for k in (0..3).filter(|&k| may(k)) {
        place[k] = round(p[k], gate, unit).unwrap_or(p[k]);
    }
    place
}

/// Whether a direction is exactly one of the world.
pub(super) fn is_world(d: &Vector) -> bool {
    d.iter().filter(|x| x.abs() == 1.0).count() == 1 && d.iter().filter(|&&x| x == 0.0).count() == 2
}

pub(super) fn snap(all: &mut [Snapping], unit: f64, snaps: &mut Vec<Snap>) {
    for snapping in all {
        let gate = GATE * snapping.error;
        match snapping.surface {
            Primitive::Plane { origin, normal } if is_world(&normal) => {
                let place = rounded_place(origin, gate / 4.0, unit, |k| normal[k] != 0.0);
                snapping.take(at(snapping.surface, place), SnapKind::Place, snaps);
            }
            Primitive::Plane { .. } => {}
            Primitive::Cylinder { origin, axis, radius } => {
                if let Some(radius) = round(radius, gate, unit) {
                    let surface = Primitive::Cylinder { origin, axis, radius };
                    snapping.take(surface, SnapKind::Value, snaps);
                }
            }
            Primitive::Sphere { centre, radius } => sphere(snapping, centre, radius, unit, snaps),
            Primitive::Cone { .. } => cone(snapping, unit, snaps),
            Primitive::Torus { centre, axis, major, minor } => {
                let major = round(major, gate, unit).unwrap_or(major);
                let minor = round(minor, gate, unit).unwrap_or(minor);
                let surface = Primitive::Torus { centre, axis, major, minor };
                snapping.take(surface, SnapKind::Value, snaps);
            }
        }
    }
}

fn sphere(snapping: &mut Snapping, centre: Point, radius: f64, unit: f64, snaps: &mut Vec<Snap>) {
    let gate = GATE * snapping.error;
    let place = rounded_place(centre, gate, unit, |_| true);
    let value = round(radius, gate, unit).unwrap_or(radius);
    let both = Primitive::Sphere { centre: place, radius: value };
    if !snapping.take(both, SnapKind::Value, snaps)
        && !snapping.take(Primitive::Sphere { centre: place, radius }, SnapKind::Place, snaps)
    {
        snapping.take(Primitive::Sphere { centre, radius: value }, SnapKind::Value, snaps);
    }
}

/// A round angle in degrees, then a round radius at a round height.
fn cone(snapping: &mut Snapping, unit: f64, snaps: &mut Vec<Snap>) {
    let Primitive::Cone { origin, axis, radius, angle } = snapping.surface else { return };
    let gate = 20.0 * snapping.direction_error;
    // A cone of no angle is no cone, however near to one it is.
    let rounded = round(angle.to_degrees(), gate.to_degrees(), 1.0).map(f64::to_radians);
    if let Some(angle) = rounded.filter(|&angle| angle > 0.0 && angle < FRAC_PI_2) {
        let turned = Primitive::Cone { origin, axis, radius, angle };
        if let Some(surface) = snapping.refitted(turned, &[0, 1, 2, 3, 5]) {
            snapping.take(surface, SnapKind::Value, snaps);
        }
    }
    let (Primitive::Cone { origin, axis, radius, angle }, gate) =
        (snapping.surface, GATE * snapping.error)
    else {
        return;
    };
    if !is_world(&axis) {
        return;
    }
    let along = axis.iamax();
    let mut heights: Vec<f64> = snapping.samples.iter().map(|s| s.at[along]).collect();
    heights.sort_unstable_by(f64::total_cmp);
    heights.dedup_by(|a, b| *a - *b <= 4.0 * snapping.error);
    for height in heights {
        let height = round(height, gate / 4.0, unit).unwrap_or(height);
        let at = radius + (height - origin[along]) * axis[along] * angle.tan();
        if let Some(value) = round(at, gate, unit).filter(|&r| r > 0.0) {
            let mut place = origin;
            place[along] = height;
            let surface = Primitive::Cone { origin: place, axis, radius: value, angle };
            if snapping.take(surface, SnapKind::Value, snaps) {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Uv;
    use crate::primitives::FitSample;

    #[test]
    fn a_steep_cone_is_not_rounded_to_one_without_an_angle() {
        let (origin, axis, angle) = (Point::origin(), Vector::z(), 0.2f64.to_radians());
        let surface = Primitive::Cone { origin, axis, radius: 5.0, angle };
        // So short that its angle is not known.
        let around = (0..12).map(|k| Uv::new(0.5 * f64::from(k), f64::from(k % 2)));
        let sample = |uv| FitSample { at: surface.point_at(uv), error: 2e-3 };
        let samples: Vec<FitSample> = around.map(sample).collect();
        let (error, looseness, direction_error) = (2e-3, 1.0, 2e-4);
        let mut all = [Snapping { region: 0, surface, samples, error, looseness, direction_error }];
        assert_eq!(round(0.2, (20.0 * direction_error).to_degrees(), 1.0), Some(0.0));
        snap(&mut all, 1.0, &mut Vec::new());
        let Primitive::Cone { angle, .. } = all[0].surface else { panic!("no cone") };
        assert!(angle > 0.0);
    }
}
