//! What lies around a region: tangent neighbours, and whether the region ends as a face does.

use super::coincidences::{SAME_PLACE, different};
use super::exact::{ExactFacets, MOST_TURN};
use super::facets::Border;
use super::growth::{Evidence, GrownRegion};
use super::significance::median;
use super::tessellation::MOST_ERRORS;
use crate::geometry::Vector;
use crate::geometry::sets::Sets;
use crate::primitives::PrimitiveKind;

/// A neighbour that is so many times as large as a facet of a curved face is a face of its own.
const MUCH_LARGER: f64 = 4.0;

/// The share of its border along which a region that is found with larger errors may continue smoothly into what is not
/// explained. A face ends at creases and at other faces; a quadric that happens to come near a free-form surface does not.
const OPEN_BORDER: f64 = 0.25;

/// Whether a face that has a facet may end at one of its borders: at a crease, at a flat face, at a region that is there already.
fn is_end(evidence: &ExactFacets, facet: u32, border: &Border) -> bool {
    let other = evidence.facets.get(border.facet);
    border.dihedral > MOST_TURN
        || other.is_flat
        || other.area > MUCH_LARGER * evidence.facets.get(facet).area
        || evidence.closed[border.facet as usize]
}

/// The number of pieces of at least two facets of the pool that end as faces do.
pub(super) fn closed_pieces(evidence: &ExactFacets, pool: &[bool]) -> usize {
    let mut sets = Sets::new(pool.len());
    let mut joined = 0;
    for f in (0..pool.len() as u32).filter(|&f| pool[f as usize]) {
        for border in &evidence.facets.get(f).borders {
            if pool[border.facet as usize] && !is_end(evidence, f, border) {
                sets.join(f as usize, border.facet as usize);
            }
        }
    }
    let mut sizes = vec![0; pool.len()];
    (0..pool.len()).filter(|&f| pool[f]).for_each(|f| {
        let root = sets.find(f);
        sizes[root] += 1;
        joined += usize::from(sizes[root] == 2);
    });
    joined
}

/// Whether a region ends at creases and at regions that are there already.
pub(super) fn is_bordered(evidence: &ExactFacets, growth: &GrownRegion) -> bool {
    let mut inside = growth.units.clone();
    inside.sort_unstable();
    let (mut all, mut smooth) = (0.0, 0.0);
    for &f in &growth.units {
        for border in &evidence.facets.get(f).borders {
            if inside.binary_search(&border.facet).is_err() {
                all += border.length;
                smooth += if is_end(evidence, f, border) { 0.0 } else { border.length };
            }
        }
    }
    smooth <= OPEN_BORDER * all
}

/// A misfit beyond the end of a face that is so many times the bound is not that of a surface that fits gradually less,
/// however few facets tell.
const MOST_GRADUAL: f64 = 20.0;

/// Whether the region ends at once. A surface that merely osculates a free-form one fits gradually less: beyond `n` facets the
/// misfit grows by the Taylor factor ((n+2)/n)^(parameters+1).
pub(super) fn ends_abruptly(evidence: &ExactFacets, growth: &GrownRegion) -> bool {
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

/// Neighbours that the surface meets tangentially: each flat one, and those along each of up to two sides of which the
/// facets are chords.
pub(super) fn tangent_neighbours(evidence: &ExactFacets, growth: &GrownRegion) -> usize {
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
pub(super) fn straight_edges(evidence: &ExactFacets, growth: &GrownRegion) -> usize {
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
