//! The boundary representation of a network of faces.

use formats::Brep;
use formats::brep::{BrepCurve, BrepSurface, EdgeId, EdgeUse, Face, Shell, Solid, VertexId};

use super::{spline, spline_surface};
use crate::error::{BrepFault, Error, Result};
use crate::geometry::Point;
use crate::spline::{
    Curve, CutPart, KeptFace, Network, NetworkCut, PieceEnd, SideUse, curve_on_surface, side_line,
};

/// Builds and checks the solid that a closed network bounds. Its faces share edges and vertices.
///
/// # Errors
/// [`Error::Brep`] if the network is not closed or an edge is farther from a surface than
/// `uncertainty_mm`.
pub fn closed(network: &Network, name: &str, uncertainty_mm: f64) -> Result<Brep> {
    let cut = NetworkCut::none(network);
    let mut parts = NetworkParts::new(network, &cut, name, uncertainty_mm)?;
    let outer = parts.shell(true)?;
    parts.brep.solids.push(Solid { outer, voids: Vec::new() });
    parts.checked()
}

/// Builds and checks a closed shell that faces into a void.
///
/// # Errors
/// Those of [`closed`].
pub fn void(network: &Network, name: &str, uncertainty_mm: f64) -> Result<Brep> {
    let cut = NetworkCut::none(network);
    let mut parts = NetworkParts::new(network, &cut, name, uncertainty_mm)?;
    parts.shell(true)?;
    parts.checked()
}

/// Builds and checks the shell of the faces that a cut leaves of a network. They share edges and
/// vertices, and the loops of the cut are the boundary of the shell.
///
/// # Errors
/// [`Error::Brep`] if the faces do not fit together or an edge is farther from a surface than
/// `uncertainty_mm`.
pub fn open(network: &Network, cut: &NetworkCut, name: &str, uncertainty_mm: f64) -> Result<Brep> {
    let mut parts = NetworkParts::new(network, cut, name, uncertainty_mm)?;
    parts.shell(false)?;
    parts.checked()
}

/// The edges of a network while its faces are added.
struct NetworkParts<'a> {
    network: &'a Network,
    cut: &'a NetworkCut,
    /// The edges along each track, and the parameters at their ends.
    pieces: Vec<Vec<(Option<EdgeId>, [f64; 2])>>,
    /// The edges along each arc.
    arcs: Vec<Vec<EdgeId>>,
    brep: Brep,
}

impl<'a> NetworkParts<'a> {
    fn new(
        network: &'a Network,
        cut: &'a NetworkCut,
        name: &str,
        uncertainty_mm: f64,
    ) -> Result<Self> {
        let brep = Brep { name: name.to_owned(), uncertainty_mm, ..Brep::default() };
        let mut parts = NetworkParts { network, cut, pieces: Vec::new(), arcs: Vec::new(), brep };
        parts.add_edges()?;
        Ok(parts)
    }

    /// Adds the edges that kept faces have, with their vertices.
    fn add_edges(&mut self) -> Result<()> {
        let ends = self.cut.piece_ends(self.network);
        let mut is_kept: Vec<Vec<bool>> = ends.iter().map(|ends| vec![false; ends.len()]).collect();
        for face in &self.cut.faces {
            for part in face.loops.iter().flatten() {
                if let CutPart::Side(k, piece) = *part {
                    is_kept[self.network.sides[face.surface][k].track][piece] = true;
                }
            }
        }
        let mut corners = vec![None; self.network.corners.len()];
        let of_node = |node: &crate::spline::TrackNode| {
            Point::from(self.network.tracks[node.track].curve.point(node.at))
        };
        let nodes: Vec<Point> = self.cut.nodes.iter().map(of_node).collect();
        let nodes: Vec<VertexId> =
            nodes.iter().map(|p| self.brep.add_vertex(p.coords.into())).collect();
        for (track, ends) in ends.iter().enumerate() {
            let mut pieces = Vec::with_capacity(ends.len() - 1);
            for (piece, pair) in ends.windows(2).enumerate() {
                let range = [pair[0].0, pair[1].0];
                if !is_kept[track][piece] {
                    pieces.push((None, range));
                    continue;
                }
                let vertices = [pair[0].1, pair[1].1].map(|end| match end {
                    PieceEnd::Node(node) => nodes[node],
                    PieceEnd::Corner(corner) => {
                        let p = self.network.corners[corner];
                        *corners[corner]
                            .get_or_insert_with(|| self.brep.add_vertex(p.coords.into()))
                    }
                });
                let whole = &self.network.tracks[track].curve;
                let curve =
                    if ends.len() == 2 { whole.clone() } else { whole.part(range[0], range[1]) };
                let edge = self.brep.add_edge(BrepCurve::Spline(spline(&curve)?), vertices);
                pieces.push((Some(edge), range));
            }
            self.pieces.push(pieces);
        }
        for arc in 0..self.cut.arcs.len() {
            let edges = self.arc_edges(arc, &nodes)?;
            self.arcs.push(edges);
        }
        Ok(())
    }

