//! The parts of a network that are kept after loops have cut it.

use nalgebra::Vector2;

use super::network::{Network, SideUse};
use super::{Curve, KnotVector};
use crate::geometry::{Uv, is_inside};

/// Loops on a network, and the faces on their left.
#[derive(Debug, Clone, Default)]
pub struct NetworkCut {
    /// Where loops cross tracks.
    pub nodes: Vec<TrackNode>,
    /// The parts of the loops on single surfaces.
    pub arcs: Vec<CutArc>,
    /// The faces that are kept. A surface that loops divide may have several.
    pub faces: Vec<KeptFace>,
}

/// A place at which a loop crosses a track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackNode {
    /// The track, as a position in [`Network::tracks`].
    pub track: usize,
    /// The parameter of the track.
    pub at: f64,
}

/// The part of a loop on one surface. What is kept lies on its left.
#[derive(Debug, Clone)]
pub struct CutArc {
    /// The surface.
    pub surface: usize,
    /// The curves in the parameter plane, one after another.
    pub pcurves: Vec<Curve<2>>,
    /// The nodes at its start and at its end. `None` if it is a whole loop.
    pub ends: Option<[usize; 2]>,
}

/// A face on a surface of the network.
#[derive(Debug, Clone)]
pub struct KeptFace {
    /// The surface.
    pub surface: usize,
    /// The loops; the first one is the outer one. It runs counter-clockwise, and the others run clockwise.
    pub loops: Vec<Vec<CutPart>>,
}

/// A part of a loop of a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CutPart {
    /// An arc, as a position in [`NetworkCut::arcs`].
    Arc(usize),
    /// A piece of a side: the number of the side, and the number of the piece along its track.
    Side(usize, usize),
}

/// An end of a piece of a track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PieceEnd {
    /// A corner of the network.
    Corner(usize),
    /// A node of the cut.
    Node(usize),
}

impl NetworkCut {
    /// The cut without loops, which keeps everything.
    pub fn none(network: &Network) -> Self {
        let sides = || vec![(0..4).map(|k| CutPart::Side(k, 0)).collect()];
        let face = |surface| KeptFace { surface, loops: sides() };
        let faces = (0..network.surfaces.len()).map(face).collect();
        NetworkCut { faces, ..NetworkCut::default() }
    }

    /// The ends of the pieces of each track, with their parameters in ascending order.
    pub(crate) fn piece_ends(&self, network: &Network) -> Vec<Vec<(f64, PieceEnd)>> {
        let ends = network.tracks.iter().map(|track| {
            let [start, end] = track.ends.map(PieceEnd::Corner);
            vec![(0.0, start), (network.end(), end)]
        });
        let mut ends: Vec<Vec<(f64, PieceEnd)>> = ends.collect();
        for (number, node) in self.nodes.iter().enumerate() {
            ends[node.track].push((node.at, PieceEnd::Node(number)));
        }
        ends.iter_mut().for_each(|ends| ends.sort_by(|a, b| a.0.total_cmp(&b.0)));
        ends
    }

    /// The places that are kept.
    pub fn kept_places(&self, network: &Network) -> KeptPlaces {
        let mut polygons = vec![Some(Vec::new()); network.surfaces.len()];
        for face in &self.faces {
            let of = &mut polygons[face.surface];
            match of {
                Some(of) if !face.is_whole() => {
                    let loops = self.boundary(network, face);
                    of.extend(loops.iter().map(|curves| chord_points(curves)));
                }
                _ => *of = None,
            }
        }
        KeptPlaces { polygons }
    }

    /// The loops of a face in the parameter plane of its surface.
    pub(crate) fn boundary(&self, network: &Network, face: &KeptFace) -> Vec<Vec<Curve<2>>> {
        let ends = self.piece_ends(network);
        let curves = |part: &CutPart| match *part {
            CutPart::Arc(arc) => self.arcs[arc].pcurves.clone(),
            CutPart::Side(k, piece) => {
                let side = network.sides[face.surface][k];
                let at = [0, 1].map(|i| ends[side.track][piece + i].0);
                let of = SideUse { face: face.surface, k, forward: side.forward };
                let line = side_line(network.end(), of, at);
                vec![if side.forward { line } else { line.reversed() }]
            }
        };
        face.loops.iter().map(|parts| parts.iter().flat_map(curves).collect()).collect()
    }
}

/// The places of a network that a cut keeps.
#[derive(Debug, Clone)]
pub struct KeptPlaces {
    /// The loops of the faces of each surface as polygons. `None` if the whole surface is kept.
    polygons: Vec<Option<Vec<Vec<Uv>>>>,
}

/// The number of points of a span by which a loop is approximated. The places that are asked for are
/// farther from loops than the chords, or it does not matter to which side they belong.
const CHORDS: usize = 8;

impl KeptPlaces {
    /// Whether a place is on a kept face. Places nearer to a loop than its chords may be on the other side.
    pub(crate) fn contains(&self, surface: usize, at: Uv) -> bool {
        match &self.polygons[surface] {
            None => true,
            Some(polygons) => polygons.iter().filter(|p| is_inside(at, p)).count() % 2 == 1,
        }
    }
}

/// Points along curves that follow each other.
pub(crate) fn chord_points(curves: &[Curve<2>]) -> Vec<Uv> {
    let points = |curve: &Curve<2>| {
        let breaks = curve.knots.breaks();
        let spans = breaks.windows(2).flat_map(|span| {
            let step = (span[1] - span[0]) / CHORDS as f64;
            (0..CHORDS).map(move |i| span[0] + step * i as f64)
        });
        spans.map(|t| Uv::from(curve.point(t))).collect::<Vec<_>>()
    };
    curves.iter().flat_map(points).collect()
}

impl KeptFace {
    /// Whether the face is a whole surface.
    pub(crate) fn is_whole(&self) -> bool {
        self.loops.iter().flatten().all(|part| matches!(part, CutPart::Side(..)))
    }
}

/// The straight pcurve along a piece of a side, in the direction of its track and with its
/// parameter.
pub(crate) fn side_line(end: f64, side: SideUse, [from, to]: [f64; 2]) -> Curve<2> {
    let at = |t: f64| {
        let place = side.place(end, t, 0.0);
        Vector2::new(place.x, place.y)
    };
    Curve::new(KnotVector::clamped(1, &[from, to], 1), vec![at(from), at(to)])
}
