//! Smoothing of the surface: each point is projected onto the MLS surface of its neighbourhood.
//!
//! One polynomial is fitted around each cluster of points. A point is projected onto the
//! polynomials of its own cluster and of the neighbouring clusters, and the foot points are blended
//! with weights that decrease with distance. Where the support varies over the scan, the foot
//! points on two levels are blended.

use std::sync::Arc;

use rayon::prelude::*;

use super::clusters::ScratchPool;
use super::levels::SupportLevel;
use crate::error::Result;
use crate::geometry::{BLOCK, NEGLIGIBLE, NONE, Point, Vector, VertexId};
use crate::mesh::Mesh;
use crate::mesh::mls::{Polynomial, Projection};
use crate::progress::Progress;

/// The MLS surface of a scan.
pub(crate) struct MlsSurface {
    levels: Vec<SupportLevel>,
    /// The normals of the scan at the vertices, averaged over neighbouring points.
    scan_normals: Arc<Vec<Vector>>,
    /// The level of each vertex. A fraction means a blend of two adjacent levels.
    place: Vec<f32>,
    /// Whether each vertex stays where it was measured, because the surface misses the shape there.
    pub stays: Vec<bool>,
    fits: Vec<Fits>,
}

/// The polynomials of those clusters of a level that are needed.
struct Fits {
    /// For each cluster the number of its polynomial, or [`NONE`].
    number: Vec<u32>,
    all: Vec<Polynomial>,
}

impl MlsSurface {
    /// Fits the polynomials that the vertices need. `place` is the level of each vertex. All vertices
    /// move to the surface.
    pub(super) fn new(
        scan_normals: Arc<Vec<Vector>>,
        mut levels: Vec<SupportLevel>,
        place: Vec<f32>,
        progress: &mut Progress,
    ) -> Result<Self> {
        let mut fits = Vec::with_capacity(levels.len());
        let count = levels.len();
        for (k, level) in levels.iter_mut().enumerate() {
            progress(k as f64 / count as f64)?;
            let needed = needed(level, k, &place);
            if needed.is_empty() {
                level.forget();
            }
            fits.push(Fits::new(level, &needed));
        }
        let stays = vec![false; place.len()];
        Ok(MlsSurface { levels, scan_normals, place, stays, fits })
    }

    /// The same surface for some of its vertices.
    pub(crate) fn of_vertices(self, left: &[u32]) -> Self {
        let normals = left.iter().map(|&v| self.scan_normals[v as usize]).collect();
        MlsSurface {
            levels: self.levels.iter().map(|level| level.of_vertices(left)).collect(),
            scan_normals: Arc::new(normals),
            place: left.iter().map(|&v| self.place[v as usize]).collect(),
            stays: left.iter().map(|&v| self.stays[v as usize]).collect(),
            fits: self.fits,
        }
    }

    /// Places near the foot points of all vertices: those on the polynomials of their own clusters alone. They are
    /// much nearer to the surface than the noise, and take a tenth of the time. The second value is how far
    /// each vertex moves there, along the normal.
    pub(crate) fn places_nearby(&self, mesh: &Mesh) -> (Vec<Point>, Vec<f64>) {
        let foot = |(v, &p): (usize, &Point)| {
            let (k, share) = split(self.place[v]);
            let own = |k: usize| {
                let level = self.levels.get(k)?;
                self.fits[k].get(*level.cluster.get(v)? as usize)
            };
            let (nearer, other) = if share < 0.5 { (k, k + 1) } else { (k + 1, k) };
            own(nearer).or_else(|| own(other)).map_or((p, 0.0), |fit| {
                let (foot, normal) = fit.at(p);
                (foot, (foot - p).dot(&normal))
            })
        };
        mesh.points.par_iter().enumerate().map(foot).unzip()
    }

    /// The foot points and normals of all vertices. A vertex with too few neighbours keeps its
    /// position.
    pub(crate) fn feet(
        &self,
        mesh: &Mesh,
        progress: &mut Progress,
    ) -> Result<(Vec<Point>, Vec<Vector>)> {
        let foot = |v: usize| {
            let (p, v) = (mesh.points[v], VertexId::from(v));
            self.project(v, p).map_or((p, self.scan_normal(v)), |foot| (foot.point, foot.normal))
        };
        let count = mesh.points.len();
        let (mut points, mut normals) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for first in (0..count).step_by(BLOCK) {
            progress(first as f64 / count as f64)?;
            let feet = (first..count.min(first + BLOCK)).into_par_iter().map(foot);
            let (more_points, more_normals): (Vec<Point>, Vec<Vector>) = feet.unzip();
            points.extend(more_points);
            normals.extend(more_normals);
        }
        Ok((points, normals))
    }

    /// The number of vertices for which there is a polynomial.
    pub(crate) fn reached(&self, mesh: &Mesh) -> f64 {
        let points = mesh.points.par_iter().enumerate();
        points.filter(|(v, p)| self.project(VertexId::from(*v), **p).is_some()).count() as f64
    }