    /// Adds the edges of an arc.
    fn arc_edges(&mut self, arc: usize, nodes: &[VertexId]) -> Result<Vec<EdgeId>> {
        let arc = &self.cut.arcs[arc];
        let surface = &self.network.surfaces[arc.surface];
        let start = |pcurve: &Curve<2>| surface.point(pcurve.control[0].into()).coords.into();
        let mut vertices: Vec<VertexId> = Vec::new();
        for (i, pcurve) in arc.pcurves.iter().enumerate() {
            vertices.push(match arc.ends {
                Some([first, _]) if i == 0 => nodes[first],
                _ => self.brep.add_vertex(start(pcurve)),
            });
        }
        vertices.push(arc.ends.map_or(vertices[0], |ends| nodes[ends[1]]));
        let mut edges = Vec::with_capacity(arc.pcurves.len());
        for (pcurve, ends) in arc.pcurves.iter().zip(vertices.windows(2)) {
            let edge = curve_on_surface(surface, pcurve, self.brep.uncertainty_mm);
            edges.push(self.brep.add_edge(BrepCurve::Spline(spline(&edge)?), [ends[0], ends[1]]));
        }
        Ok(edges)
    }

    /// Adds the kept faces as a shell.
    fn shell(&mut self, closed: bool) -> Result<formats::brep::ShellId> {
        let mut faces = Vec::with_capacity(self.cut.faces.len());
        let mut surfaces = vec![None; self.network.surfaces.len()];
        for number in 0..self.cut.faces.len() {
            let face = self.cut.faces[number].clone();
            let surface = match surfaces[face.surface] {
                Some(surface) => surface,
                None => {
                    let surface = spline_surface(&self.network.surfaces[face.surface])?;
                    self.brep.add_surface(BrepSurface::Spline(surface))
                }
            };
            surfaces[face.surface] = Some(surface);
            let loops = face.loops.iter().map(|parts| self.edge_uses(&face, parts));
            let loops = loops.collect::<Result<_>>()?;
            faces.push(self.brep.add_face(Face { surface, forward: true, loops }));
        }
        Ok(self.brep.add_shell(Shell { faces, closed }))
    }

    /// A loop of a face.
    fn edge_uses(&self, face: &KeptFace, parts: &[CutPart]) -> Result<Vec<EdgeUse>> {
        let mut uses = Vec::new();
        for part in parts {
            match *part {
                CutPart::Arc(arc) => {
                    for (&edge, pcurve) in self.arcs[arc].iter().zip(&self.cut.arcs[arc].pcurves) {
                        uses.push(EdgeUse { edge, forward: true, pcurve: spline(pcurve)?.into() });
                    }
                }
                CutPart::Side(k, piece) => {
                    let side = self.network.sides[face.surface][k];
                    let (Some(edge), range) = self.pieces[side.track][piece] else { continue };
                    let forward = side.forward;
                    let of = SideUse { face: face.surface, k, forward };
                    let pcurve = spline(&side_line(self.network.end(), of, range))?.into();
                    uses.push(EdgeUse { edge, forward, pcurve });
                }
            }
        }
        Ok(uses)
    }

    fn checked(self) -> Result<Brep> {
        self.brep.check().map_err(|fault| Error::Brep(BrepFault::Parts(fault)))?;
        Ok(self.brep)
    }
}
