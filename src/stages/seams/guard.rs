//! The solid against the mesh: all corners are on their faces, and areas and the volume are what the mesh allows.

use std::collections::BTreeMap;

use formats::Brep;
use formats::brep::{FaceId, ShellId};

use super::fallback::SeamFault;
use super::free_face::FreeSurface;
use super::network::ChainNetwork;
use super::shell::none;
use super::{EXACT, FreeForms, Work, leading};
use crate::geometry::{Point, VertexId};
use crate::primitives::Primitive;

/// A corner is on its face within so many errors: κ = 2 for free fits, and a quarter more for snapped ones.
const ON_FACE: f64 = 2.5;

/// Loose edges of the model put corners off their faces by errors of up to this share of the part's diagonal, as measured on parts
/// of several systems.
const LOOSE: f64 = 2.5e-5;

/// Areas and volumes agree with their bounds to this share: rounding of the integrals.
const INTEGRALS: f64 = 1e-6;

/// Normals at a corner are taken this share of the way to the middle of the triangle, as an apex has none.
const INSIDE: f64 = 1e-3;

impl Work<'_> {
    /// How far edges and vertices may be from their faces where the mesh has an error: no farther than the model that was
    /// exported has them.
    pub(super) fn limit_at(&self, error: f64) -> f64 {
        self.limit.max(ON_FACE * error)
    }

    /// Whether a vertex of the mesh is on a surface.
    pub(super) fn is_on(&self, surface: &Primitive, v: VertexId) -> bool {
        let most = self.loose.max(ON_FACE * self.errors[v.index()]);
        surface.distance(self.mesh.point(v)).0.abs() <= most
    }

    /// Finds the corners that are not on their faces. Others may be off by loose edges of the model, and then
    /// their errors are larger than the rounding.
    pub(super) fn loosen(&mut self) -> Vec<SeamFault> {
        let most = ON_FACE * LOOSE * self.mesh.diagonal();
        let mut loose: f64 = 0.0;
        let mut faults = Vec::new();
        for (i, patch) in self.patches.iter().enumerate().filter(|(_, patch)| !patch.is_facet) {
            let corners = patch.triangles.iter().flat_map(|&t| self.mesh.triangles[t as usize]);
            let mut off = Vec::new();
            for v in corners {
                let away = patch.surface.distance(self.mesh.point(v)).0.abs();
                let error = &mut self.errors[v.index()];
                if away <= ON_FACE * *error {
                    continue;
                }
                if away <= most {
                    *error = away / ON_FACE;
                    loose = loose.max(away);
                } else {
                    off.push(v.0);
                }
            }
            off.sort_unstable();
            off.dedup();
            if !off.is_empty() {
                let why = format!("{} vertices are not on the surface", off.len());
                faults.push(SeamFault::near(&[i], &off, why));
            }
        }
        self.loose = loose;
        faults
    }

    /// Compares the areas of faces and the volume with the mesh.
    pub(super) fn guard(
        &self,
        brep: &Brep,
        strips: &[f64],
        patch_of: &[usize],
        free: &BTreeMap<usize, FreeSurface>,
    ) -> Result<(), Vec<SeamFault>> {
        let mut areas = vec![0.0; strips.len()];
        let is_known = |i: usize| self.free_forms != FreeForms::Near || !free.contains_key(&i);
        let known = patch_of.iter().enumerate().filter(|of| is_known(*of.1));
        known.for_each(|(n, &i)| areas[i] += brep.face_area(FaceId(n)));
        let mut worst: (f64, Vec<usize>) = (0.0, Vec::new());
        let mut faults = Vec::new();
        for (i, &strip) in strips.iter().enumerate().filter(|of| is_known(of.0)) {
            let own = areas[i];
            let [low, meshed, high] = match free.contains_key(&i) {
                true => self.free_areas(i, strip),
                false => self.areas(i, strip),
            };
            if !(own >= low && own <= high) {
                let why = format!("its area {own} is not between {low} and {high}");
                faults.push(SeamFault::new(&[i], why));
            }
            let off = (own / meshed.max(f64::MIN_POSITIVE) - 1.0).abs();
            if off > worst.0 {
                worst = (off, vec![i]);
            }
        }
        none(faults)?;
        if self.is_open() {
            return Ok(());
        }
        let volume = brep.volume(ShellId(0));
        let [low, high] = self.volumes(free);
        if volume >= low && volume <= high {
            return Ok(());
        }
        let why = format!("the volume {volume} is not between {low} and {high}");
        Err(vec![SeamFault::new(&worst.1, why)])
    }

    /// For each patch a bound of the area between its borders and the chords of the mesh.
    pub(super) fn strips(&self, network: &ChainNetwork) -> Vec<f64> {
        let mut strips = vec![0.0; self.patches.len()];
        for chain in &network.chains {
            let pair = self.pair(chain);
            let off = |p: Point| (pair.project(p) - p).norm();
            let places: Vec<Point> =
                chain.mesh_vertices.iter().map(|&v| self.mesh.points[v as usize]).collect();
            let mut offs: Vec<f64> = places.iter().map(|&p| off(p)).collect();
            if let Some(ends) = chain.ends {
                let last = places.len() - 1;
                offs[0] = (network.vertices[ends[0]] - places[0]).norm();
                offs[last] = (network.vertices[ends[1]] - places[last]).norm();
            }
            let mut bend = 0.0;
            if pair.is_led() {
                for (off, &p) in offs.iter_mut().zip(&places) {
                    *off = off.max(leading::off_polygon(&chain.points, p));
                }
                bend = leading::bend(&chain.points);
            }
            let parts = places.windows(2).zip(offs.windows(2));
            let of = |(ends, offs): (&[Point], &[f64])| {
                let middle = off(nalgebra::center(&ends[0], &ends[1])) + bend;
                (ends[1] - ends[0]).norm() * (middle + offs[0].max(offs[1]))
            };
            let area: f64 = parts.map(of).sum();
            for side in [chain.left, chain.right] {
                strips[side] += area;
                if chain.arch.is_some() && self.is_bent(side) {
                    // A parabola over a chord begins with a slope of four times its height by its length. Areas grow by half of
                    // the slope's square.
                    let long = (places[1] - places[0]).norm();
                    let slope = 4.0 * off(nalgebra::center(&places[0], &places[1])) / long;
                    strips[side] += 0.5 * slope * slope * self.patches[side].area(self.mesh);
                }
            }
        }
        strips
    }

    /// The bounds of the area of a face, and between them the area of its triangles. A facet whose normal leaves that
    /// of the surface by an angle covers an area between the squared cosine (one for each curvature) and its inverse; what lies between border and
    /// chords, the strip, comes on top.
    fn areas(&self, i: usize, strip: f64) -> [f64; 3] {
        let patch = &self.patches[i];
        let [mut low, mut meshed, mut high, mut around] = [0.0; 4];
        for &t in &patch.triangles {
            let corners = self.mesh.corners(self.mesh.triangles[t as usize]);
            let [a, b, c] = corners;
            let double = (b - a).cross(&(c - a));
            let area = 0.5 * double.norm();
            let middle = Point::from((a.coords + b.coords + c.coords) / 3.0);
            let cosine = |p: Point| {
                let normal = patch.surface.normal(p + INSIDE * (middle - p));
                patch.side * normal.dot(&double) / double.norm()
            };
            let least = corners.map(cosine).iter().copied().fold(1.0, f64::min);
            meshed += area;
            around += (b - a).norm() + (c - b).norm() + (a - c).norm();
            // A triangle that is turned over covers what others cover, too.
            low += area * least * least.abs();
            // A sliver has no normal, and no area.
            high += if least > 0.0 { area / (least * least) } else { area };
        }
        low -= strip;
        high += strip;
        // Edges that are off by what is exact cover as much.
        let slack = INTEGRALS * meshed + EXACT * around;
        [low - slack, meshed, high + slack]
    }

    /// The same of a free-form face, whose normals leave those of its triangles by no more than these turn.
    fn free_areas(&self, i: usize, strip: f64) -> [f64; 3] {
        // The length of the area vector is twice the area.
        let meshed = 0.5 * self.patches[i].area(self.mesh);
        let least = self.chord_error(i).turn.cos().powi(2);
        [meshed * least - strip, meshed, meshed / least + strip]
    }

    /// The bounds of the volume: that of the mesh, and each triangle's area times its largest distance from the surface
    /// on either side.
    fn volumes(&self, free: &BTreeMap<usize, FreeSurface>) -> [f64; 2] {
        let (mut volume, mut size) = (0.0, 0.0);
        let (mut low, mut high) = (0.0, 0.0);
        for (i, patch) in self.patches.iter().enumerate() {
            for &t in &patch.triangles {
                let [a, b, c] = self.mesh.corners(self.mesh.triangles[t as usize]);
                let cone = a.coords.dot(&b.coords.cross(&c.coords)) / 6.0;
                volume += cone;
                size += cone.abs();
                let area = 0.5 * (b - a).cross(&(c - a)).norm();
                if let Some(surface) = free.get(&i) {
                    low += area * surface.off;
                    high += area * surface.off;
                    continue;
                }
                let middle = Point::from((a.coords + b.coords + c.coords) / 3.0);
                let places = [
                    middle,
                    (a + b.coords) * 0.5,
                    (b + c.coords) * 0.5,
                    (c + a.coords) * 0.5,
                    a,
                    b,
                    c,
                ];
                let offs = places.map(|p| patch.side * patch.surface.distance(p).0);
                // Where the mesh is outside, the solid is smaller.
                low += area * offs.iter().copied().fold(0.0, f64::max);
                high -= area * offs.iter().copied().fold(0.0, f64::min);
            }
        }
        let slack = INTEGRALS * size;
        [volume - low - slack, volume + high + slack]
    }
}
