//! The curves of edges: lines, arcs of circles and ellipses through exact points, else cubic B-splines.

use std::f64::consts::TAU;

use formats::brep::{BrepCurve, Frame};
use nalgebra::{DMatrix, Matrix2, Vector2};

use super::chart::{array, vector};
use super::followed::{followed, led_curve};
use super::hermite::through;
use super::network::Chain;
use crate::geometry::{Point, Vector};
use crate::primitives::contact::{contact, crossing};
use crate::primitives::{Primitive, PrimitiveKind};

/// A conic fits exact points to this share of its size: rounding of the steps of its fit.
const FITS: f64 = 1e-8;

/// A curve of an elementary kind lies on both surfaces within so many mm, half of what files may state.
const LIES: f64 = 5e-7;

/// A spline lies on both surfaces within so many mm, a fifth of the kernels' precision.
pub(super) const SPLINE: f64 = 2e-8;

/// The most points of a spline.
pub(super) const MOST_POINTS: usize = 1500;

/// So often a spline gets more points. Each time halves the pieces that are too far off, and divides their error by sixteen. What is
/// left after so many is beside a vertex that is off the surfaces.
pub(super) const MOST_ROUNDS: usize = 20;

/// The fewest exact points of a chain: enough for an ellipse and its check.
const FEWEST_POINTS: usize = 24;

/// The parts of a curve between the points where it is compared with its surfaces.
const SAMPLES: usize = 32;

/// The points that a conic is fitted to. All points are compared with it.
const FITTED: usize = 48;

/// How a curve is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SeamKind {
    /// Two surfaces cross.
    Crosses,
    /// Two surfaces touch.
    Touches,
    /// Through the points of the chain, on the only surface beside it.
    Follows,
    /// Through the points of the chain, as no surface is known beside it.
    Loose,
}

/// The surfaces of a chain.
pub(super) struct Pair<'a> {
    pub a: &'a Primitive,
    pub b: &'a Primitive,
    pub kind: SeamKind,
    /// The largest distance of a led curve from the chords of its points, if that is known.
    pub most_sagitta: Option<f64>,
}

