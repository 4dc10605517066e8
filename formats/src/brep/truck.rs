//! Conversion of shells and solids between truck-modeling and this crate.
//!
//! Planes, lines and B-splines are converted in both directions. truck has no cylinders, cones,
//! spheres, tori, extrusions and circles as such.
//!
//! truck has no pcurves. On a plane, the pcurve is the image of the edge's curve. On a B-spline
//! surface, the pcurve is assumed to be straight between its ends, and [`Brep::check`] finds out
//! whether this is right.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use truck_modeling as truck;
use truck_modeling::SearchParameter;

use super::{
    Brep, BrepCurve, BrepSurface, EdgeId, EdgeUse, Face, Frame, PCurve, Shell, ShellId, Solid,
    VertexId,
};
use crate::spline::{SplineCurve, SplineKnots, SplineSurface};

/// The reason why a model cannot be converted.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Refusal(String);

/// The largest number of Newton steps to the parameters of a point.
const STEPS: usize = 100;

impl Brep {
    /// Adds an open or closed shell of truck.
    ///
    /// # Errors
    /// A face is on a surface of revolution, an edge is an intersection curve, or the end of an
    /// edge is not found on a surface.
    pub fn add_truck_shell(&mut self, shell: &truck::Shell) -> Result<ShellId, Refusal> {
        Taking { brep: self, vertices: HashMap::new(), edges: HashMap::new() }.shell(shell)
    }

    /// Adds a solid of truck.
    ///
    /// # Errors
    /// The same as those of [`Brep::add_truck_shell`].
    pub fn add_truck_solid(&mut self, solid: &truck::Solid) -> Result<(), Refusal> {
        let mut taking = Taking { brep: self, vertices: HashMap::new(), edges: HashMap::new() };
        let shells = solid.boundaries().iter().map(|shell| taking.shell(shell));
        let mut shells = shells.collect::<Result<Vec<_>, _>>()?.into_iter();
        let outer = shells.next().ok_or_else(|| Refusal("a solid without shells".into()))?;
        self.solids.push(Solid { outer, voids: shells.collect() });
        Ok(())
    }

    /// Converts a shell to truck. The result has no pcurves.
    ///
    /// # Errors
    /// An edge is closed, or a curve or a surface is of a kind that truck does not have, or truck
    /// refuses a face.
    pub fn truck_shell(&self, shell: ShellId) -> Result<truck::Shell, Refusal> {
        let vertices = self.vertices.iter().map(|&p| truck::Vertex::new(p.into()));
        let vertices: Vec<truck::Vertex> = vertices.collect();
        let edge = |edge: &super::Edge| {
            let [front, back] = edge.ends.map(|end| &vertices[end.0]);
            truck::Edge::try_new(front, back, truck_curve(&edge.curve)?).map_err(refused)
        };
        // Edges of other shells may be of a kind that truck does not have.
        let mut edges: HashMap<EdgeId, truck::Edge> = HashMap::new();
        let mut faces = Vec::new();
        for face in self.shells[shell.0].faces.iter().map(|face| &self.faces[face.0]) {
            for id in face.loops.iter().flatten().map(|of_loop| of_loop.edge) {
                if let Entry::Vacant(new) = edges.entry(id) {
                    new.insert(edge(&self.edges[id.0])?);
                }
            }
            let of_loop = |u: &EdgeUse| {
                let edge = &edges[&u.edge];
                // A face with the opposite normal is inverted as a whole below.
                if u.forward == face.forward { edge.clone() } else { edge.inverse() }
            };
            let wire = |uses: &Vec<EdgeUse>| -> truck::Wire {
                let mut wire: Vec<truck::Edge> = uses.iter().map(of_loop).collect();
                if !face.forward {
                    wire.reverse();
                }
                wire.into()
            };
            let wires = face.loops.iter().map(wire).collect();
            let surface = truck_surface(&self.surfaces[face.surface.0])?;
            let mut built = truck::Face::try_new(wires, surface).map_err(refused)?;
            if !face.forward {
                built.invert();
            }
            faces.push(built);
        }
        Ok(faces.into())
    }

    /// Converts a solid to truck, which checks that its shells are closed and manifold.
    ///
    /// # Errors
    /// The same as those of [`Brep::truck_shell`], and truck may refuse the shells.
    pub fn truck_solid(&self, solid: &Solid) -> Result<truck::Solid, Refusal> {
        let shells = solid.shells().map(|shell| self.truck_shell(shell));
        truck::Solid::try_new(shells.collect::<Result<_, _>>()?).map_err(refused)
    }
}

/// The elements of truck that have been converted.
struct Taking<'a> {
    brep: &'a mut Brep,
    vertices: HashMap<truck::VertexID, VertexId>,
    edges: HashMap<truck::EdgeID, EdgeId>,
}

