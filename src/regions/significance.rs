//! Whether a surface that facets lie on is more than chance.

use super::exact::{ExactFacets, MOST_TURN};
use super::growth::{Evidence, Growth};
use super::tessellation::MOST_ERRORS;
use crate::geometry::{Vector, plane_axes};
use crate::primitives::{Primitive, PrimitiveKind};

/// A region of facets on one surface.
#[derive(Debug, Clone)]
pub(super) struct Found {
    pub(super) growth: Growth,
    pub(super) area: f64,
    /// Independent coincidences: what lies on the surface beyond what its parameters can follow.
    pub(super) coincidences: usize,
    /// The chance of one of them.
    pub(super) chance: f64,
    /// Vertices, straight edges on the surface and tangent neighbours minus parameters: what the region explains.
    pub(super) weight: f64,
}

/// The false surfaces that one part may have on average.
const FALSE_ALARMS: f64 = 1e-3;

/// Coincidences are never rarer than this share of the rounding, below which distances are not uniform.
const LEAST_DISTANCE: f64 = 0.3;

/// Two vertices are at one place along a circle if they are nearer than so many errors: two for each of the two
/// vertices, and as much for the axis.
const SAME_PLACE: f64 = 8.0;

/// A misfit beyond the end of a face that is so many times the bound is not that of a surface that fits gradually less,
/// however few facets tell.
const MOST_GRADUAL: f64 = 20.0;

/// The facets and neighbours that are looked at for a median.
const SAMPLE: usize = 200;

/// Judges a region. `known` are the surfaces accepted so far; `tests` is the number of surfaces that the search of the
/// whole part tries. `None` if chance explains the region.
pub(super) fn judged(
    evidence: &ExactFacets,
    growth: Growth,
    known: &[Primitive],
    tests: f64,
) -> Option<Found> {
    let surface = growth.surface();
    let kind = surface.kind();
    if growth.units.len() < 2 || is_extruded(evidence, &growth) && kind != PrimitiveKind::Cylinder {
        return None;
    }
    if evidence.slack > 1.0 && !is_bordered(evidence, &growth) {
        return None;
    }
    let tangent = tangent_neighbours(evidence, &growth);
    let ruled = matches!(kind, PrimitiveKind::Cylinder | PrimitiveKind::Cone);
    if ruled && growth.units.len() < 3 && tangent < 2 {
        return None;
    }
    let mut coincidences = independent(evidence, &growth) + tangent as f64;
    if known.iter().any(|other| is_coaxial(evidence, &growth, other)) {
        coincidences += 2.0;
    }
    let sagittas = growth
        .units
        .iter()
        .step_by(growth.units.len().div_ceil(SAMPLE))
        .map(|&f| evidence.sagitta(&surface, evidence.facets.get(f)));
    let sagitta = median(sagittas.collect())?;
    let error = typical_error(evidence, &growth);
    let chance = (growth.fit.worst.max(LEAST_DISTANCE) * error / sagitta).max(f64::MIN_POSITIVE);
    if std::env::var("DBG").is_ok() { eprintln!("judge {:?} units {} verts {} k {} tan {} chance {:.1e} sag {:.2e} worst {:.2} abrupt {}", surface, growth.units.len(), growth.vertices.len(), coincidences, tangent, chance, sagitta, growth.fit.worst, ends_abruptly(evidence,&growth)); }
    let is_chance = tests.log10() + coincidences * chance.log10() >= FALSE_ALARMS.log10();
    if coincidences <= 0.0 || chance >= 0.5 || is_chance || evidence.slack <= 1.0 && !ends_abruptly(evidence, &growth) {
        return None;
    }
    let area = growth.units.iter().map(|&f| evidence.facets.get(f).area).sum();
    let weight = (growth.vertices.len() + straight_edges(evidence, &growth) + tangent) as f64
        - kind.parameters() as f64;
    Some(Found { growth, area, coincidences: coincidences as usize, chance, weight })
}

/// A neighbour that is so many times as large as a facet of a curved face is a face of its own.
const MUCH_LARGER: f64 = 4.0;

/// The share of its border along which a region that is found with larger errors may continue smoothly into what is not
/// explained. A face ends at creases and at other faces; a quadric that happens to come near a free-form surface does not.
const OPEN_BORDER: f64 = 0.25;

