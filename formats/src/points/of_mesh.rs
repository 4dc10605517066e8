//! The points of a mesh as a cloud.

use super::{Lost, PointScan, Points};
use crate::Soup;
use crate::cad::affine::cross;

impl Points {
    /// The points that the polygons of a mesh use, with their normals: the means of those of the polygons around
    /// them, weighted by area. The polygons themselves are forgotten. Points that are not finite are left out.
    pub fn of_mesh(soup: &Soup) -> Points {
        let mut normals = vec![[0.0; 3]; soup.points.len()];
        let mut is_used = vec![false; soup.points.len()];
        for polygon in soup.polygons.iter() {
            let at = |k: usize| soup.points[polygon[k % polygon.len()] as usize];
            // Newell's vector, which is twice the area of the polygon.
            let vector = (0..polygon.len()).fold([0.0; 3], |sum, k| {
                let turn = cross(at(k), at(k + 1));
                [0, 1, 2].map(|axis| sum[axis] + turn[axis])
            });
            for &corner in polygon {
                is_used[corner as usize] = true;
                let sum = &mut normals[corner as usize];
                (0..3).for_each(|axis| sum[axis] += vector[axis]);
            }
        }
        let is_kept = |&v: &usize| {
            is_used[v] && soup.points[v].iter().all(|coordinate| coordinate.is_finite())
        };
        let kept: Vec<usize> = (0..soup.points.len()).filter(is_kept).collect();
        let scan = PointScan { points: 0..kept.len(), viewpoint: None, pose: None, grid: None };
        Points {
            origin: [0.0; 3],
            positions: kept.iter().map(|&v| soup.points[v]).collect(),
            normals: Some(kept.iter().map(|&v| unit(normals[v])).collect()),
            scans: vec![scan],
            unit: soup.unit,
            lost: Lost::default(),
            notes: Vec::new(),
        }
    }
}

/// The vector of length 1 in this direction; zero if there is none.
fn unit(v: [f64; 3]) -> [f32; 3] {
    let length = v.iter().fold(0.0, |length: f64, x| length.hypot(*x));
    let scaled = v.map(|x| (x / length) as f32);
    if scaled.iter().all(|x| x.is_finite()) { scaled } else { [0.0; 3] }
}