impl Pair<'_> {
    fn is_flat(&self) -> bool {
        !self.is_led() && [self.a, self.b].iter().all(|s| s.kind() == PrimitiveKind::Plane)
    }

    /// Whether the curve runs through the points of its chain.
    pub(super) fn is_led(&self) -> bool {
        matches!(self.kind, SeamKind::Follows | SeamKind::Loose)
    }

    pub(super) fn project(&self, p: Point) -> Point {
        match self.kind {
            SeamKind::Loose => p,
            SeamKind::Follows => self.a.closest(p),
            _ if self.is_flat() => p,
            SeamKind::Touches => contact(self.a, self.b, p),
            SeamKind::Crosses => crossing(self.a, self.b, p),
        }
    }

    /// The normal of the surface that a curve follows.
    pub(super) fn normal(&self, p: Point) -> Option<Vector> {
        (self.kind == SeamKind::Follows).then(|| self.a.normal(p))
    }

    fn off(&self, p: Point) -> f64 {
        match self.kind {
            SeamKind::Loose => 0.0,
            _ => self.a.distance(p).0.abs().max(self.b.distance(p).0.abs()),
        }
    }

    /// Replaces the points of a chain by more of them on both surfaces. The ends stay if they are vertices.
    pub(super) fn refine(&self, chain: &mut Chain) -> Result<(), String> {
        if self.is_flat() {
            let (Some(first), Some(last)) = (chain.points.first(), chain.points.last()) else {
                return Err("an empty chain".into());
            };
            chain.points = vec![*first, *last];
            return if chain.ends.is_none() { Err("a ring between planes".into()) } else { Ok(()) };
        }
        if chain.points.len() < 2 {
            return Err("a border without a length".into());
        }
        let n = chain.points.len() - 1;
        if self.is_led() {
            chain.points[1..n].iter_mut().for_each(|p| *p = self.project(*p));
            return Ok(());
        }
        let parts = FEWEST_POINTS.div_ceil(n);
        let mut points = Vec::with_capacity(n * parts + 1);
        let mut size: f64 = 0.0;
        for pair in chain.points.windows(2) {
            size = size.max((pair[1] - chain.points[0]).norm());
            for k in 0..parts {
                points
                    .push(self.project(pair[0] + (pair[1] - pair[0]) * (k as f64 / parts as f64)));
            }
        }
        points.push(points[0]);
        if chain.ends.is_some() {
            points[0] = chain.points[0];
            points[n * parts] = chain.points[n];
        }
        for (i, p) in points.iter().enumerate() {
            let moved = (p - chain.points[i / parts]).norm();
            // A point that leaves the chain by more than its length is on another branch.
            if moved >= size || !p.coords.iter().all(|x| x.is_finite()) {
                return Err("a border whose points leave it".into());
            }
        }
        chain.points = points;
        Ok(())
    }

    /// The curve through the points of a chain, and how far it is from the surfaces.
    pub(super) fn curve(&self, chain: &Chain) -> Result<(BrepCurve, f64), String> {
        let points = &chain.points;
        let (first, last) = (points[0], points[points.len() - 1]);
        if self.is_flat() {
            let curve = BrepCurve::line(array(first), array(last))?;
            let off = self.worst(&curve);
            return Ok((curve, off));
        }
        let off = points.iter().map(|&p| self.off(p)).fold(0.0, f64::max);
        let lies = LIES.max(3.0 * off);
        if self.is_led() {
            let chord = BrepCurve::line(array(first), array(last))?;
            let along = (last - first).normalize();
            let aside = |p: &Point| along.cross(&(p - first)).norm();
            let worst = self.worst(&chord);
            if points.iter().map(aside).fold(worst, f64::max) <= SPLINE {
                return Ok((chord, worst));
            }
            if self.kind == SeamKind::Follows && self.a.kind() != PrimitiveKind::Plane {
                return followed(self.a, points, chain.tangents, self.most_sagitta);
            }
            let curve = led_curve(points, chain.tangents, self.most_sagitta)?;
            return Ok((BrepCurve::Spline(curve), off));
        }
        if let Some(curve) = elementary(points, chain.is_closed(), off)
            && self.worst(&curve) <= lies
        {
            let worst = self.worst(&curve);
            return Ok((curve, worst));
        }
        self.spline(points.clone(), chain.is_closed())
    }

    /// The same. A curve that is nearly an arc becomes a spline where the arc is too far from the surfaces.
    pub(super) fn curve_within(
        &self,
        chain: &Chain,
        limit: f64,
    ) -> Result<(BrepCurve, f64), String> {
        let found = self.curve(chain)?;
        if found.1 < limit || self.is_flat() {
            return Ok(found);
        }
        let spline = self.spline(chain.points.clone(), chain.is_closed());
        Ok(spline.ok().filter(|spline| spline.1 < found.1).unwrap_or(found))
    }

    /// The largest distance of a curve from its surfaces.
    pub(super) fn worst(&self, curve: &BrepCurve) -> f64 {
        samples(curve).map(|p| self.off(p)).fold(0.0, f64::max)
    }

    /// Where a curve is farthest from its surfaces.
    pub(super) fn worst_place(&self, curve: &BrepCurve) -> Point {
        let worst = samples(curve).max_by(|p, q| self.off(*p).total_cmp(&self.off(*q)));
        worst.unwrap_or_default()
    }

    /// The largest distance of a curve from those of its surfaces that are planes.
    pub(super) fn off_planes(&self, curve: &BrepCurve) -> f64 {
        let is_plane = |of: &&Primitive| of.kind() == PrimitiveKind::Plane;
        let off =
            |of: &Primitive| samples(curve).map(|p| of.distance(p).0.abs()).fold(0.0, f64::max);
        [self.a, self.b].into_iter().filter(is_plane).map(off).fold(0.0, f64::max)
    }

    fn spline(&self, points: Vec<Point>, is_closed: bool) -> Result<(BrepCurve, f64), String> {
        let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
        let last = points[points.len() - 1];
        // Points that nearly coincide would make the spline swing.
        let mut kept = vec![points[0]];
        for &p in &points[1..points.len() - 1] {
            let is_apart = |q: &Point| (p - q).norm() > 1e-3 * size;
            if kept.last().is_none_or(is_apart) && is_apart(&last) {
                kept.push(p);
            }
        }
        kept.push(last);
        onwards(&mut kept);
        let mut rounds = 0;
        loop {
            rounds += 1;
            let mut t = vec![0.0];
            for pair in kept.windows(2) {
                t.push(t[t.len() - 1] + (pair[1] - pair[0]).norm());
            }
            let places: Vec<[f64; 3]> = kept.iter().map(|&p| array(p)).collect();
            let spline = through(&t, &places, is_closed)?;
            let mut worst: f64 = 0.0;
            let mut finer = vec![kept[0]];
            for i in 0..t.len() - 1 {
                let middle = Point::from(spline.point(0.5 * (t[i] + t[i + 1])));
                let off = self.off(middle);
                worst = worst.max(off);
                let ends = [kept[i], kept[i + 1]];
                // More points do not mend what an end is off.
                if off > SPLINE && ends.iter().all(|&end| off > self.off(end)) {
                    // Where surfaces hardly cross, the next point of both may lie behind an end.
                    let there = self.project(middle);
                    finer
                        .extend(Some(there).filter(|&there| is_onwards([ends[0], there, ends[1]])));
                }
                finer.push(kept[i + 1]);
            }
            let is_done = finer.len() == kept.len() || finer.len() > MOST_POINTS;
            if is_done || rounds == MOST_ROUNDS {
                return Ok((BrepCurve::Spline(spline), worst));
            }
            kept = finer;
        }
    }
}

