//! How a map stretches (Sander, Snyder, Gortler, Hoppe, "Texture mapping
//! progressive meshes", 2001).

use crate::geometry::{Uv, Vector};
use crate::mesh::{FaceOrigin, Patch};

/// Stretch of the map from the parameter plane to the measured triangles,
/// normalised to 1 for an isometry. The plane is scaled to the rectangle that
/// stretches least, since a map to the square is one to any rectangle.
#[derive(Debug, Clone, Copy, Default)]
pub struct Stretch {
    /// Root mean square over directions and (area-weighted) triangles.
    pub l2: f64,
    /// The largest singular value of any triangle's map.
    pub max: f64,
    /// Width over height of the rectangle.
    pub aspect: f64,
}

/// Of one triangle: area in space, area in the plane, ∂S/∂u, ∂S/∂v.
type Derivatives = (f64, f64, Vector, Vector);

/// A triangle's map is taken for no flatter than this share of the mean, so
/// that one lost to rounding still has a stretch.
const FLATTEST: f64 = 1e-14;

fn derivatives(patch: &Patch, uv: &[Uv], t: usize) -> Derivatives {
    let corners = patch.mesh.triangles[t];
    let [p, q, r] = patch.mesh.corners(corners);
    let [a, b, c] = corners.map(|v| uv[v.index()]);
    let (d, e) = (b - a, c - a);
    let twice = (d.x * e.y - d.y * e.x).max(FLATTEST / uv.len() as f64);
    let su = ((q - p) * e.y - (r - p) * d.y) / twice;
    let sv = ((r - p) * d.x - (q - p) * e.x) / twice;
    (0.5 * patch.mesh.area_vector(corners).norm(), 0.5 * twice, su, sv)
}

/// The stretch around each vertex, over all triangles, its mean 1 or so.
pub fn of_vertices(patch: &Patch, uv: &[Uv]) -> Vec<f64> {
    let all: Vec<Derivatives> =
        (0..patch.mesh.triangles.len()).map(|t| derivatives(patch, uv, t)).collect();
    let [area, along_u, along_v] = sums(&all);
    let w = (along_u / along_v).powf(0.25);
    let (mut squares, mut areas) = (vec![0.0; uv.len()], vec![0.0; uv.len()]);
    for (d, t) in all.iter().zip(&patch.mesh.triangles) {
        let square = 0.5 * (d.2.norm_squared() / (w * w) + d.3.norm_squared() * w * w);
        for v in t {
            squares[v.index()] += d.0 * square;
            areas[v.index()] += d.0;
        }
    }
    let mean = 1.0 / area.sqrt();
    squares.iter().zip(&areas).map(|(s, a)| (s / a).sqrt() * mean).map(limited).collect()
}

/// One round changes a weight by a few orders of magnitude at the most.
fn limited(stretch: f64) -> f64 {
    if stretch.is_finite() { stretch.clamp(1e-4, 1e4) } else { 1.0 }
}

/// Area, and its integrals of |∂S/∂u|² and |∂S/∂v|².
fn sums(all: &[Derivatives]) -> [f64; 3] {
    let add = |[a, u, v]: [f64; 3], t: &Derivatives| {
        [a + t.0, u + t.0 * t.2.norm_squared(), v + t.0 * t.3.norm_squared()]
    };
    all.iter().fold([0.0; 3], add)
}

fn measured(patch: &Patch) -> impl Iterator<Item = usize> + '_ {
    (0..patch.mesh.triangles.len()).filter(|&t| patch.origin[t] == FaceOrigin::Measured)
}

/// The measured triangle that adds most to the stretch.
pub fn worst(patch: &Patch, uv: &[Uv]) -> Option<usize> {
    let share = |t: &usize| {
        let (area, _, su, sv) = derivatives(patch, uv, *t);
        area * (su.norm_squared() + sv.norm_squared())
    };
    measured(patch).max_by(|i, j| share(i).total_cmp(&share(j)))
}

/// Measures the stretch.
pub fn measure(patch: &Patch, uv: &[Uv]) -> Stretch {
    let all: Vec<Derivatives> = measured(patch).map(|t| derivatives(patch, uv, t)).collect();
    let [area, along_u, along_v] = sums(&all);
    let flat: f64 = all.iter().map(|t| t.1).sum();
    // Of the rectangles w × 1/w the best has w⁴ = along_u / along_v.
    let w = (along_u / along_v).powf(0.25);
    let scale = (flat / area).sqrt();
    let largest = |t: &Derivatives| {
        let (su, sv) = (t.2 / w, t.3 * w);
        let (a, b, c) = (su.norm_squared(), su.dot(&sv), sv.norm_squared());
        (0.5 * (a + c + ((a - c).powi(2) + 4.0 * b * b).sqrt())).sqrt()
    };
    Stretch {
        l2: scale * (0.5 * (along_u / (w * w) + along_v * w * w) / area).sqrt(),
        max: scale * all.iter().map(largest).fold(0.0, f64::max),
        aspect: w * w,
    }
}
