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

/// Measures the stretch.
pub fn measure(patch: &Patch, uv: &[Uv]) -> Stretch {
    let derivatives = |t: usize| {
        let corners = patch.mesh.triangles[t];
        let [p, q, r] = patch.mesh.corners(corners);
        let [a, b, c] = corners.map(|v| uv[v.index()]);
        let (d, e) = (b - a, c - a);
        let twice = d.x * e.y - d.y * e.x;
        let su = ((q - p) * e.y - (r - p) * d.y) / twice;
        let sv = ((r - p) * d.x - (q - p) * e.x) / twice;
        (0.5 * patch.mesh.area_vector(corners).norm(), 0.5 * twice, su, sv)
    };
    let measured =
        (0..patch.mesh.triangles.len()).filter(|&t| patch.origin[t] == FaceOrigin::Measured);
    let all: Vec<Derivatives> = measured.map(derivatives).collect();
    let sum = |f: &dyn Fn(&Derivatives) -> f64| all.iter().map(f).sum::<f64>();
    let (area, flat) = (sum(&|t| t.0), sum(&|t| t.1));
    let (along_u, along_v) =
        (sum(&|t| t.0 * t.2.norm_squared()), sum(&|t| t.0 * t.3.norm_squared()));
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
