//! Free-form faces in place of facets that hang together. Each is a B-spline surface through its border: no edge of it crosses the face.
//!
//! The border runs through the vertices of the mesh, smoothly and on the faces beside it. Four corners divide it into the sides of the surface,
//! and the vertices inside bend it. A face that leaves its triangles or folds is divided into halves, and into facets at last.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use super::Fallback;
use super::fallback::SeamFault;
use super::free_face::FreeSurface;
use super::shell::{BuiltShell, shell};
use super::{FacePatch, FacetForm, FreeForms, Work};
use crate::geometry::VertexId;
use crate::spline::Surface;

/// The rounds in which faces that fail are halved. In later ones they become facets. A check sees what the ones before it let pass, so that most rounds
/// have few faces left to divide.
const HALVED: usize = 24;

/// The most rounds.
const ROUNDS: usize = 60;

/// So many facets of a clean mesh that hang together smoothly are a curved face whose surface is not known.
pub(super) const FEWEST_FACETS: usize = 5;

/// The vertices of a border that may become corners: those with the sharpest angles, and some in even distances.
const SHARPEST: usize = 12;
const EVEN: usize = 8;

/// The facets that a free-form face takes the place of, and its surface.
#[derive(Debug)]
pub struct FreeForm {
    facets: Vec<FacePatch>,
    /// The border counterclockwise, from a corner on.
    pub(super) border: Vec<VertexId>,
    /// The places of the four corners in the border.
    pub(super) corners: [usize; 4],
    /// The vertices where the border of a face of a clean mesh turns sharply.
    kinks: BTreeSet<VertexId>,
    surface: Option<Surface>,
    off: f64,
    passes: f64,
}

impl FreeForm {
    /// Whether curves of the border end at a vertex of the mesh.
    pub(super) fn is_corner(&self, v: usize) -> bool {
        self.corners.iter().any(|&k| self.border[k].index() == v)
            || self.kinks.contains(&VertexId(v as u32))
    }

    /// The surface of a face that was made.
    pub fn surface(&self) -> Option<&Surface> {
        self.surface.as_ref()
    }

    /// The farthest that it is off its triangles, in mm.
    pub fn off(&self) -> f64 {
        self.off
    }

    /// Within how many mm it passes the vertices of a clean mesh.
    pub(crate) fn passes(&self) -> f64 {
        self.passes
    }
}

/// A vertex that may be a corner.
struct BorderCorner {
    place: usize,
    /// How far along the border it is.
    along: f64,
    /// What is lost if it is a corner. A side without one where the border turns would have a kink.
    cost: f64,
}

