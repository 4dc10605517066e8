//! How many vertices of a region lie on its surface by more than its parameters can follow.

use std::f64::consts::TAU;

use super::exact::ExactFacets;
use super::growth::{Evidence, GrownRegion};
use super::significance::typical_error;
use crate::geometry::{Point, Vector, plane_axes};
use crate::primitives::{FitSample, Primitive};

/// Two vertices are at one place along a circle if they are nearer than so many errors: two for each of the two
/// vertices, and as much for the axis.
pub(super) const SAME_PLACE: f64 = 8.0;

/// The number of different values on a circle of length `period`, or on a line without one.
pub(super) fn different(mut values: Vec<(f64, f64)>, period: Option<f64>) -> usize {
    values.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let apart = |pair: &[(f64, f64)]| pair[1].0 - pair[0].0 > pair[0].1.max(pair[1].1);
    let mut count = 1 + values.windows(2).filter(|pair| apart(pair)).count();
    if let (Some(period), Some(first), Some(last)) = (period, values.first(), values.last())
        && count > 1
        && first.0 + period - last.0 <= first.1.max(last.1)
    {
        count -= 1;
    }
    count
}

/// Coincidences of the vertices, those that lie above each other or on one ring counted once.
pub(super) fn independent(evidence: &ExactFacets, growth: &GrownRegion) -> f64 {
    let surface = growth.surface();
    let vertices = growth.vertices.iter().map(|&v| evidence.sample(v));
    let spare = growth.vertices.len() as f64 - surface.kind().parameters() as f64;
    let turn = Some(TAU);
    let around = |origin: Point, axis: Vector| {
        let (x, y) = plane_axes(axis);
        let place = |s: FitSample| {
            let q = s.at - origin;
            let (a, b) = (q.dot(&x), q.dot(&y));
            (b.atan2(a), SAME_PLACE * s.error / a.hypot(b).max(f64::MIN_POSITIVE))
        };
        different(vertices.clone().map(place).collect(), turn) as f64
    };
    match surface {
        Primitive::Plane { .. } => spare,
        Primitive::Cylinder { origin, axis, .. } => {
            let places = around(origin, axis);
            (places - 3.0).min(spare) + equal_steps(evidence, growth, places)
        }
        Primitive::Cone { origin, axis, .. } => (around(origin, axis) - 3.0).min(spare),
        Primitive::Sphere { .. } => {
            let axes = principal_axes(evidence, growth);
            spare.min(rings(evidence, growth, &axes)).min(images(evidence, growth, &axes))
        }
        Primitive::Torus { centre, axis, .. } => {
            let rings = different(around_tube(evidence, growth), turn) as f64;
            spare.min(rings - 3.0).min(around(centre, axis) - 3.0)
        }
    }
}

/// The largest step of a face is at most so many times the next one. Of 131 parts made for it, half of this cuts tori of three, and
/// twice as much takes circles of different faces for a torus in one.
const MOST_UNEVEN: f64 = 2.25;

/// The angles of a torus's vertices around its tube, each with the angle by which two of one place may differ.
fn around_tube(evidence: &ExactFacets, growth: &GrownRegion) -> Vec<(f64, f64)> {
    let Primitive::Torus { centre, axis, major, minor } = growth.surface() else {
        return Vec::new();
    };
    let tube = |&v: &u32| {
        let s = evidence.sample(v);
        let q = s.at - centre;
        let h = q.dot(&axis);
        let rho = (q - h * axis).norm();
        (h.atan2(rho - major), SAME_PLACE * s.error / minor)
    };
    growth.vertices.iter().map(tube).collect()
}

/// Whether the vertices of a torus are as dense around its tube everywhere. Any three circles about one axis are on a torus,
/// but of different faces they lie at distances that one face does not have.
pub(super) fn has_even_steps(evidence: &ExactFacets, growth: &GrownRegion) -> bool {
    let mut angles = around_tube(evidence, growth);
    angles.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let (Some(first), Some(last)) = (angles.first(), angles.last()) else { return true };
    let mut steps = vec![first.0 + TAU - last.0];
    steps.extend(angles.windows(2).map(|pair| pair[1].0 - pair[0].0));
    steps.sort_unstable_by(|a, b| b.total_cmp(a));
    // The largest one is what the face leaves out.
    steps.get(1).zip(steps.get(2)).is_none_or(|(most, next)| *most <= MOST_UNEVEN * next)
}

