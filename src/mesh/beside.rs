//! Pieces of a scan that touch or overlap each other and are not joined.

use super::components::Components;
use super::triangles::Triangles;
use super::{Choice, Mesh};
use crate::geometry::{FEW, Point, SAME_SIDE, SAMPLE, Vector, unit_normal};

/// A piece touches another one if at least this share of its rim is within an edge of it.
const LEAST_RIM: f64 = 0.05;

impl Components {
    /// The other components whose rims run along or over a component with this mesh, facing the same way. Of a scan
    /// in very many pieces the largest ones are looked at.
    pub(crate) fn beside(&self, component: Choice, mesh: &Mesh) -> Vec<usize> {
        if self.sizeable() < 2 {
            return Vec::new();
        }
        let (reach, own) = (mesh.mean_edge(), component.number());
        let [low, high] = mesh.bounds();
        let is_near = |p: &Point| (0..3).all(|k| low[k] - reach <= p[k] && p[k] <= high[k] + reach);
        let others = (0..self.sizeable().min(FEW)).filter(|&n| n != own);
        let rims = others.map(|n| (n, self.rim_of(n)));
        let rims: Vec<(usize, Vec<(Point, Vector)>)> =
            rims.filter(|(_, rim)| rim.iter().any(|(p, _)| is_near(p))).collect();
        if rims.is_empty() {
            return Vec::new();
        }
        let triangles = Triangles::new(mesh);
        let is_beside = |&&(p, normal): &&(Point, Vector)| {
            if !is_near(&p) {
                return false;
            }
            let (distance, t) = triangles.nearest(p);
            let faces = unit_normal(mesh.corners(mesh.triangles[t]));
            distance <= reach && faces.is_some_and(|own| own.dot(&normal) > SAME_SIDE)
        };
        let touches = |(_, rim): &&(usize, Vec<(Point, Vector)>)| {
            let step = rim.len().div_ceil(SAMPLE).max(1);
            let looked_at: Vec<&(Point, Vector)> = rim.iter().step_by(step).collect();
            let beside = looked_at.iter().filter(|at| is_beside(at)).count();
            beside as f64 > LEAST_RIM * looked_at.len() as f64
        };
        rims.iter().filter(touches).map(|(n, _)| *n).collect()
    }

    /// The middle of each side on the rim of a component, with the direction that its triangle faces.
    fn rim_of(&self, component: usize) -> Vec<(Point, Vector)> {
        let (mesh, edges) = (&self.build.mesh, &self.build.edges);
        let sides = self.pieces[component].iter().flat_map(|&t| 3 * t..3 * t + 3);
        let open = sides.filter(|&side| edges.across(side).is_none());
        let at = |side: usize| {
            let (a, b) = mesh.side(side);
            let normal = unit_normal(mesh.corners(mesh.triangles[side / 3]))?;
            Some((nalgebra::center(&mesh.point(a), &mesh.point(b)), normal))
        };
        open.filter_map(at).collect()
    }
}
