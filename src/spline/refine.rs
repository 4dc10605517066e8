//! Knot refinement: the same surface over a finer knot vector.

use nalgebra::SVector;

use super::{KnotVector, Surface};

impl Surface {
    /// The same surface over finer knot vectors, which must contain the present knots.
    pub(crate) fn over(&self, [u, v]: [KnotVector; 2]) -> Self {
        let net = refined(&self.net, [&self.u, &self.v], [&u, &v]);
        Surface::new(u, v, net)
    }
}

/// The control net of the same surface over finer knot vectors, refined along v first and then
/// along u. The new vectors must contain the old knots.
pub(crate) fn refined<const D: usize>(
    net: &[SVector<f64, D>],
    from: [&KnotVector; 2],
    to: [&KnotVector; 2],
) -> Vec<SVector<f64, D>> {
    let [nu, nv] = from.map(KnotVector::functions);
    let [more_u, more_v] = to.map(KnotVector::functions);
    let rows: Vec<_> = net.chunks(nv).flat_map(|row| inserted(row, from[1], to[1])).collect();
    let mut all = vec![SVector::zeros(); more_u * more_v];
    for j in 0..more_v {
        let column: Vec<_> = (0..nu).map(|i| rows[i * more_v + j]).collect();
        let column = inserted(&column, from[0], to[0]);
        column.into_iter().enumerate().for_each(|(i, p)| all[i * more_v + j] = p);
    }
    all
}

/// The control points of a curve over a finer knot vector. Each is a blossom of the piece at the
/// start of the new basis function (Oslo algorithm: Cohen, Lyche, Riesenfeld, 1980).
pub(crate) fn inserted<const D: usize>(
    control: &[SVector<f64, D>],
    from: &KnotVector,
    to: &KnotVector,
) -> Vec<SVector<f64, D>> {
    let at = |i: usize| {
        let knots = &to.knots()[i..i + 4];
        from.blossom(from.span(knots[0]), control, &knots[1..])
    };
    (0..to.functions()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Uv, Vector};

    #[test]
    fn more_knots_leave_the_surface_as_it_was() {
        let breaks: Vec<f64> = (0..=50).map(|i| (f64::from(i) / 50.0).powf(1.3)).collect();
        let every = |n: usize| breaks.iter().copied().step_by(n).collect::<Vec<f64>>();
        let [coarse, fine] = [every(5), every(1)].map(|b| KnotVector::clamped(3, &b, 1));
        let [few, more] = [8, 32].map(|n| KnotVector::uniform(3, n + 3));
        let count = coarse.functions() * few.functions();
        let control = |i: usize| Vector::new((i % 7) as f64, (i % 5) as f64, (i % 11) as f64);
        let before = Surface::new(coarse, few, (0..count).map(control).collect());
        let after = before.over([fine, more]);
        assert_eq!(after.shape(), [53, 35]);
        for i in 0..400 {
            let at = Uv::new(f64::from(i % 20) / 19.0, f64::from(i / 20) / 19.0);
            assert!((before.point(at) - after.point(at)).norm() < 1e-12, "{at}");
        }
    }
}