/// Whether a region ends at creases and at regions that are there already.
fn is_bordered(evidence: &ExactFacets, growth: &Growth) -> bool {
    let mut inside = growth.units.clone();
    inside.sort_unstable();
    let (mut all, mut smooth) = (0.0, 0.0);
    for &f in &growth.units {
        for border in &evidence.facets.get(f).borders {
            if inside.binary_search(&border.facet).is_err() {
                all += border.length;
                let other = evidence.facets.get(border.facet);
                let is_end = border.dihedral > MOST_TURN
                    || other.is_flat
                    || other.area > MUCH_LARGER * evidence.facets.get(f).area
                    || evidence.closed[border.facet as usize];
                smooth += if is_end { 0.0 } else { border.length };
            }
        }
    }
    smooth <= OPEN_BORDER * all
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

fn typical_error(evidence: &ExactFacets, growth: &Growth) -> f64 {
    let stride = growth.vertices.len().div_ceil(SAMPLE).max(1);
    let errors = growth.vertices.iter().step_by(stride).map(|&v| evidence.error(v));
    median(errors.collect()).unwrap_or(0.0)
}

/// Whether all normals are perpendicular to one direction. Then all vertices along this direction are one coincidence, and
/// only a cylinder counts them so.
fn is_extruded(evidence: &ExactFacets, growth: &Growth) -> bool {
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

/// The number of different values on a circle of length `period`, or on a line without one.
fn different(mut values: Vec<(f64, f64)>, period: Option<f64>) -> usize {
    values.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let apart = |pair: &[(f64, f64)]| pair[1].0 - pair[0].0 > pair[0].1.max(pair[1].1);
    let mut count = 1 + values.windows(2).filter(|pair| apart(pair)).count();
    if let (Some(period), Some(first), Some(last)) = (period, values.first(), values.last()) {
        if count > 1 && first.0 + period - last.0 <= first.1.max(last.1) {
            count -= 1;
        }
    }
    count
}

/// Coincidences of the vertices, those that lie above each other or on one ring counted once.
fn independent(evidence: &ExactFacets, growth: &Growth) -> f64 {
    let surface = growth.surface();
    let vertices = growth.vertices.iter().map(|&v| evidence.sample(v));
    let spare = growth.vertices.len() as f64 - surface.kind().parameters() as f64;
    let turn = Some(std::f64::consts::TAU);
    let around = |origin: crate::geometry::Point, axis: Vector| {
        let (x, y) = plane_axes(axis);
        let place = |s: crate::primitives::Sample| {
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
        Primitive::Sphere { .. } => spare.min(rings(evidence, growth)),
        Primitive::Torus { centre, axis, major, minor } => {
            let tube = |s: crate::primitives::Sample| {
                let q = s.at - centre;
                let h = q.dot(&axis);
                let rho = (q - h * axis).norm();
                (h.atan2(rho - major), SAME_PLACE * s.error / minor)
            };
            let rings = different(vertices.clone().map(tube).collect(), turn) as f64;
            spare.min(rings - 3.0).min(around(centre, axis) - 3.0)
        }
    }
}

/// Equal steps are the mark of a tessellation: each beyond the first is a coincidence. They count only if the vertices
/// alone do not suffice.
fn equal_steps(evidence: &ExactFacets, growth: &Growth, places: f64) -> f64 {
    let Primitive::Cylinder { radius, .. } = growth.surface() else { return 0.0 };
    if !(4.0..6.0).contains(&places) {
        return 0.0;
    }
    let slack = SAME_PLACE * typical_error(evidence, growth) / radius;
    let mut turns: Vec<f64> = Vec::new();
    for &f in &growth.units {
        let facet = evidence.facets.get(f);
        let inner = facet.borders.iter().filter(|b| b.facet > f && growth.units.contains(&b.facet));
        turns.extend(inner.map(|b| b.dihedral).filter(|&d| d > slack));
    }
    turns.sort_unstable_by(f64::total_cmp);
    turns.windows(2).filter(|pair| pair[1] - pair[0] < slack).count() as f64
}

/// Coincidences of a sphere whose vertices lie on few parallel circles: any two such circles are on a sphere.
fn rings(evidence: &ExactFacets, growth: &Growth) -> f64 {
    let points = growth.vertices.iter().map(|&v| evidence.mesh.point(v));
    let n = growth.vertices.len() as f64;
    let middle = points.clone().fold(Vector::zeros(), |sum, p| sum + p.coords) / n;
    let mut moments = nalgebra::Matrix3::zeros();
    for p in points {
        let q = p.coords - middle;
        moments += q * q.transpose();
    }
    let eigen = moments.symmetric_eigen();
    let fewest = (0..3).map(|k| {
        let along: Vector = eigen.eigenvectors.column(k).into_owned();
        let height = |&v: &u32| {
            let height = (evidence.mesh.point(v).coords - middle).dot(&along);
            (height, SAME_PLACE * evidence.error(v))
        };
        different(growth.vertices.iter().map(height).collect(), None)
    });
    let fewest = fewest.min().unwrap_or(0) as f64;
    if fewest * 3.0 <= n { fewest - 2.0 } else { n }
}

/// Whether a region has the axis of another surface.
fn is_coaxial(evidence: &ExactFacets, growth: &Growth, other: &Primitive) -> bool {
    let surface = growth.surface();
    let (Some(a), Some(b)) = (surface.axis(), other.axis()) else { return false };
    let error = typical_error(evidence, growth);
    let sine = a.cross(&b).norm();
    let offset = surface.origin() - other.origin();
    let away = (offset - offset.dot(&b) * b).norm();
    let reach = growth.fit.deviation_at(growth.surface().origin()).max(error);
    away < 2.0 * SAME_PLACE * reach
        && sine * surface.radius().unwrap_or(0.0).max(error) < SAME_PLACE * reach
        && sine < 1e-4
}

/// Neighbours that the surface meets tangentially: each flat one, and those along each of up to two sides of which the
/// facets are chords.
fn tangent_neighbours(evidence: &ExactFacets, growth: &Growth) -> usize {
    let surface = growth.surface();
    let axis = surface.axis().unwrap_or_else(Vector::zeros);
    let mut inside = growth.units.clone();
    inside.sort_unstable();
    let mut flats: Vec<u32> = Vec::new();
    let mut leans: Vec<(f64, f64)> = Vec::new();
    for &f in &growth.units {
        let facet = evidence.facets.get(f);
        for border in &facet.borders {
            let other = evidence.facets.get(border.facet);
            if border.dihedral > MOST_TURN || inside.binary_search(&border.facet).is_ok() {
                continue;
            }
            let slack = evidence.normal_error(facet) + evidence.normal_error(other);
            let ends = evidence.facets.common_sides(border).iter();
            let ends = ends.flat_map(|&side| evidence.mesh.ends(side as usize));
            let normal = |v: u32| growth.side * surface.normal(evidence.mesh.point(v));
            let sum: Vector = ends.map(normal).sum();
            let Some(mean) = sum.try_normalize(0.0) else { continue };
            if mean.cross(&other.normal).norm() > slack || border.dihedral <= SAME_PLACE * slack {
                continue;
            }
            if other.is_flat || other.area > MUCH_LARGER * facet.area {
                flats.push(border.facet);
            } else {
                leans.push((mean.dot(&axis), SAME_PLACE * slack));
            }
        }
    }
    flats.sort_unstable();
    flats.dedup();
    let sides = if leans.len() < 2 { 0 } else { different(leans, None).min(2) };
    flats.len() + if surface.kind() == PrimitiveKind::Torus { sides } else { 0 }
}

/// Edges between facets of a region that lie on its surface over their whole length.
fn straight_edges(evidence: &ExactFacets, growth: &Growth) -> usize {
    let surface = growth.surface();
    let mut inside = growth.units.clone();
    inside.sort_unstable();
    let mut count = 0;
    for &f in &growth.units {
        for border in &evidence.facets.get(f).borders {
            if border.facet < f || inside.binary_search(&border.facet).is_err() {
                continue;
            }
            for &side in evidence.facets.common_sides(border) {
                let [a, b] = evidence.mesh.ends(side as usize);
                let middle = nalgebra::center(&evidence.mesh.point(a), &evidence.mesh.point(b));
                let error = evidence.error(a).max(evidence.error(b));
                count += usize::from(surface.distance(middle).0.abs() <= MOST_ERRORS * error);
            }
        }
    }
    count
}

/// Whether the region ends at once. A surface that merely osculates a free-form one fits gradually less: beyond `n` facets the
/// misfit grows by the Taylor factor ((n+2)/n)^(parameters+1).
fn ends_abruptly(evidence: &ExactFacets, growth: &Growth) -> bool {
    let surface = growth.surface();
    let mut inside = growth.units.clone();
    inside.sort_unstable();
    let mut vertices = growth.vertices.clone();
    vertices.sort_unstable();
    let mut misfits = Vec::new();
    for &f in &growth.units {
        for border in &evidence.facets.get(f).borders {
            let other = evidence.facets.get(border.facet);
            if border.dihedral > MOST_TURN
                || other.is_flat
                || inside.binary_search(&border.facet).is_ok()
            {
                continue;
            }
            let outside = other.corners.iter().filter(|v| vertices.binary_search(v).is_err());
            let off = outside.map(|&v| {
                let s = evidence.sample(v);
                surface.distance(s.at).0.abs() / s.error
            });
            misfits.extend(off.reduce(f64::max));
        }
    }
    if misfits.len() < 2 {
        return true;
    }
    let kind = surface.kind();
    let n = growth.units.len() as f64;
    let across =
        if matches!(kind, PrimitiveKind::Sphere | PrimitiveKind::Torus) { n.sqrt() } else { n };
    let gradual = ((across + 2.0) / across).powi(kind.parameters() as i32 + 1).min(MOST_GRADUAL);
    median(misfits).is_none_or(|off| off > 2.0 * MOST_ERRORS * gradual)
}
