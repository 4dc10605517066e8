//! Scans that are far from zero, as those in the coordinates of a map projection are. CAD programs lose their
//! last digits there. Round numbers are taken off, so that a part has the same positions wherever it is.

use crate::Soup;

/// A scan with a coordinate beyond this, in millimetres, is far from zero: a kilometre is
/// more than any part measures, and less than any map projection's coordinates.
pub(crate) const LARGE_MM: f64 = 1e6;

/// The origin of a far scan is a power of ten that is at least so many of its extents, times a
/// whole number. So a part has the same positions whether or not round numbers moved it.
const ROUND: f64 = 10.0;

/// The most digits after the point that coordinates are looked for. Nobody measures finer.
const MOST_DIGITS: i32 = 9;

/// So many numbers of 53 bits at least must lie between two numbers of as many digits. Then it is no
/// accident if all coordinates are numbers of so many digits.
const BETWEEN: f64 = 16.0;

impl Soup {
    /// The point from which its coordinates are measured best, in its own unit, which has so many `mm`. It
    /// is zero unless a coordinate of a polygon is beyond a kilometre. Then it is a round number
    /// near the middle, as that of a far cloud ([`Points::origin`](crate::Points::origin)).
    pub fn round_origin(&self, mm: f64) -> [f64; 3] {
        let is_large = |xyz: &[f64; 3]| xyz.iter().any(|x| (x * mm).abs() > LARGE_MM);
        if !self.points.iter().any(is_large) {
            return [0.0; 3];
        }
        let used = self.polygons.iter().flatten();
        let corners = used.filter_map(|&corner| self.points.get(corner as usize));
        let [low, high] = bounds(corners.filter(|xyz| xyz.iter().all(|x| x.is_finite())));
        let bounds = [0, 1, 2].map(|axis| [low[axis], high[axis]]);
        if !bounds.iter().flatten().any(|x| x.is_finite() && (x * mm).abs() > LARGE_MM) {
            return [0.0; 3];
        }
        let extent = bounds.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
        bounds.map(|bounds| origin_of_axis(bounds, extent))
    }

    /// Its points relative to an origin of whole numbers, without a loss of digits where all are decimal numbers.
    pub fn relative_to(&self, origin: [f64; 3]) -> Vec<[f64; 3]> {
        let mut points = self.points.clone();
        match decimal_power(points.as_flattened().iter().copied()) {
            Some(power) => take_off_decimals(&mut points, origin, power),
            None => {
                for point in &mut points {
                    *point = [0, 1, 2].map(|axis| point[axis] - origin[axis]);
                }
            }
        }
        points
    }
}

/// The least and the greatest coordinates of all axes. All are finite, so that a comparison is
/// enough, which takes half the time of `f64::min`.
pub(crate) fn bounds<'a>(positions: impl IntoIterator<Item = &'a [f64; 3]>) -> [[f64; 3]; 2] {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for position in positions {
        for axis in 0..3 {
            let x = position[axis];
            low[axis] = if x < low[axis] { x } else { low[axis] };
            high[axis] = if x > high[axis] { x } else { high[axis] };
        }
    }
    [low, high]
}

/// About the middle of an axis, or zero if some coordinates would lose digits by taking it off. (The
/// difference of two numbers is exact if neither is more than twice the other: Sterbenz's lemma.)
pub(crate) fn origin_of_axis([low, high]: [f64; 2], extent: f64) -> f64 {
    let step = 10f64.powf((ROUND * extent).log10().ceil()).max(1.0);
    let origin = ((low / 2.0 + high / 2.0) / step).round() * step;
    let [nearest, farthest] = if origin < 0.0 { [-high, -low] } else { [low, high] };
    let exact = origin.abs() / 2.0 <= nearest && farthest <= 2.0 * origin.abs();
    if exact { origin } else { 0.0 }
}

/// The power of ten by which all these coordinates become whole numbers, but for the error of a number of
/// 53 bits, if there is one.
pub(crate) fn decimal_power(coordinates: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let reach = coordinates.clone().fold(1.0, |reach: f64, x| reach.max(x.abs()));
    let is_whole = |x: f64, power: f64| {
        let scaled = x * power;
        (scaled - rounded(scaled)).abs() <= scaled.abs() * f64::EPSILON
    };
    let powers = (0..=MOST_DIGITS).map(|digits| 10f64.powi(digits));
    let mut powers = powers.take_while(|power| BETWEEN * reach * power * f64::EPSILON < 1.0);
    powers.find(|&power| coordinates.clone().all(|x| is_whole(x, power)))
}

/// Makes decimal numbers relative to an origin. The difference of two numbers has the error of the
/// larger one. That of their digits has not, so that the cloud is the same wherever it is.
pub(crate) fn take_off_decimals(positions: &mut [[f64; 3]], origin: [f64; 3], power: f64) {
    for axis in (0..3).filter(|&axis| origin[axis] != 0.0) {
        let whole = origin[axis] * power;
        for position in &mut *positions {
            position[axis] = (rounded(position[axis] * power) - whole) / power;
        }
    }
}

/// The nearest whole number to a number of less than 51 bits before the point. Without a call it takes
/// a tenth of the time of `f64::round`.
fn rounded(x: f64) -> f64 {
    const SHIFT: f64 = 1.5 * (1u64 << 52) as f64;
    (x + SHIFT) - SHIFT
}
