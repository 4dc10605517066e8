//! The boundary representation of a network of faces.

use formats::Brep;
use formats::brep::{BrepCurve, BrepSurface, EdgeId, EdgeUse, Face, Shell, Solid, VertexId};
use nalgebra::Vector2;

use super::{spline, spline_surface};
use crate::error::{BrepFault, Error, Result};
use crate::spline::{Curve, KnotVector, Network};

/// Builds and checks the solid that a closed network bounds. Its faces share edges and vertices.
///
/// # Errors
/// [`Error::Brep`] if the network is not closed or an edge is farther from a surface than
/// `uncertainty_mm`.
pub fn closed(network: &Network, name: &str, uncertainty_mm: f64) -> Result<Brep> {
    let mut brep = Brep { name: name.to_owned(), uncertainty_mm, ..Brep::default() };
    let corners = network.corners.iter().map(|&p| brep.add_vertex(p.coords.into()));
    let corners: Vec<VertexId> = corners.collect();
    let mut edges = Vec::with_capacity(network.tracks.len());
    for track in &network.tracks {
        let curve = BrepCurve::Spline(spline(&track.curve)?);
        edges.push(brep.add_edge(curve, track.ends.map(|end| corners[end])));
    }
    let mut faces = Vec::with_capacity(network.surfaces.len());
    for number in 0..network.surfaces.len() {
        let surface = BrepSurface::Spline(spline_surface(&network.surfaces[number])?);
        let surface = brep.add_surface(surface);
        let loops = vec![outer_loop(network, number, &edges)?];
        faces.push(brep.add_face(Face { surface, forward: true, loops }));
    }
    let outer = brep.add_shell(Shell { faces, closed: true });
    brep.solids.push(Solid { outer, voids: Vec::new() });
    brep.check().map_err(|fault| Error::Brep(BrepFault::Parts(fault)))?;
    Ok(brep)
}

/// The four sides of a surface as a loop, counter-clockwise.
fn outer_loop(network: &Network, number: usize, edges: &[EdgeId]) -> Result<Vec<EdgeUse>> {
    let surface = &network.surfaces[number];
    let ((u0, u1), (v0, v1)) = (surface.u.range(), surface.v.range());
    let corner = [(u0, v0), (u1, v0), (u1, v1), (u0, v1)].map(|(u, v)| Vector2::new(u, v));
    let mut uses = Vec::with_capacity(4);
    for (k, side) in network.sides[number].iter().enumerate() {
        let (mut from, mut to) = (corner[k], corner[(k + 1) % 4]);
        if !side.forward {
            std::mem::swap(&mut from, &mut to);
        }
        let (start, end) = network.tracks[side.track].curve.knots.range();
        let line = Curve::new(KnotVector::clamped(1, &[start, end], 1), vec![from, to]);
        let edge = edges[side.track];
        uses.push(EdgeUse { edge, forward: side.forward, pcurve: spline(&line)? });
    }
    Ok(uses)
}
