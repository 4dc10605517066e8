//! The control points that each quad of a subdivision surface depends on.
//!
//! Quads go in. For every quad, its control points come out in a fixed order, with the half-edges
//! that lead from a quad to its neighbours.

use std::collections::HashMap;

use crate::geometry::VertexId;

/// The half-edges of closed, oriented quads. Half-edge `4 q + k` leaves corner `k` of quad `q` and
/// ends at corner `k + 1`.
#[derive(Debug, Clone)]
pub(super) struct HalfEdges {
    quads: Vec<[VertexId; 4]>,
    twins: Vec<u32>,
}

impl HalfEdges {
    /// Returns `None` unless every side of a quad has exactly one quad on its other side.
    pub(super) fn new(quads: &[[VertexId; 4]]) -> Option<Self> {
        let ends = |h: usize| (quads[h / 4][h % 4], quads[h / 4][(h + 1) % 4]);
        let all: HashMap<_, u32> = (0..4 * quads.len()).map(|h| (ends(h), h as u32)).collect();
        if all.len() != 4 * quads.len() {
            return None;
        }
        let twin = |h| all.get(&(ends(h).1, ends(h).0)).copied();
        let twins = (0..4 * quads.len()).map(twin).collect::<Option<_>>()?;
        Some(HalfEdges { quads: quads.to_vec(), twins })
    }

    pub(crate) fn twin(&self, h: usize) -> usize {
        self.twins[h] as usize
    }

    fn next(h: usize, by: usize) -> usize {
        h / 4 * 4 + (h + by) % 4
    }

    /// The vertex at which a half-edge ends.
    fn end(&self, h: usize) -> u32 {
        self.quads[h / 4][(h + 1) % 4].0
    }

    /// The half-edge that leaves the same vertex, one quad further counter-clockwise.
    fn turned(&self, h: usize) -> usize {
        self.twin(Self::next(h, 3))
    }

    /// A vertex and its ring: the vertex, then for each quad around it counter-clockwise, from the
    /// half-edge `h` that leaves it, the end of the half-edge and the opposite corner of the quad.
    pub(super) fn ring(&self, h: usize, out: &mut Vec<u32>) {
        out.push(self.quads[h / 4][h % 4].0);
        let mut spoke = h;
        loop {
            out.push(self.end(spoke));
            out.push(self.end(Self::next(spoke, 1)));
            spoke = self.turned(spoke);
            if spoke == h {
                break;
            }
        }
    }

    /// The number of quads around the vertex that a half-edge leaves.
    pub(crate) fn valence(&self, h: usize) -> usize {
        let mut spoke = self.turned(h);
        let mut count = 1;
        while spoke != h {
            spoke = self.turned(spoke);
            count += 1;
        }
        count
    }

    /// The control points of the quad of `h`, in a grid in which the vertex that `h` leaves is at
    /// (0, 0), `h` ends at (1, 0), and the quad is to the left of `h`: the ring of that vertex, then
    /// the points at (2, −1), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2) and (−1, 2). The other three
    /// corners of the quad must have four quads.
    pub(super) fn control(&self, h: usize, out: &mut Vec<u32>) {
        self.ring(h, out);
        let right = self.twin(Self::next(h, 1));
        let top = self.twin(Self::next(h, 2));
        let end = |h: usize, by: usize| self.end(Self::next(h, by));
        out.extend([
            end(self.twin(Self::next(right, 1)), 2),
            end(right, 1),
            end(right, 2),
            end(self.twin(Self::next(right, 3)), 1),
            end(top, 1),
            end(top, 2),
            end(self.twin(Self::next(top, 3)), 1),
        ]);
    }
}
