//! Closed loops of cubic arcs in the parameter plane. It is certified that they cross neither
//! themselves nor each other, and point-in-loop tests are exact.
//!
//! A polygon of chords cannot tell whether two curves touch. Here a loop is divided into Bézier
//! pieces until each piece is proved to be simple. Two pieces are apart only if the boxes around
//! their control points, which contain the curves, are apart.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::bezier_piece::{BezierPiece, run_on};
use super::{Curve, LoopFault};
use crate::geometry::{ROUNDING, Uv, uv_bounds};

/// The smallest distance in (u, v) between two loops, between different parts of a loop, and between a
/// loop and the end of the domain. Importers treat curves that are nearer as touching, and refuse a
/// pcurve that leaves the domain by any amount.
const CLEARANCE: f64 = 1e-8;

/// A fault of a loop, with the parameter at which it occurs if there is a single one.
pub(crate) type LocatedFault = (LoopFault, Option<f64>);

/// A loop that is proved to be closed, without cusps, and inside [0, 1]².
#[derive(Debug, Clone)]
pub struct CertifiedLoop {
    pieces: Vec<BezierPiece>,
    low: Uv,
    high: Uv,
}

impl CertifiedLoop {
    /// Checks a loop of arcs. Each arc must start where the one before ends.
    ///
    /// # Errors
    /// The fault and its parameter if the loop is open, has a cusp or leaves the domain.
    pub fn new(arcs: &[Curve<2>]) -> Result<Self, LocatedFault> {
        let pieces = BezierPiece::all(arcs).ok_or((LoopFault::Open, None))?;
        let closed = |(i, p): (usize, &BezierPiece)| {
            (p.end() - pieces[(i + 1) % pieces.len()].start()).amax() <= ROUNDING
        };
        if !pieces.iter().enumerate().all(closed) {
            return Err((LoopFault::Open, None));
        }
        let pieces = simple(pieces)?;
        if let Some(p) = pieces.iter().find(|p| !p.is_within(CLEARANCE, 1.0 - CLEARANCE, CLEARANCE))
        {
            return Err((LoopFault::Leaves, Some(p.middle())));
        }
        let corners: Vec<Uv> = pieces.iter().flat_map(|p| p.points).collect();
        let [low, high] = uv_bounds(&corners);
        Ok(CertifiedLoop { pieces, low, high })
    }

    /// The signed area of the polygon of chords, positive for a counter-clockwise loop.
    fn area(&self) -> f64 {
        let cross = |p: &BezierPiece| p.start().x * p.end().y - p.end().x * p.start().y;
        0.5 * self.pieces.iter().map(cross).sum::<f64>()
    }

    /// Whether a point that does not lie on the loop is inside it.
    fn holds(&self, p: Uv) -> bool {
        let boxed = self.low.x < p.x && p.x < self.high.x && self.low.y < p.y && p.y < self.high.y;
        boxed && self.pieces.iter().filter(|piece| piece.ray_crosses(p, CLEARANCE)).count() % 2 == 1
    }
}

/// Divides pieces until each turns little and neighbours meet only at their common end.
fn simple(pieces: Vec<BezierPiece>) -> Result<Vec<BezierPiece>, LocatedFault> {
    let mut todo: Vec<BezierPiece> = pieces.into_iter().rev().collect();
    let mut done: Vec<BezierPiece> = Vec::with_capacity(todo.len());
    while let Some(piece) = todo.pop() {
        let fine = piece.turns_little();
        let joined = done.last().is_none_or(|before| run_on(before, &piece));
        if fine && joined {
            done.push(piece);
        } else if piece.length() < CLEARANCE {
            return Err((LoopFault::Cusp, Some(piece.middle())));
        } else {
            todo.extend(piece.split().into_iter().rev());
            // At a sharp corner the pieces on both sides have to be divided.
            if fine && let Some(before) = done.pop() {
                todo.extend(before.split().into_iter().rev());
            }
        }
    }
    close(done)
}

