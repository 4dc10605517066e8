//! Where something is: a map of points, and its rigid part.

use crate::cad::affine::{cross, dot};

/// An affine map: `axes[0] * x + axes[1] * y + axes[2] * z + translation`.
///
/// The placements of a [`Scene`](super::Scene) are rigid: their axes are perpendicular unit vectors, right-handed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Where the three axes of what is placed point to.
    pub axes: [[f64; 3]; 3],
    /// Where its origin lies.
    pub translation: [f64; 3],
}

/// A matrix whose columns are the images of the axes.
pub(super) type MatrixColumns = [[f64; 3]; 3];

pub(super) const UNIT: MatrixColumns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A matrix that changes no square of a length by more than this share is a rotation. Six digits, which `%g` prints
/// and single precision has, leave errors of up to 5e-7 in each of nine entries, and products of
/// some such matrices have several times as much.
const RIGID: f64 = 1e-5;

/// Newton's iteration for the polar decomposition doubles its digits in each step, after a step for each factor of two
/// between the scales of the axes. So many steps are enough for scales of 1e12 and each of its parts.
const MOST_STEPS: usize = 60;

impl Placement {
    /// The map that moves nothing.
    pub const IDENTITY: Placement = Placement { axes: UNIT, translation: [0.0; 3] };

    /// A map without a motion of the origin.
    pub(crate) fn linear(axes: [[f64; 3]; 3]) -> Self {
        Placement { axes, translation: [0.0; 3] }
    }

    /// The composition: first `inner`, then this one.
    #[must_use]
    pub fn after(&self, inner: &Placement) -> Placement {
        let axes = inner.axes.map(|axis| self.turn(axis));
        Placement { axes, translation: self.apply(inner.translation) }
    }

    /// The image of a point.
    pub fn apply(&self, point: [f64; 3]) -> [f64; 3] {
        let turned = self.turn(point);
        [0, 1, 2].map(|i| turned[i] + self.translation[i])
    }

    /// The image of a vector.
    pub fn turn(&self, v: [f64; 3]) -> [f64; 3] {
        product(&self.axes, v)
    }

    /// Whether the map reverses orientations.
    pub fn mirrors(&self) -> bool {
        determinant(&self.axes) < 0.0
    }

    /// The same, or nothing but the identity if it is that but for rounding.
    pub(super) fn rounded_to_identity(self) -> Placement {
        let is_near = |a: f64, b: f64| (a - b).abs() <= 16.0 * f64::EPSILON;
        let mut of_unit = self.axes.iter().flatten().zip(UNIT.iter().flatten());
        let is_identity = self.translation == [0.0; 3] && of_unit.all(|(a, b)| is_near(*a, *b));
        if is_identity { Placement::IDENTITY } else { self }
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.axes.iter().chain([&self.translation]).flatten().all(|v| v.is_finite())
    }

    /// Whether the map has no inverse.
    pub(crate) fn is_flat(&self) -> bool {
        inverse_transposed(&self.axes).is_none()
    }

    /// The rigid map `r` and the matrix `s` with `self` = `r` ∘ `s`, where `s` is symmetric: the polar
    /// decomposition (Higham, *Computing the polar decomposition*, 1986). `s` is `None` if the map is rigid but for
    /// rounding. If the map mirrors, `s` does. A map without an inverse has no rotation: `s` is all of it.
    pub(super) fn split(&self) -> (Placement, Option<MatrixColumns>) {
        let translation = self.translation;
        let stretched = |axes, rest| (Placement { axes, translation }, rest);
        let Some(mut turn) = nearest_orthogonal(&self.axes) else {
            return stretched(UNIT, Some(self.axes));
        };
        if determinant(&turn) < 0.0 {
            turn = turn.map(|axis| axis.map(|x| -x));
        } else if is_rigid(&self.axes) {
            return stretched(turn, None);
        }
        let rest = self.axes.map(|axis| turn.map(|of_turn| dot(of_turn, axis)));
        stretched(turn, Some(rest))
    }
}

/// Whether all products of axes are those of perpendicular unit vectors but for rounding.
fn is_rigid(axes: &MatrixColumns) -> bool {
    let is_near = |i: usize, j: usize| (dot(axes[i], axes[j]) - UNIT[i][j]).abs() <= RIGID;
    (0..3).all(|i| (0..=i).all(|j| is_near(i, j)))
}

