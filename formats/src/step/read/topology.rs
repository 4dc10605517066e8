//! Reader of faces, loops and edges (ISO 10303-42, clause 5). Lengths are in millimetres.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::exchange::Exchange;
use super::geometry::StepGeometry;
use crate::Result;
use crate::brep::Frame;
use crate::cad::affine::Affine;
use crate::cad::{
    CadCurve, CadEdge, CadFace, CadModel, CadPlace, CadShell, CadSurface, CurveShape,
};

/// Reads the faces of one representation.
pub(super) struct TopologyReader<'f, 'a> {
    pub(super) file: &'f Exchange<'a>,
    pub(super) geometry: StepGeometry<'f, 'a>,
    unit: Affine,
    /// The places of the representation in the model. `None` if nothing tells them.
    places: Option<Arc<[CadPlace]>>,
    /// The surfaces in millimetres, by the places of those in the unit of the file, which `geometry` keeps.
    surfaces: HashMap<*const CadSurface, Arc<CadSurface>>,
    edges: HashMap<u64, Arc<EdgeCurve>>,
    /// The faces and the shells that have been read. A face that two bodies share counts once.
    pub(super) seen: &'f mut SeenParts,
    /// The number of faces so far, each counted at each of its places.
    placed: usize,
}

/// The largest number of faces of a representation, each counted at each of its places.
const MOST_PLACED: usize = 1_000_000;

/// The faces and shells of a file that have been read, with their numbers in the model.
#[derive(Default)]
pub(super) struct SeenParts {
    pub(super) faces: HashMap<u64, usize>,
    shells: HashMap<u64, usize>,
    /// The solids, by their entities.
    pub(super) solids: HashSet<u64>,
}

/// An edge, which all its uses share.
struct EdgeCurve {
    curve: Option<Arc<CadCurve<3>>>,
    ends: [[f64; 3]; 2],
    /// Whether the edge has the direction of its curve.
    along: bool,
    /// The curves in the parameter planes of surfaces.
    pcurves: Pcurves,
}

/// The curves of an edge in the parameter plane of each surface: one, or two at a seam.
pub(super) type Pcurves = HashMap<u64, SurfacePcurves>;
pub(super) type SurfacePcurves = Vec<Arc<CadCurve<2>>>;

/// An edge has so many curves in the parameter plane of a surface at most: both sides of a seam.
const MOST_PCURVES: usize = 2;

impl<'f, 'a> TopologyReader<'f, 'a> {
    /// `units` are those of length in mm and of angles in radians.
    pub(super) fn new(
        file: &'f Exchange<'a>,
        units: [f64; 2],
        places: Option<Arc<[CadPlace]>>,
        seen: &'f mut SeenParts,
    ) -> Self {
        let [unit_mm, angle] = units;
        TopologyReader {
            file,
            geometry: StepGeometry::new(file, angle),
            unit: Affine::scaling(unit_mm),
            places,
            surfaces: HashMap::new(),
            edges: HashMap::new(),
            seen,
            placed: 0,
        }
    }

    /// Adds a shell and returns its number.
    pub(super) fn shell(&mut self, id: u64, model: &mut CadModel) -> Result<usize> {
        if let Some(&known) = self.seen.shells.get(&id) {
            return Ok(known);
        }
        let (mut kind, mut attributes) = self.file.simple(id)?;
        attributes.skip(1)?;
        if matches!(kind, "ORIENTED_OPEN_SHELL" | "ORIENTED_CLOSED_SHELL") {
            attributes.skip(1)?;
            (kind, attributes) = self.file.simple(attributes.reference()?)?;
            attributes.skip(1)?;
        }
        if !matches!(kind, "OPEN_SHELL" | "CLOSED_SHELL" | "CONNECTED_FACE_SET") {
            return Err(self.file.error(id, format!("is {kind} where a shell is expected")));
        }
        let (mut faces, mut inverted) = (Vec::new(), Vec::new());
        for face in attributes.references()? {
            let (face, is_inverted) = self.face(face, model)?;
            faces.push(face);
            inverted.push(is_inverted);
        }
        model.shells.push(CadShell { faces, inverted, closed: kind == "CLOSED_SHELL" });
        self.seen.shells.insert(id, model.shells.len() - 1);
        Ok(model.shells.len() - 1)
    }

