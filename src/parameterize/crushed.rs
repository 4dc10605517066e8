//! Places that the map crushes so much that no net holds the tolerance there.

use std::collections::HashMap;

use nalgebra::{SMatrix, SVector};

use super::Parameterized;
use crate::geometry::Point;

/// Where the map leaves too little room.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crushed {
    /// Measured points in knot cells that no net can have smaller.
    pub points: usize,
    /// One of them, where most of them are together.
    pub at: Point,
}

/// Knot lines may stand so many times as close as in an even net.
const CLOSER: f64 = 4.0;

/// Points in a cell that tell whether a polynomial follows them: twice as many
/// as a bicubic has coefficients.
const ENOUGH: usize = 32;

type Basis = SVector<f64, 16>;

/// Looks for knot cells, the smallest that a net of `max_net` control points can
/// have, on which no bicubic polynomial comes within `tolerance` mm of the
/// measured points in the mean.
pub fn crushed(map: &Parameterized, tolerance: f64, max_net: usize) -> Option<Crushed> {
    let side = CLOSER * (max_net.max(16) as f64).sqrt();
    let number = |t: f64| (t * side).floor() as u32;
    let mut cells: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
    for (i, at) in map.uv[..map.patch.measured].iter().enumerate() {
        cells.entry([number(at.x), number(at.y)]).or_default().push(i);
    }
    let mut full: Vec<([u32; 2], Vec<usize>)> =
        cells.into_iter().filter(|cell| cell.1.len() >= ENOUGH).collect();
    full.sort_unstable();
    full.retain(|(cell, points)| off_a_polynomial(map, side, *cell, points) > tolerance);
    let worst = full.iter().max_by_key(|cell| cell.1.len())?;
    let points = full.iter().map(|cell| cell.1.len()).sum();
    Some(Crushed { points, at: map.patch.mesh.points[worst.1[0]] })
}

/// The root mean square distance of points from the bicubic polynomial that
/// fits them best.
fn off_a_polynomial(map: &Parameterized, side: f64, cell: [u32; 2], points: &[usize]) -> f64 {
    let basis = |i: usize| {
        let x = 2.0 * (map.uv[i].x * side - f64::from(cell[0])) - 1.0;
        let y = 2.0 * (map.uv[i].y * side - f64::from(cell[1])) - 1.0;
        Basis::from_fn(|k, _| x.powi(k as i32 / 4) * y.powi(k as i32 % 4))
    };
    let origin = map.patch.mesh.points[points[0]];
    let mut gram = SMatrix::<f64, 16, 16>::identity() * 1e-9;
    let mut right = SMatrix::<f64, 16, 3>::zeros();
    for &i in points {
        let b = basis(i);
        gram += b * b.transpose();
        right += b * (map.patch.mesh.points[i] - origin).transpose();
    }
    let Some(factor) = gram.cholesky() else { return 0.0 };
    let net = factor.solve(&right);
    let off = |&i: &usize| {
        (map.patch.mesh.points[i] - origin - net.transpose() * basis(i)).norm_squared()
    };
    (points.iter().map(off).sum::<f64>() / points.len() as f64).sqrt()
}