/// Does the same for the last piece and the first.
fn close(mut pieces: Vec<BezierPiece>) -> Result<Vec<BezierPiece>, LocatedFault> {
    while pieces.len() < 2 || !run_on(&pieces[pieces.len() - 1], &pieces[0]) {
        let Some(last) = pieces.pop() else { return Err((LoopFault::Open, None)) };
        if last.length() < CLEARANCE {
            return Err((LoopFault::Cusp, Some(last.middle())));
        }
        pieces.extend(last.split());
        let first = pieces.remove(0).split();
        pieces.splice(0..0, first);
    }
    Ok(pieces)
}

/// The required position of a loop among the other loops.
#[derive(Debug, Clone, Default)]
pub(crate) struct Nest {
    /// The loops that contain this one. No other loop may contain it.
    pub around: Vec<usize>,
    /// Whether the loop runs clockwise, around a hole, or counter-clockwise, around a face.
    pub clockwise: bool,
}

/// The loops with the wrong direction or in the wrong position. No two loops may cross.
pub(crate) fn misplaced(outlines: &[&CertifiedLoop], nests: &[Nest]) -> Vec<(usize, LocatedFault)> {
    let mut found = Vec::new();
    for (i, (outline, nest)) in outlines.iter().zip(nests).enumerate() {
        let area = outline.area();
        if area == 0.0 || (area < 0.0) != nest.clockwise {
            found.push((i, (LoopFault::WrongWay, None)));
        }
        let start = outline.pieces[0].start();
        let wrong = |(j, other): (usize, &&CertifiedLoop)| {
            j != i && other.holds(start) != nest.around.contains(&j)
        };
        if outlines.iter().enumerate().any(wrong) {
            found.push((i, (LoopFault::Misplaced, None)));
        }
    }
    found
}

/// The places where loops come too near to each other or to themselves, as the position of the loop
/// in `outlines` and the fault.
pub fn crossings(outlines: &[&CertifiedLoop]) -> Vec<(usize, LocatedFault)> {
    let mut order: Vec<PieceEntry> = Vec::new();
    for (ring, outline) in outlines.iter().enumerate() {
        let entry = |(number, piece)| PieceEntry::new(ring, number, piece);
        order.extend(outline.pieces.iter().enumerate().map(entry));
    }
    order.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
    let mut found = Vec::new();
    // Only pieces whose boxes overlap can come too near.
    let place =
        |(k, e): (usize, &PieceEntry)| GeomWithData::new(Rectangle::from_aabb(e.within(0.0)), k);
    let tree = RTree::bulk_load(order.iter().enumerate().map(place).collect());
    let mut near: Vec<usize> = Vec::new();
    for (k, a) in order.iter().enumerate() {
        let met = tree.locate_in_envelope_intersecting(a.within(CLEARANCE));
        near.clear();
        near.extend(met.map(|other| other.data).filter(|&other| other > k));
        near.sort_unstable();
        for b in near.iter().map(|&other| &order[other]) {
            let count = outlines[a.ring].pieces.len();
            let next = a.ring == b.ring && [1, count - 1].contains(&a.number.abs_diff(b.number));
            if next || a.piece.is_apart(b.piece, CLEARANCE, CLEARANCE) {
                continue;
            }
            let same = a.ring == b.ring;
            let fault = if same { LoopFault::CrossesItself } else { LoopFault::CrossesAnother };
            found.extend([a, b].map(|e| (e.ring, (fault, Some(e.piece.middle())))));
        }
    }
    found
}

/// A piece among those of all loops, with its bounding box.
struct PieceEntry<'a> {
    ring: usize,
    number: usize,
    piece: &'a BezierPiece,
    low: Uv,
    high: Uv,
}

impl<'a> PieceEntry<'a> {
    fn new(ring: usize, number: usize, piece: &'a BezierPiece) -> Self {
        let [low, high] = piece.bounds();
        PieceEntry { ring, number, piece, low, high }
    }

