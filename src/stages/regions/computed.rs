//! How much farther vertices are from their surfaces than the numbers of the file are rounded: programs that compute in
//! 32 bits round after each step.

use super::exact::ExactFacets;
use super::facets::FacetMesh;
use super::growth::GrownRegion;
use super::precision::FlatPairs;
use super::search::SeedSearch;
use super::tessellation::{MOST_ERRORS, Tessellation};

/// The largest factor that is looked for. A profile that is spun in steps of 32 bits ends about fifteen bounds of the
/// rounding off its circle. Scanners are a hundred times less exact than such a program.
const MOST_FACTOR: f64 = 32.0;

/// Surfaces are measured with errors of twice the largest factor.
const WIDE: f64 = 2.0 * MOST_FACTOR;

/// The seeds of surfaces on which the factor is measured: a program computes all of a mesh in the same way.
const SOUNDINGS: usize = 24;

/// The bound of the rounding holds for nearly all vertices, and this share of them must be farther off. Of normally distributed
/// errors whose largest of a thousand is at the limit of a region, twice as many are.
const LEAST_BEYOND: f64 = 0.05;

/// So few vertices may be mistakes of a model.
const FEWEST_BEYOND: usize = 3;

/// The factor, a power of two, by which the errors of vertices are larger than those of a mesh whose numbers are only
/// rounded. It is 1 unless significant surfaces show that they are.
///
/// Surfaces are searched with much larger errors. No vertex of an exact face comes near this bound, as those of other
/// faces are off by far more. A region of a free-form surface goes up to the bound, and does not count. Nor do
/// vertices at the ends of faces, where edges of the model may be loose.
pub fn computed(mesh: &Tessellation) -> f64 {
    if !may_be_clean(mesh) {
        return 1.0;
    }
    let facets = FacetMesh::of(mesh, f64::INFINITY);
    let closed = vec![false; facets.all.len()];
    let evidence = ExactFacets { mesh, facets: facets.into(), slack: WIDE, closed: closed.into() };
    let found = SeedSearch::new(&evidence, Vec::new(), Vec::new(), WIDE).sounded(SOUNDINGS);
    let is_exact = |region: &&GrownRegion| WIDE * region.fit.worst <= MOST_FACTOR * MOST_ERRORS;
    let regions = found.iter().map(|found| &found.growth).filter(is_exact);
    factor(regions.flat_map(|region| residuals(&evidence, region)).collect())
}

/// Whether pairs of triangles are those of a clean mesh with errors of any factor, so that they need not be noise.
fn may_be_clean(mesh: &Tessellation) -> bool {
    let factors = std::iter::successors(Some(1.0), |factor| Some(2.0 * factor));
    let mut factors = factors.take_while(|&factor| factor <= MOST_FACTOR);
    factors.any(|factor| FlatPairs::within(mesh, factor).is_clean() != Some(false))
}

/// The factor of the bounds that some distances from exact surfaces, in units of these bounds, tell.
fn factor(off: Vec<f64>) -> f64 {
    let beyond = off.iter().filter(|&&d| d > 1.0).count();
    if beyond < FEWEST_BEYOND || (beyond as f64) < LEAST_BEYOND * off.len() as f64 {
        return 1.0;
    }
    let most = off.into_iter().fold(MOST_ERRORS, f64::max) / MOST_ERRORS;
    most.log2().ceil().exp2()
}

/// The distances of the vertices inside of a region from its surface, in units of their errors.
fn residuals(evidence: &ExactFacets, region: &GrownRegion) -> Vec<f64> {
    let mesh = evidence.mesh;
    let mut is_inside = vec![false; evidence.facets.all.len()];
    region.units.iter().for_each(|&f| is_inside[f as usize] = true);
    let mut is_end = vec![false; mesh.errors.len()];
    for (t, &facet) in (0..).zip(&evidence.facets.of) {
        if !is_inside[facet as usize] {
            mesh.corners(t).into_iter().for_each(|v| is_end[v as usize] = true);
        }
    }
    let surface = region.surface();
    let inner = region.vertices.iter().filter(|&&v| !is_end[v as usize]);
    inner.map(|&v| surface.distance(mesh.point(v)).0.abs() / mesh.error(v)).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;
    use crate::geometry::{Point, Vector, VertexId, random::scattered};
    use crate::mesh::Mesh;
    use crate::stages::regions::FileRounding;

    /// A number in [-1, 1].
    fn random(k: usize) -> f64 {
        (scattered(k as u64) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A torus of quadrangles, or of a wavy tube, whose vertices are moved by so many of their bounds.
    fn factor_of(waves: f64, noise: f64) -> f64 {
        let (around, across) = (48, 20);
        let turn = Rotation3::new(Vector::new(0.3, 1.1, -0.7));
        let mut mesh = Mesh::default();
        for k in 0..around * across {
            let angle = |k: usize, n: usize| std::f64::consts::TAU * k as f64 / n as f64;
            let (u, v) = (angle(k / across, around), angle(k % across, across));
            let minor = 3.0 * (1.0 + waves * (5.0 * u).sin());
            let wide = 10.0 + minor * v.cos();
            let at = turn * Point::new(wide * u.cos(), wide * u.sin(), minor * v.sin());
            mesh.points.push(at.map(|x| f64::from(x as f32)));
            let corner = |i: usize, j: usize| VertexId::from(i % around * across + j % across);
            let (i, j) = (k / across, k % across);
            let [a, b, c, d] =
                [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
        let errors = FileRounding::errors_of(&mesh.points, 1.0);
        assert!(errors.is_single);
        for (k, p) in mesh.points.iter_mut().enumerate() {
            let shift = Vector::new(random(3 * k), random(3 * k + 1), random(3 * k + 2));
            *p += noise * errors.bounds[k] * shift;
        }
        computed(&Tessellation::new(&mesh, &errors.bounds))
    }

    #[test]
    fn the_factor_is_that_of_the_largest_errors() {
        assert_eq!(factor_of(0.0, 0.0), 1.0);
        for noise in [4.0, 10.0, 25.0] {
            let found = factor_of(0.0, noise);
            let bound = MOST_ERRORS * found;
            // Shifts along the normal are about as large as those of one coordinate.
            assert!(bound > noise && bound < 4.0 * noise, "{found} for {noise}");
        }
    }

    #[test]
    fn noise_and_free_forms_are_no_rounding() {
        assert_eq!(factor_of(0.0, 1e4), 1.0);
        assert_eq!(factor_of(0.03, 0.0), 1.0);
        assert_eq!(factor_of(0.03, 10.0), 1.0);
        // Waves of a few bounds are not seen.
        assert_eq!(factor_of(1e-3, 0.0), 1.0);
    }

    #[test]
    fn few_vertices_that_are_off_are_mistakes() {
        let exact = vec![0.3; 1000];
        assert_eq!(factor(exact.clone()), 1.0);
        assert_eq!(factor([exact.clone(), vec![20.0; 40]].concat()), 1.0);
        assert_eq!(factor([exact, vec![20.0; 60]].concat()), 16.0);
        assert_eq!(factor(vec![30.0; 2]), 1.0);
    }
}
