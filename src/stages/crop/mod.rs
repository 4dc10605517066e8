//! What is left out of a scan before anything else is done with it: what lies outside of a box or below a
//! plane, and the plane on which the object stands.
//!
//! Points go in, and whether each is kept comes out. The plane is found by random triples of points (Fischler and
//! Bolles, "Random sample consensus", 1981). The random numbers are the same in each run.

use nalgebra::Matrix3;

use crate::error::{Error, Result, of};
use crate::geometry::random::scattered;
use crate::geometry::{Point, Vector};
use crate::rules;
use crate::statistics::outlying;

/// What is kept of a scan. Places are in the scan's own numbers. By default everything is kept.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Options {
    /// Two opposite corners of a box. What is outside is left out.
    pub within: Option<[[f64; 3]; 2]>,
    /// A plane as `[a, b, c, d]`. Points are kept if a x + b y + c z > d.
    pub above: Option<[f64; 4]>,
    /// Whether the largest plane that has the rest of the scan on one side is left out, with all that is on its
    /// other side: the turntable.
    pub without_plane: bool,
}

/// The number of points that are looked at to find the plane.
const SAMPLES: usize = 20_000;

/// The number of random planes. A plane with a fifth of the points is missed once in 10⁴ scans:
/// (1 − 0.2³)¹²⁰⁰.
const TRIPLES: usize = 1200;

/// The share of the extent by which points of the plane may be off it, until the noise is known.
const NEAR: f64 = 0.005;

/// The rounds in which the plane is fitted again to the points that are near it.
const ROUNDS: usize = 4;

/// The least share of all points that lie in the plane, and the largest share of the others on its other side.
const LEAST: f64 = 0.05;
const OTHER_SIDE: f64 = 0.01;

/// A plane: a unit normal, and the distance of the plane from the origin along it.
#[derive(Debug, Clone, Copy)]
struct Plane {
    normal: Vector,
    offset: f64,
}

impl Options {
    /// Whether everything is kept.
    pub(crate) fn keeps_all(&self) -> bool {
        *self == Options::default()
    }

    pub(crate) fn check(&self) -> Result<()> {
        let corners = self.within.iter().flatten();
        corners.flatten().try_for_each(|&x| rules::finite(x)).map_err(of("within"))?;
        let numbers = self.above.iter().flatten();
        numbers.copied().try_for_each(rules::finite).map_err(of("above"))?;
        match self.above {
            Some([a, b, c, _]) if [a, b, c] == [0.0; 3] => Err(of("above")(rules::Fault::Point)),
            _ => Ok(()),
        }
    }
}

/// Whether each point is kept. `origin` is where the points are measured from.
///
/// # Errors
/// [`Error::Crop`] if nothing is kept, or if there is no plane that could be left out.
pub fn kept(points: &[[f64; 3]], origin: [f64; 3], options: &Options) -> Result<Vec<bool>> {
    let mut kept: Vec<bool> =
        points.iter().map(|p| options.has([0, 1, 2].map(|k| p[k] + origin[k]))).collect();
    let is_any_left = |kept: &[bool]| match kept.contains(&true) {
        true => Ok(()),
        false => Err(Error::Crop("nothing of the scan is left")),
    };
    is_any_left(&kept)?;
    if options.without_plane {
        let left = points.iter().zip(&kept).filter(|of| *of.1).map(|of| Point::from(*of.0));
        let (plane, near) = plane(&left.collect::<Vec<_>>())?;
        for (p, keeps) in points.iter().zip(&mut kept) {
            *keeps &= plane.height(&Point::from(*p)) > near;
        }
        is_any_left(&kept)?;
    }
    Ok(kept)
}

impl Options {
    /// Whether a place is in the box and above the plane.
    fn has(&self, p: [f64; 3]) -> bool {
        let inside = |[a, b]: [[f64; 3]; 2]| {
            (0..3).all(|k| (a[k].min(b[k])..=a[k].max(b[k])).contains(&p[k]))
        };
        let above = |[a, b, c, d]: [f64; 4]| a * p[0] + b * p[1] + c * p[2] > d;
        p.iter().all(|x| x.is_finite())
            && self.within.is_none_or(inside)
            && self.above.is_none_or(above)
    }
}

/// The largest plane that has the other points on one side, its normal on that side, and how far points of the
/// plane are from it at most. There is at least one point.
fn plane(points: &[Point]) -> Result<(Plane, f64)> {
    let step = points.len().div_ceil(SAMPLES).max(1);
    let sample: Vec<Point> = points.iter().step_by(step).copied().collect();
    let [low, high] = crate::geometry::bounds(sample.iter().copied());
    let mut near = NEAR * (high - low).norm();
    let mut random = 0;
    let triples = (0..TRIPLES).filter_map(|_| {
        Plane::through([0; 3].map(|_| {
            random += 1;
            sample[(scattered(random) % sample.len() as u64) as usize]
        }))
    });
    let best = triples.filter_map(|plane| plane.supporting(&sample, near)).max_by_key(|of| of.1);
    let (mut plane, _) =
        best.ok_or(Error::Crop("no plane has the rest of the scan on one side"))?;
    for _ in 0..ROUNDS {
        let own: Vec<Point> =
            sample.iter().filter(|p| plane.height(p).abs() <= near).copied().collect();
        let Some(fitted) = Plane::fitted(&own) else { break };
        plane = if fitted.normal.dot(&plane.normal) < 0.0 { fitted.turned() } else { fitted };
        let squares: f64 = own.iter().map(|p| plane.height(p).powi(2)).sum();
        // The rim of the object is smooth, and loses as much.
        near = near.min(outlying(points.len()) * (squares / own.len() as f64).sqrt());
    }
    Ok((plane, near))
}

