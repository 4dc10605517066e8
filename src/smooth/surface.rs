//! The surface step: each point onto its MLS surface.

use rayon::prelude::*;

use crate::geometry::Point;
use crate::mesh::Mesh;
use crate::mesh::mls::{Cloud, Scratch};

/// The projections of all vertices, with support `h`. A vertex with too few
/// neighbours stays where it is.
pub fn project_all(mesh: &Mesh, cloud: &Cloud, h: f64) -> Vec<Point> {
    let project = |scratch: &mut Scratch, i: usize| {
        let p = mesh.points[i];
        cloud.project(p, cloud.normal(i), h, scratch).map_or(p, |foot| foot.point)
    };
    (0..mesh.points.len()).into_par_iter().map_init(Scratch::default, project).collect()
}
