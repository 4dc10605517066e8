//! What fails becomes facets: the triangles next to the place, and all of a face only if that fails again.

use std::collections::{BTreeMap, BTreeSet};

use super::{FacePatch, FacetForm, Fallback, Work};
use crate::geometry::sets::Sets;
use crate::primitives::PrimitiveKind;

/// A face loses triangles next to failing places so often, a strip each time. Then the strips become twice as wide each time, until all of
/// the face is lost if it fails again and again.
const TRIES: u32 = 24;

/// Why patches do not become faces.
#[derive(Debug, Clone)]
pub(super) struct SeamFault {
    /// The patches of which one has to yield.
    pub patches: Vec<usize>,
    /// The mesh vertices of the place. None stands for the whole patch.
    pub vertices: Vec<u32>,
    pub why: String,
}

impl SeamFault {
    pub(super) fn new(patches: &[usize], why: impl Into<String>) -> Self {
        SeamFault::near(patches, &[], why)
    }

    pub(super) fn near(patches: &[usize], vertices: &[u32], why: impl Into<String>) -> Self {
        SeamFault { patches: patches.to_vec(), vertices: vertices.to_vec(), why: why.into() }
    }
}

/// Triangles that leave a patch.
struct Loss<'a> {
    triangles: BTreeSet<u32>,
    why: &'a str,
}

