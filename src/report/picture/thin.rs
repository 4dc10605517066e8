//! Fewer triangles of a mesh: as many as a browser takes.
//!
//! Vertices are gathered in the cells of a grid, and each cell keeps one of them
//! (Rossignac & Borrel 1993). The vertices that are left are the scan's own, evenly
//! spread, so that what was measured at each can be shown as it is; methods that
//! keep shape with the least triangles would leave few where the scan is flat.

use foldhash::fast::FixedState;
use hashbrown::{HashMap, HashSet};

use crate::geometry::{Point, Vector, VertexId};
use crate::mesh::Mesh;

/// A mesh with fewer triangles.
#[derive(Debug, Clone)]
pub struct Thinned {
    /// What is left.
    pub mesh: Mesh,
    /// The number that each of its vertices had.
    pub old: Vec<usize>,
    /// The vertex that stands for each of the vertices that were.
    pub new: Vec<VertexId>,
}

/// How much a cell's side grows from one try to the next.
const GROWTH: f64 = 1.15;

/// A mesh with `most` triangles at the most, its vertices some of `mesh`'s, the
/// vertices `kept` among them, unless two of these are in one cell.
pub fn thin(mesh: &Mesh, most: usize, kept: &[usize]) -> Thinned {
    if mesh.triangles.len() <= most {
        let all = 0..mesh.points.len();
        return Thinned {
            mesh: mesh.clone(),
            old: all.clone().collect(),
            new: all.map(VertexId::from).collect(),
        };
    }
    let area: f64 = mesh.area();
    let [low, _] = mesh.bounds();
    // About three triangles a cell that the surface passes.
    let mut side = (3.0 * area / most.max(1) as f64).sqrt();
    if !(side > 0.0 && side.is_finite()) {
        side = mesh.diagonal().max(f64::MIN_POSITIVE);
    }
    loop {
        let thinned = gather(mesh, low, side, kept);
        if thinned.mesh.triangles.len() <= most {
            return thinned;
        }
        side *= GROWTH;
    }
}

/// The vertices of a cell.
#[derive(Clone, Copy)]
struct Cell {
    sum: Vector,
    count: f64,
    /// The vertex that stays, and the square of its distance from the mean.
    best: (usize, f64),
}

fn gather(mesh: &Mesh, low: Point, side: f64, kept: &[usize]) -> Thinned {
    let mut cells: Vec<Cell> = Vec::new();
    let mut number: HashMap<[i32; 3], u32, FixedState> = HashMap::default();
    let mut new = Vec::with_capacity(mesh.points.len());
    for p in &mesh.points {
        let key = ((p - low) / side).map(|x| x as i32).into();
        let cell = *number.entry(key).or_insert(cells.len() as u32);
        if cell as usize == cells.len() {
            cells.push(Cell { sum: Vector::zeros(), count: 0.0, best: (0, f64::INFINITY) });
        }
        let of = &mut cells[cell as usize];
        of.sum += p - low;
        of.count += 1.0;
        new.push(VertexId(cell));
    }
    for (v, p) in mesh.points.iter().enumerate() {
        let cell = &mut cells[new[v].index()];
        let off = (p - low - cell.sum / cell.count).norm_squared();
        if off < cell.best.1 {
            cell.best = (v, off);
        }
    }
    for &v in kept.iter().filter(|&&v| v < new.len()) {
        cells[new[v].index()].best.0 = v;
    }
    let old: Vec<usize> = cells.iter().map(|cell| cell.best.0).collect();
    let points = old.iter().map(|&v| mesh.points[v]).collect();
    Thinned { mesh: Mesh { points, triangles: triangles(mesh, &new) }, old, new }
}

/// The triangles whose corners are in three cells, each once.
fn triangles(mesh: &Mesh, new: &[VertexId]) -> Vec<[VertexId; 3]> {
    let mut seen: HashSet<[VertexId; 3], FixedState> = HashSet::default();
    let moved = mesh.triangles.iter().map(|t| t.map(|v| new[v.index()]));
    moved
        .filter(|t| {
            let mut sorted = *t;
            sorted.sort();
            t[0] != t[1] && t[1] != t[2] && t[2] != t[0] && seen.insert(sorted)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wavy sheet of n × n squares of 1 mm.
    fn sheet(n: usize) -> Mesh {
        let at = |k: usize| (k / (n + 1), k % (n + 1));
        let points = (0..(n + 1) * (n + 1)).map(at).map(|(i, j)| {
            let (x, y) = (i as f64, j as f64);
            Point::new(x, y, (0.2 * x).sin() + (0.3 * y).cos())
        });
        let triangles = (0..n * n).flat_map(|k| {
            let corner = |di: usize, dj: usize| VertexId::from((k / n + di) * (n + 1) + k % n + dj);
            [[corner(0, 0), corner(1, 0), corner(1, 1)], [corner(0, 0), corner(1, 1), corner(0, 1)]]
        });
        Mesh { points: points.collect(), triangles: triangles.collect() }
    }

    #[test]
    fn what_is_left_covers_the_sheet_with_its_own_vertices() {
        let mesh = sheet(100);
        let thinned = thin(&mesh, 3000, &[4321]);
        let count = thinned.mesh.triangles.len();
        assert!(count <= 3000 && count > 1000, "{count}");
        assert!(thinned.old.contains(&4321));
        for (p, &v) in thinned.mesh.points.iter().zip(&thinned.old) {
            assert_eq!(*p, mesh.points[v]);
        }
        let share = thinned.mesh.area() / mesh.area();
        assert!((0.93..1.07).contains(&share), "{share}");
    }

    #[test]
    fn few_triangles_stay_as_they_are() {
        let mesh = sheet(10);
        let thinned = thin(&mesh, 200, &[]);
        assert_eq!(thinned.mesh.triangles, mesh.triangles);
        assert_eq!(thinned.old.len(), mesh.points.len());
    }

    #[test]
    fn no_bound_is_too_small() {
        assert!(thin(&sheet(10), 0, &[]).mesh.triangles.is_empty());
    }
}
