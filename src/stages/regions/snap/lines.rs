//! Axes: of one line, or at round places.

use super::round_values::{is_world, rounded_place};
use super::{Snap, SnapKind, Snapping};
use crate::geometry::{Point, Vector};
use crate::primitives::Primitive;
use crate::primitives::round_numbers::round;

/// Axes this many errors apart are tried as one line.
const GATE: f64 = 40.0;

/// Lines that are tried. The first ones belong to the regions with most vertices.
const MOST_LINES: usize = 200;

/// The motions that keep the axis: turns and shifts are frozen.
const AXIS: [usize; 4] = [0, 1, 2, 3];

pub(super) fn snap(all: &mut [Snapping], unit: f64, snaps: &mut Vec<Snap>) {
    let mut order: Vec<usize> =
        (0..all.len()).filter(|&i| all[i].surface.axis().is_some()).collect();
    order.sort_by_key(|&i| std::cmp::Reverse(all[i].samples.len()));
    let mut lines: Vec<(Point, Vector)> = Vec::new();
    for i in order {
        let snapping = &mut all[i];
        if !joined(snapping, &lines, snaps) {
            placed(snapping, unit, snaps);
            if lines.len() < MOST_LINES {
                let axis = snapping.surface.axis().unwrap_or_else(Vector::z);
                lines.push((snapping.surface.origin(), axis));
            }
        }
    }
}

/// Moves an axis onto a known line. Returns whether it did.
fn joined(snapping: &mut Snapping, lines: &[(Point, Vector)], snaps: &mut Vec<Snap>) -> bool {
    let Some(axis) = snapping.surface.axis() else { return false };
    let origin = snapping.surface.origin();
    let gate = GATE * snapping.error;
    lines.iter().any(|&(o, a)| {
        if a.cross(&axis).norm() > 1e-12 {
            return false;
        }
        let foot = o + (origin - o).dot(&a) * a;
        if (foot - origin).norm() > gate {
            return false;
        }
        let moved = at(snapping.surface, foot);
        let fitted = snapping.refitted(moved, &AXIS);
        fitted.is_some_and(|s| snapping.take(s, SnapKind::Coaxial, snaps))
    })
}

/// Moves an axis in a direction of the world to a round place.
fn placed(snapping: &mut Snapping, unit: f64, snaps: &mut Vec<Snap>) {
    let Some(axis) = snapping.surface.axis().filter(is_world) else { return };
    let along = axis.iamax();
    let place =
        rounded_place(snapping.surface.origin(), 8.0 * snapping.error, unit, |k| k != along);
    let moved = at(snapping.surface, place);
    if let Some(surface) = snapping.refitted(moved, &AXIS) {
        snapping.take(surface, SnapKind::Place, snaps);
    }
    if let Primitive::Torus { centre, .. } = snapping.surface {
        let mut level = centre;
        level[along] = round(centre[along], 8.0 * snapping.error, unit).unwrap_or(centre[along]);
        snapping.take(at(snapping.surface, level), SnapKind::Place, snaps);
    }
}

/// The surface at another origin.
pub(super) fn at(surface: Primitive, place: Point) -> Primitive {
    match surface {
        Primitive::Plane { normal, .. } => Primitive::Plane { origin: place, normal },
        Primitive::Cylinder { axis, radius, .. } => {
            Primitive::Cylinder { origin: place, axis, radius }
        }
        Primitive::Cone { axis, radius, angle, .. } => {
            Primitive::Cone { origin: place, axis, radius, angle }
        }
        Primitive::Sphere { radius, .. } => Primitive::Sphere { centre: place, radius },
        Primitive::Torus { axis, major, minor, .. } => {
            Primitive::Torus { centre: place, axis, major, minor }
        }
    }
}