impl Work<'_> {
    pub(super) fn is_free(&self, i: usize) -> bool {
        self.patches[i].free_form().is_some()
    }

    /// The shell with free-form faces in place of its facets as far as that is valid. Other faces may become facets for it.
    pub(super) fn with_free_forms(
        mut self,
        built: BuiltShell,
        fallbacks: &mut Vec<Fallback>,
    ) -> BuiltShell {
        if self.is_open() || self.free_forms == FreeForms::None {
            return built;
        }
        let (facets, exact): (Vec<_>, Vec<_>) =
            self.patches.drain(..).partition(|patch| patch.is_facet);
        self.patches = exact;
        self.number();
        self.most_sagitta = self.most_sagitta();
        self.patches.extend(self.hung_together(facets));
        let mut lost = Vec::new();
        for round in 0..ROUNDS {
            if !self.patches.iter().any(|patch| patch.free_form().is_some()) {
                break;
            }
            self.tries = vec![0; self.patches.len()];
            self.number();
            match shell(&mut self) {
                Ok(better) => {
                    fallbacks.extend(lost);
                    return better;
                }
                Err(faults) if self.divide(&faults, round < HALVED) => {}
                Err(faults) if self.give_up(&faults, &mut lost) => {}
                Err(_) => break,
            }
        }
        built
    }

    /// The facets with free-form faces in place of those that hang together.
    fn hung_together(&self, facets: Vec<FacePatch>) -> Vec<FacePatch> {
        let made = |own: Vec<FacePatch>| {
            if self.is_curved_face(&own) { self.joined_facets(own) } else { own }
        };
        self.groups(&facets, self.most_sagitta).into_iter().flat_map(made).collect()
    }

    /// Whether facets that hang together are a curved face. Few ones in a clean mesh may be meant as they are, unless a curved face lost them.
    fn is_curved_face(&self, facets: &[FacePatch]) -> bool {
        let mut triangles = facets.iter().flat_map(|of| &of.triangles);
        self.free_forms == FreeForms::Near
            || facets.len() >= FEWEST_FACETS
            || triangles.any(|&t| self.is_lost[t as usize])
    }

    /// A free-form face of facets that hang together. What has no border of one loop is divided.
    fn joined_facets(&self, facets: Vec<FacePatch>) -> Vec<FacePatch> {
        if facets.len() == 1 {
            return facets;
        }
        match self.free_form_of(&facets) {
            Some(form) => {
                let triangles = facets.iter().flat_map(|of| of.triangles.clone()).collect();
                let form = FreeForm { facets, ..form };
                let joined = FacePatch::facet(self.mesh, triangles);
                vec![FacePatch { form: FacetForm::Free(Arc::new(form)), ..joined }]
            }
            None => self.divided(facets),
        }
    }

    /// The free-form faces of facets that hang together, divided at the borders of wide ones if there are such, else into halves.
    fn divided(&self, facets: Vec<FacePatch>) -> Vec<FacePatch> {
        let parts = self.groups(&facets, None);
        if parts.len() > 1 {
            return parts.into_iter().flat_map(|part| self.joined_facets(part)).collect();
        }
        let is_first = self.halves(&facets);
        let half = |k: bool| {
            let own = facets.iter().zip(&is_first).filter(|of| *of.1 == k);
            own.map(|(facet, _)| facet.clone()).collect()
        };
        [true, false].into_iter().flat_map(|k| self.joined_facets(half(k))).collect()
    }

    /// The border and the corners of a free-form face, if its facets have one border.
    fn free_form_of(&self, facets: &[FacePatch]) -> Option<FreeForm> {
        let triangles: BTreeSet<u32> = facets.iter().flat_map(|of| of.triangles.clone()).collect();
        let border = self.border_of(&triangles)?;
        let corners = self.corners_of_border(&border, &triangles)?;
        let border = [&border[corners[0]..], &border[..corners[0]]].concat();
        let corners = corners.map(|k| (k + border.len() - corners[0]) % border.len());
        let kinks = self.kinks_of(&border);
        Some(FreeForm {
            facets: Vec::new(),
            border,
            corners,
            kinks,
            surface: None,
            off: 0.0,
            passes: 0.0,
        })
    }

    /// Where a border in a clean mesh turns by more than a smooth one.
    fn kinks_of(&self, border: &[VertexId]) -> BTreeSet<VertexId> {
        let FreeForms::Through { turn, .. } = self.free_forms else { return BTreeSet::new() };
        let n = border.len();
        let is_kink = |k: &usize| {
            let [p, q, r] = [k + n - 1, *k, k + 1].map(|k| self.mesh.point(border[k % n]));
            (q - p).angle(&(r - q)) > turn
        };
        (0..n).filter(is_kink).map(|k| border[k]).collect()
    }

    /// The border of some triangles counterclockwise, if they are a disk.
    fn border_of(&self, triangles: &BTreeSet<u32>) -> Option<Vec<VertexId>> {
        let mut next: BTreeMap<VertexId, VertexId> = BTreeMap::new();
        let mut vertices = BTreeSet::new();
        let mut inner = 0;
        for side in triangles.iter().flat_map(|&t| 3 * t as usize..3 * t as usize + 3) {
            let (from, to) = self.mesh.side(side);
            vertices.insert(from);
            let twin = self.edges.across(side)?;
            if triangles.contains(&((twin / 3) as u32)) {
                inner += 1;
            } else if next.insert(from, to).is_some() {
                return None;
            }
        }
        // Euler's number of a disk is 1.
        let edges = inner / 2 + next.len();
        if vertices.len() + triangles.len() != edges + 1 {
            return None;
        }
        let (&first, &second) = next.first_key_value()?;
        let mut border = vec![first];
        let mut at = second;
        while at != first {
            border.push(at);
            at = *next.get(&at)?;
        }
        (border.len() == next.len()).then_some(border)
    }

    /// The four vertices of a border between which its sides are best: right angles, and opposite sides of the same length.
    fn corners_of_border(
        &self,
        border: &[VertexId],
        triangles: &BTreeSet<u32>,
    ) -> Option<[usize; 4]> {
        let n = border.len();
        let mut angles: BTreeMap<VertexId, f64> = border.iter().map(|&v| (v, 0.0)).collect();
        for &t in triangles {
            let corners = self.mesh.triangles[t as usize];
            for k in 0..3 {
                let [p, q, r] = [0, 1, 2].map(|j| self.mesh.point(corners[(k + j) % 3]));
                if let Some(angle) = angles.get_mut(&corners[k]) {
                    *angle += (q - p).angle(&(r - p));
                }
            }
        }
        let mut along = vec![0.0];
        for k in 0..n {
            let step = self.mesh.point(border[(k + 1) % n]) - self.mesh.point(border[k]);
            along.push(along[k] + step.norm());
        }
        let whole = along[n];
        let cost = |k: usize| {
            let angle = angles[&border[k]];
            (angle - FRAC_PI_2).powi(2) - (PI - angle).max(0.0).powi(2)
        };
        let mut sharp: Vec<usize> = (0..n).collect();
        sharp.sort_by(|&a, &b| cost(a).total_cmp(&cost(b)).then(a.cmp(&b)));
        let mut places: BTreeSet<usize> = sharp.into_iter().take(SHARPEST).collect();
        let even = |k: usize| along[..n].partition_point(|&s| s < whole * k as f64 / EVEN as f64);
        places.extend((0..EVEN).map(even).filter(|&k| k < n));
        let candidate =
            |place: usize| BorderCorner { place, along: along[place], cost: cost(place) };
        let candidates: Vec<BorderCorner> = places.into_iter().map(candidate).collect();
        let unlike = |a: f64, b: f64| (a / b).ln().powi(2);
        let mut best: Option<(f64, [usize; 4])> = None;
        for (a, first) in candidates.iter().enumerate() {
            for (b, second) in candidates.iter().enumerate().skip(a + 1) {
                for (c, third) in candidates.iter().enumerate().skip(b + 1) {
                    for fourth in &candidates[c + 1..] {
                        let sides = [
                            second.along - first.along,
                            third.along - second.along,
                            fourth.along - third.along,
                            whole + first.along - fourth.along,
                        ];
                        let all = [first, second, third, fourth];
                        let found = all.iter().map(|of| of.cost).sum::<f64>()
                            + unlike(sides[0], sides[2])
                            + unlike(sides[1], sides[3]);
                        if best.is_none_or(|(least, _)| found < least) {
                            best = Some((found, all.map(|of| of.place)));
                        }
                    }
                }
            }
        }
        // The second side is one of the two long ones: programs integrate over faces with few places along u.
        best.map(|(_, [a, b, c, d])| {
            let long = |from: usize, to: usize| (along[to] - along[from]).rem_euclid(whole);
            let turned = long(a, b) + long(c, d) > long(b, c) + long(d, a);
            if turned { [b, c, d, a] } else { [a, b, c, d] }
        })
    }

    /// Divides the free-form faces at the faults, or makes facets of them. Returns false if there are none.
    fn divide(&mut self, faults: &[SeamFault], halves: bool) -> bool {
        let mut failed: BTreeSet<usize> = BTreeSet::new();
        for fault in faults {
            let own = fault.patches.iter().copied().filter(|&i| self.is_free(i));
            let mut own: BTreeSet<usize> = own.collect();
            if own.is_empty() {
                let beside = self.neighbours(&fault.patches).into_iter();
                own.extend(beside.filter(|&i| self.is_free(i)));
                let at: BTreeSet<usize> =
                    own.iter().copied().filter(|&i| self.touches(i, &fault.vertices)).collect();
                if !at.is_empty() {
                    own = at;
                }
            }
            failed.extend(own);
        }
        let mut patches = Vec::new();
        for (i, patch) in std::mem::take(&mut self.patches).into_iter().enumerate() {
            match patch.free_form().filter(|_| failed.contains(&i)) {
                Some(form) if halves => patches.extend(self.divided(form.facets.clone())),
                Some(form) => patches.extend(form.facets.clone()),
                None => patches.push(patch),
            }
        }
        self.patches = patches;
        !failed.is_empty()
    }

    fn touches(&self, i: usize, vertices: &[u32]) -> bool {
        let corners = self.patches[i].triangles.iter();
        let mut corners = corners.flat_map(|&t| self.mesh.triangles[t as usize]);
        corners.any(|v| vertices.contains(&v.0))
    }

    /// A patch with the surface that was made for it.
    pub(super) fn made_patch(&self, i: usize, free: &BTreeMap<usize, FreeSurface>) -> FacePatch {
        let patch = self.patches[i].clone();
        let (Some(form), Some(made)) = (patch.free_form(), free.get(&i)) else { return patch };
        let form = FreeForm {
            facets: Vec::new(),
            border: form.border.clone(),
            corners: form.corners,
            kinks: BTreeSet::new(),
            surface: Some(made.surface.clone()),
            off: made.off,
            passes: made.passes,
        };
        FacePatch { form: FacetForm::Free(Arc::new(form)), ..patch }
    }
}