    /// Adds a face, if it has not been added before. Returns its number, and whether the shell has its opposite
    /// side.
    pub(super) fn face(&mut self, id: u64, model: &mut CadModel) -> Result<(usize, bool)> {
        let (kind, mut attributes) = self.file.simple(id)?;
        if kind == "ORIENTED_FACE" {
            attributes.skip(2)?;
            let element = attributes.reference()?;
            let forward = attributes.logical()?;
            if self.file.is_a(element, kind) {
                return Err(self.file.error(id, "is an oriented face of an oriented face"));
            }
            return Ok((self.face(element, model)?.0, !forward));
        }
        if !matches!(kind, "ADVANCED_FACE" | "FACE_SURFACE" | "FACE") {
            return Err(self.file.unread(id, format!("is a face of an unsupported kind: {kind}")));
        }
        if let Some(&known) = self.seen.faces.get(&id) {
            let same = |places: &Arc<[CadPlace]>| *places == model.faces[known].places;
            return match self.places.as_ref().is_none_or(same) {
                true => Ok((known, false)),
                false => Err(self.file.unread(id, "is a face of two parts with other places")),
            };
        }
        attributes.skip(1)?;
        let bounds = attributes.references()?;
        let (surface_id, forward) = match kind {
            "FACE" => (0, true),
            _ => (self.geometry.basis(attributes.reference()?)?, attributes.logical()?),
        };
        let (mut loops, mut has_pole) = (Vec::with_capacity(bounds.len()), false);
        for bound in bounds {
            match self.bound(bound, surface_id)? {
                Some(edges) => loops.push(edges),
                None => has_pole = true,
            }
        }
        let surface = match kind {
            "FACE" => self.plane_of(id, &loops)?,
            _ => self.surface(surface_id)?,
        };
        // A vertex as the boundary of a sphere stands for the whole sphere.
        let sphere = matches!(*surface, CadSurface::Sphere { .. });
        let natural = loops.is_empty() || has_pole && sphere && loops.is_empty();
        let number = model.faces.len();
        self.seen.faces.insert(id, number);
        self.push(id, (surface, natural, Some(forward)), loops, model)?;
        Ok((number, false))
    }

    /// Adds a face to the model at the places of the representation.
    pub(super) fn push(
        &mut self,
        id: u64,
        (surface, natural, forward): (Arc<CadSurface>, bool, Option<bool>),
        loops: Vec<Vec<CadEdge>>,
        model: &mut CadModel,
    ) -> Result<()> {
        let lost = || {
            let what = "belongs to a representation that no part of the assembly has, so its place is unknown";
            self.file.unread(id, what)
        };
        let places = self.places.clone().ok_or_else(lost)?;
        self.placed = self.placed.saturating_add(places.len());
        if self.placed > MOST_PLACED {
            let what = format!("is one of more than {MOST_PLACED} faces at their places");
            return Err(self.file.unread(id, what));
        }
        let entity = format!("#{id}");
        model.faces.push(CadFace { entity, surface, natural, forward, loops, places });
        Ok(())
    }

    /// The plane of a face that is given by its loops alone. Its normal is that of the first loop (Newell's method).
    fn plane_of(&self, id: u64, loops: &[Vec<CadEdge>]) -> Result<Arc<CadSurface>> {
        let bad = || self.file.error(id, "is a face without a plane");
        let edges = loops.first().ok_or_else(bad)?;
        let mut normal = [0.0; 3];
        for [a, b] in edges.iter().filter_map(|edge| edge.ends) {
            let [a, b] = if edges[0].forward { [a, b] } else { [b, a] };
            let side = |k: usize| {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                normal[k] + (a[i] - b[i]) * (a[j] + b[j])
            };
            normal = [side(0), side(1), side(2)];
        }
        let origin = edges.first().and_then(|edge| edge.ends).ok_or_else(bad)?[0];
        let frame = Frame::along(origin, normal).map_err(|_| bad())?;
        Ok(Arc::new(CadSurface::Plane { origin, x: frame.x(), y: frame.y() }))
    }

