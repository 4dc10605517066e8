//! The sizes of exact faces: how exactly a scan tells them, which ones are round, and how far parallel planes are from each other.

use crate::convert::{ExactFit, FaceSize};
use crate::geometry::Vector;
use crate::primitives::{Primitive, Uncertainty};
use crate::stages::sharpen::{Size, SizeKind};
use crate::words::significant;

/// The standard deviations of the parameters of a surface of a scan. Those that its kind does not have are `None`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct UncertaintyFigures {
    /// Of the place: of a plane along its normal, of a sphere and a torus that of the centre, and of others that of the axis. The
    /// direction in which it is largest counts.
    pub place_mm: f64,
    /// Of the normal or the axis.
    pub direction_deg: Option<f64>,
    /// Of the radius. Of a torus it is that of its circle.
    pub radius_mm: Option<f64>,
    /// Of the radius of the tube of a torus.
    pub tube_radius_mm: Option<f64>,
    /// Of the angle between the axis of a cone and its generators.
    pub half_angle_deg: Option<f64>,
}

/// A size that is round within two standard deviations.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct SizeFigures {
    /// "radius", "circle radius" of a torus, "half angle" or "distance" of parallel planes.
    pub size: &'static str,
    /// The faces that have it. Of a distance the two planes.
    pub faces: Vec<usize>,
    /// "mm" or "°".
    pub unit: &'static str,
    /// The value that the scan tells.
    pub value: f64,
    /// Its standard deviation.
    pub standard_deviation: f64,
    /// The round number.
    pub round: f64,
    /// Whether the faces have it: `--regularize` makes them so.
    pub taken: bool,
}

/// The distance of two parallel planes that follow each other.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct PlaneDistanceFigures {
    /// The planes.
    pub faces: [usize; 2],
    /// How far they are from each other.
    pub distance_mm: f64,
    /// The standard deviation, if the faces are those of a scan.
    pub standard_deviation_mm: Option<f64>,
}

impl UncertaintyFigures {
    pub(super) fn of(surface: &Primitive, of: &Uncertainty) -> Self {
        let is_torus = matches!(surface, Primitive::Torus { .. });
        let (radius_mm, tube_radius_mm) =
            if is_torus { (of.major, of.radius) } else { (of.radius, None) };
        UncertaintyFigures {
            place_mm: of.place,
            direction_deg: of.direction.map(f64::to_degrees),
            radius_mm,
            tube_radius_mm,
            half_angle_deg: of.angle.map(f64::to_degrees),
        }
    }
}

impl SizeFigures {
    pub(super) fn of(of: &FaceSize) -> Self {
        let (size, unit, factor) = match of.kind {
            SizeKind::Own(Size::Radius) => ("radius", "mm", 1.0),
            SizeKind::Own(Size::MajorRadius) => ("circle radius", "mm", 1.0),
            SizeKind::Own(Size::HalfAngle) => ("half angle", "°", 1.0_f64.to_degrees()),
            SizeKind::Distance(_) => ("distance", "mm", 1.0),
        };
        // The side on which a plane is has no meaning for its distance.
        SizeFigures {
            size,
            faces: of.faces.clone(),
            unit,
            value: (factor * of.value).abs(),
            standard_deviation: factor * of.deviation,
            round: (factor * of.round).abs(),
            taken: of.is_taken,
        }
    }

    /// In words: "radius 2.496 mm ± 0.004 is 2.5".
    pub fn phrase(&self) -> String {
        let [value, deviation] = [self.value, self.standard_deviation].map(significant);
        let round = self.round;
        format!("{} {value} {} ± {deviation} is {round}", self.size, self.unit)
    }
}

/// Directions are parallel to this sine. Conditions are met, and snaps made, more exactly.
const PARALLEL: f64 = 1e-9;

/// Planes that are so near to each other, in mm, are one: modelling kernels tell no more.
const ONE: f64 = 1e-6;

/// The distances of parallel planes, each to the next one of its direction.
pub(super) fn distances(fit: &ExactFit) -> Vec<PlaneDistanceFigures> {
    let mut directions: Vec<(Vector, Vec<(f64, usize)>)> = Vec::new();
    for (number, face) in fit.faces.iter().enumerate().filter(|(_, face)| !face.is_facet) {
        let Primitive::Plane { origin, normal } = face.surface else { continue };
        let known = directions.iter_mut().find(|of| of.0.cross(&normal).norm() <= PARALLEL);
        let own = (origin.coords.dot(&normal), number);
        match known {
            Some((axis, planes)) => planes.push((origin.coords.dot(axis), number)),
            None => directions.push((normal, vec![own])),
        }
    }
    let mut found = Vec::new();
    for (_, mut planes) in directions {
        planes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        planes.dedup_by(|next, before| next.0 - before.0 <= ONE);
        for pair in planes.windows(2) {
            let faces = [pair[0].1, pair[1].1];
            let [a, b] = faces.map(|face| fit.faces[face].uncertainty.map(|of| of.place));
            found.push(PlaneDistanceFigures {
                faces,
                distance_mm: pair[1].0 - pair[0].0,
                standard_deviation_mm: a.zip(b).map(|(a, b)| a.hypot(b)),
            });
        }
    }
    found
}
