//! Reader of faces, loops and edges (ISO 10303-42, clause 5). Lengths are in millimetres.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::exchange::Exchange;
use super::geometry::StepGeometry;
use crate::Result;
use crate::cad::affine::Affine;
use crate::cad::{CadCurve, CadEdge, CadFace, CadModel, CadShell, CadSolid, CadSurface};

/// Reads the faces of one representation.
pub(super) struct TopologyReader<'f, 'a> {
    file: &'f Exchange<'a>,
    geometry: StepGeometry<'f, 'a>,
    unit: Affine,
    surfaces: HashMap<u64, Arc<CadSurface>>,
    edges: HashMap<u64, Arc<EdgeCurve>>,
    /// The faces that have been read. A face that two bodies share counts once.
    seen: &'f mut HashSet<u64>,
}

/// An edge, which all its uses share.
struct EdgeCurve {
    curve: Option<Arc<CadCurve<3>>>,
    ends: [[f64; 3]; 2],
    /// Whether the edge has the direction of its curve.
    along: bool,
    /// The surfaces and the curves in their parameter planes.
    pcurves: Vec<(u64, Arc<CadCurve<2>>)>,
}

impl<'f, 'a> TopologyReader<'f, 'a> {
    /// `units` are those of length in mm and of angles in radians.
    pub(super) fn new(file: &'f Exchange<'a>, units: [f64; 2], seen: &'f mut HashSet<u64>) -> Self {
        let [unit_mm, angle] = units;
        TopologyReader {
            file,
            geometry: StepGeometry::new(file, angle),
            unit: Affine::scaling(unit_mm),
            surfaces: HashMap::new(),
            edges: HashMap::new(),
            seen,
        }
    }

    /// Adds the faces of an item of a representation. Items without faces, such as placements and
    /// points, add nothing.
    pub(super) fn item(&mut self, id: u64, model: &mut CadModel) -> Result<()> {
        if self.file.entity(id)?.records.len() > 1 {
            return Ok(());
        }
        let (kind, mut attributes) = self.file.simple(id)?;
        match kind {
            "SHELL_BASED_SURFACE_MODEL" | "FACE_BASED_SURFACE_MODEL" => {
                attributes.skip(1)?;
                for shell in attributes.references()? {
                    self.shell(shell, model)?;
                }
                Ok(())
            }
            "MANIFOLD_SOLID_BREP" | "FACETED_BREP" | "BREP_WITH_VOIDS" => {
                attributes.skip(1)?;
                let outer = self.shell(attributes.reference()?, model)?;
                let mut voids = Vec::new();
                if kind == "BREP_WITH_VOIDS" {
                    for shell in attributes.references()? {
                        voids.push(self.shell(shell, model)?);
                    }
                }
                model.solids.push(CadSolid { outer, voids });
                Ok(())
            }
            "OPEN_SHELL" | "CLOSED_SHELL" | "CONNECTED_FACE_SET" => self.shell(id, model).map(drop),
            "ADVANCED_FACE" | "FACE_SURFACE" => self.face(id, model).map(drop),
            "MAPPED_ITEM" => {
                Err(self.file.unread(id, "gives a part a placement, which is not supported"))
            }
            _ => Ok(()),
        }
    }

    /// Adds a shell and returns its number.
    fn shell(&mut self, id: u64, model: &mut CadModel) -> Result<usize> {
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
        let mut faces = Vec::new();
        for face in attributes.references()? {
            faces.extend(self.face(face, model)?);
        }
        model.shells.push(CadShell { faces, closed: kind == "CLOSED_SHELL" });
        Ok(model.shells.len() - 1)
    }

    /// Adds a face and returns its number. `None` if the face has been added before.
    fn face(&mut self, id: u64, model: &mut CadModel) -> Result<Option<usize>> {
        let (kind, mut attributes) = self.file.simple(id)?;
        if !matches!(kind, "ADVANCED_FACE" | "FACE_SURFACE") {
            return Err(self.file.unread(id, format!("is a face of an unsupported kind: {kind}")));
        }
        if !self.seen.insert(id) {
            return Ok(None);
        }
        attributes.skip(1)?;
        let bounds = attributes.references()?;
        let surface_id = attributes.reference()?;
        let surface = self.surface(surface_id)?;
        let (mut loops, mut has_pole) = (Vec::with_capacity(bounds.len()), false);
        for bound in bounds {
            match self.bound(bound, surface_id)? {
                Some(edges) => loops.push(edges),
                None => has_pole = true,
            }
        }
        // A vertex as the boundary of a sphere stands for the whole sphere.
        let sphere = matches!(*surface, CadSurface::Sphere { .. });
        let natural = loops.is_empty() || has_pole && sphere;
        model.faces.push(CadFace { entity: format!("#{id}"), surface, natural, loops });
        Ok(Some(model.faces.len() - 1))
    }

    fn surface(&mut self, id: u64) -> Result<Arc<CadSurface>> {
        if let Some(known) = self.surfaces.get(&id) {
            return Ok(known.clone());
        }
        let mut surface = self.geometry.surface(id)?;
        if self.unit.scale != 1.0 {
            surface = Arc::new(self.unit.surface(Arc::unwrap_or_clone(surface)));
        }
        self.surfaces.insert(id, surface.clone());
        Ok(surface)
    }

    /// The loop of a bound. `None` if it is a single vertex, which is a pole of the surface.
    fn bound(&mut self, id: u64, surface: u64) -> Result<Option<Vec<CadEdge>>> {
        let (_, mut attributes) = self.file.simple(id)?;
        attributes.skip(1)?;
        let (ring, along) = (attributes.reference()?, attributes.logical()?);
        let (kind, mut attributes) = self.file.simple(ring)?;
        match kind {
            "VERTEX_LOOP" => return Ok(None),
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

    fn edge_use(&mut self, id: u64, surface: u64) -> Result<CadEdge> {
        let mut attributes = self.file.of_type(id, "ORIENTED_EDGE")?;
        attributes.skip(3)?;
        let edge = self.edge(attributes.reference()?)?;
        let forward = attributes.logical()? == edge.along;
        let on_it = edge.pcurves.iter().filter(|(on, _)| *on == surface);
        Ok(CadEdge {
            curve: edge.curve.clone(),
            ends: Some(edge.ends),
            forward,
            pcurves: on_it.map(|(_, curve)| curve.clone()).collect(),
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
    #[allow(clippy::type_complexity)]
    fn edge_geometry(
        &self,
        id: u64,
    ) -> Result<(Option<Arc<CadCurve<3>>>, Vec<(u64, Arc<CadCurve<2>>)>)> {
        let entity = self.file.entity(id)?;
        let kind = entity.records.first().map_or("", |record| record.name);
        match kind {
            "SURFACE_CURVE" | "SEAM_CURVE" | "INTERSECTION_CURVE" => {
                let mut attributes = self.file.of_type(id, kind)?;
                attributes.skip(1)?;
                let curve = self.unit.curve(self.geometry.curve(attributes.reference()?)?);
                let mut pcurves = Vec::new();
                for associated in attributes.references()? {
                    pcurves.extend(self.pcurve(associated)?);
                }
                Ok((Some(Arc::new(curve)), pcurves))
            }
            "PCURVE" => Ok((None, self.pcurve(id)?.into_iter().collect())),
            _ => Ok((Some(Arc::new(self.unit.curve(self.geometry.curve(id)?))), Vec::new())),
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