    pub(super) fn surface(&mut self, id: u64) -> Result<Arc<CadSurface>> {
        let surface = self.geometry.surface(id)?;
        Ok(if self.unit.scale == 1.0 { surface } else { self.in_mm(&surface) })
    }

    /// A surface in millimetres. Those that share a base still share it.
    fn in_mm(&mut self, surface: &Arc<CadSurface>) -> Arc<CadSurface> {
        let place = Arc::as_ptr(surface);
        if let Some(known) = self.surfaces.get(&place) {
            return known.clone();
        }
        let scaled = match &**surface {
            CadSurface::Offset { base, distance } => {
                let base = self.in_mm(base);
                CadSurface::Offset { base, distance: distance * self.unit.scale }
            }
            CadSurface::Part { base, u, v } => {
                CadSurface::Part { base: self.in_mm(base), u: *u, v: *v }
            }
            other => self.unit.surface(other.clone()),
        };
        let scaled = Arc::new(scaled);
        self.surfaces.insert(place, scaled.clone());
        scaled
    }

    /// The loop of a bound. `None` if it is a single vertex, which is a pole of the surface.
    fn bound(&mut self, id: u64, surface: u64) -> Result<Option<Vec<CadEdge>>> {
        let (_, mut attributes) = self.file.simple(id)?;
        attributes.skip(1)?;
        let (ring, along) = (attributes.reference()?, attributes.logical()?);
        let (kind, mut attributes) = self.file.simple(ring)?;
        match kind {
            "VERTEX_LOOP" => return Ok(None),
            "POLY_LOOP" => return self.polygon(ring, along).map(Some),
            "EDGE_LOOP" => {}
            other => {
                let what = format!("is a loop of an unsupported kind: {other}");
                return Err(self.file.unread(ring, what));
            }
        }
        attributes.skip(1)?;
        let uses = attributes.references()?;
        self.file.spend(ring, uses.len())?;
        let mut uses: Vec<CadEdge> =
            uses.into_iter().map(|u| self.edge_use(u, surface)).collect::<Result<_>>()?;
        if !along {
            uses.reverse();
            for edge in &mut uses {
                edge.forward = !edge.forward;
                edge.pcurve_forward = !edge.pcurve_forward;
            }
        }
        Ok(Some(uses))
    }

    /// The sides of a polygon.
    fn polygon(&self, id: u64, along: bool) -> Result<Vec<CadEdge>> {
        let mut attributes = self.file.of_type(id, "POLY_LOOP")?;
        attributes.skip(1)?;
        let corners = attributes.references()?;
        self.file.spend(id, corners.len())?;
        let point = |corner| Ok(self.unit.point(self.geometry.point(corner)?));
        let corners: Vec<[f64; 3]> = corners.into_iter().map(point).collect::<Result<_>>()?;
        let side = |i: usize| {
            let (from, to) = (corners[i], corners[(i + 1) % corners.len()]);
            let direction = [0, 1, 2].map(|k| to[k] - from[k]);
            let shape = CurveShape::Line { origin: from, direction };
            let curve = Some(Arc::new(CadCurve { shape, range: None }));
            let (ends, pcurves) = (Some([from, to]), Vec::new());
            CadEdge { curve, ends, forward: along, pcurves, pcurve_forward: along }
        };
        let mut sides: Vec<CadEdge> = (0..corners.len()).map(side).collect();
        if !along {
            sides.reverse();
        }
        Ok(sides)
    }

    fn edge_use(&mut self, id: u64, surface: u64) -> Result<CadEdge> {
        let mut attributes = self.file.of_type(id, "ORIENTED_EDGE")?;
        attributes.skip(3)?;
        let edge = self.edge(attributes.reference()?)?;
        let forward = attributes.logical()? == edge.along;
        let on_it = edge.pcurves.get(&surface).into_iter().flatten();
        Ok(CadEdge {
            curve: edge.curve.clone(),
            ends: Some(edge.ends),
            forward,
            pcurves: on_it.cloned().collect(),
            pcurve_forward: forward,
        })
    }