/// Drops points from which the next one lies back: a curve through them would have a cusp.
fn onwards(points: &mut Vec<Point>) {
    let mut k = 1;
    while k + 1 < points.len() {
        if is_onwards([points[k - 1], points[k], points[k + 1]]) {
            k += 1;
        } else {
            points.remove(k);
            k = (k - 1).max(1);
        }
    }
}

/// Whether the way from the first to the last point passes the second one without turning back.
fn is_onwards([before, at, next]: [Point; 3]) -> bool {
    (at - before).dot(&(next - at)) >= 0.0
}

/// Points along a curve.
fn samples(curve: &BrepCurve) -> impl Iterator<Item = Point> + '_ {
    let (start, end) = curve.range();
    (0..=SAMPLES)
        .map(move |i| Point::from(curve.point(start + (end - start) * i as f64 / SAMPLES as f64)))
}

/// The line or the arc through points, if there is one.
fn elementary(points: &[Point], is_closed: bool, off: f64) -> Option<BrepCurve> {
    let n = points.len();
    let step = n.div_ceil(FITTED).max(1);
    let mut some: Vec<Point> = points.iter().copied().step_by(step).collect();
    some.push(points[n - 1]);
    let count = some.len();
    let centre = some.iter().map(|p| p.coords).sum::<Vector>() / count as f64;
    let rows = DMatrix::from_fn(count, 3, |i, k| some[i][k] - centre[k]);
    let svd = rows.svd(false, true);
    let axes = svd.v_t.as_ref()?;
    let axis = |k: usize| Vector::new(axes[(k, 0)], axes[(k, 1)], axes[(k, 2)]);
    let scale = (svd.singular_values[0] / (count as f64).sqrt()).max(1.0);
    let tolerance = (FITS * scale).max(2.0 * off);
    let spread = |k: usize| svd.singular_values[k] / (count as f64).sqrt();
    if spread(1) < tolerance && !is_closed {
        return BrepCurve::line(array(points[0]), array(points[n - 1])).ok();
    }
    if spread(2) > tolerance {
        return None;
    }
    let (x, y) = (axis(0), axis(1));
    let flat = |p: &Point| {
        let q = p.coords - centre;
        Vector2::new(q.dot(&x), q.dot(&y))
    };
    let flats: Vec<Vector2<f64>> = some.iter().map(flat).collect();
    let arc = circle(&flats, tolerance).or_else(|| ellipse(&flats))?;
    let placed = |v: Vector2<f64>| v.x * x + v.y * y;
    let middle = Point::from(centre + placed(arc.centre));
    arc_through(points, is_closed, middle, placed(arc.x), placed(arc.y), arc.radii)
}

/// An ellipse or a circle in a plane.
pub(super) struct PlaneArc {
    pub centre: Vector2<f64>,
    x: Vector2<f64>,
    y: Vector2<f64>,
    pub radii: [f64; 2],
}

