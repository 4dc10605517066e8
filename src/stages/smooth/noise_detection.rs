//! Distinguishes noise from shape, by the correlation of residuals along edges.
//!
//! The residual of a point is its distance from the polynomial around it. It is noise, or shape
//! that the polynomial misses. Noise is independent from vertex to vertex. The residuals of two
//! neighbours, each of which influences the other's polynomial, then have a known correlation,
//! which is negative. Missed shape, or the facets of a coarse triangulation, is nearly the same at
//! both. The correlation along edges therefore tells which share of the residuals is noise. Where
//! noise is not the larger part by far, points are not moved.

use rayon::prelude::*;

use super::clusters::Neighbourhood;
use super::levels::SupportLevel;
use super::median;
use crate::geometry::VertexId;
use crate::mesh::Mesh;

/// The residuals at the two ends of an edge.
#[derive(Debug, Clone, Copy)]
pub struct ResidualPair {
    /// The residuals, in units in which noise with a variance of 1 mm² has variance 1.
    pub residuals: [f64; 2],
    /// The correlation that pure noise would have.
    pub expected: f64,
}

/// The residuals count as noise if noise makes up at least this share of their variance. Range
/// scans have 0.9 and more. Meshes of smooth or faceted shapes without noise have less than 0.77.
/// The exception is a saddle whose vertices have four and eight neighbours alternately.
const MIN_NOISE_SHARE: f64 = 0.8;

/// The number of standard errors from which on a difference is significant.
const SIGNIFICANT: f64 = 3.0;

/// A polynomial may follow its own point so closely that less than this share of the noise variance
/// is left. Such a residual is not used.
const MIN_VARIANCE: f64 = 0.01;

/// The residual of a vertex, as a linear combination of the heights of the points around it.
struct Residual {
    value: f64,
    /// The numbers of these points in ascending order, with the coefficients of their heights.
    factors: Vec<(u32, f64)>,
}

/// The residual pairs along the edges from a vertex to vertices with higher numbers. In this way no
/// edge is used twice.
pub fn pairs(
    mesh: &Mesh,
    finest: &SupportLevel,
    v: VertexId,
    scratch: &mut Neighbourhood,
) -> Vec<ResidualPair> {
    let Some(own) = Residual::of(mesh, finest, v.0, scratch) else { return Vec::new() };
    let beside = finest.clusters.near(v.index()).iter().filter(|&&w| w > v.0);
    let other = |&w: &u32| Residual::of(mesh, finest, w, scratch);
    beside.filter_map(other).map(|other| own.with(&other)).collect()
}

impl Residual {
    /// The residual of vertex `v`, divided by its standard deviation for points of variance 1.
    fn of(
        mesh: &Mesh,
        finest: &SupportLevel,
        v: u32,
        scratch: &mut Neighbourhood,
    ) -> Option<Residual> {
        let (p, normal) = (mesh.point(VertexId(v)), finest.clusters.normals[v as usize]);
        let (fit, scatter) = finest.fit_with_scatter(v as usize, scratch)?;
        let factor = |(&i, influence): (&u32, f64)| (i, influence - f64::from(u8::from(i == v)));
        let mut factors: Vec<_> =
            scratch.numbers.iter().zip(scatter.influence).map(factor).collect();
        factors.sort_unstable_by_key(|(i, _)| *i);
        let variance: f64 = factors.iter().map(|(_, x)| x * x).sum();
        let deviation = variance.sqrt();
        factors.iter_mut().for_each(|(_, x)| *x /= deviation);
        let value = (fit.at(p).0 - p).dot(&normal) / deviation;
        (variance > MIN_VARIANCE).then_some(Residual { value, factors })
    }

    fn with(&self, other: &Residual) -> ResidualPair {
        let mut left = other.factors.as_slice();
        let mut expected = 0.0;
        for (i, x) in &self.factors {
            left = &left[left.partition_point(|(j, _)| j < i)..];
            expected += left.first().filter(|(j, _)| j == i).map_or(0.0, |(_, y)| x * y);
        }
        ResidualPair { residuals: [self.value, other.value], expected }
    }
}

