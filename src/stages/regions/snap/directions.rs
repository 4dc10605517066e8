//! Directions, the best known first.

use super::{Snap, SnapKind, Snapping};
use crate::geometry::{Point, Vector, range};
use crate::primitives::{Primitive, PrimitiveKind};

/// A direction may turn by so many standard deviations. All vertices are tested, so a wide gate costs no truth.
const GATE: f64 = 30.0;

/// Directions of other regions that are tried. The first ones are the best known.
const MOST_DIRECTIONS: usize = 60;

/// Two directions whose cross product is shorter do not determine a third one.
const LEAST_SINE: f64 = 0.05;

/// Rounding of the coordinates of unit vectors.
const ALIKE: f64 = 1e-9;

pub(super) fn snap(all: &mut [Snapping], snaps: &mut Vec<Snap>) {
    let mut order: Vec<usize> = (0..all.len()).filter(|&i| is_directed(&all[i])).collect();
    order.sort_by(|&i, &j| all[i].direction_error.total_cmp(&all[j].direction_error));
    let world = [Vector::x(), Vector::y(), Vector::z()];
    let mut own: Vec<Vector> = Vec::new();
    for i in order {
        if !one(&mut all[i], &world, &own, snaps) && own.len() < MOST_DIRECTIONS {
            own.extend(direction(&all[i].surface));
        }
    }
}

/// Whether a direction means something: a triangle's plane says nothing.
fn is_directed(snapping: &Snapping) -> bool {
    match snapping.surface.kind() {
        PrimitiveKind::Sphere => false,
        PrimitiveKind::Plane => snapping.samples.len() > 3,
        _ => true,
    }
}

pub(super) fn direction(surface: &Primitive) -> Option<Vector> {
    match *surface {
        Primitive::Plane { normal, .. } => Some(normal),
        _ => surface.axis(),
    }
}

/// Snaps one direction. Returns whether it became a known one.
fn one(snapping: &mut Snapping, world: &[Vector], own: &[Vector], snaps: &mut Vec<Snap>) -> bool {
    let Some(now) = direction(&snapping.surface) else { return true };
    let gate = GATE * snapping.direction_error + ALIKE;
    let signed = |d: &Vector| if d.dot(&now) < 0.0 { -d } else { *d };
    let near = |d: &Vector| (d - now).norm() <= gate;
    for (list, kind) in [(world, SnapKind::World), (own, SnapKind::Parallel)] {
        for d in list.iter().map(signed).filter(near) {
            if turned(snapping, d).is_some_and(|s| snapping.take(s, kind, snaps)) {
                return true;
            }
        }
    }
    let across: Vec<Vector> =
        world.iter().chain(own).copied().filter(|d| d.dot(&now).abs() < gate).collect();
    for (i, a) in across.iter().enumerate() {
        for b in &across[..i] {
            let cross = a.cross(b);
            if cross.norm() < LEAST_SINE {
                continue;
            }
            let d = signed(&cross.normalize());
            if near(&d)
                && turned(snapping, d)
                    .is_some_and(|s| snapping.take(s, SnapKind::Perpendicular, snaps))
            {
                return true;
            }
        }
    }
    for a in across {
        let d = (now - now.dot(&a) * a).normalize();
        if turned(snapping, d).is_some_and(|s| snapping.take(s, SnapKind::Perpendicular, snaps)) {
            return false;
        }
    }
    false
}

/// The surface with another direction, and its other parameters fitted again.
fn turned(snapping: &Snapping, d: Vector) -> Option<Primitive> {
    match snapping.surface {
        Primitive::Plane { .. } => {
            // The middle of the extremes is the offset that allows most.
            let ends = range(snapping.samples.iter().map(|s| s.at.coords.dot(&d)));
            let base = snapping.surface.origin();
            let off = (ends[0] + ends[1]) / 2.0 - base.coords.dot(&d);
            Some(Primitive::Plane { origin: base + off * d, normal: d })
        }
        Primitive::Sphere { .. } => None,
        surface => {
            snapping.refitted(with_direction(surface, d, snapping.samples.first()?.at), &[0, 1])
        }
    }
}

fn with_direction(surface: Primitive, d: Vector, near: Point) -> Primitive {
    match surface.centred_at(near) {
        Primitive::Cylinder { origin, radius, .. } => {
            Primitive::Cylinder { origin, axis: d, radius }
        }
        Primitive::Cone { origin, radius, angle, .. } => {
            Primitive::Cone { origin, axis: d, radius, angle }
        }
        Primitive::Torus { centre, major, minor, .. } => {
            Primitive::Torus { centre, axis: d, major, minor }
        }
        other => other,
    }
}