/// The circle through points of a plane (Kåsa's fit, which is exact for exact points).
pub(super) fn circle(points: &[Vector2<f64>], tolerance: f64) -> Option<PlaneArc> {
    let scale = points.iter().map(|p| p.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let rows = DMatrix::from_fn(points.len(), 3, |i, k| match k {
        2 => 1.0,
        _ => 2.0 * points[i][k] / scale,
    });
    let right =
        DMatrix::from_fn(points.len(), 1, |i, _| points[i].norm_squared() / (scale * scale));
    let found = rows.svd(true, true).solve(&right, 1e-14).ok()?;
    let centre = Vector2::new(found[0], found[1]);
    let square = found[2] + centre.norm_squared();
    let (centre, radius) = (centre * scale, square.max(0.0).sqrt() * scale);
    let fits = points.iter().all(|p| ((p - centre).norm() - radius).abs() < tolerance);
    fits.then(|| PlaneArc { centre, x: Vector2::x(), y: Vector2::y(), radii: [radius; 2] })
}

/// The ellipse through points of a plane (least algebraic distance).
fn ellipse(points: &[Vector2<f64>]) -> Option<PlaneArc> {
    let scale = points.iter().map(|p| p.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let rows = DMatrix::from_fn(points.len(), 6, |i, k| {
        let p = points[i] / scale;
        [p.x * p.x, p.x * p.y, p.y * p.y, p.x, p.y, 1.0][k]
    });
    let svd = rows.svd(false, true);
    let v = svd.v_t?;
    let w: Vec<f64> = (0..6).map(|k| v[(5, k)]).collect();
    let form = Matrix2::new(w[0], 0.5 * w[1], 0.5 * w[1], w[2]);
    // Almost parabolic conics have no centre that is known well.
    if form.determinant() <= 1e-9 * form.norm_squared() {
        return None;
    }
    let centre = (2.0 * form).try_inverse()? * -Vector2::new(w[3], w[4]);
    let rest = (centre.transpose() * form * centre)[0] + w[3] * centre.x + w[4] * centre.y + w[5];
    let eigen = form.symmetric_eigen();
    let squares = eigen.eigenvalues.map(|e| -rest / e);
    if squares.min() <= 0.0 {
        return None;
    }
    let long = squares.imax();
    let x: Vector2<f64> = eigen.eigenvectors.column(long).into();
    let radii = [squares[long].sqrt() * scale, squares[1 - long].sqrt() * scale];
    Some(PlaneArc { centre: centre * scale, x, y: Vector2::new(-x.y, x.x), radii })
}

/// The arc from the first to the last point through all of them.
fn arc_through(
    points: &[Point],
    is_closed: bool,
    centre: Point,
    x: Vector,
    mut y: Vector,
    radii: [f64; 2],
) -> Option<BrepCurve> {
    let angle = |p: &Point, y: Vector| {
        let q = p - centre;
        (q.dot(&y) / radii[1]).atan2(q.dot(&x) / radii[0])
    };
    let total = |y: Vector| -> f64 {
        let turns =
            points.windows(2).map(|w| super::chart::around(angle(&w[1], y) - angle(&w[0], y)));
        turns.sum()
    };
    let mut turn = total(y);
    if turn < 0.0 {
        y = -y;
        turn = -turn;
    }
    if is_closed {
        turn = TAU;
    }
    if turn > TAU + 1e-9 {
        return None;
    }
    let z = x.cross(&y);
    let start = angle(&points[0], y);
    if radii[0] == radii[1] {
        let towards = start.cos() * x + start.sin() * y;
        let frame = Frame::new(array(centre), vector(z), vector(towards)).ok()?;
        return BrepCurve::arc(&frame, radii[0], turn.min(TAU)).ok();
    }
    let frame = Frame::new(array(centre), vector(z), vector(x)).ok()?;
    let mut start = start.rem_euclid(TAU);
    if start >= TAU || TAU - start < 1e-12 {
        start = 0.0;
    }
    let mut end = start + turn;
    if end - start > TAU {
        end = start + TAU;
        while end - start > TAU {
            end = end.next_down();
        }
    }
    BrepCurve::ellipse(&frame, radii, (start, end)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_from_which_the_next_one_lies_back_are_dropped() {
        let at = |x: f64| Point::new(x, 0.1 * x * x, 0.0);
        let mut points = [0.0, 1.0, 2.0, 3.2, 3.1, 3.0].map(at).to_vec();
        onwards(&mut points);
        assert_eq!(points, [0.0, 1.0, 2.0, 3.0].map(at));
    }
}