/// Equal steps are the mark of a tessellation: each beyond the first is a coincidence. They count only if the vertices
/// alone do not suffice.
fn equal_steps(evidence: &ExactFacets, growth: &GrownRegion, places: f64) -> f64 {
    if !(4.0..6.0).contains(&places) {
        return 0.0;
    }
    let mut turns: Vec<f64> = Vec::new();
    let mut slack = 0.0f64;
    for &f in &growth.units {
        let facet = evidence.facets.get(f);
        // Two normals make a turn, and two turns are compared.
        slack = slack.max(2.0 * evidence.normal_error(facet));
        let inner = facet.borders.iter().filter(|b| b.facet > f && growth.units.contains(&b.facet));
        turns.extend(inner.map(|b| b.dihedral).filter(|&d| d > slack));
    }
    turns.sort_unstable_by(f64::total_cmp);
    turns.windows(2).filter(|pair| pair[1] - pair[0] < slack).count() as f64
}

/// Coincidences of a sphere whose vertices lie on few parallel circles: any two such circles are on a sphere.
fn rings(
    evidence: &ExactFacets,
    growth: &GrownRegion,
    (middle, axes): &(Point, [Vector; 3]),
) -> f64 {
    let n = growth.vertices.len() as f64;
    let fewest = axes.each_ref().map(|along| {
        let height = |&v: &u32| {
            let height = (evidence.mesh.point(v) - middle).dot(along);
            (height, SAME_PLACE * evidence.error(v))
        };
        different(growth.vertices.iter().map(height).collect(), None)
    });
    let fewest = fewest.into_iter().min().unwrap_or(0) as f64;
    if fewest * 3.0 <= n { fewest - 2.0 } else { n }
}

/// The middle of a region's vertices, and the axes of their second moments.
fn principal_axes(evidence: &ExactFacets, growth: &GrownRegion) -> (Point, [Vector; 3]) {
    let points = || growth.vertices.iter().map(|&v| evidence.mesh.point(v));
    let n = growth.vertices.len() as f64;
    let middle = Point::from(points().fold(Vector::zeros(), |sum, p| sum + p.coords) / n);
    let moments: nalgebra::Matrix3<f64> =
        points().map(|p| (p - middle) * (p - middle).transpose()).sum();
    let eigen = moments.symmetric_eigen();
    (middle, [0, 1, 2].map(|k| eigen.eigenvectors.column(k).into_owned()))
}

/// The most vertices of a region that are compared with each other. An eighth of so many, with three mirrors, are still far more than a sphere
/// has parameters.
const MOST_MIRRORED: usize = 200;

/// Coincidences of a sphere whose vertices are mirror images of each other: an image says nothing new, and the centre lies in the plane
/// between them. So three pairs are on a sphere whatever they are.
fn images(
    evidence: &ExactFacets,
    growth: &GrownRegion,
    (middle, axes): &(Point, [Vector; 3]),
) -> f64 {
    let mut left = growth.vertices.clone();
    if left.len() > MOST_MIRRORED {
        return f64::INFINITY;
    }
    let mut free = growth.surface().kind().parameters() as f64;
    for along in axes {
        let height = |v: u32| (evidence.mesh.point(v) - middle).dot(along);
        let image = |v: u32| evidence.mesh.point(v) - 2.0 * height(v) * along;
        let is_at = |p: Point, v: u32| {
            (evidence.mesh.point(v) - p).norm() <= SAME_PLACE * evidence.error(v)
        };
        let has_image = |&v: &u32| growth.vertices.iter().any(|&w| is_at(image(v), w));
        if growth.vertices.iter().all(has_image) {
            free -= 1.0;
            left.retain(|&v| height(v) >= -SAME_PLACE * evidence.error(v));
        }
    }
    left.len() as f64 - free
}

/// Whether a region has the axis of another surface.
pub(super) fn is_coaxial(evidence: &ExactFacets, growth: &GrownRegion, other: &Primitive) -> bool {
    let surface = growth.surface();
    let (Some(a), Some(b)) = (surface.axis(), other.axis()) else { return false };
    let sine = a.cross(&b).norm();
    if sine >= 1e-4 {
        return false;
    }
    let error = typical_error(evidence, growth);
    let offset = surface.origin() - other.origin();
    let away = (offset - offset.dot(&b) * b).norm();
    let reach = growth.fit.deviation_at(growth.surface().origin()).max(error);
    away < 2.0 * SAME_PLACE * reach
        && sine * surface.radius().unwrap_or(0.0).max(error) < SAME_PLACE * reach
}

/// Whether all normals are perpendicular to one direction. Then all vertices along this direction are one coincidence, and
/// only a cylinder counts them so.
pub(super) fn is_extruded(evidence: &ExactFacets, growth: &GrownRegion) -> bool {
    let mut moments = nalgebra::Matrix3::zeros();
    for &f in &growth.units {
        let facet = evidence.facets.get(f);
        moments += facet.area * facet.normal * facet.normal.transpose();
    }
    let eigen = moments.symmetric_eigen();
    let along: Vector = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    growth.units.iter().all(|&f| {
        let facet = evidence.facets.get(f);
        facet.normal.dot(&along).abs() <= evidence.normal_error(facet)
    })
}