impl Plane {
    fn through([a, b, c]: [Point; 3]) -> Option<Self> {
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
        Some(Plane { normal, offset: normal.dot(&a.coords) })
    }

    /// The plane of least squares.
    fn fitted(points: &[Point]) -> Option<Self> {
        if points.len() < 3 {
            return None;
        }
        let middle = points.iter().map(|p| p.coords).sum::<Vector>() / points.len() as f64;
        let spread: Matrix3<f64> =
            points.iter().map(|p| (p.coords - middle) * (p.coords - middle).transpose()).sum();
        let eigen = spread.symmetric_eigen();
        let normal: Vector = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into();
        Some(Plane { normal, offset: normal.dot(&middle) })
    }

    fn turned(self) -> Self {
        Plane { normal: -self.normal, offset: -self.offset }
    }

    fn height(&self, p: &Point) -> f64 {
        self.normal.dot(&p.coords) - self.offset
    }

    /// The plane with most points above it, and the number of points in it. `None` if it has too few points, or
    /// too many on both sides.
    fn supporting(self, points: &[Point], near: f64) -> Option<(Self, usize)> {
        let heights = || points.iter().map(|p| self.height(p));
        let own = heights().filter(|h| h.abs() <= near).count();
        let above = heights().filter(|&h| h > near).count();
        let below = points.len() - own - above;
        let few = OTHER_SIDE * (points.len() - own) as f64;
        let is_large = own as f64 >= LEAST * points.len() as f64 && above.max(below) > 0;
        let plane = if above >= below { self } else { self.turned() };
        (is_large && above.min(below) as f64 <= few).then_some((plane, own))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of radius 20 on a tilted table of 100 × 100, both with noise.
    fn ball_on_table() -> (Vec<[f64; 3]>, usize) {
        let mut points = Vec::new();
        let noise = |k: usize| (scattered(k as u64) % 1000) as f64 * 1e-4 - 0.05;
        for k in 0..4000 {
            let (x, y) = ((k % 63) as f64 * 1.6 - 50.0, (k / 63) as f64 * 1.6 - 50.0);
            points.push([x, y, 0.1 * x + noise(k)]);
        }
        let table = points.len();
        for k in 0..3000 {
            let (z, turn) = (1.0 - 2.0 * (k as f64 + 0.5) / 3000.0, 2.4 * k as f64);
            let r = 20.0 * (1.0 - z * z).sqrt();
            points.push([r * turn.cos(), r * turn.sin(), 22.0 + 20.0 * z + noise(k)]);
        }
        (points, table)
    }

    #[test]
    fn the_table_goes_and_the_ball_stays() {
        let (points, table) = ball_on_table();
        let options = Options { without_plane: true, ..Options::default() };
        let kept = kept(&points, [0.0; 3], &options).unwrap();
        assert!(kept[..table].iter().filter(|k| **k).count() < table / 200);
        assert!(kept[table..].iter().filter(|k| !**k).count() < 15);
    }

    #[test]
    fn a_ball_alone_stands_on_no_plane() {
        let (points, table) = ball_on_table();
        let options = Options { without_plane: true, ..Options::default() };
        assert!(matches!(kept(&points[table..], [0.0; 3], &options), Err(Error::Crop(_))));
    }

    #[test]
    fn a_box_that_keeps_nothing_is_an_error_with_a_plane_too() {
        let (points, _) = ball_on_table();
        let within = Some([[1e6; 3], [2e6; 3]]);
        for without_plane in [false, true] {
            let options = Options { within, without_plane, ..Options::default() };
            let error = kept(&points, [0.0; 3], &options).unwrap_err().to_string();
            assert_eq!(error, "nothing of the scan is left");
        }
    }

    #[test]
    fn a_box_and_a_plane_are_in_the_numbers_of_the_scan() {
        let points = [[0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [f64::NAN, 0.0, 0.0]];
        let within = Some([[11.5, 13.0, 14.0], [10.5, 11.0, 12.0]]);
        let options = Options { within, ..Options::default() };
        assert_eq!(kept(&points, [10.0; 3], &options).unwrap(), [false, true, false]);
        let options = Options { above: Some([0.0, 0.0, 2.0, 21.0]), ..Options::default() };
        assert_eq!(kept(&points, [10.0; 3], &options).unwrap(), [false, true, false]);
        assert!(kept(&points, [0.0; 3], &options).is_err());
    }
}
