//! A triangulation that becomes coarser, with an exact map back to the scan.
//!
//! Each change replaces the triangles of a disk by others, and a step keeps both in a common plane. Read
//! backwards, the steps lead a point of the coarse triangulation to its place on the scan (Lee et
//! al., "MAPS: multiresolution adaptive parameterization of surfaces", 1998).

use super::ground::Ground;
use crate::geometry::{NONE, Point, Uv, Vector, orient2d};

/// A place on a triangle: its number, and the weights of its corners.
#[derive(Debug, Clone, Copy)]
pub(super) struct TrianglePlace {
    pub triangle: u32,
    pub weights: [f64; 3],
}

/// A triangle in the plane of a step.
pub(super) type Flat = (u32, [Uv; 3]);

/// A disk before and after a change.
struct MapStep {
    old: Vec<Flat>,
    new: Vec<Flat>,
}

/// A triangulation whose first triangles and vertices are those of the scan.
pub(super) struct Base {
    /// The places of the vertices.
    pub points: Vec<Point>,
    /// Smoothed unit normals of the scan at the vertices.
    pub normals: Vec<Vector>,
    /// All triangles that ever existed. Those of the scan come first.
    pub triangles: Vec<[u32; 3]>,
    /// Whether each triangle still exists.
    pub alive: Vec<bool>,
    /// The step that made each triangle.
    made_by: Vec<u32>,
    steps: Vec<MapStep>,
    /// The triangles around each vertex, in no order. There are none around a removed vertex.
    pub around: Vec<Vec<u32>>,
    /// The removed vertices of the scan in each triangle.
    pub members: Vec<Vec<(u32, [f64; 3])>>,
    /// The mean length of the scan's edges at each vertex.
    edges: Vec<f64>,
}

impl Base {
    pub(super) fn new(ground: &Ground) -> Self {
        let scan = &ground.mesh;
        let triangles: Vec<[u32; 3]> = scan.triangles.iter().map(|t| t.map(|v| v.0)).collect();
        let mut around = vec![Vec::new(); scan.points.len()];
        for (t, corners) in triangles.iter().enumerate() {
            corners.iter().for_each(|&v| around[v as usize].push(t as u32));
        }
        let count = triangles.len();
        let edges = around.iter().enumerate().map(|(v, around)| {
            let ends = around.iter().flat_map(|&t| scan.triangles[t as usize]);
            let lengths = ends.map(|w| (scan.point(w) - scan.points[v]).norm());
            // Each triangle adds a length of zero and two edges.
            lengths.sum::<f64>() / (2 * around.len().max(1)) as f64
        });
        let edges = edges.collect();
        Base {
            points: scan.points.clone(),
            normals: ground.normals.clone(),
            edges,
            triangles,
            alive: vec![true; count],
            made_by: vec![NONE; count],
            steps: Vec::new(),
            around,
            members: vec![Vec::new(); count],
        }
    }

    pub(super) fn point(&self, v: u32) -> Point {
        self.points[v as usize]
    }

    /// The length of side `k` of a triangle.
    pub(crate) fn side_length(&self, t: usize, k: usize) -> f64 {
        let corners = self.triangles[t];
        (self.point(corners[(k + 1) % 3]) - self.point(corners[k])).norm()
    }

    /// The length of the longest side of a triangle as a multiple of the scan's edges at its corners.
    pub(crate) fn scan_edges(&self, t: [u32; 3]) -> f64 {
        let [a, b, c] = t.map(|v| self.point(v));
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        3.0 * longest / t.iter().map(|&v| self.edges[v as usize]).sum::<f64>()
    }

    /// The number of triangles around a vertex.
    pub(crate) fn valence(&self, v: u32) -> usize {
        self.around[v as usize].len()
    }

    /// Adds a vertex that has no triangles yet. `like` is a vertex beside it.
    pub(crate) fn add_vertex(&mut self, point: Point, normal: Vector, like: u32) -> u32 {
        self.points.push(point);
        self.normals.push(normal);
        self.edges.push(self.edges[like as usize]);
        self.around.push(Vec::new());
        self.points.len() as u32 - 1
    }

    /// The neighbours of a vertex, counter-clockwise, each with the triangle between it and the next
    /// one. `None` if the triangles do not form one ring.
    pub(super) fn ring(&self, v: u32) -> Option<Vec<(u32, u32)>> {
        let around = &self.around[v as usize];
        let sides: Vec<(u32, u32, u32)> = around
            .iter()
            .map(|&t| {
                let c = self.triangles[t as usize];
                let k = c.iter().position(|&w| w == v).unwrap_or(0);
                (c[(k + 1) % 3], c[(k + 2) % 3], t)
            })
            .collect();
        let mut ring = Vec::with_capacity(sides.len());
        let mut at = sides.first()?.0;
        for _ in 0..sides.len() {
            let &(_, next, t) = sides.iter().find(|side| side.0 == at)?;
            ring.push((at, t));
            at = next;
        }
        (at == ring[0].0).then_some(ring)
    }