    /// The bounding box, enlarged by a margin on every side.
    fn within(&self, margin: f64) -> AABB<[f64; 2]> {
        let (low, high) = (self.low, self.high);
        AABB::from_corners([low.x - margin, low.y - margin], [high.x + margin, high.y + margin])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::UvVector;

    fn ring(points: &[(f64, f64)]) -> Vec<Curve<2>> {
        let n = points.len();
        let at = |i: usize| UvVector::new(points[i % n].0, points[i % n].1);
        let third = |i: usize, k: usize| at(i).lerp(&at(i + 1), k as f64 / 3.0);
        let knots = |i: usize| [i as f64 / n as f64, (i + 1) as f64 / n as f64];
        (0..n)
            .map(|i| {
                let knots = super::super::KnotVector::clamped(3, &knots(i), 1);
                Curve::new(knots, (0..4).map(|k| third(i, k)).collect())
            })
            .collect()
    }

    /// A clockwise square, or one in the opposite direction.
    fn square(u: f64, r: f64, clockwise: bool) -> CertifiedLoop {
        let mut corners = [(-r, -r), (-r, r), (r, r), (r, -r)];
        if !clockwise {
            corners.reverse();
        }
        CertifiedLoop::new(&ring(&corners.map(|(x, y)| (u + x, 0.5 + y)))).unwrap()
    }

    #[test]
    fn islands_run_the_other_way_within_their_holes() {
        let fault = |u: f64, r: f64, clockwise, around: &[usize]| {
            let loops = [square(0.3, 0.2, true), square(0.8, 0.1, true), square(u, r, clockwise)];
            let loops = [&loops[0], &loops[1], &loops[2]];
            let nest = |around: &[usize]| Nest {
                around: around.to_vec(),
                clockwise: around.len().is_multiple_of(2),
            };
            let nests = [nest(&[]), nest(&[]), nest(around)];
            !crossings(&loops).is_empty() || !misplaced(&loops, &nests).is_empty()
        };
        assert!(!fault(0.3, 0.1, false, &[0]));
        assert!(fault(0.3, 0.1, true, &[0]), "clockwise");
        assert!(fault(0.6, 0.02, false, &[0]), "in no hole");
        assert!(fault(0.8, 0.02, false, &[0]), "in another one");
        assert!(fault(0.45, 0.1, false, &[0]), "across a rim");
        assert!(fault(0.3, 0.1, true, &[]), "a hole in a hole");
        assert!(fault(0.52, 0.02 + 1e-12, true, &[]), "touching a rim");
        assert!(!fault(0.52, 0.02 - 1e-7, true, &[]), "beside a rim");
        assert!(!fault(0.6, 0.02, true, &[]));
    }

    #[test]
    fn loops_that_cross_themselves_or_the_edge_are_found() {
        let eight = ring(&[(0.2, 0.2), (0.8, 0.8), (0.8, 0.2), (0.2, 0.8)]);
        let eight = CertifiedLoop::new(&eight).unwrap();
        assert_eq!(crossings(&[&eight])[0].1.0, LoopFault::CrossesItself);
        let spike = ring(&[(0.2, 0.2), (0.8, 0.2), (0.5, 0.2)]);
        assert_eq!(CertifiedLoop::new(&spike).unwrap_err().0, LoopFault::Cusp);
        let beyond = ring(&[(0.2, 0.2), (0.2, 1.0), (0.8, 0.2)]);
        assert_eq!(CertifiedLoop::new(&beyond).unwrap_err().0, LoopFault::Leaves);
        let open = &ring(&[(0.2, 0.2), (0.2, 0.9), (0.8, 0.2)])[..2];
        assert_eq!(CertifiedLoop::new(open).unwrap_err().0, LoopFault::Open);
    }

    #[test]
    fn a_point_between_a_curve_and_its_chord_is_inside() {
        let knots = super::super::KnotVector::clamped(3, &[0.0, 1.0], 1);
        let arc = |y: f64, from: f64| {
            let (a, b) = (UvVector::new(from, 0.5), UvVector::new(1.0 - from, 0.5));
            let (p, q) = (UvVector::new(from, 0.5 + y), UvVector::new(1.0 - from, 0.5 + y));
            Curve::new(knots.clone(), vec![a, p, q, b])
        };
        let lens = CertifiedLoop::new(&[arc(0.4, 0.3), arc(-0.4, 0.7)]).unwrap();
        // The top of the arc is at 0.5 + 3/4 · 0.4.
        assert!(lens.holds(Uv::new(0.5, 0.7999)) && !lens.holds(Uv::new(0.5, 0.8001)));
        assert!(lens.area() < 0.0);
    }
}