/// The orthogonal matrix that is nearest to `m`. `None` if `m` has no inverse in double precision.
fn nearest_orthogonal(m: &MatrixColumns) -> Option<MatrixColumns> {
    let mut at = *m;
    for _ in 0..MOST_STEPS {
        let inverse = inverse_transposed(&at)?;
        let next = [0, 1, 2].map(|i| [0, 1, 2].map(|k| f64::midpoint(at[i][k], inverse[i][k])));
        let change = (0..3).map(|i| distance_square(at[i], next[i])).sum::<f64>();
        at = next;
        // The next step would change less than the rounding, because the iteration is quadratic.
        if change < f64::EPSILON {
            let inverse = inverse_transposed(&at)?;
            return Some(
                [0, 1, 2].map(|i| [0, 1, 2].map(|k| f64::midpoint(at[i][k], inverse[i][k]))),
            );
        }
    }
    None
}

/// The rotation that is nearest to a matrix. `None` if the matrix has no inverse, or mirrors.
pub(super) fn rotation_of(m: &MatrixColumns) -> Option<MatrixColumns> {
    nearest_orthogonal(m).filter(|turn| determinant(turn) > 0.0)
}

/// The transpose of the inverse: the vector products of the columns, divided by the determinant.
fn inverse_transposed(m: &MatrixColumns) -> Option<MatrixColumns> {
    let determinant = determinant(m);
    let [a, b, c] = *m;
    let products = [cross(b, c), cross(c, a), cross(a, b)];
    let inverse = products.map(|axis| axis.map(|x| x / determinant));
    let is_finite = determinant != 0.0 && inverse.iter().flatten().all(|x| x.is_finite());
    is_finite.then_some(inverse)
}

pub(super) fn product(m: &MatrixColumns, v: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| (0..3).map(|c| m[c][i] * v[c]).sum())
}

fn determinant(m: &MatrixColumns) -> f64 {
    dot(m[0], cross(m[1], m[2]))
}

fn distance_square(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: &MatrixColumns, b: &MatrixColumns) -> bool {
        (0..3).all(|i| distance_square(a[i], b[i]) < 1e-24)
    }

    /// A turn by 40° about (1, 2, 2) / 3.
    fn turned() -> MatrixColumns {
        let (n, angle) = ([1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0], 40f64.to_radians());
        UNIT.map(|e| {
            let (along, across) = (dot(n, e) * (1.0 - angle.cos()), cross(n, e));
            [0, 1, 2].map(|i| e[i] * angle.cos() + across[i] * angle.sin() + n[i] * along)
        })
    }

    #[test]
    fn motions_stay_and_the_rest_is_symmetric() {
        let turn = turned();
        let (rigid, rest) = Placement::linear(turn).split();
        assert!(near(&rigid.axes, &turn) && rest.is_none());
        assert_eq!(Placement::IDENTITY.split(), (Placement::IDENTITY, None));
        // Six digits are a motion all the same.
        let rounded = turn.map(|axis| axis.map(|x| (x * 1e6).round() / 1e6));
        let (rigid, rest) = Placement::linear(rounded).split();
        assert!(rest.is_none() && is_rigid(&rigid.axes));
        for scales in [[2.0, 2.0, 2.0], [1.0, 3.0, 0.5], [-1.0, 1.0, 1.0], [1e-6, 1e-6, 1e6]] {
            let scaled = [0, 1, 2].map(|k| UNIT[k].map(|x| x * scales[k]));
            let map = Placement::linear(scaled.map(|axis| product(&turn, axis)));
            let (rigid, rest) = map.split();
            let rest = rest.expect("no motion");
            assert!((determinant(&rigid.axes) - 1.0).abs() < 1e-12, "{scales:?}");
            assert_eq!(determinant(&rest) < 0.0, scales[0] < 0.0);
            let again = rest.map(|axis| product(&rigid.axes, axis));
            let size = scales.into_iter().map(f64::abs).fold(0.0, f64::max);
            for (a, b) in again.iter().zip(&map.axes) {
                assert!(distance_square(*a, *b).sqrt() < 1e-9 * size, "{scales:?}");
            }
        }
    }

    #[test]
    fn flat_maps_have_no_rotation() {
        let flat = Placement::linear([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]]);
        assert_eq!(flat.split(), (Placement::IDENTITY, Some(flat.axes)));
        assert_eq!(Placement::linear([[0.0; 3]; 3]).split().1, Some([[0.0; 3]; 3]));
    }
}