    /// The triangle across side `k` of a triangle, and the vertex opposite to the side there.
    pub(crate) fn across(&self, t: usize, k: usize) -> Option<(u32, u32)> {
        let corners = self.triangles[t];
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        let other = self.around[a as usize]
            .iter()
            .copied()
            .find(|&o| o as usize != t && self.triangles[o as usize].contains(&b))?;
        let apex = self.triangles[other as usize].into_iter().find(|&w| w != a && w != b)?;
        Some((other, apex))
    }

    /// The area-weighted normal of three points.
    pub(super) fn area_vector(&self, t: [u32; 3]) -> Vector {
        let [a, b, c] = t.map(|v| self.point(v));
        (b - a).cross(&(c - a))
    }

    /// Where the vertices in old triangles, and a removed vertex at the origin, lie in new ones.
    /// The result has a list for each new triangle.
    pub(crate) fn moved_members(
        &self,
        old: &[Flat],
        new: &[Flat],
        removed: Option<u32>,
    ) -> Vec<Vec<(u32, [f64; 3])>> {
        let mut lists = vec![Vec::new(); new.len()];
        let mut put = |v: u32, at: Uv| {
            let (k, weights) = located(new, at);
            lists[k].push((v, weights));
        };
        for (t, corners) in old {
            for (v, weights) in &self.members[*t as usize] {
                put(*v, combined(corners, weights));
            }
        }
        removed.into_iter().for_each(|v| put(v, Uv::origin()));
        lists
    }

    /// Replaces triangles. `corners` are those of the new ones, and `new` has their places in the
    /// plane, with any numbers.
    pub(crate) fn replace(
        &mut self,
        old: Vec<Flat>,
        mut new: Vec<Flat>,
        corners: &[[u32; 3]],
        members: Vec<Vec<(u32, [f64; 3])>>,
    ) {
        for (t, _) in &old {
            let t = *t as usize;
            self.alive[t] = false;
            self.members[t] = Vec::new();
            for v in self.triangles[t] {
                self.around[v as usize].retain(|&other| other as usize != t);
            }
        }
        let step = self.steps.len() as u32;
        for ((flat, &corners), members) in new.iter_mut().zip(corners).zip(members) {
            let t = self.triangles.len() as u32;
            flat.0 = t;
            self.triangles.push(corners);
            self.alive.push(true);
            self.made_by.push(step);
            self.members.push(members);
            corners.iter().for_each(|&v| self.around[v as usize].push(t));
        }
        self.steps.push(MapStep { old, new });
    }

    /// The place on the scan of a place on the triangulation.
    pub(crate) fn on_scan(&self, mut place: TrianglePlace) -> TrianglePlace {
        while let Some(step) = self.steps.get(self.made_by[place.triangle as usize] as usize) {
            let Some((_, corners)) = step.new.iter().find(|(t, _)| *t == place.triangle) else {
                break;
            };
            let (k, weights) = located(&step.old, combined(corners, &place.weights));
            place = TrianglePlace { triangle: step.old[k].0, weights };
        }
        place
    }
}

fn combined(corners: &[Uv; 3], weights: &[f64; 3]) -> Uv {
    Uv::from(
        corners.iter().zip(weights).map(|(c, w)| c.coords * *w).sum::<nalgebra::Vector2<f64>>(),
    )
}

/// The triangle that contains a point, or is nearest to it, and the weights of its corners.
fn located(triangles: &[Flat], at: Uv) -> (usize, [f64; 3]) {
    let weights = |corners: &[Uv; 3]| {
        let [a, b, c] = *corners;
        let all = [orient2d(at, b, c), orient2d(a, at, c), orient2d(a, b, at)];
        let sum: f64 = all.iter().sum();
        all.map(|x| x / sum)
    };
    let least = |w: &[f64; 3]| w.iter().copied().fold(f64::INFINITY, f64::min);
    let mut best = (0, [1.0, 0.0, 0.0], f64::NEG_INFINITY);
    for (k, (_, corners)) in triangles.iter().enumerate() {
        let w = weights(corners);
        if least(&w) > best.2 {
            best = (k, w, least(&w));
        }
    }
    let clamped = best.1.map(|x| x.max(0.0));
    let sum: f64 = clamped.iter().sum();
    (best.0, clamped.map(|x| x / sum))
}
