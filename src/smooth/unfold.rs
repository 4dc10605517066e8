//! Projections move vertices by about the noise; where that is near the point
//! spacing, or where a boundary was drawn in over its neighbours, triangles
//! come to lie upside down. They are turned back by sliding their vertices
//! along the surface, which itself stays where it is.

use super::surface::Surface;
use crate::geometry::{Point, Vector, VertexId};
use crate::mesh::{Disk, Rings};

/// Rounds of sliding at the most.
const ROUNDS: usize = 30;

/// Rounds after which boundary vertices have to give way too.
const PATIENCE: usize = 6;

/// Turns folded triangles back. Inner vertices slide towards the middle of
/// their neighbours; boundary vertices go half of the way back to `projected`,
/// where the surface step put them, if the triangle has no inner vertex or
/// sliding does not help.
pub fn unfold(disk: &mut Disk, surface: &Surface, projected: &[Point]) {
    let rings = Rings::new(&disk.mesh);
    let mut on_boundary = vec![false; projected.len()];
    disk.loops().flatten().for_each(|v| on_boundary[v.index()] = true);
    let inner = |v: &VertexId| !on_boundary[v.index()];
    for round in 0..ROUNDS {
        let folded = folded(disk, surface);
        if folded.is_empty() {
            return;
        }
        let mut slide: Vec<VertexId> = Vec::new();
        let mut retreat: Vec<VertexId> = Vec::new();
        for t in folded {
            if round >= PATIENCE || !t.iter().any(inner) {
                retreat.extend(t.iter().filter(|v| !inner(v)));
            }
            slide.extend(t.iter().filter(|v| inner(v)));
            let around = t.iter().flat_map(|&v| rings.neighbours(&disk.mesh, v));
            slide.extend(around.filter(inner));
        }
        for v in unique(retreat) {
            let p = &mut disk.mesh.points[v.index()];
            *p = nalgebra::center(p, &projected[v.index()]);
        }
        slide_all(disk, surface, &rings, &unique(slide));
    }
}

fn unique(mut vertices: Vec<VertexId>) -> Vec<VertexId> {
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// Triangles that look away from the surface's side at their corners.
fn folded(disk: &Disk, surface: &Surface) -> Vec<[VertexId; 3]> {
    let up = |t: &[VertexId; 3]| t.iter().map(|v| surface.scan_normal(*v)).sum::<Vector>();
    let folded = |t: &&[VertexId; 3]| disk.mesh.area_vector(**t).dot(&up(t)) <= 0.0;
    disk.mesh.triangles.iter().filter(folded).copied().collect()
}

/// Moves the vertices half of the way to the middle of their neighbours, and
/// back onto the surface.
fn slide_all(disk: &mut Disk, surface: &Surface, rings: &Rings, vertices: &[VertexId]) {
    let targets: Vec<Point> = vertices
        .iter()
        .map(|&v| {
            let (p, n) = (disk.mesh.point(v), surface.scan_normal(v));
            let (mut sum, mut count) = (Vector::zeros(), 0.0);
            for w in rings.neighbours(&disk.mesh, v) {
                sum += disk.mesh.point(w) - p;
                count += 1.0;
            }
            let step = 0.5 * sum / count;
            let target = p + (step - step.dot(&n) * n);
            surface.project(v, target).map_or(target, |foot| foot.point)
        })
        .collect();
    for (v, p) in vertices.iter().zip(targets) {
        disk.mesh.points[v.index()] = p;
    }
}
