//! The boundary representation of a trimmed surface.
//!
//! The input is the fitted surface and the loops of its faces. The output is a checked
//! [`formats::Brep`]. The outer loop of a face is a trim loop or the four sides of the surface as
//! exact iso-curves. Every hole is an inner loop. An island in a hole is another face on the same
//! surface.

mod check;
mod network;

use formats::Brep;
use formats::brep::{self, EdgeUse, Face, Shell, SurfaceId, VertexId};
use formats::spline::{SplineCurve, SplineKnots, SplineSurface};
use nalgebra::{SVector, Vector2};

use crate::error::{BrepFault, Error, Result};
use crate::spline::{Curve, KnotVector, MOST_SPANS, Surface, runs};
pub use network::{closed, open, void};

/// An edge, its pcurve, and whether the loop runs in the direction of the edge.
type Directed = (Curve<3>, Curve<2>, bool);

/// A closed loop: its pcurves and the edges in space that they trace.
pub(crate) type Arcs<'a> = (&'a [Curve<2>], &'a [Curve<3>]);

/// The loops that bound one face of the surface.
#[derive(Debug, Clone, Default)]
pub struct FaceBounds<'a> {
    /// The outer loop, counter-clockwise in (u, v). `None` stands for the sides of the surface.
    pub outer: Option<Arcs<'a>>,
    /// The inner loops, clockwise in (u, v).
    pub inner: Vec<Arcs<'a>>,
}

/// Builds and checks the B-rep of faces that lie on one surface.
///
/// # Errors
/// [`Error::Brep`] if a loop is open, runs the wrong way, leaves the domain, or crosses itself or
/// another loop, or if an edge is farther from the surface than `uncertainty_mm`.
pub fn build(
    surface: &Surface,
    faces: &[FaceBounds],
    name: &str,
    uncertainty_mm: f64,
) -> Result<Brep> {
    check::check(faces).map_err(Error::Brep)?;
    let mut brep = Brep { name: name.to_owned(), uncertainty_mm, ..Brep::default() };
    let on = brep.add_surface(brep::BrepSurface::Spline(spline_surface(surface)?));
    for bounds in faces {
        let outer = bounds.outer.map_or_else(|| outer_edges(surface), forwards);
        let mut loops = vec![add_loop(&mut brep, &outer)?];
        for &arcs in &bounds.inner {
            loops.push(add_loop(&mut brep, &forwards(arcs))?);
        }
        add_sheet(&mut brep, on, loops);
    }
    brep.check().map_err(|fault| Error::Brep(BrepFault::Parts(fault)))?;
    Ok(brep)
}

/// The edges of a loop that runs in the direction of all its edges.
fn forwards((pcurves, edges): Arcs) -> Vec<Directed> {
    let along = |(e, c): (&Curve<3>, &Curve<2>)| (e.clone(), c.clone(), true);
    edges.iter().zip(pcurves).map(along).collect()
}

/// Adds a face with its own shell. Faces on the same surface share no edges.
fn add_sheet(brep: &mut Brep, surface: SurfaceId, loops: Vec<Vec<EdgeUse>>) {
    let face = brep.add_face(Face { surface, forward: true, loops });
    brep.add_shell(Shell { faces: vec![face], closed: false });
}

/// Adds the edges of a closed loop. Neighbouring edges share a vertex.
fn add_loop(brep: &mut Brep, ring: &[Directed]) -> Result<Vec<EdgeUse>> {
    let start = |(edge, _, forward): &Directed| {
        let end = if *forward { edge.control.first() } else { edge.control.last() };
        end.copied().unwrap_or_default().into()
    };
    let vertices: Vec<VertexId> = ring.iter().map(|edge| brep.add_vertex(start(edge))).collect();
    let mut uses = Vec::with_capacity(ring.len());
    for (k, (edge, pcurve, forward)) in ring.iter().enumerate() {
        let mut ends = [vertices[k], vertices[(k + 1) % ring.len()]];
        if !forward {
            ends.reverse();
        }
        let edge = brep.add_edge(brep::BrepCurve::Spline(spline(edge)?), ends);
        uses.push(EdgeUse { edge, forward: *forward, pcurve: spline(pcurve)?.into() });
    }
    Ok(uses)
}

fn spline_surface(surface: &Surface) -> Result<SplineSurface> {
    let net = surface.net.iter().map(|&p| p.into()).collect();
    SplineSurface::new(knots(&surface.u)?, knots(&surface.v)?, net, None).map_err(unsuited)
}

fn spline<const D: usize>(curve: &Curve<D>) -> Result<SplineCurve<D>> {
    let poles = curve.control.iter().map(|&p: &SVector<f64, D>| p.into()).collect();
    let knots = &curve.knots;
    SplineCurve::new(knots.degree(), knots.knots().to_vec(), poles, None).map_err(unsuited)
}

fn knots(knots: &KnotVector) -> Result<SplineKnots> {
    SplineKnots::new(knots.degree(), knots.knots().to_vec(), knots.functions()).map_err(unsuited)
}

fn unsuited(what: String) -> Error {
    Error::Brep(BrepFault::Spline(what))
}

/// The four sides of the surface, counter-clockwise from (0, 0): exact iso-curves with straight
/// lines as pcurves. Each side is divided into edges of a few knot spans.
pub fn outer_edges(surface: &Surface) -> Vec<(Curve<3>, Curve<2>, bool)> {
    let [nu, nv] = surface.shape();
    let along_u = |j: usize| {
        let control = (0..nu).map(|i| surface.control(i, j)).collect();
        Curve::new(surface.u.clone(), control)
    };
    let along_v = |i: usize| {
        let control = (0..nv).map(|j| surface.control(i, j)).collect();
        Curve::new(surface.v.clone(), control)
    };
    let ((u0, u1), (v0, v1)) = (surface.u.range(), surface.v.range());
    let at_v = |v: f64| move |t: f64| Vector2::new(t, v);
    let at_u = |u: f64| move |t: f64| Vector2::new(u, t);
    let mut sides = parts(&along_u(0), &at_v(v0), true);
    sides.extend(parts(&along_v(nu - 1), &at_u(u1), true));
    sides.extend(parts(&along_u(nv - 1), &at_v(v1), false));
    sides.extend(parts(&along_v(0), &at_u(u0), false));
    sides
}

/// The edges of a side in the order of the outer loop. `at` maps a parameter of the side to its
/// parameter point on the surface.
fn parts(
    side: &Curve<3>,
    at: &dyn Fn(f64) -> Vector2<f64>,
    forward: bool,
) -> Vec<(Curve<3>, Curve<2>, bool)> {
    let ends = runs(&side.knots.breaks(), MOST_SPANS, 1);
    let part = |w: &[f64]| {
        let line = Curve::new(KnotVector::clamped(1, w, 1), vec![at(w[0]), at(w[1])]);
        (side.part(w[0], w[1]), line, forward)
    };
    let mut parts: Vec<_> = ends.windows(2).map(part).collect();
    if !forward {
        parts.reverse();
    }
    parts
}
