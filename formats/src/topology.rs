//! A [`Brep`] as numbered vertices, edges and faces, checked before a byte is
//! written.

use std::collections::HashMap;
use std::io;

use truck_modeling::{
    BSplineCurve, BSplineSurface, Curve, Edge, EdgeID, Point3, Surface, Vertex, VertexID, Wire,
};

use crate::brep::{Brep, PCurve, TrimmedFace};

/// OpenCASCADE's limit; other kernels' are no lower.
const MAX_DEGREE: usize = 25;

/// Everything the writers need, in the order in which they write it.
#[derive(Default)]
pub(crate) struct Topology<'a> {
    pub vertices: Vec<Point3>,
    pub edges: Vec<EdgeData<'a>>,
    pub faces: Vec<FaceData<'a>>,
}

/// An edge, shared by all its uses.
pub(crate) struct EdgeData<'a> {
    /// Vertex at the curve's start and at its end.
    pub ends: [usize; 2],
    pub curve: BSplineCurve<Point3>,
    /// Face and pcurve of every use.
    pub uses: Vec<(usize, &'a PCurve)>,
}

/// A face and its loops, outer one first.
pub(crate) struct FaceData<'a> {
    pub surface: BSplineSurface<Point3>,
    /// Whether the face looks where its surface's normal looks.
    pub forward: bool,
    pub loops: Vec<Vec<EdgeUse<'a>>>,
}

/// One use of an edge in a loop.
#[derive(Clone, Copy)]
pub(crate) struct EdgeUse<'a> {
    pub edge: usize,
    /// Whether the loop runs along the edge's curve.
    pub forward: bool,
    pub pcurve: &'a PCurve,
}

impl<'a> Topology<'a> {
    /// Numbers `brep`'s parts; an error of kind `InvalidInput` if one of them
    /// cannot stand in a file.
    pub(crate) fn new(brep: &'a Brep) -> io::Result<Self> {
        ensure(!brep.faces.is_empty(), || "no face".into())?;
        ensure(brep.uncertainty_mm.is_finite() && brep.uncertainty_mm > 0.0, || {
            format!("uncertainty of {} mm", brep.uncertainty_mm)
        })?;
        let mut index = Index::default();
        for (i, face) in brep.faces.iter().enumerate() {
            index.face(face).map_err(|e| invalid(format!("face {i}: {e}")))?;
        }
        Ok(index.topology)
    }

    /// The faces in groups that hang together by edges: one shell each.
    pub(crate) fn shells(&self) -> Vec<Vec<usize>> {
        // Each face leads to a former one of its shell; the first one to itself.
        let mut leads: Vec<usize> = (0..self.faces.len()).collect();
        for pair in self.edges.iter().flat_map(|edge| edge.uses.windows(2)) {
            let (a, b) = (first(&mut leads, pair[0].0), first(&mut leads, pair[1].0));
            leads[a.max(b)] = a.min(b);
        }
        let mut shells: Vec<Vec<usize>> = Vec::new();
        let mut number = vec![0; leads.len()];
        for face in 0..leads.len() {
            let head = first(&mut leads, face);
            if head == face {
                number[face] = shells.len();
                shells.push(Vec::new());
            }
            shells[number[head]].push(face);
        }
        shells
    }

    /// The largest absolute coordinate of vertices and surface poles.
    pub(crate) fn reach(&self) -> f64 {
        let poles = self.faces.iter().flat_map(|f| f.surface.control_points().iter().flatten());
        self.vertices
            .iter()
            .chain(poles)
            .flat_map(|p| [p.x, p.y, p.z])
            .fold(0.0, |reach, x| x.abs().max(reach))
    }
}

/// The first face of a face's shell. What was passed leads on more directly then.
fn first(leads: &mut [usize], mut face: usize) -> usize {
    while leads[face] != face {
        leads[face] = leads[leads[face]];
        face = leads[face];
    }
    face
}

#[derive(Default)]
struct Index<'a> {
    topology: Topology<'a>,
    vertices: HashMap<VertexID, usize>,
    edges: HashMap<EdgeID, usize>,
}