    fn edge(&mut self, id: u64) -> Result<Arc<EdgeCurve>> {
        if let Some(known) = self.edges.get(&id) {
            return Ok(known.clone());
        }
        let mut attributes = self.file.of_type(id, "EDGE_CURVE")?;
        attributes.skip(1)?;
        let ends = [attributes.reference()?, attributes.reference()?];
        let ends = [self.vertex(ends[0])?, self.vertex(ends[1])?];
        let geometry = attributes.reference()?;
        let along = attributes.logical()?;
        let (curve, pcurves) = self.edge_geometry(geometry)?;
        let ends = if along { ends } else { [ends[1], ends[0]] };
        let edge = Arc::new(EdgeCurve { curve, ends, along, pcurves });
        self.edges.insert(id, edge.clone());
        Ok(edge)
    }

    fn vertex(&self, id: u64) -> Result<[f64; 3]> {
        let mut attributes = self.file.of_type(id, "VERTEX_POINT")?;
        attributes.skip(1)?;
        Ok(self.unit.point(self.geometry.point(attributes.reference()?)?))
    }

    /// The curve in space and the pcurves of an edge.
    pub(super) fn edge_geometry(&self, id: u64) -> Result<(Option<Arc<CadCurve<3>>>, Pcurves)> {
        let entity = self.file.entity(id)?;
        let kind = entity.records.first().map_or("", |record| record.name);
        match kind {
            _ if entity.records.len() > 1 && self.file.is_a(id, "SURFACE_CURVE") => {
                let mut entity = entity;
                let missing = || self.file.error(id, "is no curve");
                let mut own = self.file.part(&mut entity, "SURFACE_CURVE").ok_or_else(missing)?;
                let curve = self.unit.curve(self.geometry.curve(own.reference()?)?);
                Ok((Some(Arc::new(curve)), Pcurves::new()))
            }
            "SURFACE_CURVE" | "SEAM_CURVE" | "INTERSECTION_CURVE" => {
                let mut attributes = self.file.of_type(id, kind)?;
                attributes.skip(1)?;
                let curve = self.unit.curve(self.geometry.curve(attributes.reference()?)?);
                let mut pcurves = Pcurves::new();
                for associated in attributes.references()? {
                    let Some((surface, pcurve)) = self.pcurve(associated)? else { continue };
                    let surface = self.geometry.basis(surface)?;
                    let on_it = pcurves.entry(surface).or_default();
                    if on_it.len() < MOST_PCURVES {
                        on_it.push(pcurve);
                    }
                }
                Ok((Some(Arc::new(curve)), pcurves))
            }
            "PCURVE" => {
                let pcurve = self.pcurve(id)?.into_iter();
                Ok((None, pcurve.map(|(surface, pcurve)| (surface, vec![pcurve])).collect()))
            }
            _ => Ok((Some(Arc::new(self.unit.curve(self.geometry.curve(id)?))), Pcurves::new())),
        }
    }

    /// A pcurve and its surface. `None` if only a surface is associated.
    fn pcurve(&self, id: u64) -> Result<Option<(u64, Arc<CadCurve<2>>)>> {
        if self.file.entity(id)?.records.len() > 1 {
            return Ok(None);
        }
        let (kind, mut attributes) = self.file.simple(id)?;
        if kind != "PCURVE" {
            return Ok(None);
        }
        attributes.skip(1)?;
        let surface = attributes.reference()?;
        let representation = attributes.reference()?;
        let mut attributes = self.file.of_type(representation, "DEFINITIONAL_REPRESENTATION")?;
        attributes.skip(1)?;
        let items = attributes.references()?;
        let [curve] = items[..] else {
            return Err(self.file.error(representation, "does not have exactly one pcurve"));
        };
        Ok(Some((surface, Arc::new(self.geometry.curve(curve)?))))
    }
}
