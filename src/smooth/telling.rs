//! Noise, told from shape.
//!
//! A point's distance from the polynomial around it is noise, or what the polynomial
//! misses of the shape. Noise is independent from vertex to vertex: the distances of two
//! neighbours, each of which draws the other's polynomial its way, then have a known
//! correlation, which is negative. What is missed of a shape, or of the facets of a
//! coarse triangulation, is nearly the same at both. So the correlation along edges says
//! which share of the distances is noise. Where that is not most of it, nothing is
//! taken out.

use rayon::prelude::*;

use super::clusters::Gathering;
use super::levels::Level;
use super::median;
use crate::geometry::VertexId;
use crate::mesh::Mesh;

/// The residuals at the ends of an edge.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    /// In units in which noise of a variance of 1 mm² has that variance.
    pub residuals: [f64; 2],
    /// The correlation that noise has.
    pub expected: f64,
}

/// The residuals are noise where it makes so much of their variance: range scans have
/// 0.9 and more. Clean meshes of smooth or faceted shapes have less than 0.77, but for a saddle
/// whose vertices have four and eight neighbours by turns.
const SHARE: f64 = 0.8;

/// So many standard errors are no chance.
const SURE: f64 = 3.0;

/// Residuals beyond so many standard deviations count as these, lest an edge of the
/// object or an outlier outvote all others.
const FAR: f64 = 3.0;

/// A polynomial that follows its own point so closely that less than this is left of the
/// noise's variance says nothing of the noise.
const FREE: f64 = 0.01;

/// A vertex's distance from its polynomial, as a sum over the heights of the points around.
struct Residual {
    value: f64,
    /// The numbers of the points, ascending, and the factors of their heights.
    factors: Vec<(u32, f64)>,
}

/// Looks along those edges of a vertex that lead to one of a higher number, so that no
/// edge counts twice.
pub fn pairs(mesh: &Mesh, finest: &Level, v: VertexId, room: &mut Gathering) -> Vec<Pair> {
    let Some(own) = Residual::of(mesh, finest, v.0, room) else { return Vec::new() };
    let beside = finest.grain.near(v.index()).iter().filter(|&&w| w > v.0);
    let other = |&w: &u32| Residual::of(mesh, finest, w, room);
    beside.filter_map(other).map(|other| own.with(&other)).collect()
}

impl Residual {
    /// That of vertex `v`, over the standard deviation that it has where the points' is 1.
    fn of(mesh: &Mesh, finest: &Level, v: u32, room: &mut Gathering) -> Option<Residual> {
        let (p, normal) = (mesh.point(VertexId(v)), finest.grain.normals[v as usize]);
        let (fit, scatter) = finest.fit_with_scatter(v as usize, room)?;
        let factor = |(&i, influence): (&u32, f64)| (i, influence - f64::from(u8::from(i == v)));
        let mut factors: Vec<_> = room.numbers.iter().zip(scatter.influence).map(factor).collect();
        factors.sort_unstable_by_key(|(i, _)| *i);
        let variance: f64 = factors.iter().map(|(_, x)| x * x).sum();
        let deviation = variance.sqrt();
        factors.iter_mut().for_each(|(_, x)| *x /= deviation);
        let value = (fit.at(p).0 - p).dot(&normal) / deviation;
        (variance > FREE).then_some(Residual { value, factors })
    }

    fn with(&self, other: &Residual) -> Pair {
        let mut left = other.factors.as_slice();
        let mut expected = 0.0;
        for (i, x) in &self.factors {
            left = &left[left.partition_point(|(j, _)| j < i)..];
            expected += left.first().filter(|(j, _)| j == i).map_or(0.0, |(_, y)| x * y);
        }
        Pair { residuals: [self.value, other.value], expected }
    }
}

/// For each place 1 where its residuals are noise, else 0. The whole scan has to show
/// noise: a window is small, and among many some show it by chance, or since the
/// diagonals of a coarse mesh bend it to and fro. Then all places have it but those
/// whose `window` shows shape.
pub fn told(pairs: &[&[Pair]], window: impl Fn(usize) -> Vec<u32> + Sync) -> Vec<f64> {
    let excess = |places: &[u32]| -> f64 {
        let all = places.iter().flat_map(|&i| pairs[i as usize].iter().copied());
        excess(&all.collect::<Vec<Pair>>())
    };
    let everywhere: Vec<u32> = (0..pairs.len() as u32).collect();
    if excess(&everywhere) < SURE {
        return vec![0.0; pairs.len()];
    }
    let is_noise = |i: usize| excess(&window(i)) > -SURE;
    (0..pairs.len()).into_par_iter().map(|i| f64::from(u8::from(is_noise(i)))).collect()
}

/// By how much the share of noise is more than [`SHARE`], in standard errors; 0 where there
/// is no telling.
fn excess(pairs: &[Pair]) -> f64 {
    if pairs.is_empty() {
        return 0.0;
    }
    let count = pairs.len() as f64;
    let usual = median(pairs.iter().flat_map(|pair| pair.residuals).map(f64::abs).collect());
    // Of a normal distribution half is within 0.6745 standard deviations.
    let far = FAR * usual / 0.6745;
    let near = || pairs.iter().map(|pair| pair.residuals.map(|x| x.clamp(-far, far)));
    let products: f64 = near().map(|[a, b]| a * b).sum();
    let squares: f64 = near().map(|[a, b]| 0.5 * (a * a + b * b)).sum();
    if squares == 0.0 {
        return 0.0;
    }
    let expected = pairs.iter().map(|pair| pair.expected).sum::<f64>() / count;
    // Of shape the correlation is 1; that of both is between.
    let limit = 1.0 - SHARE * (1.0 - expected);
    (limit - products / squares) * count.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 40 places of 30 pairs with about such a correlation, where noise has −0.3.
    fn places(correlation: f64) -> Vec<Vec<Pair>> {
        let share = |i: usize, step: f64| (i as f64 * step).fract();
        let random = |i: usize| share(i, 0.754_877_666) + share(i, 0.569_840_29) - 1.0;
        let pair = |i: usize| {
            let (a, b) = (random(2 * i), random(2 * i + 7919));
            let other = correlation * a + (1.0 - correlation * correlation).sqrt() * b;
            Pair { residuals: [a, other], expected: -0.3 }
        };
        (0..40).map(|k| (0..30).map(|i| pair(30 * k + i)).collect()).collect()
    }

    fn told_of(places: &[Vec<Pair>]) -> Vec<f64> {
        let places: Vec<&[Pair]> = places.iter().map(Vec::as_slice).collect();
        told(&places, |i| vec![i as u32])
    }

    #[test]
    fn noise_is_told_by_its_correlation_and_shape_by_its_own() {
        assert_eq!(told_of(&places(-0.3)), [1.0; 40]);
        assert_eq!(told_of(&places(0.5)), [0.0; 40]);
        // A scan with a clean part.
        let mixed = [places(-0.3), places(0.9)[..8].to_vec()].concat();
        assert_eq!(told_of(&mixed), [[1.0; 40].as_slice(), &[0.0; 8]].concat());
        // A clean one with a noisy part.
        let mixed = [places(0.5), places(-0.3)[..10].to_vec()].concat();
        assert_eq!(told_of(&mixed), [0.0; 50]);
        assert_eq!(told_of(&[Vec::new()]), [0.0]);
    }
}