impl Taking<'_> {
    fn shell(&mut self, shell: &truck::Shell) -> Result<ShellId, Refusal> {
        let closed = shell.shell_condition() == truck::ShellCondition::Closed;
        let mut faces = Vec::new();
        for face in shell.iter() {
            let face = self.face(face)?;
            faces.push(self.brep.add_face(face));
        }
        Ok(self.brep.add_shell(Shell { faces, closed }))
    }

    fn face(&mut self, face: &truck::Face) -> Result<Face, Refusal> {
        let wires = face.boundaries();
        let mut numbers = Vec::new();
        for edge in wires.iter().flat_map(|wire| wire.iter()) {
            numbers.push(self.edge(edge)?);
        }
        let curves = numbers.iter().map(|id| &self.brep.edges[id.0].curve);
        let (surface, pcurves) = match face.surface() {
            truck::Surface::Plane(plane) => on_plane(&plane, curves)?,
            truck::Surface::BSplineSurface(surface) => {
                let find = |p| surface.search_parameter(p, None, STEPS);
                let pcurves =
                    curves.map(|curve| straight(curve, find)).collect::<Result<_, _>>()?;
                (BrepSurface::Spline(polynomial(&surface)?), pcurves)
            }
            truck::Surface::NurbsSurface(surface) => {
                let find = |p| surface.search_parameter(p, None, STEPS);
                let pcurves =
                    curves.map(|curve| straight(curve, find)).collect::<Result<_, _>>()?;
                (BrepSurface::Spline(rational(surface.non_rationalized())?), pcurves)
            }
            truck::Surface::RevolutedCurve(_) => {
                return Err(Refusal("a face on a surface of revolution".into()));
            }
        };
        let surface = self.brep.add_surface(surface);
        let mut of_edges = numbers.into_iter().zip(pcurves);
        let of_wire = |wire: &truck::Wire| {
            let uses = wire.iter().zip(of_edges.by_ref());
            let of_edge = |(edge, (id, pcurve)): (&truck::Edge, (EdgeId, PCurve))| EdgeUse {
                edge: id,
                forward: edge.orientation(),
                pcurve,
            };
            uses.map(of_edge).collect()
        };
        let loops = wires.iter().map(of_wire).collect();
        Ok(Face { surface, forward: face.orientation(), loops })
    }

    fn edge(&mut self, edge: &truck::Edge) -> Result<EdgeId, Refusal> {
        if let Some(&known) = self.edges.get(&edge.id()) {
            return Ok(known);
        }
        let curve = our_curve(edge.curve())?;
        let ends = [edge.absolute_front(), edge.absolute_back()].map(|v| self.vertex(v));
        let id = self.brep.add_edge(curve, ends);
        self.edges.insert(edge.id(), id);
        Ok(id)
    }

    fn vertex(&mut self, vertex: &truck::Vertex) -> VertexId {
        let brep = &mut self.brep;
        *self.vertices.entry(vertex.id()).or_insert_with(|| brep.add_vertex(vertex.point().into()))
    }
}

/// A plane, and the images of curves in its parameters.
fn on_plane<'a>(
    plane: &truck::Plane,
    curves: impl Iterator<Item = &'a BrepCurve>,
) -> Result<(BrepSurface, Vec<PCurve>), Refusal> {
    let (x, y) = (plane.u_axis(), plane.v_axis());
    let frame = Frame::new(plane.origin().into(), x.cross(y).into(), x.into()).map_err(Refusal)?;
    let pcurves = curves.map(|curve| PCurve::on_plane(&frame, curve).map_err(Refusal));
    Ok((BrepSurface::plane(frame), pcurves.collect::<Result<_, _>>()?))
}

/// The pcurve of an edge that is a straight line in the parameter plane.
fn straight(
    curve: &BrepCurve,
    find: impl Fn(truck::Point3) -> Option<(f64, f64)>,
) -> Result<PCurve, Refusal> {
    let end = |p: [f64; 3]| {
        let found = find(p.into()).map(|(u, v)| [u, v]);
        found.ok_or_else(|| Refusal(format!("{p:?} is not found on its surface")))
    };
    let [start, end] = curve.ends().map(end);
    PCurve::line(start?, end?, curve.range()).map_err(Refusal)
}

fn our_curve(curve: truck::Curve) -> Result<BrepCurve, Refusal> {
    let spline = match curve {
        truck::Curve::Line(line) => {
            return BrepCurve::line(line.0.into(), line.1.into()).map_err(Refusal);
        }
        truck::Curve::BSplineCurve(curve) => polynomial_curve(&curve),
        truck::Curve::NurbsCurve(curve) => {
            let (poles, weights) = curve.control_points().iter().map(split).unzip();
            let knots = curve.knot_vec().to_vec();
            SplineCurve::new(curve.degree(), knots, poles, Some(weights)).map_err(Refusal)
        }
        truck::Curve::IntersectionCurve(_) => Err(Refusal("an intersection curve".into())),
    };
    spline.map(BrepCurve::Spline)
}

