//! Sizes that a designer would have chosen: round radii, angles, and distances between parallel planes.

use super::Work;
use super::constraints::{Condition, ConditionKind, Size, apart, direction};
use super::surfaces::FittedSurface;
use crate::primitives::Primitive;
use crate::primitives::round_numbers::round;

/// A value is round if a round number is within so many standard deviations.
const GATE: f64 = 2.0;

/// Directions are parallel to this sine once the conditions are met, and lengths are equal to this share of an edge.
const SAME: f64 = 1e-9;

/// A size of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SizeKind {
    /// A size of one surface.
    Own(Size),
    /// The distance of another plane, which is parallel.
    Distance(usize),
}

/// A size that is round within two standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundSize {
    /// The number of the surface.
    pub surface: usize,
    /// What it is.
    pub kind: SizeKind,
    /// The value that the scan tells.
    pub value: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// The round number.
    pub round: f64,
    /// Whether the surfaces have it.
    pub is_taken: bool,
}

impl Work<'_> {
    /// The round sizes of the surfaces. `unit` is the length of the mesh's unit in that of the file.
    pub(super) fn round_sizes(&self, fits: &[FittedSurface], unit: f64) -> Vec<RoundSize> {
        let mut found = self.own_sizes(fits, unit);
        found.extend(self.distances(fits, unit));
        found
    }

    /// Radii and angles. Equal radii count once, with the surface that tells them best.
    fn own_sizes(&self, fits: &[FittedSurface], unit: f64) -> Vec<RoundSize> {
        let mut all: Vec<(f64, usize, Size, f64)> = Vec::new();
        for (r, fit) in fits.iter().enumerate() {
            let Some(of) = fit.uncertainty else { continue };
            let sizes = [
                (Size::Radius, of.radius),
                (Size::MajorRadius, of.major),
                (Size::HalfAngle, of.angle),
            ];
            for (size, deviation) in sizes {
                let value = size.of(self.surface(r as u32));
                all.extend(value.zip(deviation).map(|(value, own)| (own, r, size, value)));
            }
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut known: Vec<(Size, f64)> = Vec::new();
        let mut found = Vec::new();
        for (deviation, surface, size, value) in all {
            let near = SAME * self.edge;
            if known.iter().any(|of| of.0 == size && (of.1 - value).abs() <= near) {
                continue;
            }
            known.push((size, value));
            let rounded = match size {
                Size::HalfAngle => {
                    let gate = (GATE * deviation).to_degrees();
                    round(value.to_degrees(), gate, 1.0).map(f64::to_radians)
                }
                Size::Radius | Size::MajorRadius => round(value, GATE * deviation, unit),
            };
            let Some(round) = rounded.filter(|&round| round > 0.0) else { continue };
            let kind = SizeKind::Own(size);
            found.push(RoundSize { surface, kind, value, deviation, round, is_taken: false });
        }
        found
    }

    /// The distances of parallel planes from the best known one of their direction.
    fn distances(&self, fits: &[FittedSurface], unit: f64) -> Vec<RoundSize> {
        let is_plane = |&r: &usize| matches!(self.surface(r as u32), Primitive::Plane { .. });
        let deviation = |r: usize| fits[r].uncertainty.map(|of| of.place);
        let planes = (0..fits.len()).filter(is_plane);
        let mut planes: Vec<(f64, usize)> =
            planes.filter_map(|r| Some((deviation(r)?, r))).collect();
        planes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // For each direction the best known plane, and the distances from it.
        let mut known: Vec<(usize, f64, Vec<f64>)> = Vec::new();
        let mut found = Vec::new();
        for (own, r) in planes {
            let d = direction(self.surface(r as u32));
            let is_parallel =
                |datum: usize| direction(self.surface(datum as u32)).cross(&d).norm() <= SAME;
            let Some((datum, of_datum, values)) = known.iter_mut().find(|of| is_parallel(of.0))
            else {
                known.push((r, own, vec![0.0]));
                continue;
            };
            let value = apart(self.surface(*datum as u32), self.surface(r as u32));
            if values.iter().any(|of| (of - value).abs() <= SAME * self.edge) {
                continue;
            }
            values.push(value);
            let deviation = own.hypot(*of_datum);
            let Some(round) = round(value, GATE * deviation, unit) else { continue };
            if round != 0.0 {
                let (surface, kind) = (*datum, SizeKind::Distance(r));
                found.push(RoundSize { surface, kind, value, deviation, round, is_taken: false });
            }
        }
        found
    }

    /// Marks the sizes that the surfaces have.
    pub(super) fn mark_taken(&self, sizes: &mut [RoundSize]) {
        for of in sizes {
            let first = self.surface(of.surface as u32);
            let now = match of.kind {
                SizeKind::Own(size) => size.of(first),
                SizeKind::Distance(other) => Some(apart(first, self.surface(other as u32))),
            };
            of.is_taken = now.is_some_and(|now| (now - of.round).abs() <= SAME * self.edge);
        }
    }
}

impl RoundSize {
    /// The condition that makes the size round.
    pub(super) fn condition(&self) -> Condition {
        let (first, round) = (self.surface, self.round);
        match self.kind {
            SizeKind::Own(size) => {
                Condition { first, second: first, kind: ConditionKind::Sized(size, round) }
            }
            SizeKind::Distance(second) => {
                Condition { first, second, kind: ConditionKind::Apart(round) }
            }
        }
    }
}