impl<'a> Index<'a> {
    fn face(&mut self, face: &'a TrimmedFace) -> io::Result<()> {
        let Surface::BSplineSurface(surface) = face.face.surface() else {
            return Err(invalid("its surface is no B-spline surface"));
        };
        check_surface(&surface)?;
        let wires = face.face.boundaries();
        ensure(!wires.is_empty() && wires.len() == face.pcurves.len(), || {
            format!("{} loops, pcurves for {}", wires.len(), face.pcurves.len())
        })?;
        let mut loops = Vec::with_capacity(wires.len());
        for (wire, pcurves) in wires.iter().zip(&face.pcurves) {
            loops.push(self.closed_loop(wire, pcurves)?);
        }
        let forward = face.face.orientation();
        self.topology.faces.push(FaceData { surface, forward, loops });
        Ok(())
    }

    fn closed_loop(&mut self, wire: &Wire, pcurves: &'a [PCurve]) -> io::Result<Vec<EdgeUse<'a>>> {
        ensure(wire.len() == pcurves.len(), || {
            format!("a loop of {} edges with {} pcurves", wire.len(), pcurves.len())
        })?;
        wire.iter().zip(pcurves).map(|(edge, pcurve)| self.edge_use(edge, pcurve)).collect()
    }

    fn edge_use(&mut self, edge: &Edge, pcurve: &'a PCurve) -> io::Result<EdgeUse<'a>> {
        let number = self.edge(edge)?;
        let face = self.topology.faces.len();
        let data = &mut self.topology.edges[number];
        check_knots(pcurve.knot_vec(), pcurve.control_points().len())?;
        let finite = pcurve.control_points().iter().all(|p| p.x.is_finite() && p.y.is_finite());
        ensure(finite, || "a pcurve's pole is not finite".into())?;
        let (range, of_edge) = (ends(pcurve.knot_vec()), ends(data.curve.knot_vec()));
        ensure(range == of_edge, || {
            format!("a pcurve over {range:?} belongs to an edge over {of_edge:?}")
        })?;
        data.uses.push((face, pcurve));
        Ok(EdgeUse { edge: number, forward: edge.orientation(), pcurve })
    }

    fn edge(&mut self, edge: &Edge) -> io::Result<usize> {
        if let Some(&number) = self.edges.get(&edge.id()) {
            return Ok(number);
        }
        let Curve::BSplineCurve(curve) = edge.curve() else {
            return Err(invalid("an edge's curve is no B-spline curve"));
        };
        check_knots(curve.knot_vec(), curve.control_points().len())?;
        ensure(curve.control_points().iter().all(is_finite), || {
            "an edge's pole is not finite".into()
        })?;
        let ends = [self.vertex(edge.absolute_front()), self.vertex(edge.absolute_back())];
        let number = self.topology.edges.len();
        self.topology.edges.push(EdgeData { ends, curve, uses: Vec::new() });
        self.edges.insert(edge.id(), number);
        Ok(number)
    }

    fn vertex(&mut self, vertex: &Vertex) -> usize {
        let vertices = &mut self.topology.vertices;
        *self.vertices.entry(vertex.id()).or_insert_with(|| {
            vertices.push(vertex.point());
            vertices.len() - 1
        })
    }
}

fn check_surface(surface: &BSplineSurface<Point3>) -> io::Result<()> {
    let net = surface.control_points();
    check_knots(surface.uknot_vec(), net.len())?;
    check_knots(surface.vknot_vec(), net[0].len())?;
    ensure(net.iter().flatten().all(is_finite), || "a pole of the surface is not finite".into())
}

fn check_knots(knots: &[f64], poles: usize) -> io::Result<()> {
    ensure(poles >= 2 && knots.len() > poles, || {
        format!("{} knots for {poles} poles", knots.len())
    })?;
    let degree = knots.len() - poles - 1;
    ensure((1..=MAX_DEGREE).contains(&degree), || format!("degree {degree}"))?;
    let rising = knots.windows(2).all(|pair| pair[0] <= pair[1]);
    ensure(rising && knots[0].is_finite() && knots[knots.len() - 1].is_finite(), || {
        "knots that do not rise, or are not finite".into()
    })?;
    let clamped = knots[0] == knots[degree] && knots[poles] == knots[knots.len() - 1];
    ensure(clamped && knots[0] < knots[poles], || "knots that are not clamped".into())
}

/// The first and the last of some knots: a curve's range.
pub(crate) fn ends(knots: &[f64]) -> (f64, f64) {
    (knots[0], knots[knots.len() - 1])
}

fn is_finite(p: &Point3) -> bool {
    p.x.is_finite() && p.y.is_finite() && p.z.is_finite()
}

fn ensure(holds: bool, what: impl FnOnce() -> String) -> io::Result<()> {
    if holds { Ok(()) } else { Err(invalid(what())) }
}

fn invalid(what: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, what.into())
}