    /// The supports of the vertices, in mm.
    pub(crate) fn supports(&self) -> impl Iterator<Item = f64> {
        self.place.iter().map(|&place| self.support(place))
    }

    /// The supports of the vertices that move to the surface, in mm, and 0 for others.
    pub(crate) fn smoothed_supports(&self) -> impl Iterator<Item = f64> {
        let moves = |(h, stays): (f64, &bool)| if *stays { 0.0 } else { h };
        self.supports().zip(&self.stays).map(moves)
    }

    /// The vertices of each level, the lower one where two are blended.
    pub(crate) fn by_level(&self) -> Vec<Vec<usize>> {
        let mut vertices = vec![Vec::new(); self.levels.len()];
        self.place.iter().enumerate().for_each(|(v, &place)| vertices[split(place).0].push(v));
        vertices
    }

    fn support(&self, place: f32) -> f64 {
        let (k, share) = split(place);
        let above = self.levels.get(k + 1).map_or(1.0, |above| above.h / self.levels[k].h);
        self.levels[k].h * above.powf(share)
    }

    /// The normal of the scan at a vertex, averaged over neighbouring points.
    fn scan_normal(&self, v: VertexId) -> Vector {
        self.scan_normals[v.index()]
    }

    /// Whether a vertex does not move.
    pub(crate) fn keeps(&self, v: VertexId) -> bool {
        self.stays[v.index()]
    }

    /// Moves `p`, which is near vertex `v`, to the surface, unless the vertex stays where it is.
    /// `None` if too few points are near.
    pub(super) fn project(&self, v: VertexId, p: Point) -> Option<Projection> {
        let foot = self.foot(v, p)?;
        Some(if self.keeps(v) { Projection { point: p, ..foot } } else { foot })
    }

    fn foot(&self, v: VertexId, p: Point) -> Option<Projection> {
        let (k, share) = split(self.place[v.index()]);
        let low = self.project_on(k, v, p);
        if share == 0.0 {
            return low;
        }
        match (low, self.project_on(k + 1, v, p)) {
            (Some(low), Some(high)) => Some(Projection {
                point: low.point + share * (high.point - low.point),
                normal: (low.normal + share * (high.normal - low.normal)).normalize(),
            }),
            (low, high) => low.or(high),
        }
    }

    fn project_on(&self, k: usize, v: VertexId, p: Point) -> Option<Projection> {
        let level = &self.levels[k];
        let own = *level.cluster.get(v.index())? as usize;
        let (mut weight, mut point, mut normal) = (0.0, Vector::zeros(), Vector::zeros());
        let beside = level.clusters.near(own).iter().map(|&c| c as usize);
        for c in std::iter::once(own).chain(beside) {
            let w = level.weight(c, p);
            if let Some(fit) = self.fits[k].get(c).filter(|_| w > NEGLIGIBLE) {
                let (foot, n) = fit.at(p);
                weight += w;
                point += w * (foot - p);
                normal += w * n;
            }
        }
        (weight > 0.0).then(|| Projection { point: p + point / weight, normal: normal.normalize() })
    }
}

/// The lower of two levels, and the share of the upper one.
fn split(place: f32) -> (usize, f64) {
    (place as usize, f64::from(place.fract()))
}

impl Fits {
    /// The fits of the clusters that are `needed`.
    fn new(level: &SupportLevel, needed: &[u32]) -> Self {
        let scratch_pool = ScratchPool::default();
        let fit = |&c: &u32| scratch_pool.with(|scratch| level.fit(c as usize, scratch));
        let fits: Vec<Option<Polynomial>> = needed.par_iter().map(fit).collect();
        let mut number = vec![NONE; level.clusters.samples.len()];
        let mut all = Vec::with_capacity(needed.len());
        for (&c, fit) in needed.iter().zip(fits) {
            if let Some(fit) = fit {
                number[c as usize] = all.len() as u32;
                all.push(fit);
            }
        }
        Fits { number, all }
    }

    fn get(&self, c: usize) -> Option<&Polynomial> {
        self.all.get(self.number[c] as usize)
    }
}

/// The clusters of level `k` that contain, or are next to a cluster that contains, a vertex at this
/// level.
fn needed(level: &SupportLevel, k: usize, place: &[f32]) -> Vec<u32> {
    let mut needed = vec![false; level.clusters.samples.len()];
    for (&c, &place) in level.cluster.iter().zip(place) {
        needed[c as usize] |= (place - k as f32).abs() < 1.0;
    }
    let held: Vec<usize> = (0..needed.len()).filter(|&c| needed[c]).collect();
    for c in held {
        level.clusters.near(c).iter().for_each(|&beside| needed[beside as usize] = true);
    }
    (0..needed.len() as u32).filter(|&c| needed[c as usize]).collect()
}