fn polynomial_curve(curve: &truck::BSplineCurve<truck::Point3>) -> Result<SplineCurve<3>, Refusal> {
    let poles = curve.control_points().iter().map(|&p| p.into()).collect();
    SplineCurve::new(curve.degree(), curve.knot_vec().to_vec(), poles, None).map_err(Refusal)
}

fn polynomial(surface: &truck::BSplineSurface<truck::Point3>) -> Result<SplineSurface, Refusal> {
    let poles = surface.control_points().iter().flatten().map(|&p| p.into()).collect();
    over(surface, poles, None)
}

fn rational(surface: &truck::BSplineSurface<truck::Vector4>) -> Result<SplineSurface, Refusal> {
    let (poles, weights) = surface.control_points().iter().flatten().map(split).unzip();
    over(surface, poles, Some(weights))
}

fn over<P>(
    surface: &truck::BSplineSurface<P>,
    poles: Vec<[f64; 3]>,
    weights: Option<Vec<f64>>,
) -> Result<SplineSurface, Refusal> {
    let net = surface.control_points();
    let knots = |knots: &truck::KnotVec, poles: usize| {
        SplineKnots::new(knots.len().saturating_sub(poles + 1), knots.to_vec(), poles)
    };
    let u = knots(surface.uknot_vec(), net.len()).map_err(Refusal)?;
    let v = knots(surface.vknot_vec(), net.first().map_or(0, Vec::len)).map_err(Refusal)?;
    SplineSurface::new(u, v, poles, weights).map_err(Refusal)
}

/// A point and its weight.
fn split(p: &truck::Vector4) -> ([f64; 3], f64) {
    ([p.x / p.w, p.y / p.w, p.z / p.w], p.w)
}

fn joined((p, &w): (&[f64; 3], &f64)) -> truck::Vector4 {
    truck::Vector4::new(p[0] * w, p[1] * w, p[2] * w, w)
}

fn knot_vec(knots: &SplineKnots) -> truck::KnotVec {
    truck::KnotVec::from(knots.knots().to_vec())
}

fn truck_curve(curve: &BrepCurve) -> Result<truck::Curve, Refusal> {
    match curve {
        BrepCurve::Spline(spline) => Ok(truck_spline(spline)),
        BrepCurve::Line(_) => {
            let [from, to] = curve.ends().map(|end| end.into());
            Ok(truck::Curve::Line(truck::Line(from, to)))
        }
        BrepCurve::Ellipse(_) => Err(Refusal("an edge on a circle or an ellipse".into())),
    }
}

fn truck_spline(curve: &SplineCurve<3>) -> truck::Curve {
    let knots = knot_vec(curve.knots());
    match curve.weights() {
        None => {
            let poles = curve.poles().iter().map(|&p| p.into()).collect();
            truck::Curve::BSplineCurve(truck::BSplineCurve::new_unchecked(knots, poles))
        }
        Some(weights) => {
            let poles = curve.poles().iter().zip(weights).map(joined).collect();
            let curve = truck::BSplineCurve::new_unchecked(knots, poles);
            truck::Curve::NurbsCurve(truck::NurbsCurve::new(curve))
        }
    }
}

fn truck_surface(surface: &BrepSurface) -> Result<truck::Surface, Refusal> {
    match surface {
        BrepSurface::Spline(spline) => Ok(truck_spline_surface(spline)),
        BrepSurface::Plane { frame } => {
            let corner = |at| frame.point(at).into();
            let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(corner);
            let [origin, x, y] = corners;
            Ok(truck::Surface::Plane(truck::Plane::new(origin, x, y)))
        }
        _ => Err(Refusal("a face on a surface that truck does not have".into())),
    }
}

fn truck_spline_surface(surface: &SplineSurface) -> truck::Surface {
    let knots = (knot_vec(surface.u()), knot_vec(surface.v()));
    let row = surface.v().poles();
    match surface.weights() {
        None => {
            let rows = surface.poles().chunks(row);
            let net = rows.map(|row| row.iter().map(|&p| p.into()).collect()).collect();
            truck::Surface::BSplineSurface(truck::BSplineSurface::new_unchecked(knots, net))
        }
        Some(weights) => {
            let rows = surface.poles().chunks(row).zip(weights.chunks(row));
            let net = rows.map(|(p, w)| p.iter().zip(w).map(joined).collect()).collect();
            let surface = truck::BSplineSurface::new_unchecked(knots, net);
            truck::Surface::NurbsSurface(truck::NurbsSurface::new(surface))
        }
    }
}

fn refused(e: impl std::fmt::Display) -> Refusal {
    Refusal(e.to_string())
}
