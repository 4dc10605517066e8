//! Thinning: points that are much closer to each other than the spacing become one vertex.

use rayon::prelude::*;

use super::LEFT_OUT;
use super::nearest_lists::NearestLists;
use super::project::SurfacePoint;
use crate::geometry::Point;
use crate::mesh::Neighbours;

/// The share of the spacing below which a point is removed. Half keeps nearly all points of a
/// single scan; less leaves triangles that noise turns over.
const CLOSE: f64 = 0.5;

/// The same where the noise is large. Points then have moved so far that more of them are close;
/// half leaves false loops.
const CLOSE_IN_NOISE: f64 = 0.7;

/// The noise is large if it is more than this share of the spacing. Below it, the longer distance
/// loses small holes in sparse parts.
const LARGE_NOISE: f64 = 0.3;

/// The points that were kept, and the kept point that stands for each point.
pub(super) struct KeptPoints {
    /// The numbers of the points that were kept, ascending.
    pub points: Vec<u32>,
    /// For each point its vertex: a position in `points`, or [`LEFT_OUT`] for outliers.
    pub vertex: Vec<u32>,
}

impl KeptPoints {
    /// Keeps each point that no earlier one has removed. A kept point removes later ones that are
    /// closer than a share of its spacing, or closer than `apart`.
    pub(super) fn new(
        surface: &[SurfacePoint],
        spacing: &[f64],
        noise: f64,
        lists: &NearestLists,
        outlier: &[bool],
        apart: f64,
    ) -> Self {
        let place = |i: usize| surface[i].place;
        let places = || surface.iter().map(|s| s.place).collect::<Vec<Point>>();
        // The lists reach no farther than a few spacings.
        let near = (apart > 0.0).then(|| Neighbours::new(&places()));
        let mut found = Vec::new();
        let mut kept = KeptPoints { points: Vec::new(), vertex: vec![LEFT_OUT; surface.len()] };
        for i in 0..surface.len() {
            if outlier[i] || kept.vertex[i] != LEFT_OUT {
                continue;
            }
            let vertex = kept.points.len() as u32;
            kept.vertex[i] = vertex;
            kept.points.push(i as u32);
            let share = if noise > LARGE_NOISE * spacing[i] { CLOSE_IN_NOISE } else { CLOSE };
            let close = share * spacing[i];
            let around = match &near {
                Some(near) if apart > close => {
                    near.within(place(i), apart, &mut found);
                    &found
                }
                _ => lists.of(i),
            };
            let squared = close.max(apart).powi(2);
            for j in around.iter().map(|&j| j as usize) {
                let is_free = kept.vertex[j] == LEFT_OUT && !outlier[j];
                if is_free && (place(j) - place(i)).norm_squared() < squared {
                    kept.vertex[j] = vertex;
                }
            }
        }
        kept.choose_nearest(surface, lists);
        kept
    }

    /// Gives each removed point the nearest vertex among its neighbours. Without one it keeps the
    /// vertex that removed it.
    fn choose_nearest(&mut self, surface: &[SurfacePoint], lists: &NearestLists) {
        let is_kept = |j: u32| {
            let vertex = self.vertex[j as usize];
            vertex != LEFT_OUT && self.points[vertex as usize] == j
        };
        let nearest = |i: usize| {
            let vertex = self.vertex[i];
            if vertex == LEFT_OUT || is_kept(i as u32) {
                return vertex;
            }
            let squared = |&j: &u32| (surface[j as usize].place - surface[i].place).norm_squared();
            let kept = lists.of(i).iter().copied().filter(|&j| is_kept(j));
            let nearest = kept.min_by(|a, b| squared(a).total_cmp(&squared(b)));
            nearest.map_or(vertex, |j| self.vertex[j as usize])
        };
        let chosen = (0..surface.len()).into_par_iter().map(nearest).collect();
        self.vertex = chosen;
    }
}