/// For each place, 1 if its residuals are noise and 0 otherwise. First the whole scan must show
/// noise. A single window is small; among many, some show noise by chance, or because the diagonals
/// of a coarse mesh bend it to and fro. If the whole scan shows noise, all places do, except those
/// whose `window` shows shape.
pub fn noise_share(
    pairs: &[&[ResidualPair]],
    window: impl Fn(usize) -> Vec<u32> + Sync,
) -> Vec<f64> {
    let excess = |places: &[u32]| -> f64 {
        let all = places.iter().flat_map(|&i| pairs[i as usize].iter().copied());
        excess(&all.collect::<Vec<ResidualPair>>())
    };
    let everywhere: Vec<u32> = (0..pairs.len() as u32).collect();
    if excess(&everywhere) < SIGNIFICANT {
        return vec![0.0; pairs.len()];
    }
    let is_noise = |i: usize| excess(&window(i)) > -SIGNIFICANT;
    (0..pairs.len()).into_par_iter().map(|i| f64::from(u8::from(is_noise(i)))).collect()
}

/// The amount in standard errors by which the share of noise exceeds [`MIN_NOISE_SHARE`]; 0 if it
/// is unknown.
fn excess(pairs: &[ResidualPair]) -> f64 {
    if pairs.is_empty() {
        return 0.0;
    }
    let count = pairs.len() as f64;
    let usual = median(pairs.iter().flat_map(|pair| pair.residuals).map(f64::abs).collect());
    // Half of a normal distribution lies within 0.6745 standard deviations.
    // An edge of the object or an outlier must not outweigh all other residuals.
    let far = SIGNIFICANT * usual / 0.6745;
    let near = || pairs.iter().map(|pair| pair.residuals.map(|x| x.clamp(-far, far)));
    let products: f64 = near().map(|[a, b]| a * b).sum();
    let squares: f64 = near().map(|[a, b]| 0.5 * (a * a + b * b)).sum();
    if squares == 0.0 {
        return 0.0;
    }
    let expected = pairs.iter().map(|pair| pair.expected).sum::<f64>() / count;
    // The correlation of shape is 1; that of a mixture lies between the two.
    let limit = 1.0 - MIN_NOISE_SHARE * (1.0 - expected);
    (limit - products / squares) * count.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 40 places with 30 pairs each, with about this correlation. Noise has −0.3.
    fn places(correlation: f64) -> Vec<Vec<ResidualPair>> {
        let share = |i: usize, step: f64| (i as f64 * step).fract();
        let random = |i: usize| share(i, 0.754_877_666) + share(i, 0.569_840_29) - 1.0;
        let pair = |i: usize| {
            let (a, b) = (random(2 * i), random(2 * i + 7919));
            let other = correlation * a + (1.0 - correlation * correlation).sqrt() * b;
            ResidualPair { residuals: [a, other], expected: -0.3 }
        };
        (0..40).map(|k| (0..30).map(|i| pair(30 * k + i)).collect()).collect()
    }

    fn told_of(places: &[Vec<ResidualPair>]) -> Vec<f64> {
        let places: Vec<&[ResidualPair]> = places.iter().map(Vec::as_slice).collect();
        noise_share(&places, |i| vec![i as u32])
    }

    #[test]
    fn noise_is_told_by_its_correlation_and_shape_by_its_own() {
        assert_eq!(told_of(&places(-0.3)), [1.0; 40]);
        assert_eq!(told_of(&places(0.5)), [0.0; 40]);
        // A noisy scan with a clean part.
        let mixed = [places(-0.3), places(0.9)[..8].to_vec()].concat();
        assert_eq!(told_of(&mixed), [[1.0; 40].as_slice(), &[0.0; 8]].concat());
        // A clean scan with a noisy part.
        let mixed = [places(0.5), places(-0.3)[..10].to_vec()].concat();
        assert_eq!(told_of(&mixed), [0.0; 50]);
        assert_eq!(told_of(&[Vec::new()]), [0.0]);
    }
}