impl Work<'_> {
    /// Makes facets of what failed. Returns false if nothing is left that can become facets.
    pub(super) fn give_up(&mut self, faults: &[SeamFault], fallbacks: &mut Vec<Fallback>) -> bool {
        let mut losses: BTreeMap<usize, Loss> = BTreeMap::new();
        for fault in faults {
            for (patch, triangles) in self.yielding(fault) {
                let fresh = || Loss { triangles: BTreeSet::new(), why: &fault.why };
                losses.entry(patch).or_insert_with(fresh).triangles.extend(triangles);
            }
        }
        if losses.is_empty() {
            let why = faults.first().map_or("", |fault| &fault.why);
            for i in (0..self.patches.len()).filter(|&i| self.can_yield(i)) {
                let triangles = self.patches[i].triangles.iter().copied().collect();
                losses.insert(i, Loss { triangles, why });
            }
        }
        for (&i, loss) in &losses {
            if !self.patches[i].is_facet {
                let is_curved = self.is_curved(i);
                loss.triangles.iter().for_each(|&t| self.is_lost[t as usize] |= is_curved);
                let first = loss.triangles.first().copied().unwrap_or_default() as usize;
                fallbacks.push(Fallback {
                    kind: self.patches[i].surface.kind(),
                    triangles: loss.triangles.len(),
                    place: self.mesh.point(self.mesh.triangles[first][0]),
                    why: loss.why.into(),
                });
            }
            self.lose(i, &loss.triangles);
        }
        !losses.is_empty()
    }

    /// Whether a patch can become smaller facets.
    fn can_yield(&self, i: usize) -> bool {
        !self.patches[i].is_facet || self.patches[i].triangles.len() > 1
    }

    fn is_curved(&self, i: usize) -> bool {
        self.patches[i].surface.kind() != PrimitiveKind::Plane
    }

    /// The patches that yield to a fault, and the triangles that they lose.
    fn yielding(&self, fault: &SeamFault) -> Vec<(usize, Vec<u32>)> {
        // Facets lose nothing, and small faces little. A plane that fails as a whole is wrong in its border.
        let rank = |&i: &usize| {
            let of = &self.patches[i];
            (if of.is_facet { 0 } else { 1 + u8::from(!self.is_curved(i)) }, of.triangles.len(), i)
        };
        let able = fault.patches.iter().copied().filter(|&i| self.can_yield(i));
        let first = able.min_by_key(rank);
        let is_flat = first.is_none_or(|i| !self.patches[i].is_facet && !self.is_curved(i));
        if is_flat && fault.vertices.is_empty() {
            let curved = self.neighbours(&fault.patches);
            let curved: Vec<usize> = curved.into_iter().filter(|&i| self.is_curved(i)).collect();
            if !curved.is_empty() {
                let border = self.corners_of(&fault.patches);
                return curved.into_iter().map(|i| (i, self.strip(i, &border))).collect();
            }
        }
        let Some(first) = first else {
            // Facets that cannot become smaller take the triangles around them.
            let around = self.neighbours(&fault.patches).into_iter();
            let around = around.filter(|&i| !self.patches[i].is_facet);
            let corners = self.corners_of(&fault.patches);
            return around.map(|i| (i, self.strip(i, &corners))).collect();
        };
        vec![(first, self.strip(first, &fault.vertices))]
    }

    fn corners_of(&self, patches: &[usize]) -> Vec<u32> {
        let triangles = patches.iter().flat_map(|&i| &self.patches[i].triangles);
        triangles.flat_map(|&t| self.mesh.triangles[t as usize].map(|v| v.0)).collect()
    }

    pub(super) fn neighbours(&self, patches: &[usize]) -> Vec<usize> {
        let mut found = BTreeSet::new();
        for &t in patches.iter().flat_map(|&i| &self.patches[i].triangles) {
            let sides = 3 * t as usize..3 * t as usize + 3;
            found.extend(sides.filter_map(|side| self.edges.across(side)).map(|twin| twin / 3));
        }
        let found: BTreeSet<usize> = found.into_iter().map(|t| self.of_triangle[t]).collect();
        found.into_iter().filter(|i| !patches.contains(i)).collect()
    }

    /// The triangles of a patch at given vertices, together with those in the planes of these triangles.
    fn strip(&self, i: usize, vertices: &[u32]) -> Vec<u32> {
        let patch = &self.patches[i];
        if vertices.is_empty() || patch.is_facet {
            return patch.triangles.clone();
        }
        let mut vertices: BTreeSet<u32> = vertices.iter().copied().collect();
        let wider = (self.tries[i] + 1).saturating_sub(TRIES);
        for _ in 1..1usize.checked_shl(wider).unwrap_or(usize::MAX) {
            let before = vertices.len();
            let corners = patch.triangles.iter().map(|&t| self.mesh.triangles[t as usize]);
            let at = corners.filter(|of| of.iter().any(|v| vertices.contains(&v.0)));
            let around: Vec<u32> = at.flatten().map(|v| v.0).collect();
            vertices.extend(around);
            if vertices.len() == before {
                break;
            }
        }
        let is_at = |t: &u32| {
            self.mesh.triangles[*t as usize].iter().any(|corner| vertices.contains(&corner.0))
        };
        let mut sets = self.flat_sets(&patch.triangles, self.is_curved(i));
        let lost: BTreeSet<usize> = (0..patch.triangles.len())
            .filter(|&k| is_at(&patch.triangles[k]))
            .map(|k| sets.find(k))
            .collect();
        let all = 0..patch.triangles.len();
        all.filter(|&k| lost.contains(&sets.find(k))).map(|k| patch.triangles[k]).collect()
    }

    /// Takes triangles out of a patch. They become facets, and the rest falls into connected patches.
    fn lose(&mut self, i: usize, triangles: &BTreeSet<u32>) {
        let old = self.patches[i].clone();
        let is_lost = |t: &u32| triangles.contains(t);
        let (lost, kept): (Vec<u32>, Vec<u32>) = old.triangles.iter().partition(|t| is_lost(t));
        // A facet falls into triangles, but for thin ones, and those too if it fails again.
        let flat = match old.is_facet && (self.tries[i] > 0 || matches!(old.form, FacetForm::Bent))
        {
            true => Sets::new(lost.len()),
            false => self.flat_sets(&lost, !old.is_facet && self.is_curved(i)),
        };
        let pick = |set: &[u32], from: &[u32]| set.iter().map(|&k| from[k as usize]).collect();
        let mut made: Vec<(FacePatch, u32)> = Vec::new();
        for set in self.joined(&kept).members() {
            made.push((
                FacePatch { triangles: pick(&set, &kept), ..old.clone() },
                self.tries[i] + 1,
            ));
        }
        for set in flat.members() {
            let triangles: Vec<u32> = pick(&set, &lost);
            let tries = u32::from(old.is_facet);
            let facet = FacePatch {
                is_facet: true,
                form: FacetForm::Flat,
                side: 1.0,
                triangles,
                ..old.clone()
            };
            made.push((facet, tries));
        }
        let mut made = made.into_iter();
        if let Some((first, tries)) = made.next() {
            (self.patches[i], self.tries[i]) = (first, tries);
        }
        for (patch, tries) in made {
            self.patches.push(patch);
            self.tries.push(tries);
        }
    }

    /// Triangles that share edges.
    pub(super) fn joined(&self, triangles: &[u32]) -> Sets {
        self.sets(triangles, |_, _| true)
    }

    /// Triangles that share edges and lie in a plane, or those that are too thin for a plane of their own with
    /// the one at their longest edge.
    fn flat_sets(&self, triangles: &[u32], if_in_plane: bool) -> Sets {
        self.sets(triangles, |side, twin| {
            self.is_thin(side) || self.is_thin(twin) || if_in_plane && self.is_flat(side, twin)
        })
    }

    fn sets(&self, triangles: &[u32], join: impl Fn(usize, usize) -> bool) -> Sets {
        let place: BTreeMap<u32, usize> =
            triangles.iter().enumerate().map(|(k, &t)| (t, k)).collect();
        let mut sets = Sets::new(triangles.len());
        for (k, &t) in triangles.iter().enumerate() {
            for side in 3 * t as usize..3 * t as usize + 3 {
                let Some(twin) = self.edges.across(side) else { continue };
                if let Some(&other) = place.get(&((twin / 3) as u32))
                    && join(side, twin)
                {
                    sets.join(k, other);
                }
            }
        }
        sets
    }
}
